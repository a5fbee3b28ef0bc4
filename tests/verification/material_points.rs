//! Constitutive laws at a point: FEBio's numbers, and the incompressible and compressible closed forms.

use crate::record::{assert_at_most, assert_close};
use contuse::mechanics::material::{
    CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, MooneyRivlin,
    Ogden, OgdenTerm, Path, PathPoint, Volumetric, eval_path, eval_point, tangent_along,
};
use contuse::mechanics::tensor::{Mat3, Tensor};
use serde_json::Value;

/// Two families at ±`degrees` to x in the plane x, y.
fn families_at(degrees: f64) -> FibreFamilies {
    let (s, c) = degrees.to_radians().sin_cos();
    FibreFamilies::new(&[[c, s, 0.0], [c, -s, 0.0]]).unwrap()
}

// --- FEBio -----------------------------------------------------------------------------------------------------

/// A set of the reference file as the law that it is.
fn law_of_set(set: &Value) -> Material {
    let p = |name: &str| set["params"][name].as_f64().unwrap();
    let hgo = |i4, matrix, volumetric| {
        Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
            c: p("c"),
            k1: p("k1"),
            k2: p("k2"),
            kappa: p("kappa"),
            families: families_at(p("gamma")),
            i4,
            matrix,
            volumetric,
        })
    };
    match set["febio_type"].as_str().unwrap() {
        "Mooney-Rivlin" => {
            let volumetric = Volumetric::LnSquared(p("k"));
            Material::MooneyRivlin(MooneyRivlin { c10: p("c1"), c01: p("c2"), volumetric })
        }
        "Ogden" => {
            let term = |c: &str, m: &str| OgdenTerm { mu: p(c) / p(m), alpha: p(m) };
            let terms = [term("c1", "m1"), term("c2", "m2")];
            Ogden::new(&terms, Volumetric::LnSquared(p("k"))).unwrap().into()
        }
        "neo-Hookean" => {
            let (E, nu) = (p("E"), p("v"));
            let lambda = nu * E / ((1.0 + nu) * (1.0 - 2.0 * nu));
            Material::CoupledNeoHookean(CoupledNeoHookean { mu: E / (2.0 * (1.0 + nu)), lambda })
        }
        // Its "default" pressure model is the (ln J)² of the other materials; without the parameter, Abaqus's.
        "Holzapfel-Gasser-Ogden" if set["params"]["pressure_model"] == "default" => {
            hgo(I4Form::Isochoric, MatrixForm::Isochoric, Volumetric::LnSquared(p("k")))
        }
        "Holzapfel-Gasser-Ogden" => {
            hgo(I4Form::Isochoric, MatrixForm::Isochoric, Volumetric::QuadraticLn(p("k")))
        }
        "HGO unconstrained" => hgo(I4Form::Full, MatrixForm::Coupled, Volumetric::QuadraticLn(p("k"))),
        other => panic!("no law for {other}"),
    }
}

/// The Cauchy stress of a case.
fn cauchy_of(case: &Value) -> Mat3 {
    let s = |name: &str| case["cauchy_Pa"][name].as_f64().unwrap();
    Mat3::new(s("xx"), s("xy"), s("xz"), s("xy"), s("yy"), s("yz"), s("xz"), s("yz"), s("zz"))
}

#[test]
fn febio_material_reference() {
    let text = include_str!("../data/material_reference.json");
    let reference: Value = serde_json::from_str(text).unwrap();
    let mut cases = 0;
    for set in reference["materials"].as_array().unwrap() {
        let law = law_of_set(set);
        for case in set["cases"].as_array().unwrap() {
            let what = format!("{} {}", set["name"], case["case"]);
            let F = Mat3::from_fn(|i, j| case["F"][i][j].as_f64().unwrap());
            let point = eval_point(&law, &F).unwrap();
            // The file has 12 digits, and strains formed from nodal positions.
            let expected = cauchy_of(case);
            let error = (point.cauchy - expected).amax() / expected.amax();
            assert_at_most(error, 1e-11, "stress of other codes' cases, error over its size");
            assert_close(point.psi, case["sed_J_per_m3"].as_f64().unwrap(), 1e-11, &what);
            cases += 1;
        }
    }
    assert_eq!(cases, 29);
}

// --- Incompressible closed forms: p is eliminated by differences of principal Cauchy stresses ---------------------

/// Principal Cauchy stresses but for the pressure of diag(`stretches`), det = 1, and their change along diag(`along`).
fn principal_stresses(law: &Material, stretches: [f64; 3], along: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let F = Mat3::from_diagonal(&stretches.into());
    let dF = Mat3::from_diagonal(&along.into());
    let (H, fibres) = (Tensor::from(&(F - Mat3::identity())), law.fibre_directions());
    let P = law.eval_total(&H, fibres).P;
    let dP = tangent_along(law, &H, fibres, &Tensor::from(&dF));
    let sigma = std::array::from_fn(|i| P.0[i][i] * stretches[i]);
    let change = std::array::from_fn(|i| dP.0[i][i] * stretches[i] + P.0[i][i] * along[i]);
    (sigma, change)
}

/// Uniaxial stress of an incompressible law along the axis `pulled`: (σ, the two lateral stretches), the lateral
/// condition σ_b = σ_c solved by Newton's method on the exact tangent, loading in small steps from rest.
fn incompressible_uniaxial(law: &Material, pulled: usize, stretch: f64) -> (f64, [f64; 2]) {
    let (b, c) = ((pulled + 1) % 3, (pulled + 2) % 3);
    let mut lateral = 1.0;
    let mut sigma = [0.0; 3];
    let steps = 200;
    for step in 1..=steps {
        let pull = 1.0 + (stretch - 1.0) * f64::from(step) / f64::from(steps);
        for _ in 0..30 {
            let (mut stretches, mut along) = ([0.0; 3], [0.0; 3]);
            (stretches[pulled], stretches[b], stretches[c]) = (pull, lateral, 1.0 / (pull * lateral));
            (along[b], along[c]) = (1.0, -1.0 / (pull * lateral * lateral));
            let change;
            (sigma, change) = principal_stresses(law, stretches, along);
            let correction = (sigma[b] - sigma[c]) / (change[b] - change[c]);
            lateral -= correction;
            if correction.abs() < 1e-14 {
                break;
            }
        }
    }
    (sigma[pulled] - sigma[c], [lateral, 1.0 / (stretch * lateral)])
}

/// An incompressible tissue: no U(J), which the pressure replaces.
fn incompressible_hgo(c: f64, k1: f64, k2: f64, kappa: f64, degrees: f64) -> Material {
    Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
        c,
        k1,
        k2,
        kappa,
        families: families_at(degrees),
        i4: I4Form::Full,
        matrix: MatrixForm::Isochoric,
        volumetric: Volumetric::Quadratic(0.0),
    })
}

#[test]
fn mooney_rivlin_incompressible_uniaxial() {
    let (c10, c01) = (0.55, 0.138);
    let law = Material::MooneyRivlin(MooneyRivlin { c10, c01, volumetric: Volumetric::Quadratic(0.0) });
    for (stretch, printed) in [(0.5, -2.891), (0.8, -0.88145), (1.5, 2.033), (2.0, 4.333)] {
        let (sigma, _) = incompressible_uniaxial(&law, 0, stretch);
        let closed = 2.0 * (stretch * stretch - 1.0 / stretch) * (c10 + c01 / stretch);
        assert_close(sigma, closed, 1e-13, "closed form");
        assert_close(sigma, printed, 1e-12, "printed");
    }
}

#[test]
fn holzapfel_gasser_ogden_incompressible_uniaxial() {
    let law = incompressible_hgo(3.0, 2.3632, 0.8393, 0.0, 29.0);
    let (sigma, [lateral, thickness]) = incompressible_uniaxial(&law, 0, 1.1);
    assert_close(sigma, 1.922_928_66, 3e-9, "σ at 1.1");
    assert_close(lateral, 0.931_578_842, 1e-9, "λ2 at 1.1");
    assert_close(thickness, 0.975_860_408, 1e-9, "λ3 at 1.1");
    for (stretch, expected) in [(1.2, 4.657_424_37), (1.5, 27.895_374_6), (2.0, 2_229.715_41)] {
        assert_close(incompressible_uniaxial(&law, 0, stretch).0, expected, 3e-9, "σ");
    }
}

#[test]
fn holzapfel_gasser_ogden_incompressible_equibiaxial() {
    let law = incompressible_hgo(3.0, 2.3632, 0.8393, 0.0, 29.0);
    for (stretch, expected) in [(1.1, [3.487_641_56, 2.166_803_91]), (1.3, [16.593_656_4, 7.883_097_53])] {
        let thickness = 1.0 / (stretch * stretch);
        let (sigma, _) = principal_stresses(&law, [stretch, stretch, thickness], [0.0; 3]);
        assert_close(sigma[0] - sigma[2], expected[0], 3e-9, "along the mean of the families");
        assert_close(sigma[1] - sigma[2], expected[1], 3e-9, "across it");
    }
}

#[test]
fn gasser_ogden_holzapfel_dispersed_uniaxial() {
    let law = incompressible_hgo(7.64, 996.6, 524.6, 0.226, 49.98);
    let circumferential = [(1.05, 1.421_135_49), (1.10, 4.069_789_9), (1.15, 12.655_758_7)];
    let axial = [(1.05, 4.727_257_43), (1.10, 27.025_877_1), (1.15, 150.542_255)];
    for (axis, rows) in [(0, circumferential), (1, axial)] {
        for (stretch, expected) in rows {
            let (sigma, _) = incompressible_uniaxial(&law, axis, stretch);
            assert_close(sigma, expected, 5e-9, &format!("axis {axis} at {stretch}"));
        }
    }
}

// --- Full against isochoric I4 (Helfenstein 2010; Nolan 2014) --------------------------------------------------------

/// One family along x in a compressible matrix of μ = 3.
fn one_family_along_x(k1: f64, k2: f64, i4: I4Form, volumetric: Volumetric) -> Material {
    let families = FibreFamilies::new(&[[1.0, 0.0, 0.0]]).unwrap();
    let matrix = MatrixForm::Isochoric;
    let law = HolzapfelGasserOgden { c: 3.0, k1, k2, kappa: 0.0, families, i4, matrix, volumetric };
    Material::HolzapfelGasserOgden(law)
}

/// The uniaxial path of such a law, K = 30.
fn uniaxial_path(i4: I4Form, stretches: &[f64]) -> Vec<PathPoint> {
    let law = one_family_along_x(10.0, 1.0, i4, Volumetric::Quadratic(30.0));
    eval_path(&law, law.fibre_directions(), Path::Uniaxial, stretches).unwrap()
}

#[test]
fn full_against_isochoric_i4_uniaxial() {
    let full = uniaxial_path(I4Form::Full, &[1.2, 1.4]);
    assert_close(full[0].stress.P[(0, 0)], 14.274_149, 5e-8, "full, 1.2");
    assert_close(full[0].F.determinant(), 1.019_08, 5e-6, "full, J at 1.2");
    assert_close(full[1].stress.P[(0, 0)], 70.104_338, 1e-8, "full, 1.4");
    let isochoric = uniaxial_path(I4Form::Isochoric, &[1.2, 1.4]);
    assert_close(isochoric[0].stress.P[(0, 0)], 9.664_992, 1e-7, "isochoric, 1.2");
    assert_close(isochoric[0].F.determinant(), 1.115_52, 5e-6, "isochoric, J at 1.2");
    assert_close(isochoric[1].stress.P[(0, 0)], 24.952_105, 5e-8, "isochoric, 1.4");
    assert_close(isochoric[1].F.determinant(), 1.298_84, 5e-6, "isochoric, J at 1.4");
}

#[test]
fn pure_dilatation_stretches_a_fibre_only_with_the_full_i4() {
    let F = Mat3::identity() * 1.1;
    let no_bulk = Volumetric::Quadratic(0.0);
    for (k1, k2, expected) in [(2.3632, 0.8393, 0.936_335_913_714), (10.0, 1.0, 3.990_331_641)] {
        let full = eval_point(&one_family_along_x(k1, k2, I4Form::Full, no_bulk), &F).unwrap();
        assert_close(full.cauchy[(0, 0)], expected, 2e-10, "along the fibre");
        assert_at_most(full.cauchy[(1, 1)], 1e-14, "across the fibre");
        let isochoric = eval_point(&one_family_along_x(k1, k2, I4Form::Isochoric, no_bulk), &F).unwrap();
        assert_at_most(isochoric.cauchy.amax(), 1e-14, "with the isochoric form");
    }
}
