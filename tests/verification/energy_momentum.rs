//! Energy–momentum scheme: a spinning, vibrating block keeps its energy and both momenta in long implicit steps.

use crate::free_flight::center;
use crate::record::{assert_at_most, assert_order};
use crate::rig::{plan, run};
use contuse::mechanics::tensor::Vec3;
use contuse::step::State;
use serde_json::{Value, json};

/// A soft block that is stretched, spins and tumbles, in free flight.
fn tumbling(step: f64, end: f64, energy_momentum: bool, bulk: f64) -> Value {
    json!({
        "name": "tumbling block",
        "end_time_s": end,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.03, 0.02, 0.01], "elements": [6, 4, 2]}},
            "velocity_m_per_s": [31.0, -7.0, 3.3],
            "spin_rad_per_s": [300.0, 500.0, 700.0],
            "initial_deformation": {
                "kind": "affine", "center_m": [0.015, 0.01, 0.005],
                "deformation_gradient": [[1.2, 0, 0], [0.1, 0.9, 0], [0, 0, 0.95]]
            },
            "parts": [{
                "part": "block", "density_kg_per_m3": 1000.0,
                "material": {"law": "mooney_rivlin", "c10_pa": 0.55e5, "c01_pa": 0.138e5, "bulk_modulus_pa": bulk}
            }]
        }],
        "integrator": {
            "kind": "implicit", "step_s": step, "energy_momentum": energy_momentum, "newton_tolerance": 1e-11, "energy_gate": 1.0
        },
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Largest errors over the run, relative to the start: energy, angular and linear momentum; and the state at its end.
fn errors(scene: &Value) -> ([f64; 3], State) {
    let plan = plan(scene);
    let (mut start, mut largest) = (None, [0.0_f64; 3]);
    let (_, state) = run(&plan, |frame| {
        let p = Vec3::from(frame.energy.momentum_kg_m_per_s);
        let spin = Vec3::from(frame.energy.angular_momentum_kg_m2_per_s) - center(frame).cross(&p);
        let body = frame.energy.bodies[0];
        let energy = body.kinetic_j + body.strain_j;
        let (energy0, spin0, p0) = *start.get_or_insert((energy, spin, p));
        let now = [
            (energy - energy0).abs() / energy0,
            (spin - spin0).norm() / spin0.norm(),
            (p - p0).norm() / p0.norm(),
        ];
        for (largest, now) in largest.iter_mut().zip(now) {
            *largest = largest.max(now);
        }
    });
    (largest, state)
}

#[test]
fn energy_and_momenta_are_conserved_in_long_steps() {
    // Some 15 times the stable step of explicit integration; the block turns by a ninth of a radian a step. And 27 times, a fifth of a
    // radian, of a block that is not compressed at the start: its volume would swing at periods below the step.
    let mut longer = tumbling(2.2e-4, 2.2e-2, true, 3e7);
    longer["bodies"][0]["initial_deformation"]["deformation_gradient"][2][2] = json!(1.0 / (1.2 * 0.9));
    for (scene, name) in [(tumbling(1.2e-4, 1.2e-2, true, 3e7), "a ninth"), (longer, "a fifth")] {
        let ([energy, angular, linear], state) = errors(&scene);
        assert_at_most(
            energy,
            1e-8,
            &format!("energy of a tumbling block, forces that conserve, {name} of a radian a step"),
        );
        assert_at_most(angular, 1e-8, "angular momentum");
        assert_at_most(linear, 1e-10, "momentum");
        assert_eq!(state.step, 100, "no step is cut");
    }
    // What the θ scheme of the same order does.
    let ([energy, angular, _], _) = errors(&tumbling(1.2e-4, 2.4e-2, false, 3e7));
    assert!(energy > 1e-3 && angular > 1e-3, "θ = ½: energy {energy:e}, angular momentum {angular:e}");
}

#[test]
fn the_motion_is_of_second_order() {
    // As stiff in volume as in shape: all waves are resolved.
    let end = 2e-3;
    let (_, reference) = errors(&tumbling(5e-6, end, true, 3e5));
    let error = |step: f64| {
        let (_, state) = errors(&tumbling(step, end, true, 3e5));
        let square: f64 = state.u.iter().zip(&reference.u).map(|(u, r)| (u - r).norm_squared()).sum();
        square.sqrt()
    };
    assert_order(&[error(8e-5), error(4e-5), error(2e-5)], 1.8, "steps of forces that conserve");
}
