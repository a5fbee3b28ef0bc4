//! Laws against their closed forms in principal stretches, and fibres against the definition of their energy.

use super::*;

/// Uniaxial, equibiaxial and planar tension and compression, and a state with three stretches, all isochoric.
fn states() -> Vec<[f64; 3]> {
    let of = |l: f64| [[l, l.powf(-0.5), l.powf(-0.5)], [l, l, l.powi(-2)], [l, 1.0, 1.0 / l]];
    let mut states: Vec<[f64; 3]> = [0.6, 0.9, 1.05, 1.4, 2.0].into_iter().flat_map(of).collect();
    states.push([1.5, 0.8, 1.0 / 1.2]);
    states
}

/// τ1 − τ3 and τ2 − τ3 of the principal Kirchhoff stresses [Pa], independent of pressure.
fn differences(law: &Material, stretches: [f64; 3]) -> [f64; 2] {
    let (_, P) = eval(law, &Mat3::from_diagonal(&stretches.into()));
    let tau = [0, 1, 2].map(|i| P[(i, i)] * stretches[i]);
    [tau[0] - tau[2], tau[1] - tau[2]]
}

/// Compares the derivatives of the energy by ln λ with `tau`, and the energy with `psi`.
fn check(law: impl Into<Material>, tau: impl Fn(f64, [f64; 3]) -> f64, psi: impl Fn([f64; 3]) -> f64) {
    let law = law.into();
    for stretches in states() {
        let exact = stretches.map(|l| tau(l, stretches));
        let scale = exact.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
        for (found, i) in differences(&law, stretches).into_iter().zip([0, 1]) {
            assert!(
                (found - (exact[i] - exact[2])).abs() <= 1e-12 * scale,
                "{law:?} at {stretches:?}: {found}"
            );
        }
        let (found, exact) = (eval(&law, &Mat3::from_diagonal(&stretches.into())).0, psi(stretches));
        assert!((found / exact - 1.0).abs() <= 1e-11, "{law:?} at {stretches:?}: {found} {exact}");
    }
}

fn sum(stretches: [f64; 3], power: f64) -> f64 {
    stretches.iter().map(|l| l.powf(power)).sum()
}

const U: Volumetric = Volumetric::LnSquared(40.0);

#[test]
fn yeoh() {
    let (c10, c20, c30) = (3.0, -0.2, 0.05);
    let law = Yeoh { c10, c20, c30, volumetric: U };
    let x = |s| sum(s, 2.0) - 3.0;
    let slope = |x: f64| c10 + 2.0 * c20 * x + 3.0 * c30 * x * x;
    check(law, |l, s| 2.0 * l * l * slope(x(s)), |s| c10 * x(s) + c20 * x(s).powi(2) + c30 * x(s).powi(3));
}

#[test]
fn demiray() {
    let (mu, b) = (5.0, 0.7);
    let e = |s: [f64; 3]| b * (sum(s, 2.0) - 3.0);
    check(
        Demiray { mu, b, volumetric: U },
        |l, s| mu * e(s).exp() * l * l,
        |s| mu / (2.0 * b) * e(s).exp_m1(),
    );
}

#[test]
fn veronda_westmann() {
    let (c1, c2) = (2.0, 1.5);
    let e = |s: [f64; 3]| c2 * (sum(s, 2.0) - 3.0);
    let tau = |l: f64, s| c1 * c2 * (2.0 * e(s).exp() * l * l + l.powi(-2));
    let psi = |s| c1 * e(s).exp_m1() - 0.5 * c1 * c2 * (sum(s, -2.0) - 3.0);
    check(VerondaWestmann { c1, c2, volumetric: U }, tau, psi);
}

#[test]
fn ogden_of_fractional_large_and_negative_powers() {
    let terms = [(3.0, 1.3), (0.01, 8.0), (-0.5, -2.0), (-1e-4, -15.0)];
    let law = Ogden::new(&terms.map(|(mu, alpha)| OgdenTerm { mu, alpha }), U).unwrap();
    let tau = |l: f64, _| terms.iter().map(|(mu, alpha)| mu * l.powf(*alpha)).sum();
    check(law, tau, |s| terms.iter().map(|(mu, alpha)| mu / alpha * (sum(s, *alpha) - 3.0)).sum());
    assert!(Ogden::new(&[OgdenTerm::default(); MAX_OGDEN_TERMS + 1], U).is_none());
}

#[test]
fn blatz_ko_in_uniaxial_stress() {
    // P/μ = λ^(−1/2) − λ^(−3)
    let law = BlatzKo { mu: 3.0 }.into();
    let exact = [(0.5, -6.585_786_44), (0.7, -1.720_223_29), (1.5, 0.520_200_285), (2.0, 0.582_106_781)];
    for (stretch, P) in exact {
        let point = eval_path(&law, &[], Path::Uniaxial, &[stretch]).unwrap()[0];
        assert!((point.stress.P[(0, 0)] / 3.0 - P).abs() < 1e-8, "{stretch}: {point:?}");
        assert!((point.F[(1, 1)] - stretch.powf(-0.25)).abs() < 1e-10);
    }
}

#[test]
fn blatz_ko_of_a_general_state() {
    let law = BlatzKo { mu: 3.0 }.into();
    let s: [f64; 3] = [1.3, 0.7, 0.9];
    let J: f64 = s.iter().product();
    let (psi, P) = eval(&law, &Mat3::from_diagonal(&s.into()));
    assert!((psi - 1.5 * (sum(s, -2.0) + 2.0 * J - 5.0)).abs() < 1e-14);
    for i in 0..3 {
        assert!((P[(i, i)] - 3.0 * (J / s[i] - s[i].powi(-3))).abs() < 1e-14);
    }
}

#[test]
fn fibres_of_weiss_follow_their_definition() {
    let (c3, c4, c5, lambda_m) = (0.6, 9.0, 20.0, 1.2);
    let fibres = StraighteningFibres::new(c3, c4, c5, lambda_m);
    let families = FibreFamilies::new(&[[1.0, 0.0, 0.0]]).unwrap();
    let volumetric = Volumetric::LnSquared(0.0);
    let law = Material::from(Weiss { c10: 0.0, c01: 0.0, fibres, families, i4: I4Form::Full, volumetric });
    let toe = |l: f64| c3 * (c4 * (l - 1.0)).exp_m1();
    let tension = |l: f64| match l {
        l if l <= 1.0 => 0.0,
        l if l <= lambda_m => toe(l),
        l => toe(lambda_m) + c5 * (l - lambda_m),
    };
    for stretch in [0.7, 1.0, 1.05, 1.2, 1.21, 1.6, 3.0] {
        let (psi, P) = eval(&law, &Mat3::from_diagonal(&[stretch, 0.9, 1.1].into()));
        assert!(
            (P[(0, 0)] * stretch - tension(stretch)).abs() <= 1e-13 * tension(stretch).max(1.0),
            "{stretch}"
        );
        // ∫ λW′/λ dλ by Simpson's rule, piecewise up to and beyond the toe.
        let simpson = |from: f64, to: f64| {
            let (n, h) = (2000, (to - from) / 2000.0);
            let weight = |i: i32| if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            let at = |i: i32| from + h * f64::from(i);
            (0..=n).map(|i| weight(i) * tension(at(i)) / at(i)).sum::<f64>() * h / 3.0
        };
        let energy = simpson(1.0, stretch.clamp(1.0, lambda_m)) + simpson(lambda_m, stretch.max(lambda_m));
        assert!((psi - energy).abs() <= 1e-11 * energy, "{stretch}: {psi} {energy}");
    }
}

#[test]
fn the_toe_s_series_holds_at_its_limits() {
    for (c4, lambda_m) in [(MOST_TOE_EXPONENT / 0.5, MOST_TOE_STRETCH), (400.0, 1.025), (0.1, 1.5)] {
        let fibres = StraighteningFibres::new(1.0, c4, 0.0, lambda_m);
        let families = FibreFamilies::new(&[[1.0, 0.0, 0.0]]).unwrap();
        let volumetric = Volumetric::LnSquared(0.0);
        let law =
            Material::from(Weiss { c10: 0.0, c01: 0.0, fibres, families, i4: I4Form::Full, volumetric });
        let h = 1e-4 * (lambda_m - 1.0);
        for fraction in [0.1, 0.5, 0.9] {
            let stretch = 1.0 + fraction * (lambda_m - 1.0);
            let psi = |l: f64| eval(&law, &Mat3::from_diagonal(&[l, 1.0, 1.0].into())).0;
            let (d1, d2) =
                (psi(stretch + h) - psi(stretch - h), psi(stretch + 2.0 * h) - psi(stretch - 2.0 * h));
            let slope = (8.0 * d1 - d2) / (12.0 * h);
            let P = (c4 * (stretch - 1.0)).exp_m1() / stretch;
            assert!((slope / P - 1.0).abs() < 1e-8, "{c4} {stretch}: {slope} {P}");
        }
    }
}

#[test]
fn balzani_is_a_power_of_the_invariants_and_off_below() {
    let F = Mat3::new(1.2, 0.3, -0.1, 0.05, 0.9, 0.2, 0.1, -0.15, 1.05);
    let law = balzani(3.0, Volumetric::LnSquared(0.0));
    let isochoric = law.eval_total(&gradient(&F), &[]).psi;
    let C = F.transpose() * F;
    let mut expected = isochoric;
    let mut is_on = [false; 2];
    for (a, is_on) in FIBRES.map(nalgebra::Vector3::from).into_iter().zip(&mut is_on) {
        let x = C.trace() * a.dot(&(C * a)) - a.dot(&(C * C * a)) - 2.0;
        expected += 4.0 * x.max(0.0).powi(3);
        *is_on = x > 0.1;
    }
    let (psi, _) = eval(&law, &F);
    assert!(is_on == [true, true] && (psi / expected - 1.0).abs() < 1e-13, "{psi} {expected}");
    let crushed = gradient(&(F * 0.8));
    assert_eq!(law.eval_total(&crushed, &FIBRES).psi, law.eval_total(&crushed, &[]).psi);
}

#[test]
fn fung_is_its_exponential_of_the_isochoric_strain() {
    let law = fung(U);
    let F = Mat3::new(1.2, 0.3, -0.1, 0.05, 0.9, 0.2, 0.1, -0.15, 1.05);
    let J = F.determinant();
    let E = (F.transpose() * F * J.powf(-2.0 / 3.0) - Mat3::identity()) * 0.5;
    // The compliance of E1, E2, E3 = 12, 8, 5 and ν12, ν23, ν31 = 0.3, 0.2, 0.1
    let (s12, s23, s31) = (-0.3 / 12.0, -0.2 / 8.0, -0.1 / 5.0);
    let compliance = Mat3::new(1.0 / 12.0, s12, s31, s12, 1.0 / 8.0, s23, s31, s23, 1.0 / 5.0);
    let normal = nalgebra::Vector3::new(E[(0, 0)], E[(1, 1)], E[(2, 2)]);
    let shear = 3.0 * E[(0, 1)].powi(2) + 2.0 * E[(1, 2)].powi(2) + 4.0 * E[(0, 2)].powi(2);
    let Q = (normal.dot(&(compliance.try_inverse().unwrap() * normal)) + 4.0 * shear) / 6.0;
    let expected = 3.0 * Q.exp_m1() + U.energy(J - 1.0);
    let (psi, _) = eval(&law, &F);
    assert!((psi / expected - 1.0).abs() < 1e-13, "{psi} {expected}");
    let unstable = OrthotropicModuli { young: [1.0; 3], shear: [1.0; 3], poisson: [0.6; 3] };
    assert!(FungOrthotropic::new(1.0, &unstable, U).is_none());
}

#[test]
fn peng_guo_moran_resists_shear_of_fibres_against_the_matrix() {
    let shear = FibreShear { gamma: 6.0, beta: 12.0, stretch: 1.1 };
    let f = |stretch: f64| 6.0 / (1.0 + (-12.0 * (stretch - 1.1)).exp());
    let energy = |a: [f64; 3], F: &Mat3| {
        let families = FibreFamilies::new(&[a]).unwrap();
        let law = PengGuoMoran {
            c10: 2.0,
            fibre: [1.5, 0.7],
            shear,
            families,
            volumetric: Volumetric::LnSquared(0.0),
        };
        let response = Material::from(law).eval_total(&gradient(F), &[a]);
        response.psi
            - Material::from(NeoHookean { c10: 2.0, volumetric: law.volumetric })
                .eval_total(&gradient(F), &[])
                .psi
    };
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for gamma in [1e-3, 0.2, 0.9] {
        // x += γ y: a fibre along x is turned against its normal plane, unstretched; one along y is stretched, too.
        let F = Mat3::new(1.0, gamma, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let (g2, g4) = (gamma * gamma, f64::powi(gamma, 4));
        let across = f(1.0) * g4;
        let along = 1.5 * g4 + 0.7 * g4 * g4 + f((1.0 + g2).sqrt()) * g4;
        // ψ of the matrix, 2 γ², is subtracted.
        for (found, exact) in [(energy(x, &F), across), (energy(y, &F), along)] {
            assert!((found - exact).abs() < 1e-12 * exact + 1e-15 * g2, "{gamma}: {found} {exact}");
        }
    }
    // Stretched along and across, a fibre stays normal to its plane.
    let F = Mat3::from_diagonal(&[1.3, 0.8, 1.1].into());
    assert!((energy(x, &F) - (1.5 * 0.69_f64.powi(2) + 0.7 * 0.69_f64.powi(4))).abs() < 1e-12);
    assert!(energy(y, &F).abs() < 1e-13);
}
