//! Breathing of a hollow ball of nearly incompressible Mooney–Rivlin rubber, against the incompressible solution.
//!
//! C10 = 0.55 MPa, C01 = 0.138 MPa, ρ = 1000 kg/m³, radii 10 and 15 mm, at rest from an inner stretch of 1.25: strain energy
//! 1.45568966 J, other turning point 0.762489525, period 5.75607101·10⁻⁴ s; for small amplitudes 5.82887994·10⁻⁴ s.

use crate::rig::{assert_at_most, assert_close, assert_order, order, picture, plan_with, run};
use contuse::mesh::Mesh;
use contuse::mesh::generate::hollow_ball::HollowBall;
use serde_json::{Value, json};

const ENERGY: f64 = 1.455_689_66;
const TURNING_POINT: f64 = 0.762_489_525;
const PERIOD: f64 = 5.756_071_01e-4;
const LINEAR_PERIOD: f64 = 5.828_879_94e-4;
/// Stiff enough against volume: what compressibility changes is of the size of p/K, 6·10⁻⁴.
const BULK_MODULUS: f64 = 1e9;

/// The ball of hexahedra, n in a quarter.
fn ball(n: u32) -> Mesh {
    let (elements_around, elements_through) = (n, n / 2);
    HollowBall {
        center_m: [0.0; 3],
        outer_radius_m: 0.015,
        inner_radius_m: 0.01,
        elements_around,
        elements_through,
    }
    .generate()
    .unwrap()
}

fn scene(stretch: f64, formulation: &Value) -> Value {
    let mut scene = json!({
        "name": "breathing ball",
        "end_time_s": 4.8e-4,
        "bodies": [{
            "name": "ball",
            "mesh": {"file": {"name": "ball.msh"}},
            "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {
                "law": "mooney_rivlin", "c10_pa": 0.55e6, "c01_pa": 0.138e6, "bulk_modulus_pa": BULK_MODULUS
            }}],
            "initial_deformation": {
                "kind": "spherical_inflation", "center_m": [0, 0, 0], "inner_radius_m": 0.01, "inner_stretch": stretch
            }
        }],
        // The orders are those of the mesh: steps of two thirds of the usual ones.
        "integrator": {"kind": "explicit", "safety_factor": 0.6, "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "record": {"fields": [], "field_times_s": []}
    });
    if !formulation.is_null() {
        scene["bodies"][0]["parts"][0]["formulation"] = formulation.clone();
    }
    scene
}

#[derive(Debug)]
struct Seen {
    energy: f64,
    hourglass: f64,
    turning_point: f64,
    period: f64,
    linear_period: f64,
    balance: f64,
    /// Inner stretch over time.
    history: Vec<(f64, f64)>,
}

impl Seen {
    /// Relative errors of strain energy, turning point and period.
    fn errors(&self) -> [f64; 3] {
        [1.0 - self.energy / ENERGY, self.turning_point / TURNING_POINT - 1.0, self.period / PERIOD - 1.0]
    }
}

fn look(mesh: Mesh, stretch: f64, formulation: &Value) -> Seen {
    let plan = plan_with(&scene(stretch, formulation), Some(mesh));
    // On the sphere: not in the middle of its chords.
    let is_inner = |a: &usize| (plan.X[*a].norm() - 0.01).abs() < 1e-6;
    let inner: Vec<usize> = (0..plan.node_count()).filter(is_inner).collect();
    let mut radius = Vec::new();
    let (mut energy, mut hourglass) = (0.0, 0.0_f64);
    let (outcome, _) = run(&plan, |frame| {
        let sum: f64 = inner.iter().map(|a| frame.position(*a as u32).norm()).sum();
        radius.push((frame.time, sum / inner.len() as f64 / 0.01 - 1.0));
        energy = frame.energy.initial_total_j;
        hourglass = hourglass.max(frame.energy.bodies[0].hourglass_j / energy);
    });
    // The motion is its own mirror image about half a period: crossings of one level are at equal distances from it.
    let crossings: Vec<f64> = radius
        .windows(2)
        .filter(|w| w[0].1 * w[1].1 < 0.0)
        .map(|w| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1))
        .collect();
    assert_eq!(crossings.len(), 2, "{crossings:?}");
    Seen {
        energy,
        hourglass,
        turning_point: 1.0 + radius.iter().map(|r| r.1).fold(0.0, f64::min),
        period: crossings[0] + crossings[1],
        linear_period: 2.0 * (crossings[1] - crossings[0]),
        balance: outcome.balance_error,
        history: radius.iter().map(|(t, r)| (*t, 1.0 + r)).collect(),
    }
}

#[test]
fn a_large_amplitude_converges_to_the_incompressible_motion() {
    let [coarse, medium, fine] = [2, 4, 8].map(|n| look(ball(n), 1.25, &Value::Null));
    let (coarse_errors, medium_errors, errors) = (coarse.errors(), medium.errors(), fine.errors());
    // Facets: a ball of 8 elements a quarter has 0.7 % less volume; second order in all three.
    for (i, what) in ["strain energy", "turning point", "period"].into_iter().enumerate() {
        assert_order(
            &[coarse_errors[i], medium_errors[i]],
            1.3,
            &format!("{what}, 2 to 4 elements a quarter"),
        );
        assert_order(&[medium_errors[i], errors[i]], 1.6, &format!("{what}, 4 to 8 elements a quarter"));
    }
    assert_close(fine.energy, ENERGY, 0.012, "strain energy [J]");
    assert_close(fine.turning_point, TURNING_POINT, 0.0015, "smallest inner stretch");
    assert_close(fine.period, PERIOD, 0.01, "period [s]");
    assert_at_most(fine.balance, 1e-3, "error of the energy balance");
    picture(
        "Inner stretch of a breathing ball",
        ["time [s]", "stretch [-]"],
        &[
            ("2 elements a quarter", coarse.history),
            ("8 elements a quarter", fine.history),
            ("exact turning point", vec![(0.0, TURNING_POINT), (4.8e-4, TURNING_POINT)]),
        ],
    );
}

#[test]
fn a_small_amplitude_has_the_linear_period() {
    let [medium, fine] =
        [4, 8].map(|n| look(ball(n), 1.0001, &Value::Null).linear_period / LINEAR_PERIOD - 1.0);
    assert_order(&[medium, fine], 1.7, "linear period, 4 to 8 elements a quarter");
    assert_close(fine + 1.0, 1.0, 0.007, "linear period over its exact value");
}

#[test]
fn reduced_elements_converge_to_the_same_motion() {
    let [medium, fine] = [4, 8].map(|n| look(ball(n), 1.25, &json!("reduced")));
    let (medium_errors, errors) = (medium.errors(), fine.errors());
    let most = [("strain energy", 0.012), ("turning point", 0.0015), ("period", 0.01)];
    for (i, (what, most)) in most.into_iter().enumerate() {
        assert_order(&[medium_errors[i], errors[i]], 1.6, &format!("{what}, reduced elements"));
        assert_at_most(errors[i], most, &format!("{what}, reduced elements, relative error"));
    }
    // What is in the stabilisation is what the mesh does not resolve: it falls as h².
    assert!(fine.hourglass < 0.05 && order(medium.hourglass, fine.hourglass) > 1.6, "{medium:?} → {fine:?}");
    assert_at_most(fine.balance, 1e-3, "error of the energy balance, reduced elements");
}

/// Elements, as many hexahedra a quarter as they are cut from, and how; largest errors of strain energy, turning point,
/// period and energy balance on the finer mesh, set after they were measured.
type Cells = (&'static str, [u32; 2], fn(Mesh) -> Mesh, [f64; 4]);

#[test]
fn other_elements_converge_to_the_same_motion() {
    let wedges: Cells = ("wedges", [4, 8], |mesh| mesh.split_to_wedges(), [0.012, 0.0015, 0.01, 1e-3]);
    // The start is not free of volume changes in tetrahedra, whose energy is then too large.
    let quadratic: Cells = (
        "tetrahedra of ten nodes",
        [4, 8],
        |mesh| mesh.split_to_tetrahedra().to_quadratic_tetrahedra(),
        [0.015, 0.003, 0.001, 1e-3],
    );
    let linear: Cells =
        ("tetrahedra of four nodes", [4, 8], |mesh| mesh.split_to_tetrahedra(), [0.08, 0.0015, 0.011, 2e-3]);
    for (cells, n, split, most) in [wedges, quadratic, linear] {
        let [medium, fine] = n.map(|n| look(split(ball(n)), 1.25, &Value::Null));
        let (medium_errors, errors) = (medium.errors(), fine.errors());
        println!("{cells}: {medium_errors:?} {errors:?}");
        for (i, what) in ["strain energy", "turning point", "period"].into_iter().enumerate() {
            assert_order(&[medium_errors[i], errors[i]], 1.6, &format!("{what}, {cells}"));
            assert_at_most(errors[i], most[i], &format!("{what}, {cells}, relative error"));
        }
        assert_at_most(fine.balance, most[3], &format!("error of the energy balance, {cells}"));
    }
}
