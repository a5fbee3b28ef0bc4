//! The free faces of the paths, their limits, and invalid requests.

use super::*;

/// The largest load on a free face relative to the largest stress, and the asymmetry of σ.
fn free_load(path: Path, point: &PathPoint) -> f64 {
    let P = &point.stress.P;
    let free = match path {
        Path::Uniaxial => P.column(1).amax().max(P.column(2).amax()),
        Path::Equibiaxial | Path::SimpleShear => P.column(2).amax(),
    };
    let asymmetry = (point.stress.cauchy - point.stress.cauchy.transpose()).amax();
    free.max(asymmetry) / P.amax()
}

#[test]
fn the_lateral_faces_are_free_of_load_for_every_law() {
    // Families that are neither symmetric about the axes nor in a plane with them.
    let fibres = [[0.8, 0.5, 0.33], [0.1, -0.7, 0.6]];
    let axes = [[2.0, 2.0, 1.0], [-2.0, 1.0, 2.0], [1.0, -2.0, 2.0]];
    for law in all_laws(400.0) {
        let fibres = if has_matrix(&law) { &fibres[..] } else { &axes[..] };
        for (path, values) in [
            (Path::Uniaxial, [0.7, 0.95, 1.05, 1.4]),
            (Path::Equibiaxial, [0.8, 0.97, 1.04, 1.3]),
            (Path::SimpleShear, [-0.4, 0.1, 0.3, 0.8]),
        ] {
            for point in eval_path(&law, fibres, path, &values).unwrap() {
                let load = free_load(path, &point);
                assert!(load <= 1e-10, "{law:?} {path:?} at {}: {load:e}", point.value);
            }
        }
    }
}

#[test]
fn small_uniaxial_stretch_gives_young_s_modulus() {
    for law in all_laws(400.0).into_iter().filter(has_matrix) {
        let (G, K) = law.moduli_at_rest();
        let (E, nu) = (9.0 * K * G / (3.0 * K + G), (3.0 * K - 2.0 * G) / (2.0 * (3.0 * K + G)));
        let e = 1e-6;
        let point = eval_path(&law, &[], Path::Uniaxial, &[1.0 + e]).unwrap()[0];
        assert!((point.stress.P[(0, 0)] / (E * e) - 1.0).abs() < 1e-5, "{law:?}");
        assert!(((point.F[(1, 1)] - 1.0) / (-nu * e) - 1.0).abs() < 1e-5, "{law:?}");
    }
}

#[test]
fn nearly_incompressible_rubber_is_found_too() {
    // K/G = 10⁶ against the closed form of the incompressible limit, with a deviation of order G/K.
    let law = MooneyRivlin { c10: 0.5, c01: 0.0, volumetric: Volumetric::LnSquared(1e6) };
    let values = [0.4, 1.5, 3.0];
    for point in eval_path(&Material::MooneyRivlin(law), &[], Path::Uniaxial, &values).unwrap() {
        let expected = point.value.powi(2) - 1.0 / point.value;
        assert!((point.stress.cauchy[(0, 0)] / expected - 1.0).abs() < 2e-5, "{point:?}");
    }
}

#[test]
fn what_has_no_answer_is_an_error() {
    let law = hgo(0.0, I4Form::Full, MatrixForm::Isochoric, Volumetric::LnSquared(1e4));
    assert!(matches!(
        eval_path(&law, &FIBRES, Path::Uniaxial, &[1.1, -1.0]),
        Err(MaterialError::NoSuchValue { path: Path::Uniaxial, value: -1.0 })
    ));
    assert!(matches!(
        eval_path(&law, &FIBRES, Path::SimpleShear, &[f64::NAN]),
        Err(MaterialError::NoSuchValue { .. })
    ));
    assert!(matches!(eval_path(&law, &[[0.0; 3]], Path::Uniaxial, &[1.1]), Err(MaterialError::NoSuchFibres)));
    assert!(matches!(
        eval_path(&law, &[[1.0; 3]; 5], Path::Uniaxial, &[1.1]),
        Err(MaterialError::NoSuchFibres)
    ));
    let inverted = Mat3::from_diagonal(&[1.0, 1.0, -0.5].into());
    assert_eq!(eval_point(&law, &inverted), Err(MaterialError::Inverted { J: -0.5 }));
    assert!(matches!(eval_point(&law, &(inverted * f64::NAN)), Err(MaterialError::Inverted { .. })));
    let far = Mat3::from_diagonal(&[5.0, 5.0, 0.04].into());
    assert!(matches!(eval_point(&law, &far), Err(MaterialError::Overstretched { stretch }) if stretch > 4.9));
    assert!(matches!(
        eval_path(&law, &FIBRES, Path::Equibiaxial, &[5.0]),
        Err(MaterialError::Overstretched { stretch }) if (stretch - 5.0).abs() < 1e-9
    ));
}
