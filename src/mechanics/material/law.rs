//! What a constitutive law is: the trait of all of them, and what it gives at a point.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::{Deformations, ElementTime, Invariants, Kinematics, Volumetric};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::{Sym, Tensor};

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
    /// The largest exponent [-] of an exponential law (k2 ⟨E_a⟩² of its fibre families), 0 for a law without. Beyond
    /// [`super::FIBRE_EXPONENT_LIMIT`] the law is no longer its exponential: the stepper reports `FibreOverstretched`, with the
    /// stretch from [`super::Material::overstretch`].
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
pub trait Law: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Its name, for people.
    const NAME: &'static str;
    /// Whether it can keep a U(J) apart. For a law that cannot, no kernel of mean dilatation is compiled.
    const HAS_VOLUMETRIC: bool = true;
    /// What its parameters are usually fitted to.
    const FITTED: Deformations;

    /// Unit directions of the fibre families that it reads, in the material axes: none keeps every fibre array out of the block.
    fn fibre_directions(&self) -> &[[f64; 3]] {
        &[]
    }
    /// Number of fibre families that the law reads.
    #[inline(always)]
    fn family_count(&self) -> usize {
        self.fibre_directions().len()
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
    /// What fibres add to the stiffness along one direction at rest when they are pulled, at most [Pa].
    fn fibre_modulus_at_rest(&self) -> f64 {
        0.0
    }
    /// What an element of it costs.
    fn element_time(&self) -> ElementTime {
        ElementTime::NEO_HOOKEAN
    }
    /// The same law without the families of fibres that have no stiffness: energy and stress keep their bits, since each of
    /// those would add zero.
    #[must_use]
    fn without_idle_fibres(self) -> Self {
        self
    }
    /// The same law with its isochoric stress times `factor` [-], `None` for a coupled law, which does not keep it apart.
    #[must_use]
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self>;
}
