//! The stiffness bound against the eigenvalues of the exact tangent, and the bounds of the stretches.

use super::*;
use nalgebra::SMatrix;

/// The largest eigenvalue of ∂²ψ/∂F² of a law without U.
fn largest_eigenvalue(law: &Material, F: &Mat3, fibres: &[[f64; 3]]) -> f64 {
    let A = assemble_tangent(law, &gradient(F), fibres);
    SMatrix::<f64, 9, 9>::from_fn(|i, j| 0.5 * (A[i][j] + A[j][i])).symmetric_eigenvalues().max()
}

/// The bound of the law at F.
fn bound(law: &Material, F: &Mat3, fibres: &[[f64; 3]]) -> f64 {
    let k = Kinematics::new(&gradient(F));
    let inv = Invariants::new(&k);
    crate::material::with_law!(law, law => law.eval_with_bounds(&k, &inv, fibres).stiffness_bound)
}

#[test]
fn the_bound_is_never_below_the_largest_eigenvalue() {
    let mut random = Random(7);
    for law in all_laws(0.0) {
        for spread in [0.02, 0.2, 0.5, 1.0] {
            for _ in 0..60 {
                let F = random.deformation(spread);
                let own = law.fibre_directions();
                for fibres in [own, &own[..own.len().min(1)], &[]] {
                    // An orthotropic law has three axes or none.
                    if fibres.len() < own.len() && !has_matrix(&law) {
                        continue;
                    }
                    let (bound, exact) = (bound(&law, &F, fibres), largest_eigenvalue(&law, &F, fibres));
                    assert!(bound >= exact * (1.0 - 1e-10), "{law:?} at {F}: {bound} below {exact}");
                    // Inactive fibres count as active, so only the matrix can be required to be close.
                    let is_close = !fibres.is_empty() || !has_matrix(&law) || bound <= 3.0 * exact;
                    assert!(is_close, "{law:?} at {F}: {bound} {exact}");
                }
            }
        }
    }
}

#[test]
fn the_bound_is_exact_at_rest_without_fibres_and_close_near_it() {
    let mut random = Random(8);
    for law in all_laws(0.0).into_iter().filter(has_matrix) {
        let exact = largest_eigenvalue(&law, &Mat3::identity(), &[]);
        let at_rest = bound(&law, &Mat3::identity(), &[]);
        // The coupled bound omits λ < 0 and is then 2μ, as is the exact value.
        assert!((at_rest / exact - 1.0).abs() <= 1e-12, "{law:?}: {at_rest} {exact}");
        for _ in 0..20 {
            let H = random.rotation() * 0.01;
            let F = Mat3::identity() + H;
            let ratio = bound(&law, &F, &[]) / largest_eigenvalue(&law, &F, &[]);
            // A difference of two bounds is less sharp.
            let most = if matches!(law, Material::VerondaWestmann(_)) { 1.1 } else { 1.06 };
            assert!((1.0 - 1e-12..most).contains(&ratio), "{law:?}: {ratio}");
        }
    }
}

#[test]
fn the_bound_of_one_family_at_rest_is_its_stiffness_just_switched_on() {
    for law in all_laws(0.0) {
        let Material::HolzapfelGasserOgden(law) = law else { continue };
        let law = Material::HolzapfelGasserOgden(HolzapfelGasserOgden { c: 0.0, ..law });
        // An extension along the family so small that only the activation matters, and the same compression.
        let a = nalgebra::Vector3::from(FIBRES[0]);
        let F = |e: f64| Mat3::identity() + a * a.transpose() * e;
        let exact = largest_eigenvalue(&law, &F(1e-9), &FIBRES[..1]);
        // κ = 1/3 with the isochoric I1 has no stiffness at rest: E_a is quadratic there.
        assert!(exact > 0.5 || bound(&law, &F(0.0), &FIBRES[..1]) < 1e-12, "{law:?}: {exact}");
        for e in [1e-9, 0.0, -1e-9] {
            let bound = bound(&law, &F(e), &FIBRES[..1]);
            assert!((bound - exact).abs() <= 1e-7 * exact.max(1.0), "{law:?}: {bound} {exact}");
        }
    }
}

#[test]
fn the_bound_of_an_orthotropic_law_is_exact_at_rest() {
    let law = fung(Volumetric::LnSquared(0.0));
    let exact = largest_eigenvalue(&law, &Mat3::identity(), law.fibre_directions());
    let bound = bound(&law, &Mat3::identity(), law.fibre_directions());
    assert!((bound / exact - 1.0).abs() < 1e-12, "{bound} {exact}");
}

#[test]
fn bounds_of_the_stretches_are_never_below_the_true_ones() {
    let mut random = Random(9);
    for spread in [0.0, 1e-6, 0.02, 0.2, 0.5, 1.0, 1.5] {
        for _ in 0..300 {
            let F = random.deformation(spread);
            let inv = Invariants::new(&Kinematics::new(&gradient(&F)));
            let squares = F.singular_values().map(|s| s * s);
            let (largest, smallest) = (squares.max(), squares.min());
            assert!(inv.max_C >= largest * (1.0 - 1e-12) && inv.max_C <= 1.5 * largest, "{F}");
            assert!(
                inv.max_C_inverse * smallest >= 1.0 - 1e-10 && inv.max_C_inverse * smallest <= 1.5,
                "{F}"
            );
            assert!(
                (inv.trace_C_inverse * smallest - squares.map(|s| smallest / s).sum()).abs() < 1e-9,
                "{F}"
            );
        }
    }
}
