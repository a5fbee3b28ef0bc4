//! A shock in a bar of compressible neo-Hookean rubber in uniaxial strain, thrown at a wall.
//!
//! Coupled law, μ = λ = 0.1 MPa, ρ = 1000 kg/m³. With P(Λ) = μ (Λ − 1/Λ) + λ ln Λ / Λ the jump conditions
//! `v₀ = U (1 − Λ)`, `ρ U v₀ = −P(Λ)` give the referential speed U of the front, the stretch Λ and the wall pressure; the
//! energy that the shock itself dissipates is `v₀²/2 ρ − ψ(Λ)` per reference volume: the Rankine–Hugoniot dissipation,
//! which an energy-conserving scheme cannot represent. Here bulk viscosity provides it.

use crate::rig::{assert_at_most, assert_close, assert_order, order, plan, run};
use contuse::mechanics::tensor::Vec3;
use serde_json::{Value, json};

const DENSITY: f64 = 1000.0;

/// The jump conditions solved, with more digits for the fraction than their source gives (18.69 % and 1.644 %).
struct Exact {
    v0: f64,
    /// U, referential [m/s].
    front_speed: f64,
    /// Of the wall [Pa].
    pressure: f64,
    /// Λ behind the front [-].
    stretch: f64,
}

const FAST: Exact =
    Exact { v0: 10.0, front_speed: 22.685_647_8, pressure: 226_856.478, stretch: 0.559_192_662 };
const SLOW: Exact =
    Exact { v0: 1.0, front_speed: 17.749_449_2, pressure: 17_749.449_2, stretch: 0.943_660_22 };

impl Exact {
    /// Fraction of the kinetic energy that the shock dissipates [-].
    fn fraction(&self) -> f64 {
        let ln = self.stretch.ln();
        let psi = 0.5e5 * (self.stretch.powi(2) - 1.0) - 1e5 * ln + 0.5e5 * ln * ln;
        1.0 - psi / (0.5 * DENSITY * self.v0 * self.v0)
    }
}

/// A bar 1 m long of `n` cubes, its sides guided.
fn scene(n: u32, safety_factor: f64, exact: &Exact) -> Value {
    let side = 1.0 / f64::from(n);
    json!({
        "name": "shock",
        "end_time_s": 0.8 / exact.front_speed,
        "bodies": [{
            "name": "bar",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [1, side, side], "elements": [n, 1, 1]}},
            "velocity_m_per_s": [-exact.v0, 0, 0],
            "fixed": [{"set": "*", "axes": ["y", "z"]}],
            "parts": [{
                "part": "block", "density_kg_per_m3": DENSITY,
                "material": {"law": "coupled_neo_hookean", "mu_pa": 1e5, "lambda_pa": 1e5}
            }]
        }],
        "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [1, 0, 0]}],
        "integrator": {"kind": "explicit", "safety_factor": safety_factor},
        "record": {"fields": [], "field_times_s": []}
    })
}

#[derive(Debug)]
struct Seen {
    front_speed: f64,
    pressure: f64,
    stretch: f64,
    /// Viscous dissipation over kinetic energy of the material that the front passed in the second half.
    fraction: f64,
}

/// Reference position of the front: where the velocity is half of v₀ [m].
fn front(X: &[Vec3], v: &[Vec3], v0: f64) -> f64 {
    let mut line: Vec<(f64, f64)> =
        X.iter().zip(v).filter(|(X, _)| X.y == 0.0 && X.z == 0.0).map(|(X, v)| (X.x, v.x / v0)).collect();
    line.sort_by(|a, b| a.0.total_cmp(&b.0));
    // From the undisturbed end (relative velocity 0) inwards to the first that is beyond a half.
    let i = (1..line.len()).rev().find(|i| line[i - 1].1 >= 0.5).unwrap_or(1);
    let ((x0, v0), (x1, v1)) = (line[i - 1], line[i]);
    x0 + (x1 - x0) * (v0 - 0.5) / (v0 - v1)
}

fn look(n: u32, safety_factor: f64, exact: &Exact) -> Seen {
    let plan = plan(&scene(n, safety_factor, exact));
    let area = 1.0 / f64::from(n * n);
    let mut rows = Vec::new();
    let (_, state) = run(&plan, |frame| {
        let energy = frame.energy;
        let front = front(&plan.X, frame.v_after, exact.v0);
        rows.push((frame.time, front, energy.bodies[0].viscous_j, energy.pairs[0].impulse_n_s[0]));
    });
    // From half of the run to its end: the front is steady, the wall's first node forgotten.
    let half = rows.iter().find(|row| row.0 >= 0.5 * plan.end_time).unwrap();
    let last = rows.last().unwrap();
    let time = last.0 - half.0;
    let mut stretches = Vec::new();
    plan.blocks[0].for_each_point(&plan.X, &state.u, &mut |_, _, point| {
        if (0.2..0.6).contains(&point.position.x) {
            stretches.push(point.F[(0, 0)]);
        }
    });
    let passed = 0.5 * DENSITY * exact.v0 * exact.v0 * area * exact.front_speed * time;
    Seen {
        front_speed: (last.1 - half.1) / time,
        pressure: (last.3 - half.3) / time / area,
        stretch: stretches.iter().sum::<f64>() / stretches.len() as f64,
        fraction: (last.2 - half.2) / passed,
    }
}

#[test]
fn a_strong_shock_dissipates_what_the_jump_conditions_say() {
    assert_close(FAST.fraction(), 0.1869, 2e-4, "fraction");
    let [coarse, fine] = [50, 200].map(|n| look(n, 0.9, &FAST));
    // The front is three elements wide wherever it is: its place is known to a tenth of an element of the 0.4 m (n = 50)
    // that it goes; pressure and stretch are means that feel the ripple behind it.
    assert_close(coarse.front_speed, FAST.front_speed, 0.1 / 20.0, "front speed");
    assert_close(fine.front_speed, FAST.front_speed, 0.1 / 80.0, "front speed");
    assert_close(fine.pressure, FAST.pressure, 5e-5, "wall pressure");
    assert_close(fine.stretch, FAST.stretch, 1e-5, "stretch");
    let errors = [&coarse, &fine].map(|seen| (seen.pressure / FAST.pressure - 1.0).abs());
    assert!(order(errors[0], errors[1]) > 1.5, "{errors:?}");

    // Strain rates at the front are one over a few steps on every mesh, so the last fifth of a per cent of the fraction does
    // not go with the elements but with the Courant number.
    let short_steps = look(200, 0.3, &FAST);
    let errors = [&coarse, &fine, &short_steps].map(|seen| (seen.fraction / FAST.fraction() - 1.0).abs());
    for (error, most, what) in [
        (errors[0], 0.01, "dissipated fraction, 50 elements"),
        (errors[1], 0.0025, "dissipated fraction, 200 elements"),
        (errors[2], 0.0003, "dissipated fraction, 200 elements, Courant number 0.3"),
    ] {
        assert_at_most(error, most, &format!("{what}: relative error"));
    }
}

#[test]
fn a_weak_shock_dissipates_more_in_its_width_and_converges() {
    // At a Mach number of 1.025 the linear viscosity makes a front many elements wide, which needs its time to form.
    assert_close(SLOW.fraction(), 0.01644, 1e-3, "fraction");
    let seen = [100, 200, 400, 800].map(|n| look(n, 0.9, &SLOW));
    let errors = [0, 1, 2, 3].map(|i| seen[i].fraction - SLOW.fraction());
    for pair in errors.windows(2) {
        assert!(pair[1] > 0.0, "{errors:?}");
        assert_order(pair, 0.9, "dissipated fraction of a weak shock, elements halved");
    }
    let [.., fine] = &seen;
    assert_close(fine.fraction, SLOW.fraction(), 0.02, "fraction");
    assert_close(fine.front_speed, SLOW.front_speed, 2e-4, "front speed");
    assert_close(fine.pressure, SLOW.pressure, 3e-5, "wall pressure");
    assert_close(fine.stretch, SLOW.stretch, 2e-6, "stretch");
}
