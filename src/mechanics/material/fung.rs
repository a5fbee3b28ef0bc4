//! Fung's orthotropic tissue: an exponential of a quadratic form of the isochoric strain.

use super::exponential::BoundedExponential;
use super::validity::TISSUE;
use super::{
    BoundedResponse, Deformations, ElementTime, FibreFamilies, Invariants, Kinematics, Law, Response,
    Volumetric,
};
use crate::real::Real;
use crate::tensor::{Mat3, Sym};

/// The nine moduli of an orthotropic solid in its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrthotropicModuli {
    /// Young's moduli E1, E2, E3 [Pa].
    pub young: [f64; 3],
    /// Shear moduli G12, G23, G31 [Pa].
    pub shear: [f64; 3],
    /// Poisson's ratios ν12, ν23, ν31 [-]: ν12 is the contraction along 2 under tension along 1.
    pub poisson: [f64; 3],
}

impl OrthotropicModuli {
    /// Stiffness of the normal strains [Pa], the inverse of their compliance; `None` unless it is positive definite.
    pub fn normal_stiffness(&self) -> Option<[[f64; 3]; 3]> {
        let ([e1, e2, e3], [nu12, nu23, nu31]) = (self.young, self.poisson);
        let (s12, s23, s31) = (-nu12 / e1, -nu23 / e2, -nu31 / e3);
        let compliance = Mat3::new(1.0 / e1, s12, s31, s12, 1.0 / e2, s23, s31, s23, 1.0 / e3);
        // The eigenvalue iteration does not end on a NaN.
        let is_finite = compliance.iter().all(|s| s.is_finite());
        if !(is_finite && compliance.symmetric_eigenvalues().min() > 0.0) {
            return None;
        }
        let inverse = compliance.try_inverse()?;
        Some(std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (inverse[(i, j)] + inverse[(j, i)]))))
    }
}

/// ψ = c/2 (e^Q − 1) + U(J), c Q = Ẽ : ℂ : Ẽ, Ẽ = ½ (J^(−2/3) C − I)      (Fung 1993; Ateshian & Costa 2009)
///
/// ℂ is the orthotropic stiffness of small strains, in the element's axes: FEBio's "Fung orthotropic". At rest only
/// its isochoric part has an effect, U(J) has the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FungOrthotropic {
    /// Coefficient c of the exponential [Pa].
    c: f64,
    /// ℂ of the normal strains, and the shear moduli G12, G23, G31 [Pa].
    normal: [[f64; 3]; 3],
    shear: [f64; 3],
    /// Square roots of the largest `D : ℂ : D` of a traceless D, and of that of D = I/√3, for the bound [√Pa].
    roots: [f64; 2],
    axes: FibreFamilies,
    volumetric: Volumetric,
}

impl FungOrthotropic {
    /// With c [Pa] > 0; `None` unless the moduli are those of a stable solid.
    pub fn new(c: f64, moduli: &OrthotropicModuli, volumetric: Volumetric) -> Option<Self> {
        let normal = moduli.normal_stiffness()?;
        let axes = FibreFamilies::new(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])?;
        let of = |i: usize, j: usize| normal[i][j];
        let deviator = Mat3::identity() - Mat3::from_element(1.0 / 3.0);
        let across = deviator * Mat3::from_fn(of) * deviator;
        let largest =
            moduli.shear.iter().map(|G| 2.0 * G).fold(across.symmetric_eigenvalues().max(), f64::max);
        let along = Mat3::from_fn(of).sum() / 3.0;
        let roots = [largest.sqrt(), along.sqrt()];
        Some(Self { c, normal, shear: moduli.shear, roots, axes, volumetric })
    }

    /// T = ℂ : Ẽ [Pa], both in the material axes.
    #[inline(always)]
    fn linear_stress<R: Real>(&self, E: &Sym<R>) -> Sym<R> {
        let mut T = *E;
        for i in 0..3 {
            let row = &self.normal[i];
            T.0[i] = E.0[0] * row[0] + E.0[1] * row[1] + E.0[2] * row[2];
            T.0[3 + i] = E.0[3 + i] * (2.0 * self.shear[i]);
        }
        T
    }

    /// Bound [Pa] of the Hessian, of T = ℂ : Ẽ and the exponential at Q; exact at rest.
    ///
    /// `∂Ẽ : dF = J^(−2/3) sym Fᵀ(dF − ⅓ (F⁻ᵀ : dF) F)` has norm ≤ d = J^(−2/3) √(x² I1 Y)/3, x² the largest
    /// eigenvalue of C and Y = tr C⁻¹, and a trace ≤ t = J^(−2/3) √(I1 (I1 Y/9 − 1)); hence `e^Q (√ℂ_dev d + √ℂ_vol
    /// t)²` and `2/c e^Q (T : D)²`. The term `e^Q |T| |∂²Ẽ|` is added, with |∂²Ẽ| ≤ J^(−2/3) [1 + 4/3 x √Y + (2/9 Y +
    /// ⅓ y²) |C|].
    #[inline(always)]
    fn bound<R: Real>(&self, k: &Kinematics<R>, inv: &Invariants<R>, T: &Sym<R>, slope: R) -> R {
        let j23 = k.j23_m1() + 1.0;
        let Y = inv.trace_C_inverse;
        let zero = Y.zero();
        let d2 = inv.max_C * inv.I1 * Y * (1.0 / 9.0);
        let t2 = (inv.I1 * ((inv.I1 * Y) * (1.0 / 9.0) - 1.0)).max(zero);
        let stretch = d2.sqrt() * self.roots[0] + (t2 * (1.0 / 3.0)).sqrt() * self.roots[1];
        let T2 = T.norm_squared();
        let linear = (stretch * stretch + T2 * d2 * (2.0 / self.c)) * (j23 * j23);
        let norm_C = (inv.I1 * inv.I1 - inv.I2 * 2.0).max(zero).sqrt();
        let bend = (inv.max_C * Y).sqrt() * (4.0 / 3.0)
            + (Y * (2.0 / 9.0) + inv.max_C_inverse * (1.0 / 3.0)) * norm_C
            + 1.0;
        (linear + T2.sqrt() * bend * j23) * slope
    }
}

impl Law for FungOrthotropic {
    const NAME: &'static str = "Fung orthotropic";
    const FITTED: Deformations = TISSUE;

    #[inline(always)]
    fn fibre_directions(&self) -> &[[f64; 3]] {
        self.axes.directions()
    }

    /// S = J^(−2/3) (S̃ − ⅓ (S̃ : C) C⁻¹), S̃ = e^Q T. A missing axis contributes nothing.
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        axes: &[[R; 3]],
    ) -> BoundedResponse<R> {
        // Isochoric strain in the material axes.
        let zero = k.j.zero();
        let j23_m1 = k.j23_m1();
        let j23 = j23_m1 + 1.0;
        let strain = k.C_minus_I.scaled(j23 * 0.5).plus_diagonal(j23_m1 * 0.5);
        let mut E = Sym([zero; 6]);
        for (e, (a, b)) in E.0.iter_mut().zip(Sym::<R>::INDICES) {
            if let (Some(a), Some(b)) = (axes.get(a), axes.get(b)) {
                *e = strain.bilinear_form(a, b);
            }
        }
        // Stress and exponential, rotated back.
        let T = self.linear_stress(&E);
        let Q = T.double_dot(&E) * (1.0 / self.c);
        let e = BoundedExponential::new(Q);
        let mut S = Sym([zero; 6]);
        for (i, (t, (a, b))) in T.0.iter().zip(Sym::<R>::INDICES).enumerate() {
            if let (Some(a), Some(b)) = (axes.get(a), axes.get(b)) {
                let t = *t * e.slope;
                S = S.plus_dyads(t * if i < 3 { 0.5 } else { 1.0 }, a, b);
            }
        }
        // S̃ : C̄ with C̄ = I + 2 Ẽ
        let trace_CS = S.trace() + S.double_dot(&strain) * 2.0;
        let matrix = Sym([zero; 6]).plus_diagonal(trace_CS * k.J_inverse * (-1.0 / 3.0));
        BoundedResponse {
            response: Response { psi: e.minus_one * (0.5 * self.c), matrix, fibres: Some(S.scaled(j23)) },
            stiffness_bound: self.bound(k, inv, &T, e.slope),
            fibre_exponent: Q,
        }
    }

    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }

    /// The largest shear modulus of any plane, in the absence of an isotropic part.
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (0.5 * self.roots[0] * self.roots[0], self.volumetric.bulk_modulus())
    }

    fn element_time(&self) -> ElementTime {
        ElementTime { family: [0.0, 10.0], ..ElementTime::neo_hookean_and(15.0) }
    }

    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self {
            c: self.c * factor,
            normal: self.normal.map(|row| row.map(|x| x * factor)),
            shear: self.shear.map(|x| x * factor),
            roots: self.roots.map(|x| x * factor.sqrt()),
            ..self
        })
    }
}
