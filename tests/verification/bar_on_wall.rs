//! A bar thrown at a wall, after Doyen, Ern & Piperno, *Time-integration schemes for the finite element dynamic Signorini
//! problem* (2011), scaled so that a finite-strain law stays linear.
//!
//! E = 900 Pa, ρ = 1 kg/m³, A = 1 m², L = 10 m, ν = 0, v₀ = 0.01 m/s, gap 0.005 m: c = 30 m/s, strain 1/3000. Contact lasts
//! from 0.5 s to 0.5 + 2L/c = 1.166667 s at the constant pressure √(Eρ) v₀ = 0.3 Pa; then the bar flies off at +v₀.

use crate::rig::{
    assert_at_most, assert_close, assert_order, assert_within, contact_force, mean_velocity, picture, plan,
    run,
};
use serde_json::{Value, json};

/// The bar in `n` elements.
pub fn scene(n: u32, formulation: &str) -> Value {
    json!({
        "name": "bar on wall",
        "end_time_s": 1.5,
        "bodies": [{
            "name": "bar",
            "mesh": {"generator": {"kind": "block", "min_m": [0.005, 0, 0], "max_m": [10.005, 1, 1], "elements": [n, 1, 1]}},
            "velocity_m_per_s": [-0.01, 0, 0],
            "parts": [{
                "part": "block", "density_kg_per_m3": 1.0, "formulation": formulation,
                "material": {"law": "coupled_neo_hookean", "mu_pa": 450.0, "lambda_pa": 0.0}
            }]
        }],
        "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [1, 0, 0]}],
        "integrator": {"kind": "explicit", "safety_factor": 0.9, "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// What is seen of one run.
#[derive(Debug)]
struct Seen {
    steps: usize,
    first: f64,
    last: f64,
    mean: f64,
    deviation: f64,
    overshoot: f64,
    impulse: f64,
    deepest: f64,
    lost: f64,
    numerical: f64,
    rebound: f64,
    balance: f64,
    openings: usize,
    /// Contact pressure over time.
    history: Vec<(f64, f64)>,
}

fn look(scene: &Value) -> Seen {
    let plan = plan(scene);
    let (mut force, mut deepest, mut last_energy, mut rebound) = (Vec::new(), 0.0_f64, None, 0.0);
    let (outcome, _) = run(&plan, |frame| {
        force.push((frame.time, contact_force(frame).x));
        deepest = deepest.min((0..plan.node_count()).map(|a| frame.position(a as u32).x).fold(0.0, f64::min));
        last_energy = Some(frame.energy.clone());
        rebound = mean_velocity(frame, 0).x;
    });
    let energy = last_energy.unwrap();
    let touching: Vec<_> = force.iter().filter(|(_, f)| *f > 0.0).collect();
    let mid: Vec<f64> = force.iter().filter(|(t, _)| (0.6..1.05).contains(t)).map(|(_, f)| *f).collect();
    let mean = mid.iter().sum::<f64>() / mid.len() as f64;
    let initial = energy.initial_total_j;
    Seen {
        steps: outcome.steps as usize,
        first: touching[0].0,
        last: touching[touching.len() - 1].0,
        mean,
        deviation: (mid.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / mid.len() as f64).sqrt(),
        overshoot: force.iter().map(|(_, f)| *f).fold(0.0, f64::max) / 0.3 - 1.0,
        impulse: energy.pairs[0].impulse_n_s[0],
        deepest,
        lost: 1.0 - energy.bodies.iter().map(|b| b.kinetic_j + b.strain_j).sum::<f64>() / initial,
        numerical: energy.numerical_contact_j() / initial,
        rebound,
        balance: outcome.balance_error,
        openings: force.windows(2).filter(|w| w[0].1 > 0.0 && w[1].1 == 0.0).count(),
        history: force,
    }
}

#[test]
fn contact_pressure_is_constant_and_only_impact_activation_loses_energy() {
    let [coarse, medium, fine] = [25, 50, 100].map(|n| look(&scene(n, "full")));
    for (seen, n) in [(&coarse, 25.0), (&medium, 50.0), (&fine, 100.0)] {
        let step = 1.5 / seen.steps as f64;
        // A step in which contact begins starts before the bar arrives; one in which it ends starts after it left.
        assert!((0.5 - step..=0.5).contains(&seen.first), "{seen:?}");
        assert_within(seen.last, 7.0 / 6.0, step, "end of the contact [s]");
        // No chatter: once open, open for ever.
        assert_eq!(seen.openings, 1, "{seen:?}");
        // Positions of 10 m are known to 2e-15 m.
        assert_at_most(seen.deepest.min(0.0), 2e-15, "deepest of the nodes inside the wall [m]");
        // The strain is v₀/c = 1/3000, and so is what finite strain may add to the linear answer.
        assert_close(seen.mean, 0.3, 1.0 / 3000.0, "pressure");
        assert!(seen.overshoot < 0.08, "{seen:?}");
        // What the lumped node at the wall loses on impact activation, and nothing else.
        assert!(seen.lost > 0.0 && seen.lost <= 0.75 / n, "{seen:?}");
        assert_within(
            seen.lost,
            seen.numerical,
            1.01 * seen.balance,
            "energy lost, against the ledger's line of it",
        );
        assert_at_most(seen.balance, 1e-4, "error of the energy balance");
        assert_close(seen.rebound, seen.impulse / 10.0 - 0.01, 1e-12, "momentum");
    }
    assert_at_most(fine.deviation, 1e-4, "ripple of the pressure, 100 elements");
    assert_close(fine.impulse, 0.2, 0.005, "impulse");
    assert_close(fine.rebound, 0.01, 0.01, "rebound velocity");
    // The node's impact is of the size of an element: first order in what it costs, faster in the ripple it leaves.
    assert_order(&[coarse.lost, medium.lost, fine.lost], 0.95, "energy lost on impact activation");
    assert_order(&[&coarse, &medium, &fine].map(|seen| 0.2 - seen.impulse), 0.75, "impulse");
    assert_order(&[coarse.deviation, medium.deviation], 1.0, "ripple of the pressure, 25 to 50 elements");
    assert_order(&[medium.deviation, fine.deviation], 1.0, "ripple of the pressure, 50 to 100 elements");
    let exact = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (7.0 / 6.0, 0.3), (7.0 / 6.0, 0.0), (1.5, 0.0)];
    picture(
        "Contact pressure of a bar on a wall",
        ["time [s]", "pressure [Pa]"],
        &[("25 elements", coarse.history), ("100 elements", fine.history), ("exact", exact.to_vec())],
    );
}

#[test]
fn reduced_elements_see_the_same_bar() {
    // The motion is one-dimensional: there is no hourglass, and one point knows all that eight do.
    let [full, reduced] = ["full", "reduced"].map(|formulation| {
        let mut scene = scene(50, formulation);
        // The same steps: what the stabilisation is allowed for in their bound is 2 % of it.
        scene["integrator"]["max_step_s"] = json!(0.005);
        look(&scene)
    });
    assert_eq!(full.steps, reduced.steps);
    for (a, b) in
        [(full.mean, reduced.mean), (full.impulse, reduced.impulse), (full.rebound, reduced.rebound)]
    {
        assert_close(b, a, 1e-9, "full against reduced");
    }
    assert!((full.lost - reduced.lost).abs() < 1e-9 && reduced.balance < 1e-4, "{reduced:?}");
}
