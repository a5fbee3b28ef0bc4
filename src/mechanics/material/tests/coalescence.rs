//! Ogden's law where principal stretches coincide, and close to that.

use super::*;
use nalgebra::SMatrix;

const U: Volumetric = Volumetric::LnSquared(40.0);

/// Deformations with two and three equal principal stretches, exactly and nearly, rotated.
fn deformations() -> Vec<Mat3> {
    let mut uniform = Uniform(21);
    let mut all = vec![Mat3::identity()];
    for gap in [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3] {
        for [a, b] in [[1.0, 1.0], [1.4, 0.8], [0.6, 1.5], [2.0, 0.5]] {
            let stretches = [a, a * (1.0 + gap), b * (1.0 - 0.3 * gap)];
            let plain = Mat3::from_diagonal(&stretches.into());
            all.extend([plain, uniform.rotation() * plain * uniform.rotation()]);
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
