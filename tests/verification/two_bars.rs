//! Two equal bars, one thrown at the other, after Carpenter, Taylor & Katona, *Lagrange constraints for transient finite
//! element surface contact* (1991).
//!
//! v = 202.2 in/s, E = 30·10⁶ psi, ρ = 7.3·10⁻⁴ lbf s²/in⁴, L = 10 in: c = 202 721.21 in/s, σ = 14 961.434 psi, contact lasts
//! 2L/c = 9.865766·10⁻⁵ s; then the bars have exchanged their velocities. Here in SI units, with 1 in² of cross-section.

use crate::rig::{
    assert_at_most, assert_close, assert_order, assert_within, contact_force, mean_velocity, order, picture,
    plan, run,
};
use serde_json::{Value, json};

const INCH: f64 = 0.0254;
/// 1 psi [Pa].
const PSI: f64 = 6_894.757_293_168_361;
/// 1 lbf s²/in⁴ [kg/m³].
const SLINCH: f64 = 4.448_221_615_260_5 / (INCH * INCH * INCH * INCH);
const SPEED: f64 = 202.2 * INCH;
const STRESS: f64 = 14_961.434 * PSI;
const DURATION: f64 = 9.865_766e-5;

/// Bars of `n` elements each, touching at x = 0, the left one flying.
pub fn scene(n: u32) -> Value {
    let bar = |name: &str, x: f64, v: f64| {
        json!({
            "name": name,
            "mesh": {"generator": {
                "kind": "block", "min_m": [x, 0, 0], "max_m": [x + 10.0 * INCH, INCH, INCH], "elements": [n, 1, 1]
            }},
            "velocity_m_per_s": [v, 0, 0],
            "parts": [{
                "part": "block", "density_kg_per_m3": 7.3e-4 * SLINCH,
                "material": {"law": "coupled_neo_hookean", "mu_pa": 15e6 * PSI, "lambda_pa": 0.0}
            }]
        })
    };
    json!({
        "name": "two bars",
        "end_time_s": 1.25e-4,
        "bodies": [bar("left", -10.0 * INCH, SPEED), bar("right", 0.0, 0.0)],
        "integrator": {"kind": "explicit", "safety_factor": 0.9, "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "record": {"fields": [], "field_times_s": []}
    })
}

#[derive(Debug)]
struct Seen {
    steps: u64,
    stress: f64,
    deviation: f64,
    first: f64,
    last: f64,
    left: f64,
    right: f64,
    lost: f64,
    numerical: f64,
    balance: f64,
    openings: usize,
    /// Contact stress over time.
    history: Vec<(f64, f64)>,
}

fn look(n: u32) -> Seen {
    let plan = plan(&scene(n));
    let (mut force, mut velocities, mut energy) = (Vec::new(), [0.0; 2], None);
    let (outcome, _) = run(&plan, |frame| {
        force.push((frame.time, contact_force(frame).norm()));
        velocities = [0, 1].map(|b| mean_velocity(frame, b).x);
        energy = Some(frame.energy.clone());
    });
    let energy = energy.unwrap();
    let touching: Vec<_> = force.iter().filter(|(_, f)| *f > 0.0).collect();
    let mid: Vec<f64> =
        force.iter().filter(|(t, _)| (0.2 * DURATION..0.8 * DURATION).contains(t)).map(|(_, f)| *f).collect();
    let mean = mid.iter().sum::<f64>() / mid.len() as f64;
    Seen {
        steps: outcome.steps,
        stress: mean / (INCH * INCH),
        deviation: (mid.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / mid.len() as f64).sqrt() / mean,
        first: touching[0].0,
        last: touching[touching.len() - 1].0,
        left: velocities[0],
        right: velocities[1],
        lost: 1.0
            - energy.bodies.iter().map(|b| b.kinetic_j + b.strain_j).sum::<f64>() / energy.initial_total_j,
        numerical: energy.numerical_contact_j() / energy.initial_total_j,
        balance: outcome.balance_error,
        history: force.iter().map(|(t, f)| (*t, f / (INCH * INCH))).collect(),
        openings: force.windows(2).filter(|w| w[0].1 > 0.0 && w[1].1 == 0.0).count(),
    }
}

#[test]
fn the_bars_exchange_their_velocities() {
    let [coarse, medium, fine] = [25, 50, 100].map(look);
    // The strain is v/2c = 5·10⁻⁴, and so is what finite strain may add to the linear answer.
    let strain = 0.5 * 202.2 / 202_721.21;
    for (seen, n) in [(&coarse, 25.0), (&medium, 50.0), (&fine, 100.0)] {
        let step = 1.25e-4 / seen.steps as f64;
        assert_eq!(seen.first, 0.0, "{seen:?}");
        assert_within(seen.last, DURATION, 2.0 * step, "duration of the contact [s]");
        assert_eq!(seen.openings, 1, "{seen:?}");
        assert_close(seen.stress, STRESS, strain, "contact stress");
        // Momentum: what one bar has lost the other has got.
        assert_close(seen.left + seen.right, SPEED, 1e-12, "sum of velocities");
        // Two lumped nodes of mass ρ A L/2n meet and lose half of the kinetic energy that they had, a quarter of 1/n.
        assert!(seen.lost > 0.0 && (seen.lost - seen.numerical).abs() <= 1.01 * seen.balance, "{seen:?}");
        assert_close(seen.numerical, 0.25 / n, 1e-9, "numerical contact dissipation");
        assert_at_most(seen.balance, 1e-4, "error of the energy balance");
    }
    assert_close(fine.right, SPEED, 0.005, "velocity of the right bar");
    assert_at_most(fine.left / SPEED, 0.005, "velocity of the left bar, of the speed");
    assert!(fine.deviation < 3e-4 && order(coarse.deviation, fine.deviation) > 2.0 * 1.4, "{fine:?}");
    assert_order(&[coarse.left, medium.left], 0.7, "velocity of the left bar, 25 to 50 elements");
    assert_order(&[medium.left, fine.left], 0.7, "velocity of the left bar, 50 to 100 elements");
    let exact = [(0.0, STRESS), (DURATION, STRESS), (DURATION, 0.0), (1.25e-4, 0.0)];
    picture(
        "Contact stress of two bars",
        ["time [s]", "stress [Pa]"],
        &[
            ("25 elements each", coarse.history),
            ("100 elements each", fine.history),
            ("exact", exact.to_vec()),
        ],
    );
}
