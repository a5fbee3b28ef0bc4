//! The first pass over elements, with which every other begins: reference geometry, displacement gradient and change of volume at
//! each point, and the mean of the latter.

use super::packed::Batch;
use super::rows::load_corners;
use crate::element::Element;
use crate::lanes::{Aligned, Lane, Row};
use crate::material::volume_change;
use crate::real::Real;
use crate::registers::Registers;
use crate::tensor::Tensor;

/// Kinematics of the elements of a register at their points.
pub(super) struct FirstPass<R, const Q: usize> {
    /// Cofactors of the local gradients of the scaled reference positions: `P cof` is the local stress, weight included.
    pub cof_X: Aligned<[Tensor<R>; Q]>,
    /// Reference volumes over [`Element::SCALE`] [m³].
    pub w: Aligned<[R; Q]>,
    /// H = F − I [-].
    pub H: Aligned<[Tensor<R>; Q]>,
    /// J − 1 [-].
    pub j: Aligned<[R; Q]>,
    /// Mean of J − 1 over the volume of the element [-].
    pub mean: R,
    /// Smallest J − 1 [-].
    pub smallest: R,
}

impl<R: Real, const Q: usize> FirstPass<R, Q> {
    /// First pass of elements at rest, without volume.
    #[inline(always)]
    pub fn new(zero: R) -> Self {
        let none = Tensor::diagonal(zero);
        Self {
            cof_X: Aligned([none; Q]),
            w: Aligned([zero; Q]),
            H: Aligned([none; Q]),
            j: Aligned([zero; Q]),
            mean: zero,
            smallest: zero,
        }
    }
}

impl<E: Element<N, Q>, const N: usize, const Q: usize> Batch<E, N, Q> {
    /// First pass of the elements of a register with nodal displacements `u` [m].
    #[inline(always)]
    pub fn first_pass<S: Registers>(&self, simd: S, part: usize, u: &[[Row; N]; 3]) -> FirstPass<Lane<S>, Q> {
        let mut out = FirstPass::new(Lane::splat(simd, 0.0));
        self.first_pass_to(simd, part, u, &mut out);
        out
    }

    /// As [`Self::first_pass`], into an existing place: a new one costs as much as a tenth of the evaluation.
    #[inline(always)]
    pub fn first_pass_to<S: Registers>(
        &self,
        simd: S,
        part: usize,
        u: &[[Row; N]; 3],
        out: &mut FirstPass<Lane<S>, Q>,
    ) {
        let zero = Lane::splat(simd, 0.0);
        (out.mean, out.smallest) = (zero, zero.constant(f64::MAX));
        let local_X = Aligned(E::local_gradients(&load_corners(simd, &self.corners, part)));
        let local_u = Aligned(E::local_gradients(&load_corners(simd, u, part)));
        for q in 0..Q {
            let X = E::local_gradient_at(&local_X.0, q);
            let cof = X.cofactor();
            out.w.0[q] = X.determinant_by(&cof);
            out.H.0[q] = self.gradient_at(simd, part, &local_u.0, (q, &cof));
            out.cof_X.0[q] = cof;
            out.j.0[q] = volume_change(&out.H.0[q]);
            out.mean = out.w.0[q].mul_add(out.j.0[q], out.mean);
            out.smallest = out.smallest.min(out.j.0[q]);
        }
        out.mean = out.mean * Lane::load(simd, &self.scaled_inverse_volume, part);
    }

    /// The gradient ∂/∂X of a nodal field at a point, from its local gradients and the cofactor of the first pass there; zero in padding.
    #[inline(always)]
    pub fn gradient_at<S: Registers>(
        &self,
        simd: S,
        part: usize,
        local: &E::Local<Lane<S>>,
        (q, cof_X): (usize, &Tensor<Lane<S>>),
    ) -> Tensor<Lane<S>> {
        let inverse_weight = Lane::load(simd, &self.inverse_weight[q], part);
        E::local_gradient_at(local, q).dot_transposed(cof_X).scaled(inverse_weight)
    }
}
