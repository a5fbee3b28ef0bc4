//! Free bodies without contact: uniform translation is exact to the last bit, a spinning block conserves momenta and energy.

use crate::rig::{assert_at_most, assert_close, assert_order, order, plan, run};
use contuse::mechanics::tensor::Vec3;
use serde_json::{Value, json};

fn block(spin: [f64; 3], step: Option<f64>) -> Value {
    json!({
        "name": "flight",
        "end_time_s": 0.02,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.03, 0.02, 0.01], "elements": [6, 4, 2]}},
            "velocity_m_per_s": [31.0, -7.0, 3.3],
            "spin_rad_per_s": spin,
            "parts": [{
                "part": "block", "density_kg_per_m3": 1000.0,
                "material": {"law": "mooney_rivlin", "c10_pa": 0.55e6, "c01_pa": 0.138e6, "bulk_modulus_pa": 3e7}
            }]
        }],
        "integrator": {"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0, "max_step_s": step},
        "record": {"field_times_s": []}
    })
}

#[test]
fn uniform_flight_is_bitwise_uniform() {
    let mut scene = block([0.0; 3], None);
    // Viscosity on: it must not stir either. A wall far away, so that contact is looked for.
    scene["integrator"] = json!({"kind": "explicit"});
    scene["planes"] = json!([{"name": "wall", "point_m": [10.0, 0, 0], "normal": [-1, 0, 0]}]);
    scene["solver"] = json!({"keep": ["distant_pairs"]});
    let plan = plan(&scene);
    let (outcome, state) = run(&plan, |frame| {
        assert_at_most(frame.energy.balance_error, 1e-14, "error of the energy balance in free flight");
    });
    assert!(outcome.steps > 1000);
    for values in [&state.u, &state.v] {
        assert!(values.iter().flatten().all(|c| c.to_bits() == 0), "not +0 to the last bit");
    }
}

#[test]
fn redistributed_mass_reports_what_inertia_it_takes() {
    // All axes of a cube are alike: what its polar moment loses its angular momentum loses.
    let spinning = |fraction: f64| {
        let mut scene = block([0.0, 0.0, 100.0], None);
        scene["bodies"][0]["mesh"]["generator"]["max_m"] = json!([0.02, 0.02, 0.02]);
        scene["bodies"][0]["mesh"]["generator"]["elements"] = json!([6, 6, 6]);
        scene["bodies"][0]["velocity_m_per_s"] = json!([0, 0, 0]);
        scene["contact"] = json!({"mass_redistribution": fraction});
        scene["end_time_s"] = json!(1e-5);
        let plan = plan(&scene);
        let mut spin = None;
        run(&plan, |frame| {
            spin.get_or_insert(Vec3::from(frame.energy.angular_momentum_kg_m2_per_s).norm());
        });
        (plan.bodies[0].inertia_lost, spin.unwrap())
    };
    let ((none, whole), (lost, lighter)) = (spinning(0.0), spinning(0.5));
    assert_eq!(none, 0.0);
    assert_close(lost, 1.0 - lighter / whole, 1e-6, "fraction of a cube's inertia that redistribution takes");
    // Eighths of elements counted by hand.
    assert_close(lost, 5.0 / 38.0, 1e-9, "the same, of 6×6×6 elements at a fraction of a half");
}

/// Largest relative errors over the run: angular momentum about the centre of mass, energy.
fn spin_errors(step: f64) -> (f64, f64, f64) {
    let plan = plan(&block([300.0, 500.0, 700.0], Some(step)));
    let (mut start, mut angular, mut linear) = (None, 0.0_f64, 0.0_f64);
    let (outcome, _) = run(&plan, |frame| {
        let p = Vec3::from(frame.energy.momentum_kg_m_per_s);
        let spin = Vec3::from(frame.energy.angular_momentum_kg_m2_per_s) - center(frame).cross(&p);
        let (p0, spin0) = *start.get_or_insert((p, spin));
        linear = linear.max((p - p0).norm() / p0.norm());
        angular = angular.max((spin - spin0).norm() / spin0.norm());
    });
    (angular, outcome.balance_error, linear)
}

/// Centre of mass [m].
pub fn center(frame: &contuse::step::Frame) -> Vec3 {
    let plan = frame.plan;
    let weighted = (0..plan.node_count()).map(|a| frame.position(a as u32) * plan.mass[a]);
    weighted.sum::<Vec3>() / plan.bodies[0].mass
}

#[test]
fn a_spinning_block_keeps_its_momenta_and_its_energy() {
    // 145 revolutions a second, about no principal axis, for 2.9 revolutions; vibrating from the sudden spin.
    let (coarse, fine) = (spin_errors(3.2e-6), spin_errors(1.6e-6));
    for (angular, energy, linear) in [coarse, fine] {
        // Internal forces act at x_n, where the momenta are taken: conserved but for the rounding of 10⁴ steps.
        assert_at_most(linear, 1e-13, "relative change of the momentum");
        assert_at_most(angular, 1e-12, "relative change of the angular momentum");
        // Of the half-step scheme, second order in the step; a fraction of the energy of the spin alone.
        assert_at_most(energy, 1e-5, "error of the energy balance");
    }
    assert_order(&[coarse.1, fine.1], 1.9, "energy of a spinning block, in the step");
    assert!((1.9..2.1).contains(&order(coarse.1, fine.1)), "order of the energy {}", order(coarse.1, fine.1));
}
