//! ψ and P: stress-free at rest, P = ∂ψ/∂F, objectivity, symmetries, energy near rest.

use super::*;
use crate::dual::Dual;
use nalgebra::SMatrix;

/// Fourth-order central difference of `f` at 0, step `h`.
fn central_difference(h: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

#[test]
fn every_law_is_exactly_free_of_stress_and_energy_at_rest() {
    for law in all_laws(1e9) {
        let (psi, P) = eval(&law, &Mat3::identity());
        assert!(psi == 0.0 && P.iter().all(|p| *p == 0.0), "{law:?}: {psi} {P}");
    }
}

#[test]
fn stress_is_the_derivative_of_the_energy_by_dual_numbers() {
    let mut random = Random(1);
    for law in all_laws(40.0) {
        for _ in 0..20 {
            let (F, dF) = (random.deformation(0.5), random.deformation(1.0));
            let H = gradient(&F);
            let lifted = Tensor::from_fn(|i, j| Dual { value: H.0[i][j], slope: dF[(i, j)] });
            let lifted_fibre = |a: &[f64; 3]| a.map(|value| Dual { value, slope: 0.0 });
            let fibres: Vec<_> = law.fibre_directions().iter().map(lifted_fibre).collect();
            let slope = law.eval_total(&lifted, &fibres).psi.slope;
            let (psi, P) = eval(&law, &F);
            let scale = P.norm() * dF.norm() + psi;
            assert!((P.dot(&dF) - slope).abs() <= 1e-12 * scale, "{law:?} at {F}: {} {slope}", P.dot(&dF));
        }
    }
}

#[test]
fn stress_and_tangent_agree_with_central_differences() {
    let mut random = Random(2);
    for law in all_laws(40.0) {
        for _ in 0..20 {
            let (F, dF) = (random.deformation(0.4), random.deformation(0.5).normalize());
            let at = |t: f64| eval(&law, &(F + dF * t));
            let (psi, P) = at(0.0);
            let A = tangent_along(&law, &gradient(&F), law.fibre_directions(), &Tensor::from(&dF));
            let A = Mat3::from(&A);
            let by_difference = central_difference(2e-4, |t| at(t).0);
            assert!((P.dot(&dF) - by_difference).abs() <= 1e-9 * (P.norm() + psi), "{law:?} at {F}");
            // The tangent jumps where a family is switched: there a difference is meaningless.
            let strains = [-5e-4, 5e-4].map(|t| is_on(&law, &(F + dF * t)));
            if strains[0] == strains[1] {
                let by_difference = Mat3::from_fn(|i, j| central_difference(2e-4, |t| at(t).1[(i, j)]));
                let error = (A - by_difference).norm();
                assert!(error <= 1e-8 * (A.norm() + P.norm()), "{law:?} at {F}: {error} of {}", A.norm());
            }
        }
    }
}

/// Which families are active, by the energy that each adds.
fn is_on(law: &Material, F: &Mat3) -> Vec<bool> {
    let alone =
        |a: &[f64; 3]| law.eval_total(&gradient(F), &[*a]).psi > law.eval_total(&gradient(F), &[]).psi;
    law.fibre_directions().iter().map(alone).collect()
}

#[test]
fn a_rotation_turns_the_stress_with_it() {
    let mut random = Random(3);
    for law in all_laws(40.0) {
        for _ in 0..20 {
            let (F, Q) = (random.deformation(0.6), random.rotation());
            let (psi, P) = eval(&law, &F);
            let (psi_turned, P_turned) = eval(&law, &(Q * F));
            assert!((psi_turned - psi).abs() <= 1e-11 * psi, "{law:?}: {psi} {psi_turned}");
            assert!((P_turned - Q * P).norm() <= 1e-11 * P.norm(), "{law:?}: {P} {P_turned}");
            let cauchy = P * F.transpose();
            assert!((cauchy - cauchy.transpose()).norm() <= 1e-12 * cauchy.norm(), "{law:?}");
        }
    }
}

#[test]
fn reflections_that_map_the_families_onto_themselves_change_nothing() {
    let mut random = Random(4);
    for law in all_laws(40.0) {
        for mirror in [[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
            let Q = Mat3::from_diagonal(&mirror.into());
            let F = random.deformation(0.6);
            let (psi, P) = eval(&law, &F);
            // J must stay positive: reflect the reference and the space.
            let (psi_mirrored, P_mirrored) = eval(&law, &(Q * F * Q));
            assert!((psi_mirrored - psi).abs() <= 1e-12 * psi, "{law:?}");
            assert!((P_mirrored - Q * P * Q).norm() <= 1e-12 * P.norm(), "{law:?}");
        }
    }
}

#[test]
fn a_law_without_fibres_is_isotropic() {
    let mut random = Random(5);
    for law in all_laws(40.0) {
        let (F, Q) = (random.deformation(0.6), random.rotation());
        let P = Mat3::from(&law.eval_total(&gradient(&F), &[]).P);
        let turned = Mat3::from(&law.eval_total(&gradient(&(F * Q)), &[]).P);
        assert!((turned - P * Q).norm() <= 1e-11 * P.norm(), "{law:?}");
    }
}

#[test]
fn the_tangent_has_major_symmetry() {
    let mut random = Random(6);
    for law in all_laws(40.0) {
        for _ in 0..10 {
            let A = assemble_tangent(&law, &gradient(&random.deformation(0.6)), law.fibre_directions());
            let A = SMatrix::<f64, 9, 9>::from_fn(|i, j| A[i][j]);
            assert!((A - A.transpose()).amax() <= 1e-12 * A.amax(), "{law:?}");
        }
    }
}

#[test]
fn the_tangent_at_rest_is_that_of_linear_elasticity() {
    let strain = Mat3::new(0.3, 0.1, -0.2, 0.1, -0.4, 0.25, -0.2, 0.25, 0.6);
    for law in all_laws(40.0).into_iter().filter(has_matrix) {
        let (G, K) = law.moduli_at_rest();
        let A = Mat3::from(&tangent_along(&law, &Tensor::diagonal(0.0), &[], &Tensor::from(&strain)));
        let expected = strain * (2.0 * G) + Mat3::identity() * ((K - 2.0 / 3.0 * G) * strain.trace());
        assert!((A - expected).norm() <= 1e-13 * expected.norm(), "{law:?}: {A} {expected}");
    }
}

#[test]
fn a_tiny_strain_keeps_the_digits_of_its_energy() {
    let strain = Mat3::new(0.3, 0.1, -0.2, 0.1, -0.4, 0.25, -0.2, 0.25, 0.6);
    for law in all_laws(40.0).into_iter().filter(has_matrix) {
        let (G, K) = law.moduli_at_rest();
        let h = 1e-9;
        // Half quadratic form of the tangent at rest; the cubic terms are of relative order h.
        let deviator = strain - Mat3::identity() * (strain.trace() / 3.0);
        let expected = h * h * (G * deviator.norm_squared() + 0.5 * K * strain.trace().powi(2));
        let psi = law.eval_total(&Tensor::from(&(strain * h)), &[]).psi;
        assert!((psi - expected).abs() <= 20.0 * h * expected, "{law:?}: {psi} {expected}");
    }
}

#[test]
fn a_family_in_compression_adds_nothing() {
    // κ = 1/3 with the isochoric I1 is never in compression: Ī1 ≥ 3.
    let never_off = hgo(1.0 / 3.0, I4Form::Isochoric, MatrixForm::Isochoric, Volumetric::QuadraticLn(40.0));
    assert!(is_on(&never_off, &Mat3::from_diagonal(&[0.8, 0.9, 0.95].into())) == [true, true]);
    let can_be_off = |law: &Material| match law {
        Material::HolzapfelGasserOgden(law) => law.kappa < 0.3 || law.i4 == I4Form::Full,
        Material::Weiss(_) => true,
        _ => false,
    };
    for law in all_laws(40.0).into_iter().filter(can_be_off) {
        let F = Mat3::from_diagonal(&[0.8, 0.9, 0.95].into());
        let r = law.eval_total(&gradient(&F), &FIBRES);
        let without = law.eval_total(&gradient(&F), &[]);
        assert!(r.psi == without.psi && Mat3::from(&r.P) == Mat3::from(&without.P), "{law:?}");
    }
}

#[test]
fn an_overstretched_exponential_is_reported_and_stays_finite() {
    let has_exponential = |law: &Material| {
        matches!(
            law,
            Material::HolzapfelGasserOgden(_)
                | Material::FungOrthotropic(_)
                | Material::Demiray(_)
                | Material::VerondaWestmann(_)
        )
    };
    let mut reported_laws = 0;
    for law in all_laws(40.0) {
        let fibres = law.fibre_directions();
        let fine = Mat3::from_diagonal(&[1.2, 0.9, 0.9].into());
        assert_eq!(law.overstretch(&gradient(&fine), fibres), None, "{law:?}");
        for stretch in [20.0, 1e2, 1e3] {
            let F = Mat3::from_diagonal(&[stretch, stretch, 1.0 / (stretch * stretch)].into());
            let overstretched = law.overstretch(&gradient(&F), fibres);
            assert_eq!(overstretched.is_some(), has_exponential(&law), "{law:?}");
            // For a law without fibres it is a bound.
            let excess = overstretched.map_or(0.0, |overstretched| overstretched / stretch - 1.0);
            let most = if fibres.is_empty() { 0.2 } else { 1e-12 };
            assert!(excess > -1e-12 && excess < most, "{law:?}: {excess}");
            let (psi, P) = eval(&law, &F);
            assert!(psi.is_finite() && P.iter().all(|p| p.is_finite()), "{law:?} at {stretch}: {psi} {P}");
            reported_laws += usize::from(overstretched.is_some());
        }
    }
    assert_eq!(reported_laws, 3 * (12 + 3));
}

#[test]
fn energy_and_stress_are_continuous_at_the_exponent_limit() {
    let Material::HolzapfelGasserOgden(law) =
        hgo(0.0, I4Form::Full, MatrixForm::Coupled, Volumetric::Quadratic(1.0))
    else {
        unreachable!("hgo() makes that law")
    };
    // One family along x: E = λ² − 1, so the limit is at λ² = 1 + √(200/k2).
    let at = |E: f64| {
        let F = Mat3::from_diagonal(&[(1.0 + E).sqrt(), 1.0, 1.0].into());
        Material::HolzapfelGasserOgden(law).eval_total(&gradient(&F), &[[1.0, 0.0, 0.0]])
    };
    let E = (FIBRE_EXPONENT_LIMIT / law.k2).sqrt();
    let h = 1e-10;
    let (below, above) = (at(E - h), at(E + h));
    assert!((above.psi - below.psi).abs() <= 1e-6 * below.psi);
    assert!((above.P.0[0][0] - below.P.0[0][0]).abs() <= 1e-6 * below.P.0[0][0]);
    // far beyond it the stress is still the derivative of the energy
    let slope = central_difference(1e-3, |t| at(2.0 * E + t).psi);
    let F11 = (1.0 + 2.0 * E).sqrt();
    let P11 = at(2.0 * E).P.0[0][0];
    assert!((slope * 2.0 * F11 - P11).abs() <= 1e-9 * P11);
}

#[test]
fn a_vanishing_fibre_exponent_is_the_quadratic_law() {
    let families = FibreFamilies::new(&[[1.0, 0.0, 0.0]]).unwrap();
    let law = HolzapfelGasserOgden {
        c: 0.0,
        k1: 7.0,
        k2: 0.0,
        kappa: 0.0,
        families,
        i4: I4Form::Full,
        matrix: MatrixForm::Isochoric,
        volumetric: Volumetric::Quadratic(0.0),
    };
    let F = Mat3::from_diagonal(&[1.3, 1.0, 1.0].into());
    let r = Material::HolzapfelGasserOgden(law).eval_total(&gradient(&F), families.directions());
    let E = 1.3 * 1.3 - 1.0;
    assert!((r.psi - 3.5 * E * E).abs() <= 1e-14 * r.psi);
    assert!((r.P.0[0][0] - 14.0 * E * 1.3).abs() <= 1e-14 * r.P.0[0][0]);
}
