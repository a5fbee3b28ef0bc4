//! Constitutive laws: energy per reference volume ψ [J/m³], stress P = ∂ψ/∂F [Pa], one file a law.
//!
//! A law is written once over [`Real`], see there. Its tangent comes from dual numbers ([`tangent_along`]), exact to
//! rounding, so that no second formula can disagree with the first.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

mod ellipticity;
mod fibres;
mod holzapfel_gasser_ogden;
mod isochoric;
mod kinematics;
mod mooney_rivlin;
mod neo_hookean;
mod paths;
mod prony;
mod tangent;
#[cfg(test)]
mod tests;
mod validity;
mod volumetric;

pub use ellipticity::least_acoustic_eigenvalue;
pub use fibres::{FibreFamilies, MAX_FAMILIES};
pub use holzapfel_gasser_ogden::{FIBRE_EXPONENT_LIMIT, HolzapfelGasserOgden, I4Form, MatrixForm};
pub use kinematics::{Invariants, Kinematics, bound_largest, volume_change};
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::{CoupledNeoHookean, NeoHookean};
pub use paths::{MaterialError, Path, PathPoint, PointStress, eval_path, eval_point};
pub use prony::{Branch, BranchStep, MAX_BRANCHES, PronySeries, deviator_at, isochoric_stress};
pub use tangent::{assemble_law_tangent, assemble_tangent, tangent_along};
pub use validity::{Deformations, Validity};
pub use volumetric::Volumetric;

use super::real::Real;
use super::tensor::{Sym, Tensor};

/// ψ and the stress at one point, as the laws have it: [`Response::first_piola`] makes P = ∂ψ/∂F of it.
#[derive(Clone, Copy, Debug)]
pub struct Response<R> {
    /// Strain energy per reference volume [J/m³].
    pub psi: R,
    /// `C S / J` of the matrix, symmetric because the matrix is isotropic: P = cof F · matrix [Pa].
    pub matrix: Sym<R>,
    /// Second Piola–Kirchhoff stress S of the fibres: P = F S [Pa]; `None` for a law without.
    pub fibres: Option<Sym<R>>,
}

impl<R: Real> Response<R> {
    /// P = cof F (matrix + p I) + F S [Pa], rows spatial, with the pressure `p = U′` [Pa], positive in tension.
    #[inline(always)]
    pub fn first_piola(&self, k: &Kinematics<R>, p: R) -> Tensor<R> {
        let P = k.cof.dot_sym(&self.matrix.plus_diagonal(p));
        match &self.fibres {
            Some(S) => P.plus_dot_sym(&k.F, S),
            None => P,
        }
    }
}

/// What a law gives at one point, with what the stable step and the diagnosis take of it.
#[derive(Clone, Copy, Debug)]
pub struct BoundedResponse<R> {
    /// ψ and stress.
    pub response: Response<R>,
    /// An upper bound [Pa] of the largest eigenvalue of ∂²ψ/∂F²; exact (or nearly so) at rest, where it decides the stable
    /// step of most scenes.
    pub stiffness_bound: R,
    /// The largest exponent k2 ⟨E_a⟩² [-] of the fibre families, 0 for a law without fibres. Beyond
    /// [`FIBRE_EXPONENT_LIMIT`] the law is no longer its exponential: the stepper reports `FibreOverstretched`, with the
    /// stretch from [`Material::overstretched_fibre`].
    pub fibre_exponent: R,
}

/// ψ [J/m³] and P = ∂ψ/∂F [Pa] (rows spatial) at one point, everything in.
#[derive(Clone, Copy, Debug)]
pub struct TotalResponse<R> {
    /// Strain energy per reference volume [J/m³].
    pub psi: R,
    /// First Piola–Kirchhoff stress [Pa].
    pub P: Tensor<R>,
}

/// What a hyperelastic law gives at a point, *without* the volumetric energy `U(J)` of a split law.
///
/// A split law keeps `U` apart (see [`Law::volumetric`]), because the mean-dilatation element evaluates it once
/// per element with `J̄`. A coupled law returns `None` there and puts everything into `eval`.
pub trait Law: Copy + Send + Sync + 'static {
    /// Number of fibre families that the law reads: 0 keeps every fibre array out of the block.
    fn family_count(&self) -> usize {
        0
    }
    /// ψ and stress of all but `U(J)`, with bounds for the step: together, because exponentials serve both. `fibres[a]` are
    /// the reference unit directions.
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R>;
    /// ψ and stress alone; what the bounds take is not computed where the compiler sees that nobody asks.
    #[inline(always)]
    fn eval<R: Real>(&self, k: &Kinematics<R>, fibres: &[[R; 3]]) -> Response<R> {
        self.eval_with_bounds(k, &Invariants::new(k), fibres).response
    }
    /// The volumetric energy `U(J)` of a split law, or `None` for a coupled one.
    fn volumetric(&self) -> Option<Volumetric>;
    /// Small-strain shear modulus G and bulk modulus K at rest, fibres apart [Pa].
    fn moduli_at_rest(&self) -> (f64, f64);
}

/// Any of the laws, by value: what a scene names and a plan keeps. Matched once per block of elements, outside the
/// loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// See [`MooneyRivlin`].
    MooneyRivlin(MooneyRivlin),
    /// See [`NeoHookean`].
    NeoHookean(NeoHookean),
    /// See [`CoupledNeoHookean`].
    CoupledNeoHookean(CoupledNeoHookean),
    /// See [`HolzapfelGasserOgden`].
    HolzapfelGasserOgden(HolzapfelGasserOgden),
}

/// Runs `$body` with `$law` bound to the concrete law: the one place where the enum is matched.
#[macro_export]
macro_rules! with_law {
    ($material:expr, $law:ident => $body:expr) => {
        match $material {
            $crate::mechanics::material::Material::MooneyRivlin($law) => $body,
            $crate::mechanics::material::Material::NeoHookean($law) => $body,
            $crate::mechanics::material::Material::CoupledNeoHookean($law) => $body,
            $crate::mechanics::material::Material::HolzapfelGasserOgden($law) => $body,
        }
    };
}

impl Material {
    /// ψ and P with everything in, at a point with its own J (no element average). `H = F − I` [-].
    pub fn eval_total<R: Real>(&self, H: &Tensor<R>, fibres: &[[R; 3]]) -> TotalResponse<R> {
        let k = Kinematics::new(H);
        with_law!(self, law => {
            let response = law.eval(&k, fibres);
            let (energy, pressure) =
                law.volumetric().map_or((k.j.zero(), k.j.zero()), |U| (U.energy(k.j), U.pressure(k.j)));
            TotalResponse { psi: response.psi + energy, P: response.first_piola(&k, pressure) }
        })
    }
    /// Small-strain shear modulus G and bulk modulus K at rest, fibres apart [Pa].
    pub fn moduli_at_rest(&self) -> (f64, f64) {
        with_law!(self, law => law.moduli_at_rest())
    }
    /// What fibres add to the stiffness along one direction at rest when they are pulled, at most [Pa]: 4 k1 a family.
    pub fn fibre_modulus_at_rest(&self) -> f64 {
        match self {
            Self::HolzapfelGasserOgden(law) => 4.0 * law.k1 * law.families.directions().len() as f64,
            Self::MooneyRivlin(_) | Self::NeoHookean(_) | Self::CoupledNeoHookean(_) => 0.0,
        }
    }
    /// Number of fibre families that the law reads.
    pub fn family_count(&self) -> usize {
        with_law!(self, law => law.family_count())
    }
    /// The directions of the law's own fibre families, in the material axes.
    pub fn fibre_directions(&self) -> &[[f64; 3]] {
        match self {
            Self::HolzapfelGasserOgden(law) => law.families.directions(),
            Self::MooneyRivlin(_) | Self::NeoHookean(_) | Self::CoupledNeoHookean(_) => &[],
        }
    }
    /// The same law without the families of fibres that have no stiffness: energy and stress keep their bits, since each of
    /// those would add zero.
    #[must_use]
    pub fn without_idle_fibres(self) -> Self {
        match self {
            Self::HolzapfelGasserOgden(law) if law.k1 == 0.0 => {
                Self::HolzapfelGasserOgden(HolzapfelGasserOgden { families: FibreFamilies::NONE, ..law })
            }
            other => other,
        }
    }
    /// The same law with its isochoric stress times `factor` [-], `None` for a coupled law, which does not keep it apart.
    #[must_use]
    pub fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(match self {
            Self::MooneyRivlin(law) => {
                Self::MooneyRivlin(MooneyRivlin { c10: law.c10 * factor, c01: law.c01 * factor, ..law })
            }
            Self::NeoHookean(law) => Self::NeoHookean(NeoHookean { c10: law.c10 * factor, ..law }),
            Self::HolzapfelGasserOgden(law) => Self::HolzapfelGasserOgden(HolzapfelGasserOgden {
                c: law.c * factor,
                k1: law.k1 * factor,
                ..law
            }),
            Self::CoupledNeoHookean(_) => return None,
        })
    }
    /// The stretch `|F a|` [-] of the most stretched family when a fibre exponent has passed
    /// [`FIBRE_EXPONENT_LIMIT`], else `None`. `H = F − I` [-].
    pub fn overstretched_fibre(&self, H: &Tensor<f64>, fibres: &[[f64; 3]]) -> Option<f64> {
        let k = Kinematics::new(H);
        let exponent =
            with_law!(self, law => law.eval_with_bounds(&k, &Invariants::new(&k), fibres).fibre_exponent);
        // Not `>`: an exponent that is not a number has passed the limit too.
        if exponent <= FIBRE_EXPONENT_LIMIT {
            return None;
        }
        let stretch = |a: &[f64; 3]| k.F.apply(a).iter().map(|x| x * x).sum::<f64>().sqrt();
        fibres.iter().map(stretch).reduce(f64::max)
    }
    /// The volumetric energy of a split law, `None` for a coupled one.
    pub fn volumetric(&self) -> Option<Volumetric> {
        with_law!(self, law => law.volumetric())
    }
}
