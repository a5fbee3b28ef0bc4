//! One-point elements: batches of [`Formulation::Reduced`](super::Formulation), and their energy.
//!
//! ```text
//! W(u) = V [ψ(F̄) + U(det F̄)] + ψ_hg          F̄ = I + H̄, the mean gradient
//! ```
//!
//! Everything of the law is taken at the one point, of coupled laws too: with one constraint an element on the volume it does
//! not lock. The force is the exact gradient of W. A linear field gives each node the integral of its shape function's
//! gradient times the one stress, as exact quadrature would: the patch test is passed on any hexahedron.

use super::parameters::{BlockInput, BlockParameters, Formulation};
use super::pressure::{Pressure, corners_may_fold, tangent_bound};
use super::rows::load_corners;
use crate::element::{Hourglass, HourglassResponse, ModalGeometry, Modes, V3, largest_eigenvalue};
use crate::lanes::{BATCH, Lane, Row};
use crate::material::{Invariants, Kinematics, Law, Material};
use crate::real::Real;
use crate::registers::Registers;
use crate::tensor::{Tensor, tensor};

/// Energy of the stabilisation over μV counts as so much compression when corners are looked for that may fold [-]: a corner that lost
/// 70 % of its volume in an element that keeps its own has four times the energy that is enough here.
const FOLDED: f64 = 40.0;

/// Constants of a batch of one-point elements, lane by lane; all zero in padding but `length` and `base`.
#[derive(Clone, Debug)]
pub(super) struct ReducedBatch {
    /// Reference volume V of each lane [m³].
    pub volume: Row,
    /// A_k [1/m]: `[3 k + j][lane]`, see [`ModalGeometry`].
    pub A: [Row; 9],
    /// B_α [1/m]: `[3 α + j][lane]`.
    pub B: [Row; 9],
    /// X_α [m]: `[3 α + i][lane]`.
    pub curvature: [Row; 12],
    /// Unit base vectors: `[3 k + i][lane]` [-].
    pub base: [Row; 9],
    /// Their inverse lengths [1/m].
    pub inverse_length: [Row; 3],
    /// Stiffness of the planes: `[4 n + i][lane]` [J].
    pub plane: [Row; 12],
    /// Stiffness of the fourth vector [J].
    pub fourth: Row,
    /// Inverse of the energy that the stabilisation's fourth order is measured with [1/J].
    pub inverse_scale: Row,
    /// Largest stiffness of the stabilisation's planes [J].
    pub largest: Row,
    /// λ / ρ: largest ω² per tangent norm, the stabilisation's fraction in it [1/(m² kg/m³)].
    pub frequency_bound: Row,
    /// Largest ω² per stiffness against the unit base vectors [1/(kg m²)].
    pub base_bound: Row,
    /// Tangent norm at rest α₀ [Pa].
    pub tangent_at_rest: f64,
    /// Length L of the bulk viscosity [m], as in other formulations; 1 in padding.
    pub length: Row,
}

/// Interface of the batches of a one-point formulation, common to all passes.
pub(super) trait OnePointBatch<const N: usize>:
    std::fmt::Debug + Send + Sync + Sized + 'static
{
    /// From the elements of a batch; `None` in other formulations.
    fn pack(chunk: &[BlockInput], parameters: &BlockParameters) -> Option<Self>;
    /// H̄ [-] of the elements of a register, from nodal displacements [m].
    fn mean_gradient<S: Registers>(&self, simd: S, part: usize, u: &[[Row; N]; 3]) -> Tensor<Lane<S>>;
}

/// Stands in for elements without a one-point formulation; has no values.
#[derive(Clone, Copy, Debug)]
pub(super) enum NoOnePoint {}

impl<const N: usize> OnePointBatch<N> for NoOnePoint {
    fn pack(_: &[BlockInput], _: &BlockParameters) -> Option<Self> {
        None
    }
    fn mean_gradient<S: Registers>(&self, _: S, _: usize, _: &[[Row; N]; 3]) -> Tensor<Lane<S>> {
        match *self {}
    }
}

impl OnePointBatch<8> for ReducedBatch {
    fn pack(chunk: &[BlockInput], parameters: &BlockParameters) -> Option<Self> {
        (parameters.formulation == Formulation::Reduced).then(|| Self::new(chunk, parameters))
    }
    #[inline(always)]
    fn mean_gradient<S: Registers>(&self, simd: S, part: usize, u: &[[Row; 8]; 3]) -> Tensor<Lane<S>> {
        let (A, B) = self.gradient_vectors(simd, part);
        Modes::new(&load_corners(simd, u, part)).mean_gradient(&A, &B)
    }
}

impl ReducedBatch {
    /// From the elements of a batch.
    pub fn new(chunk: &[BlockInput], parameters: &BlockParameters) -> Self {
        let (mu, K) = parameters.material.moduli_at_rest();
        let tangent_at_rest = tangent_at_rest(&parameters.material);
        let mut batch = Self {
            volume: Row::default(),
            A: [Row::default(); 9],
            B: [Row::default(); 9],
            curvature: [Row::default(); 12],
            // Unit vectors in padding too, so that no base vanishes.
            base: std::array::from_fn(|i| Row([if i % 4 == 0 { 1.0 } else { 0.0 }; BATCH])),
            inverse_length: [Row::default(); 3],
            plane: [Row::default(); 12],
            fourth: Row::default(),
            inverse_scale: Row::default(),
            largest: Row::default(),
            frequency_bound: Row::default(),
            base_bound: Row::default(),
            tangent_at_rest,
            length: Row([1.0; BATCH]),
        };
        for (lane, input) in chunk.iter().enumerate() {
            let corners = std::array::from_fn(|a| input.corners.get(a).copied().unwrap_or_default());
            let modal = ModalGeometry::new(&corners);
            let hourglass = Hourglass::new(&modal, mu, K);
            batch.volume[lane] = modal.volume;
            for k in 0..3 {
                for i in 0..3 {
                    batch.A[3 * k + i][lane] = modal.A[k][i];
                    batch.B[3 * k + i][lane] = modal.B[k][i];
                    batch.base[3 * k + i][lane] = hourglass.base[k][i];
                }
                batch.inverse_length[k][lane] = hourglass.inverse_length[k];
                for i in 0..4 {
                    batch.plane[4 * k + i][lane] = hourglass.plane[k][i];
                }
            }
            for alpha in 0..4 {
                for i in 0..3 {
                    batch.curvature[3 * alpha + i][lane] = modal.curvature[alpha][i];
                }
            }
            batch.fourth[lane] = hourglass.fourth;
            batch.inverse_scale[lane] = hourglass.inverse_scale;
            batch.largest[lane] = hourglass.largest;
            let corner_volume = &input.geometry.corner_volume;
            let largest = frequency_eigenvalue(&modal, &hourglass, corner_volume, tangent_at_rest);
            batch.frequency_bound[lane] = largest / parameters.density;
            batch.base_bound[lane] = base_eigenvalue(&hourglass, corner_volume) / parameters.density;
            batch.length[lane] = 2.0 / input.geometry.gradient_bound.sqrt();
        }
        batch
    }

    /// A and B of the elements of a register.
    #[inline(always)]
    pub fn gradient_vectors<S: Registers>(&self, simd: S, part: usize) -> (Tensor<Lane<S>>, Tensor<Lane<S>>) {
        (
            tensor!(k, j => Lane::load(simd, &self.A[3 * k + j], part)),
            tensor!(k, j => Lane::load(simd, &self.B[3 * k + j], part)),
        )
    }
}

impl ReducedBatch {
    /// The constants of the energy, of the elements of a register with its gradient vectors.
    #[inline(always)]
    pub fn one_point<S: Registers>(
        &self,
        simd: S,
        part: usize,
        A: Tensor<Lane<S>>,
        B: Tensor<Lane<S>>,
    ) -> OnePointElement<Lane<S>> {
        // A macro, not a closure: that would be compiled without the instruction set of this function.
        macro_rules! load {
            ($x:expr) => {
                Lane::load(simd, $x, part)
            };
        }
        let zero = Lane::splat(simd, 0.0);
        let mut curvature = [[zero; 3]; 4];
        for (alpha, X) in curvature.iter_mut().enumerate() {
            for (i, X) in X.iter_mut().enumerate() {
                *X = load!(&self.curvature[3 * alpha + i]);
            }
        }
        let mut constants = Hourglass {
            base: [[zero; 3]; 3],
            inverse_length: [zero; 3],
            plane: [[zero; 4]; 3],
            fourth: load!(&self.fourth),
            inverse_scale: load!(&self.inverse_scale),
            largest: load!(&self.largest),
        };
        for n in 0..3 {
            constants.inverse_length[n] = load!(&self.inverse_length[n]);
            for i in 0..3 {
                constants.base[n][i] = load!(&self.base[3 * n + i]);
            }
            for i in 0..4 {
                constants.plane[n][i] = load!(&self.plane[4 * n + i]);
            }
        }
        OnePointElement { volume: load!(&self.volume), A, B, curvature, constants }
    }
}

/// Constants of the energy of one-point elements, in any number.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnePointElement<R> {
    /// Reference volume V of the element [m³].
    pub volume: R,
    /// A_k [1/m], see [`ModalGeometry`].
    pub A: Tensor<R>,
    /// B_α [1/m], see [`ModalGeometry`].
    pub B: Tensor<R>,
    /// X_α, the bilinear and trilinear modes of the positions [m].
    pub curvature: [V3<R>; 4],
    /// Constants of the stabilisation.
    pub constants: Hourglass<R>,
}

impl<R: Real> OnePointElement<R> {
    /// The stabilisation at modes of the displacement [m] with the mean gradient `H` [-].
    #[inline(always)]
    pub fn hourglass(&self, modes: &Modes<R>, H: &Tensor<R>) -> HourglassResponse<R> {
        self.constants.eval(&modes.linear, &modes.hourglass(H, &self.curvature))
    }

    /// Forces on the corners [N] of the stress P [Pa] at the point and of the stabilisation.
    #[inline(always)]
    pub fn nodal_forces(&self, P: &Tensor<R>, hourglass: &HourglassResponse<R>) -> [[R; 8]; 3] {
        // q_α = w_α − H̄ X_α passes the forces on the hourglass vectors to w_α and H̄.
        let mut T = P.scaled(self.volume);
        for (on, X) in hourglass.on_hourglass.iter().zip(&self.curvature) {
            for i in 0..3 {
                for j in 0..3 {
                    T.0[i][j] -= on[i] * X[j];
                }
            }
        }
        let mut on = Modes { linear: hourglass.on_linear, bilinear: hourglass.on_hourglass };
        on.add_mean_stress(&T, &self.A, &self.B);
        on.nodal_forces()
    }
}

impl<S: Registers> OnePointElement<Lane<S>> {
    /// Whether a corner of an element of a register may be folding: not where it is neither compressed nor bent much.
    #[inline(always)]
    pub fn corners_may_fold(&self, j: Lane<S>, hourglass: &HourglassResponse<Lane<S>>, part: usize) -> bool {
        let bent = hourglass.energy * self.constants.inverse_scale;
        corners_may_fold::<S>(j - bent * FOLDED, j.zero(), part)
    }
}

/// The largest λ with `ω² ≤ max(α, s α₀) λ/ρ`, α₀ the tangent norm at rest, s the stiffening of the stabilisation: of the 8×8 matrix
/// `D^(−½) [V Σ_j b_j b_jᵀ + 1/α₀ Σ_α κ_α γ_α γ_αᵀ] D^(−½)`, D the corner volumes [1/m²].
///
/// As `α bbᵀ + s κγγᵀ ≤ max(α, s α₀) (bbᵀ + κγγᵀ/α₀)`. What the base vectors' part in the stabilisation adds is [`base_eigenvalue`].
fn frequency_eigenvalue(
    modal: &ModalGeometry,
    hourglass: &Hourglass<f64>,
    corner_volume: &[f64],
    tangent_at_rest: f64,
) -> f64 {
    let (b, gamma) = (modal.mean_gradients(), modal.hourglass_vectors());
    let kappa = hourglass.stiffness_bound().map(|kappa| kappa / tangent_at_rest.max(f64::MIN_POSITIVE));
    let scale: Vec<f64> = corner_volume.iter().map(|v| 1.0 / v.abs().sqrt().max(f64::MIN_POSITIVE)).collect();
    largest_eigenvalue(std::array::from_fn::<[f64; 8], 8, _>(|a| {
        std::array::from_fn(|c| {
            let stabilisation: f64 =
                (0..4).map(|alpha| kappa[alpha] * gamma[alpha][a] * gamma[alpha][c]).sum();
            (modal.volume * b[a].dot(&b[c]) + stabilisation) * scale[a] * scale[c]
        })
    }))
}

/// The largest λ with `ω² ≤ β λ/ρ`, β the stiffness against the unit base vectors: of the 8×8 matrix
/// `D^(−½) [Σ_k λ_k λ_kᵀ/|G_k|²] D^(−½)`, D the corner volumes, λ_k those combinations of corners that are l_k [1/m⁵].
fn base_eigenvalue(hourglass: &Hourglass<f64>, corner_volume: &[f64]) -> f64 {
    let linear = Modes::linear_vectors();
    let scale: Vec<f64> = corner_volume.iter().map(|v| 1.0 / v.abs().sqrt().max(f64::MIN_POSITIVE)).collect();
    largest_eigenvalue(std::array::from_fn::<[f64; 8], 8, _>(|a| {
        std::array::from_fn(|c| {
            let of = |k: usize| hourglass.inverse_length[k].powi(2) * linear[k][a] * linear[k][c];
            (0..3).map(of).sum::<f64>() * scale[a] * scale[c]
        })
    }))
}

/// The bound of the tangent's norm without strain [Pa].
fn tangent_at_rest(material: &Material) -> f64 {
    let k = Kinematics::new(&Tensor::diagonal(0.0));
    let invariants = Invariants::new(&k);
    let stiffness = material.volumetric().map_or(0.0, |U| U.stiffness(0.0));
    let point = material.eval_with_bounds(&k, &invariants, material.fibre_directions());
    tangent_bound(point.stiffness_bound, &invariants, &Pressure { p: 0.0, stiffness })
}

#[cfg(test)]
mod tests;
