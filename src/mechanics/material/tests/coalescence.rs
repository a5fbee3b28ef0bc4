//! Ogden's law where principal stretches coincide, and close to that.

use super::*;
use crate::dual::Dual;
use nalgebra::SMatrix;

const U: Volumetric = Volumetric::LnSquared(40.0);

/// Deformations with two and three equal principal stretches, exactly and nearly, rotated.
fn deformations() -> Vec<Mat3> {
    let mut random = Random(21);
    let mut all = vec![Mat3::identity()];
    for gap in [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3] {
        for [a, b] in [[1.0, 1.0], [1.4, 0.8], [0.6, 1.5], [2.0, 0.5]] {
            let stretches = [a, a * (1.0 + gap), b * (1.0 - 0.3 * gap)];
            let plain = Mat3::from_diagonal(&stretches.into());
            all.extend([plain, random.rotation() * plain * random.rotation()]);
        }
    }
    all
}

fn tangent(law: &Material, F: &Mat3) -> SMatrix<f64, 9, 9> {
    let A = assemble_tangent(law, &gradient(F), &[]);
    SMatrix::from_fn(|i, j| A[i][j])
}

#[test]
fn powers_of_two_are_mooney_rivlin() {
    let terms = [OgdenTerm { mu: 6.0, alpha: 2.0 }, OgdenTerm { mu: -4.0, alpha: -2.0 }];
    let ogden = Material::from(Ogden::new(&terms, U).unwrap());
    let mooney = Material::from(MooneyRivlin { c10: 3.0, c01: 2.0, volumetric: U });
    for F in deformations() {
        let ((psi, P), (psi_exact, P_exact)) = (eval(&ogden, &F), eval(&mooney, &F));
        assert!((psi - psi_exact).abs() <= 1e-13 * psi_exact, "{F}: {psi} {psi_exact}");
        assert!((P - P_exact).norm() <= 1e-13 * P_exact.norm(), "{F}: {P} {P_exact}");
        let (A, exact) = (tangent(&ogden, &F), tangent(&mooney, &F));
        assert!((A - exact).amax() <= 1e-11 * exact.amax(), "{F}: {:e}", (A - exact).amax() / exact.amax());
    }
}

#[test]
fn the_tangent_of_any_powers_agrees_with_differences() {
    let law = ogden(U);
    for F in deformations() {
        let A = tangent(&law, &F);
        assert!((A - A.transpose()).amax() <= 1e-12 * A.amax(), "{F}");
        for column in 0..9 {
            let along = Mat3::from_fn(|i, j| f64::from(u8::from(3 * i + j == column)));
            let P = |t: f64| eval(&law, &(F + along * t)).1;
            let h = 2e-4;
            let difference = ((P(h) - P(-h)) * 8.0 - (P(2.0 * h) - P(-2.0 * h))) / (12.0 * h);
            let exact = Mat3::from_fn(|i, j| A[(3 * i + j, column)]);
            assert!(
                (difference - exact).amax() <= 1e-9 * A.amax(),
                "{F}: {:e}",
                (difference - exact).amax() / A.amax()
            );
        }
    }
}

#[test]
fn near_rest_energy_and_stress_keep_their_relative_accuracy() {
    let terms = [OgdenTerm { mu: 6.0, alpha: 2.0 }, OgdenTerm { mu: -4.0, alpha: -2.0 }];
    let ogden = Material::from(Ogden::new(&terms, U).unwrap());
    let mooney = Material::from(MooneyRivlin { c10: 3.0, c01: 2.0, volumetric: U });
    let mut random = Random(22);
    for size in [1e-2, 1e-5, 1e-8, 1e-11, 1e-14, 1e-17, 1e-25, 1e-60] {
        for gap in [1.0, 1e-6, 1e-12, 0.0] {
            let strains = Mat3::from_diagonal(&[size, size * (1.0 + gap), -2.0 * size].into());
            let R = random.rotation();
            let H = R * strains * R.transpose();
            let H = Tensor(std::array::from_fn(|i| std::array::from_fn(|j| H[(i, j)])));
            let (found, exact) = (ogden.eval_total(&H, &[]), mooney.eval_total(&H, &[]));
            assert!((found.psi - exact.psi).abs() <= 1e-13 * exact.psi, "{size} {gap}: {}", found.psi);
            let error = found.P.plus_scaled(-1.0, &exact.P);
            let (error, of) = (error.double_dot(&error).sqrt(), exact.P.double_dot(&exact.P).sqrt());
            assert!(error <= 1e-13 * of, "{size} {gap}: {error} of {of}");
        }
    }
}

#[test]
fn values_with_and_without_derivatives_have_the_same_bits() {
    let law = ogden(U);
    let mut random = Random(23);
    let random = (0..100).map(|_| random.deformation(0.6)).collect::<Vec<_>>();
    for F in deformations().iter().chain(&random) {
        let H = gradient(F);
        let lifted = Tensor(H.0.map(|row| row.map(|value| Dual { value, slope: 0.0 })));
        let (plain, dual) = (law.eval_total(&H, &[]), law.eval_total(&lifted, &[]));
        assert!(plain.psi == dual.psi.value, "{F}: {} {}", plain.psi, dual.psi.value);
        assert!(plain.P.0 == dual.P.0.map(|row| row.map(|x| x.value)), "{F}");
    }
}
