//! The trait of all constitutive laws, and their response at a point.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::{
    Deformations, ElasticPoint, ElementTime, History, Invariants, Kinematics, Overstress, Volumetric,
};
use crate::real::Real;
use crate::tensor::{Sym, Tensor};

/// ψ and the stress at one point in the form that laws return; [`Response::first_piola`] gives P = ∂ψ/∂F.
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

/// Response of a law at one point, with the quantities for the critical time step and the diagnosis.
#[derive(Clone, Copy, Debug)]
pub struct BoundedResponse<R> {
    /// Energy ψ and stress.
    pub response: Response<R>,
    /// Upper bound [Pa] of the largest eigenvalue of ∂²ψ/∂F²; exact (or nearly so) at rest, where it determines the
    /// critical time step of most scenes.
    pub stiffness_bound: R,
    /// Largest exponent [-] of an exponential law (k2 ⟨E_a⟩² of its fibre families), 0 for other laws. Beyond
    /// [`super::FIBRE_EXPONENT_LIMIT`] the law is no longer its exponential: the stepper reports
    /// `FibreOverstretched`, with the stretch from [`super::Material::overstretch`].
    pub fibre_exponent: R,
}

/// ψ [J/m³] and P = ∂ψ/∂F [Pa] (rows spatial) at one point, including the volumetric energy.
#[derive(Clone, Copy, Debug)]
pub struct TotalResponse<R> {
    /// Strain energy per reference volume [J/m³].
    pub psi: R,
    /// First Piola–Kirchhoff stress [Pa].
    pub P: Tensor<R>,
}

/// A law at a point, *without* the volumetric energy `U(J)` of a split law: its elastic response, and what internal variables add to it.
///
/// A split law returns `U` separately (see [`Law::volumetric`]), because the mean-dilatation element evaluates it
/// once per element with `J̄`. A coupled law returns `None` there and includes everything in `eval`.
pub trait Law: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Name of the law in reports.
    const NAME: &'static str;
    /// Deformations to which its parameters are usually fitted.
    const FITTED: Deformations;

    /// Unit directions of the law's fibre families in the material axes; without any, blocks have no fibre arrays.
    fn fibre_directions(&self) -> &[[f64; 3]] {
        &[]
    }
    /// Number of fibre families of the law.
    #[inline(always)]
    fn family_count(&self) -> usize {
        self.fibre_directions().len()
    }
    /// ψ and stress without `U(J)`, with bounds for the time step: together, because both use the exponentials.
    /// `fibres[a]` are the reference unit directions.
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R>;
    /// ψ and stress alone; the compiler eliminates the computation of the bounds, which are not requested.
    #[inline(always)]
    fn eval<R: Real>(&self, k: &Kinematics<R>, fibres: &[[R; 3]]) -> Response<R> {
        self.eval_with_bounds(k, &Invariants::new(k), fibres).response
    }
    /// Numbers that a point remembers, the internal variables; 0 for elastic laws.
    #[inline(always)]
    fn history_len(&self) -> usize {
        0
    }
    /// Takes the internal variables over a step of `h` [s] to the deformation of `elastic`, and returns what they add to that response. With
    /// `h = 0` the stress that they add stays, and one that holds the last deformation is set to that of `elastic`. At the start of a run all
    /// are zero, and add nothing. Their stress is evaluated at each point, also in elements that average the dilatation.
    #[inline(always)]
    fn update<R: Real>(
        &self,
        _h: f64,
        elastic: &ElasticPoint<R>,
        _fibres: &[[R; 3]],
        _history: &mut impl History<R>,
    ) -> Overstress<R> {
        Overstress::none(elastic.psi.zero())
    }
    /// The volumetric energy `U(J)` of a split law, or `None` for a coupled one.
    fn volumetric(&self) -> Option<Volumetric>;
    /// Small-strain shear modulus G and bulk modulus K at rest, fibres apart [Pa].
    fn moduli_at_rest(&self) -> (f64, f64);
    /// Upper bound of the contribution of fibres in tension to the stiffness along one direction at rest [Pa].
    fn fibre_modulus_at_rest(&self) -> f64 {
        0.0
    }
    /// Cost of an element with this law.
    fn element_time(&self) -> ElementTime {
        ElementTime::NEO_HOOKEAN
    }
    /// The same law without fibre families of zero stiffness: energy and stress keep their bits, since each of those
    /// adds zero.
    #[must_use]
    fn without_idle_fibres(self) -> Self {
        self
    }
    /// The same law with its isochoric stress times `factor` [-]; `None` for a coupled law, where that is not
    /// separate.
    #[must_use]
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self>;
}
