//! Tests that hold for every law; here the list of laws and the deformations that they have in common.

// A law must be *exactly* free of stress at rest: equality of floats is intended.
#![allow(clippy::float_cmp, clippy::unwrap_used)]

mod closed_forms;
mod coalescence;
mod lanes;
mod paths;
mod response;
mod stiffness_bound;
mod viscous_volume;

pub use viscous_volume::ViscousVolume;

use super::*;
use crate::random::Random;
use crate::tensor::{Mat3, Tensor};
use nalgebra::Rotation3;

/// Two families in the x, y plane at ±40° to x.
pub(super) const FIBRES: [[f64; 3]; 2] = [
    [0.766_044_443_118_978, 0.642_787_609_686_539_3, 0.0],
    [0.766_044_443_118_978, -0.642_787_609_686_539_3, 0.0],
];

/// Every law in every form, with its volumetric energy of bulk modulus `K` [Pa] where it has one.
pub(super) fn all_laws(K: f64) -> Vec<Material> {
    let volumetric = [Volumetric::LnSquared(K), Volumetric::Quadratic(K), Volumetric::QuadraticLn(K)];
    let mut laws = vec![
        Material::MooneyRivlin(MooneyRivlin { c10: 3.0, c01: 0.0, volumetric: volumetric[0] }),
        Material::MooneyRivlin(MooneyRivlin { c10: 0.0, c01: 2.0, volumetric: volumetric[1] }),
        Material::MooneyRivlin(MooneyRivlin { c10: 3.0, c01: 2.0, volumetric: volumetric[2] }),
        Material::NeoHookean(NeoHookean { c10: 5.0, volumetric: volumetric[0] }),
        Material::CoupledNeoHookean(CoupledNeoHookean { mu: 4.0, lambda: 30.0 }),
        Material::CoupledNeoHookean(CoupledNeoHookean { mu: 4.0, lambda: -1.0 }),
    ];
    laws.extend(invariant_laws(&volumetric));
    laws.extend([
        ogden(volumetric[0]),
        weiss(I4Form::Full, volumetric[1]),
        weiss(I4Form::Isochoric, volumetric[2]),
    ]);
    laws.extend([BlatzKo { mu: 4.0 }.into(), fung(volumetric[0]), balzani(2.6, volumetric[1])]);
    for i4 in [I4Form::Full, I4Form::Isochoric] {
        for matrix in [MatrixForm::Isochoric, MatrixForm::Coupled] {
            for (kappa, volumetric) in [0.0, 0.2, 1.0 / 3.0].into_iter().zip(volumetric) {
                laws.push(hgo(kappa, i4, matrix, volumetric));
            }
        }
    }
    laws.push(peng_guo_moran(volumetric[2]));
    laws
}

/// Functions of the isochoric invariants.
fn invariant_laws(&[ln, quadratic, quadratic_ln]: &[Volumetric; 3]) -> [Material; 4] {
    [
        Yeoh { c10: 3.0, c20: 0.5, c30: 0.1, volumetric: ln }.into(),
        Yeoh { c10: 3.0, c20: -0.2, c30: 0.02, volumetric: quadratic }.into(),
        Demiray { mu: 5.0, b: 0.7, volumetric: quadratic_ln }.into(),
        VerondaWestmann { c1: 2.0, c2: 1.5, volumetric: ln }.into(),
    ]
}

/// An Ogden law whose terms have powers of both signs.
pub(super) fn ogden(volumetric: Volumetric) -> Material {
    let terms = [(3.0, 1.3), (0.01, 5.0), (-0.5, -2.0)].map(|(mu, alpha)| OgdenTerm { mu, alpha });
    Ogden::new(&terms, volumetric).unwrap().into()
}

/// Fibres along [`FIBRES`] that are straight from a stretch of 1.2.
pub(super) fn weiss(i4: I4Form, volumetric: Volumetric) -> Material {
    let families = FibreFamilies::new(&FIBRES).unwrap();
    let fibres = StraighteningFibres::new(0.6, 9.0, 20.0, 1.2);
    Weiss { c10: 2.0, c01: 1.0, fibres, families, i4, volumetric }.into()
}

/// A polyconvex tissue of the power `alpha2` with the families [`FIBRES`].
pub(super) fn balzani(alpha2: f64, volumetric: Volumetric) -> Material {
    Balzani { c1: 3.0, alpha1: 4.0, alpha2, families: FibreFamilies::new(&FIBRES).unwrap(), volumetric }
        .into()
}

/// A tissue with fibres that resist shear against the matrix when stretched.
pub(super) fn peng_guo_moran(volumetric: Volumetric) -> Material {
    let shear = FibreShear { gamma: 6.0, beta: 12.0, stretch: 1.1 };
    let families = FibreFamilies::new(&FIBRES).unwrap();
    PengGuoMoran { c10: 2.0, fibre: [1.5, 0.7], shear, families, volumetric }.into()
}

/// An orthotropic tissue with three Young's moduli.
pub(super) fn fung(volumetric: Volumetric) -> Material {
    let moduli =
        OrthotropicModuli { young: [12.0, 8.0, 5.0], shear: [3.0, 2.0, 4.0], poisson: [0.3, 0.2, 0.1] };
    FungOrthotropic::new(6.0, &moduli, volumetric).unwrap().into()
}

/// Whether a law has an isotropic part in addition to its fibres.
pub(super) fn has_matrix(law: &Material) -> bool {
    !matches!(law, Material::FungOrthotropic(_))
}

/// A tissue of c = 3, k1 = 7, k2 = 0.8 with the families [`FIBRES`].
pub(super) fn hgo(kappa: f64, i4: I4Form, matrix: MatrixForm, volumetric: Volumetric) -> Material {
    let families = FibreFamilies::new(&FIBRES).unwrap();
    let law = HolzapfelGasserOgden { c: 3.0, k1: 7.0, k2: 0.8, kappa, families, i4, matrix, volumetric };
    Material::HolzapfelGasserOgden(law)
}

impl Random {
    /// A rotation about a random axis by up to ±3 rad.
    pub fn rotation(&mut self) -> Mat3 {
        let axis = nalgebra::Vector3::new(self.next(), self.next(), self.next());
        *Rotation3::new(axis.normalize() * (3.0 * self.next())).matrix()
    }
    /// A deformation gradient with J in 0.2 … 3 and principal stretches apart by a factor of up to e^(2 spread).
    pub fn deformation(&mut self, spread: f64) -> Mat3 {
        let logs = [spread * self.next(), spread * self.next(), spread * self.next()];
        let J = f64::exp(0.5 * (0.2_f64.ln() + 3.0_f64.ln()) + 0.5 * 15.0_f64.ln() * self.next());
        let mean = (logs.iter().sum::<f64>() - J.ln()) / 3.0;
        let stretches = logs.map(|l| f64::exp(l - mean));
        self.rotation() * Mat3::from_diagonal(&stretches.into()) * self.rotation()
    }
}

/// H = F − I.
pub(super) fn gradient(F: &Mat3) -> Tensor<f64> {
    Tensor::from(&(F - Mat3::identity()))
}

/// (ψ, P) including U(J), at F with the law's own fibres.
pub(super) fn eval(law: &Material, F: &Mat3) -> (f64, Mat3) {
    let r = law.eval_total(&gradient(F), law.fibre_directions());
    (r.psi, Mat3::from(&r.P))
}
