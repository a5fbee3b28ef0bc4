//! Transversely isotropic tissue after Weiss: fibres with a toe and a straight region in a Mooney–Rivlin matrix.

use super::fibre_terms::{FibreEnergy, FibreInvariant, FibreTerms, I4Form};
use super::isochoric::{
    bound_first_invariant, bound_second_invariant, eval_first_invariant, eval_second_invariant,
};
use super::validity::TISSUE;
use super::{
    BoundedResponse, Deformations, ElementTime, FibreFamilies, Invariants, Kinematics, Law, Response,
    Volumetric,
};
use crate::real::Real;

/// Number of terms in the series of the toe's energy.
const SERIES: usize = 48;

/// The largest exponent C4 (λ_m − 1) of the toe [-] and its longest stretch λ_m [-], for which the series of its energy is exact to
/// 1e-14: the remainder is below z⁴⁸/48! + (λ_m − 1)⁴⁸ e^z of it.
pub const MOST_TOE_EXPONENT: f64 = 10.0;
/// Largest stretch λ_m at the end of the toe [-], see [`MOST_TOE_EXPONENT`].
pub const MOST_TOE_STRETCH: f64 = 1.5;

/// Fibres that are slack up to λ = 1, uncrimp up to λ_m and are straight beyond (Weiss, Maker & Govindjee 1996):
///
/// ```text
/// λ W′(λ) = 0                         λ ≤ 1
///         = C3 (exp[C4 (λ − 1)] − 1)  λ ≤ λ_m
///         = C5 λ + C6                 beyond, C6 from continuity
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraighteningFibres {
    c3: f64,
    c4: f64,
    c5: f64,
    /// Intercept C6 of the straight region [Pa], from continuity.
    c6: f64,
    /// Strain at the end of the toe, λ_m − 1 [-].
    toe: f64,
    /// Coefficients of ∫ (e^(C4 t) − 1)/(1 + t) dt from 0 to u, by powers of s = u/(λ_m − 1) from s² on.
    energy: [f64; SERIES],
}

impl StraighteningFibres {
    /// With C3 [Pa] ≥ 0, C4 [-] > 0, C5 [Pa] ≥ 0 and 1 < λ_m ≤ [`MOST_TOE_STRETCH`], C4 (λ_m − 1) ≤ [`MOST_TOE_EXPONENT`].
    pub fn new(c3: f64, c4: f64, c5: f64, lambda_m: f64) -> Self {
        let toe = lambda_m - 1.0;
        let mut energy = [0.0; SERIES];
        // (e^(z s) − 1)/(1 + toe s) = Σ g_n sⁿ, z = c4 toe: g_n = zⁿ/n! − toe g_(n−1)
        let (mut power, mut g) = (1.0, 0.0);
        for (n, coefficient) in (1..).zip(&mut energy) {
            power *= c4 * toe / f64::from(n);
            g = power - toe * g;
            *coefficient = g * toe / f64::from(n + 1);
        }
        let c6 = c3 * (c4 * toe).exp_m1() - c5 * lambda_m;
        Self { c3, c4, c5, c6, toe, energy }
    }

    /// W at a fibre strain E = λ² − 1 ≥ 0.
    #[inline(always)]
    fn eval<R: Real>(&self, E: R) -> FibreEnergy<R> {
        let lambda = (E + 1.0).sqrt();
        let t = E / (lambda + 1.0);
        let u = t.min(t.constant(self.toe));
        let beyond = t - u;
        // The toe, then the contribution of a straight fibre: C5 (λ − λ_m) + T_m in place of T_m.
        let e_m1 = (u * self.c4).exp_m1();
        let T = e_m1 * self.c3 + beyond * self.c5;
        let toe_slope = (e_m1 + 1.0) * (self.c3 * self.c4);
        let T_slope = beyond.select_positive(beyond.constant(self.c5), toe_slope);
        let s = u * (1.0 / self.toe);
        let mut series = s.constant(self.energy[SERIES - 1]);
        for c in self.energy[..SERIES - 1].iter().rev() {
            series = series.mul_add(s, s.constant(*c));
        }
        let straight = beyond * self.c5 + (beyond * (1.0 / (self.toe + 1.0))).ln_1p() * self.c6;
        let dW_dlambda = T / lambda;
        let ddW = (T_slope - dW_dlambda * 2.0) / (lambda * lambda * lambda * 4.0);
        FibreEnergy {
            W: series * (s * s) * self.c3 + straight,
            dW: dW_dlambda / lambda * 0.5,
            ddW: ddW.max(ddW.zero()),
        }
    }

    /// The same fibres with all stresses times `factor` [-].
    fn scaled(self, factor: f64) -> Self {
        Self { c3: self.c3 * factor, c5: self.c5 * factor, c6: self.c6 * factor, ..self }
    }
}

/// ψ = C10 (Ī1 − 3) + C01 (Ī2 − 3) + Σ_a W(λ_a) + U(J), W that of [`StraighteningFibres`].
///
/// FEBio's "trans iso Mooney-Rivlin" has one family and [`I4Form::Isochoric`]. Ligament, tendon, muscle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weiss {
    /// C10 [Pa], ≥ 0.
    pub c10: f64,
    /// C01 [Pa], ≥ 0.
    pub c01: f64,
    /// Energy of a fibre family.
    pub fibres: StraighteningFibres,
    /// Fibre families, at most [`super::MAX_FAMILIES`].
    pub families: FibreFamilies,
    /// Invariants of the fibre term: the stretch is that of F, or of J^(−1/3) F.
    pub i4: I4Form,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for Weiss {
    const NAME: &'static str = "Weiss transversely isotropic";
    const FITTED: Deformations = TISSUE;

    #[inline(always)]
    fn fibre_directions(&self) -> &[[f64; 3]] {
        self.families.directions()
    }

    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (psi1, first) = eval_first_invariant(self.c10, k);
        let (psi2, second) = eval_second_invariant(self.c01, k);
        let matrix = k.dev_C.scaled(first).plus_scaled(second, &k.dev_cof_C);
        let bound = bound_first_invariant(self.c10, k, inv) + bound_second_invariant(self.c01, k, inv);
        let psi = psi1 + psi2;
        let zero = psi.zero();
        if fibres.is_empty() {
            let response = Response { psi, matrix, fibres: None };
            return BoundedResponse { response, stiffness_bound: bound, fibre_exponent: zero };
        }
        let invariant = FibreInvariant { kappa: 0.0, form: self.i4 };
        let mut terms = FibreTerms::new(invariant, psi, bound);
        for a in fibres {
            let strain = invariant.strain(k, a);
            terms.add(k, inv, a, (strain, self.fibres.eval(strain.E)));
        }
        terms.response(k, matrix, zero)
    }

    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }

    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (2.0 * (self.c10 + self.c01), self.volumetric.bulk_modulus())
    }

    /// Slope of λ W′ just beyond λ = 1.
    fn fibre_modulus_at_rest(&self) -> f64 {
        self.fibres.c3 * self.fibres.c4 * self.families.directions().len() as f64
    }

    fn element_time(&self) -> ElementTime {
        ElementTime { family: [72.0, 55.0], ..ElementTime::neo_hookean_and(2.5) }
    }

    fn without_idle_fibres(self) -> Self {
        let idle = self.fibres.c3 == 0.0 && self.fibres.c5 == 0.0;
        if idle { Self { families: FibreFamilies::NONE, ..self } } else { self }
    }

    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self {
            c10: self.c10 * factor,
            c01: self.c01 * factor,
            fibres: self.fibres.scaled(factor),
            ..self
        })
    }
}
