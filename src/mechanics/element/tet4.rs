//! The four-node tetrahedron with one point.
//!
//! Shape functions 1 − ξ − η − ζ, ξ, η, ζ: the gradient is the same everywhere. A nearly incompressible solid locks in it.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::Element;
use crate::real::Real;
use crate::tensor::{Tensor, Vec3, tensor};

/// Nodes 1, 2, 3 are right-handed seen from node 0: the determinant of their three edges from there is positive.
#[derive(Clone, Copy, Debug)]
pub struct Tet4;

impl Tet4 {
    /// Derivatives of the volume by the positions of the nodes [m²]: a sixth of the cross products of two edges.
    pub fn volume_slopes(x: &[Vec3; 4]) -> [Vec3; 4] {
        let [a, b, c] = [1, 2, 3].map(|i| x[i] - x[0]);
        let [a, b, c] = [b.cross(&c) / 6.0, c.cross(&a) / 6.0, a.cross(&b) / 6.0];
        [-(a + b + c), a, b, c]
    }
}

impl Element<4, 1> for Tet4 {
    const DERIVATIVE: f64 = 1.0;
    const WEIGHT: f64 = 1.0 / 6.0;
    /// (ω d³)^(−½) = √6, exact to rounding.
    const SCALE: f64 = 2.449_489_742_783_178;
    /// Six lengths are as many as a rate of strain has components.
    const LENGTHS: &'static [(usize, usize)] = &[(0, 1), (0, 2), (0, 3), (1, 2), (2, 3), (3, 1)];
    const KERNELS_OF_LAWS: bool = false;
    const RELATIVE_COST: f64 = 0.25;
    const NODAL_PRESSURE: bool = true;
    type Local<R: Real> = Tensor<R>;

    #[inline(always)]
    fn local_gradients<R: Real>(u: &[[R; 4]; 3]) -> Tensor<R> {
        tensor!(i, k => u[i][k + 1] - u[i][0])
    }

    #[inline(always)]
    fn local_gradient_at<R: Real>(g: &Tensor<R>, _q: usize) -> Tensor<R> {
        *g
    }

    #[inline(always)]
    fn no_stress<R: Real>(zero: R) -> Tensor<R> {
        Tensor::diagonal(zero)
    }

    #[inline(always)]
    fn add_local_stress<R: Real>(sums: &mut Tensor<R>, _q: usize, P: &Tensor<R>, cof: &Tensor<R>) {
        *sums = sums.plus(&P.dot(cof));
    }

    #[inline(always)]
    fn nodal_forces<R: Real>(sums: &Tensor<R>) -> [[R; 4]; 3] {
        let mut forces = [[sums.0[0][0]; 4]; 3];
        for (f, s) in forces.iter_mut().zip(&sums.0) {
            *f = [-(s[0] + s[1] + s[2]), s[0], s[1], s[2]];
        }
        forces
    }

    fn shapes() -> &'static [[f64; 4]; 1] {
        &[[0.25; 4]]
    }

    fn shape_gradients() -> &'static [[[f64; 3]; 4]; 1] {
        &[[[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]]
    }
}
