//! Shear viscosity (Kelvin–Voigt) against closed forms.

use crate::rig::{assert_at_most, assert_close, assert_order, difference_of_a_mode, plan, run_on};
use contuse::step::State;
use serde_json::{Value, json};
use std::f64::consts::PI;

const LENGTH: f64 = 0.1;
const MU: f64 = 1e4;
const DENSITY: f64 = 1000.0;
/// Damping ratio of the lowest mode [-].
const ZETA: f64 = 0.2;

/// A column of elements that shears across its length, held at one end.
fn column(elements: u32, viscosity: f64, end: f64) -> Value {
    json!({
        "name": "shear wave",
        "end_time_s": end,
        "bodies": [{
            "name": "column",
            "mesh": {"generator": {
                "kind": "block", "min_m": [0, 0, 0], "max_m": [0.01, 0.01, LENGTH], "elements": [1, 1, elements]
            }},
            "fixed": [{"set": "z_min"}, {"set": "*", "axes": ["y", "z"]}],
            "parts": [{
                "part": "block", "density_kg_per_m3": DENSITY, "shear_viscosity_pa_s": viscosity,
                "material": {"law": "coupled_neo_hookean", "mu_pa": MU, "lambda_pa": 2.0 * MU}
            }]
        }],
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Relative difference of the motion from `e^(−δt) sin(ω_d t)`, of the largest displacement without damping; over one and a half
/// periods of a column that starts with the velocity of its lowest mode, `sin(πz/2L)`. And the largest error of the energy balance.
fn difference(elements: u32) -> (f64, f64) {
    let k = PI / (2.0 * LENGTH);
    let omega = k * (MU / DENSITY).sqrt();
    let viscosity = 2.0 * ZETA * omega * DENSITY / (k * k);
    let (delta, damped) = (ZETA * omega, omega * (1.0 - ZETA * ZETA).sqrt());
    let plan = plan(&column(elements, viscosity, 3.0 * PI / damped));
    let exact = |t: f64| (-delta * t).exp() * (damped * t).sin() / damped;
    // Strains of 10⁻⁶: what is not linear is of that size.
    difference_of_a_mode(&plan, (omega, 1e-7 * omega), |X| (k * X.z).sin(), exact)
}

#[test]
fn a_shear_wave_dies_down_as_it_should() {
    let (coarse, fine) = (difference(8), difference(16));
    assert_at_most(fine.0, 2e-3, "largest difference from the damped mode, 16 elements");
    // Second order in the elements; the viscous force is that of half a step before, of first order in a step that is a hundredth of the wave's.
    assert_order(&[coarse.0, fine.0], 1.8, "damped shear wave, 8 to 16 elements");
    assert_at_most(coarse.1.max(fine.1), 1e-9, "energy balance of the damped shear wave");
}

#[test]
fn a_steady_shear_flow_meets_the_viscous_force() {
    // The free end of one element is dragged at a constant speed against G γ + η γ̇.
    let (viscosity, speed, end) = (200.0, 1e-2, 0.1);
    let mut scene = column(1, viscosity, end);
    scene["bodies"][0]["prescribed"] = json!([{
        "set": "z_max", "axes": ["x"], "displacement_m": [speed * end, 0, 0],
        "ramp": {"kind": "linear", "to_s": end}
    }]);
    let plan = plan(&scene);
    let (mut work, mut dissipated) = (0.0, 0.0);
    run_on(&plan, State::new(&plan), 1, |frame| {
        work = frame.energy.bodies[0].external_work_j;
        dissipated = frame.energy.bodies[0].viscous_j;
    });
    let (rate, volume) = (speed / LENGTH, 1e-4 * LENGTH);
    let expected = viscosity * rate * rate * volume * end;
    assert_close(dissipated, expected, 1e-3, "dissipated by a steady shear flow");
    let stored = 0.5 * MU * (rate * end).powi(2) * volume;
    assert_close(work, expected + stored, 1e-3, "work of whoever shears");
}
