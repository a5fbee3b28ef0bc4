//! The eight-node hexahedron by its modes, for one-point integration.
//!
//! On the corners of the local cube the seven functions ξ, η, ζ and h₁ = ηζ, h₂ = ξζ, h₃ = ξη, h₄ = ξηζ are orthogonal, and
//! with the constant they are all there is. So a nodal field is its mean, three linear vectors `l_k` and four bilinear and
//! trilinear ones `w_α`, and the transform takes additions only:
//!
//! ```text
//! u(ξ) = ū + Σ_k l_k ξ_k + Σ_α w_α h_α(ξ)
//! ```
//!
//! The mean gradient `H̄ = 1/V ∫ ∇u dV`, exact for any hexahedron (Flanagan & Belytschko 1981), is linear in them,
//! `H̄ = Σ_k l_k⊗A_k + Σ_α w_α⊗B_α`, and what a field has beyond a linear one are the four hourglass vectors
//! `q_α = w_α − H̄ X_α` (their γ-projection), X_α those of the reference positions: a linear field, rotations among them, has
//! none at all, whatever the shape of the element.

use crate::real::Real;
use crate::tensor::{Mat3, Tensor, Vec3};

/// A vector in lanes.
pub type V3<R> = [R; 3];

/// A nodal vector field without its mean; or forces, work-conjugate to it.
#[derive(Clone, Copy, Debug)]
pub struct Modes<R> {
    /// l_k, of ξ, η, ζ: `[k][component]`.
    pub linear: [V3<R>; 3],
    /// w_α, of ηζ, ξζ, ξη, ξηζ: `[α][component]`.
    pub bilinear: [V3<R>; 4],
}

impl<R: Real> Modes<R> {
    /// From nodal values `u[component][corner]`.
    #[inline(always)]
    pub fn new(u: &[[R; 8]; 3]) -> Self {
        let zero = u[0][0].zero();
        let mut modes = Self { linear: [[zero; 3]; 3], bilinear: [[zero; 3]; 4] };
        for (i, u) in u.iter().enumerate() {
            // Sums and differences along ξ, then η, then ζ.
            let (s0, d0) = (u[0] + u[1], u[1] - u[0]);
            let (s1, d1) = (u[3] + u[2], u[2] - u[3]);
            let (s2, d2) = (u[4] + u[5], u[5] - u[4]);
            let (s3, d3) = (u[7] + u[6], u[6] - u[7]);
            let (low, high) = ([s0 + s1, s1 - s0, d0 + d1, d1 - d0], [s2 + s3, s3 - s2, d2 + d3, d3 - d2]);
            modes.linear[0][i] = (low[2] + high[2]) * 0.125;
            modes.linear[1][i] = (low[1] + high[1]) * 0.125;
            modes.linear[2][i] = (high[0] - low[0]) * 0.125;
            modes.bilinear[0][i] = (high[1] - low[1]) * 0.125;
            modes.bilinear[1][i] = (high[2] - low[2]) * 0.125;
            modes.bilinear[2][i] = (low[3] + high[3]) * 0.125;
            modes.bilinear[3][i] = (high[3] - low[3]) * 0.125;
        }
        modes
    }

    /// The transpose of [`Modes::new`]: nodal forces `f[component][corner]` from the forces on the modes.
    #[inline(always)]
    pub fn nodal_forces(&self) -> [[R; 8]; 3] {
        let mut forces = [[self.linear[0][0].zero(); 8]; 3];
        for (i, f) in forces.iter_mut().enumerate() {
            let [x, y, z] = [self.linear[0][i] * 0.125, self.linear[1][i] * 0.125, self.linear[2][i] * 0.125];
            let [yz, xz] = [self.bilinear[0][i] * 0.125, self.bilinear[1][i] * 0.125];
            let [xy, xyz] = [self.bilinear[2][i] * 0.125, self.bilinear[3][i] * 0.125];
            // In the corners' signs of ζ, then η, then ξ.
            let (one, by_y, by_x, by_xy) =
                ([-z, z], [y - yz, y + yz], [x - xz, x + xz], [xy - xyz, xy + xyz]);
            for side in 0..2 {
                let (even_0, odd_0) = (one[side] - by_y[side], by_x[side] - by_xy[side]);
                let (even_1, odd_1) = (one[side] + by_y[side], by_x[side] + by_xy[side]);
                f[4 * side] = even_0 - odd_0;
                f[4 * side + 1] = even_0 + odd_0;
                f[4 * side + 2] = even_1 + odd_1;
                f[4 * side + 3] = even_1 - odd_1;
            }
        }
        forces
    }

    /// H̄ = Σ_k l_k⊗A_k + Σ_α w_α⊗B_α of the first three w; the fourth has no part in any mean gradient.
    #[inline(always)]
    pub fn mean_gradient(&self, A: &Tensor<R>, B: &Tensor<R>) -> Tensor<R> {
        let mut H = Tensor::diagonal(A.0[0][0].zero());
        for (row, H) in H.0.iter_mut().enumerate() {
            for k in 0..3 {
                for j in 0..3 {
                    let sum = self.linear[k][row].mul_add(A.0[k][j], H[j]);
                    H[j] = self.bilinear[k][row].mul_add(B.0[k][j], sum);
                }
            }
        }
        H
    }

    /// The transpose of [`Modes::mean_gradient`]: adds the forces of a stress `T`, work-conjugate to H̄, volume included.
    #[inline(always)]
    pub fn add_mean_stress(&mut self, T: &Tensor<R>, A: &Tensor<R>, B: &Tensor<R>) {
        for k in 0..3 {
            let (a, b) = (T.apply(&A.0[k]), T.apply(&B.0[k]));
            for i in 0..3 {
                self.linear[k][i] += a[i];
                self.bilinear[k][i] += b[i];
            }
        }
    }

    /// q_α = w_α − H̄ X_α.
    #[inline(always)]
    pub fn hourglass(&self, H: &Tensor<R>, X: &[V3<R>; 4]) -> [V3<R>; 4] {
        let mut q = self.bilinear;
        for (q, X) in q.iter_mut().zip(X) {
            for (q, H) in q.iter_mut().zip(&H.0) {
                *q -= H[2].mul_add(X[2], H[1].mul_add(X[1], H[0] * X[0]));
            }
        }
        q
    }
}

impl Modes<f64> {
    /// `l_k = Σ_a λ_ka u_a`, `[k][corner]`.
    pub fn linear_vectors() -> [[f64; 8]; 3] {
        std::array::from_fn(|k| {
            let mut unit = Self { linear: [[0.0; 3]; 3], bilinear: [[0.0; 3]; 4] };
            unit.linear[k][0] = 1.0;
            unit.nodal_forces()[0]
        })
    }
}

/// Reference geometry of one element by its modes.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalGeometry {
    /// Reference volume V of the element [m³].
    pub volume: f64,
    /// ∂X/∂ξ_k at the centre [m], the linear modes of the positions.
    pub base: [Vec3; 3],
    /// X_α [m], the other modes of the positions.
    pub curvature: [Vec3; 4],
    /// A_k, the derivative of the volume by G_k over the volume [1/m].
    pub A: [Vec3; 3],
    /// B_α [1/m], α = 1, 2, 3; B₄ is 0 for every hexahedron.
    pub B: [Vec3; 3],
}

impl ModalGeometry {
    /// From the corner positions X [m].
    ///
    /// With G the base and Y the curvature, `V = 8 [G₁·(G₂×G₃) + ⅓ (G₁·(Y₃×Y₂) + G₂·(Y₁×Y₃) + G₃·(Y₂×Y₁))]`, the integral of
    /// the Jacobian; a displacement changes the volume by `V tr H̄`, so A and B are the derivatives of V by G and Y, over V.
    pub fn new(corners: &[Vec3; 8]) -> Self {
        let modes = Modes::new(&std::array::from_fn(|i| std::array::from_fn(|a| corners[a][i])));
        let (G, Y) = (modes.linear.map(Vec3::from), modes.bilinear.map(Vec3::from));
        let third = 1.0 / 3.0;
        let dG = [
            G[1].cross(&G[2]) + Y[2].cross(&Y[1]) * third,
            G[2].cross(&G[0]) + Y[0].cross(&Y[2]) * third,
            G[0].cross(&G[1]) + Y[1].cross(&Y[0]) * third,
        ];
        let dY = [
            (Y[2].cross(&G[1]) + G[2].cross(&Y[1])) * third,
            (G[0].cross(&Y[2]) + Y[0].cross(&G[2])) * third,
            (Y[1].cross(&G[0]) + G[1].cross(&Y[0])) * third,
        ];
        // V is homogeneous of degree one in the base with the rest held: Σ G·∂V/∂G counts the cubic term three times and
        // each of the others once.
        let cubic = Mat3::from_columns(&G).determinant();
        let mixed = (0..3).map(|k| G[k].dot(&dG[k])).sum::<f64>() - 3.0 * cubic;
        let volume = 8.0 * (cubic + mixed);
        let per_volume = 8.0 / volume;
        Self { volume, base: G, curvature: Y, A: dG.map(|d| d * per_volume), B: dY.map(|d| d * per_volume) }
    }

    /// Mean gradients b_a = 1/V ∫ ∇N_a dV of the corners [1/m].
    pub fn mean_gradients(&self) -> [Vec3; 8] {
        let zero = [0.0; 3];
        let [linear, bilinear] = [&self.A, &self.B].map(|vectors| vectors.map(<[f64; 3]>::from));
        let modes = Modes { linear, bilinear: [bilinear[0], bilinear[1], bilinear[2], zero] };
        let b = modes.nodal_forces();
        std::array::from_fn(|a| Vec3::new(b[0][a], b[1][a], b[2][a]))
    }

    /// The γ-vectors: `q_α = Σ_a γ_αa u_a`, `[α][corner]`.
    pub fn hourglass_vectors(&self) -> [[f64; 8]; 4] {
        let b = self.mean_gradients();
        std::array::from_fn(|alpha| {
            let mut unit = Modes { linear: [[0.0; 3]; 3], bilinear: [[0.0; 3]; 4] };
            unit.bilinear[alpha][0] = 1.0;
            let h = unit.nodal_forces()[0];
            std::array::from_fn(|a| h[a] - self.curvature[alpha].dot(&b[a]))
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::element::{Element, ElementKind, Hex8, POINTS, ReferenceGeometry, shape_at};

    /// A cube with every corner moved.
    fn distorted() -> [Vec3; 8] {
        std::array::from_fn(|a| {
            let corner = [0, 1, 2, 3, 4, 5, 6, 7].map(|b| f64::from(u8::from(b == a)));
            let modes = Modes::new(&[corner; 3]);
            let sign = |k: usize| 8.0 * modes.linear[k][0];
            let wave = |k: usize| 0.2 * ((3 * a + 7 * k) as f64 * 1.3).sin();
            Vec3::new(sign(0) + wave(0), 1.5 * sign(1) + wave(1), 0.7 * sign(2) + wave(2))
        })
    }

    #[test]
    fn modes_are_the_coefficients_of_the_shape_functions() {
        let u: [[f64; 8]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|a| ((3 * a + 7 * i) as f64).sin()));
        let modes = Modes::new(&u);
        let local @ [x, y, z] = [0.3, -0.7, 0.9];
        for i in 0..3 {
            let mean = u[i].iter().sum::<f64>() / 8.0;
            let l = [0, 1, 2].map(|k| modes.linear[k][i]);
            let w = [0, 1, 2, 3].map(|k| modes.bilinear[k][i]);
            let by_modes = mean
                + l[0] * x
                + l[1] * y
                + l[2] * z
                + w[0] * y * z
                + w[1] * x * z
                + w[2] * x * y
                + w[3] * x * y * z;
            let by_shapes: f64 = shape_at(local).iter().zip(&u[i]).map(|(N, u)| N * u).sum();
            assert!((by_modes - by_shapes).abs() < 1e-14);
        }
    }

    #[test]
    fn nodal_forces_are_the_transpose_of_the_modes() {
        let u: [[f64; 8]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|a| ((3 * a + 7 * i) as f64).sin()));
        let modes = Modes::new(&u);
        let on = Modes {
            linear: [0, 1, 2].map(|k| [0, 1, 2].map(|i| f64::from(5 * k + i).cos())),
            bilinear: [0, 1, 2, 3].map(|k| [0, 1, 2].map(|i| f64::from(2 * k + 9 * i).cos())),
        };
        let dot = |a: &[[f64; 3]], b: &[[f64; 3]]| -> f64 {
            a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
        };
        let power = dot(&modes.linear, &on.linear) + dot(&modes.bilinear, &on.bilinear);
        let f = on.nodal_forces();
        let work: f64 = (0..3).map(|i| (0..8).map(|a| f[i][a] * u[i][a]).sum::<f64>()).sum();
        assert!((power - work).abs() < 1e-13);
    }

    #[test]
    fn mean_gradients_are_those_of_the_quadrature_which_is_exact() {
        let corners = distorted();
        let modal = ModalGeometry::new(&corners);
        let points = ReferenceGeometry::new(ElementKind::Hex8, &corners);
        assert!((modal.volume / points.total_volume() - 1.0).abs() < 1e-14);
        let jacobians =
            Hex8::local_gradients(&std::array::from_fn(|i| std::array::from_fn(|a| corners[a][i])));
        let b = modal.mean_gradients();
        for a in 0..8 {
            let unit = std::array::from_fn(|_| std::array::from_fn(|c| f64::from(u8::from(c == a))));
            let g = Hex8::local_gradients(&unit);
            let mean: Vec3 = (0..POINTS)
                .map(|q| {
                    let inverse = Mat3::from(&Hex8::local_gradient_at(&jacobians, q)).try_inverse().unwrap();
                    (Mat3::from(&Hex8::local_gradient_at(&g, q)) * inverse).row(0).transpose()
                        * points.volume[q]
                })
                .sum::<Vec3>()
                / points.total_volume();
            assert!((b[a] - mean).norm() < 1e-14, "corner {a}: {} against {mean}", b[a]);
        }
    }

    #[test]
    fn a_linear_field_has_no_hourglass() {
        let corners = distorted();
        let modal = ModalGeometry::new(&corners);
        let A = Mat3::new(0.1, 0.2, -0.3, 0.4, 0.5, 0.6, -0.7, 0.8, 0.9);
        for gamma in modal.hourglass_vectors() {
            let q: Vec3 = (0..8).map(|a| (A * corners[a] + Vec3::repeat(1.0)) * gamma[a]).sum();
            assert!(q.norm() < 1e-14, "{q}");
        }
    }
}
