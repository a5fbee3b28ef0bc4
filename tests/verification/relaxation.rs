//! Prony series against exact convolutions.

use crate::rig::{assert_at_most, assert_close, assert_order, difference_of_a_mode, plan, run, run_on};
use contuse::mechanics::force::PointBatch;
use contuse::step::{Frame, State};
use serde_json::{Value, json};
use std::f64::consts::PI;

pub const G: f64 = 1e4;
/// Relative moduli [-] and relaxation times [s].
pub const BRANCHES: [[f64; 2]; 2] = [[1.0, 0.02], [0.5, 0.2]];

/// A neo-Hookean part that relaxes.
fn part(name: &str, formulation: &str) -> Value {
    let branch = |[g, tau]: [f64; 2]| json!({"relative_modulus": g, "relaxation_time_s": tau});
    json!({
        "part": name, "density_kg_per_m3": 1000.0, "formulation": formulation,
        "material": {"law": "neo_hookean", "c10_pa": 0.5 * G, "bulk_modulus_pa": 2.0 * G},
        "prony_series": {"branches": BRANCHES.map(branch)}
    })
}

/// A cube of one element and of a metre, whose upper face is displaced by `way` times a table over time, the rest held.
pub fn cube(formulation: &str, way: [f64; 3], table: &[[f64; 2]]) -> Value {
    let (times, factors): (Vec<f64>, Vec<f64>) = table.iter().map(|[t, f]| (*t, *f)).unzip();
    json!({
        "name": "relaxing cube",
        "end_time_s": times.last(),
        "bodies": [{
            "name": "cube",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [1, 1, 1], "elements": [1, 1, 1]}},
            "fixed": [{"set": "z_min"}],
            "prescribed": [{
                "set": "z_max", "displacement_m": way, "ramp": {"kind": "table", "times_s": times, "factors": factors}
            }],
            "parts": [part("block", formulation)]
        }],
        "integrator": {"kind": "explicit", "max_step_s": 1e-4},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Stresses at the points of the first element, where they are known.
fn at_points(frame: &Frame, mut look: impl FnMut(&PointBatch)) {
    if frame.is_look_time {
        frame.plan.blocks[0].for_each_moved_batch(frame.points(), &mut |_, points| look(points));
    }
}

/// Over [Pa s], the integral of `e^(−(t−s)/τ) dγ/ds` under straight lines.
fn convolved(table: &[[f64; 2]], tau: f64, t: f64) -> f64 {
    let piece = |ends: &[[f64; 2]]| {
        let ([from, a], [to, b]) = (ends[0], ends[1]);
        let end = to.min(t);
        let decay = |s: f64| (-(t - s) / tau).exp();
        if end > from { (b - a) / (to - from) * tau * (decay(end) - decay(from)) } else { 0.0 }
    };
    table.windows(2).map(piece).sum()
}

/// γ at t.
fn at(table: &[[f64; 2]], t: f64) -> f64 {
    let inside = table.windows(2).find(|ends| t <= ends[1][0]);
    inside.map_or(table[table.len() - 1][1], |e| {
        e[0][1] + (e[1][1] - e[0][1]) * (t - e[0][0]) / (e[1][0] - e[0][0])
    })
}

#[test]
fn shear_stress_relaxes_as_the_convolution_says() {
    let ramp_and_hold = [[0.0, 0.0], [0.01, 1e-3], [0.2, 1e-3]];
    let cycles = [[0.0, 0.0], [0.02, 1e-3], [0.06, -1e-3], [0.1, 1e-3], [0.14, -1e-3], [0.2, 0.0]];
    for formulation in ["mean_dilatation", "full", "reduced"] {
        for table in [&ramp_and_hold[..], &cycles] {
            let (mut looks, mut worst) = (0, 0.0_f64);
            run(&plan(&cube(formulation, [1.0, 0.0, 0.0], table)), |frame| {
                at_points(frame, |points| {
                    let over = BRANCHES.map(|[g, tau]| g * convolved(table, tau, frame.time));
                    let exact = G * (at(table, frame.time) + over.iter().sum::<f64>());
                    looks += 1;
                    for point in &points.cauchy {
                        worst = worst.max((point[5].0[0] - exact).abs() / (2.5e-3 * G));
                    }
                });
            });
            assert!(looks > 40);
            // What is left: strains of a thousandth are finite, and a step may straddle a kink of the table.
            assert_at_most(worst, 2e-3, &format!("shear stress of {formulation}, relative to G₀ γ"));
        }
    }
}

#[test]
fn what_is_dissipated_closes_the_ledger() {
    let (ramp, end, gamma) = (0.01, 0.2, 1e-3);
    let table = [[0.0, 0.0], [ramp, gamma], [end, gamma]];
    let mut last = None;
    run(&plan(&cube("mean_dilatation", [1.0, 0.0, 0.0], &table)), |frame| {
        last = Some(frame.energy.bodies[0]);
    });
    let last = last.unwrap();
    // Each branch: ∫ σ²/(g G τ) dt.
    let (mut dissipated, mut stored) = (0.0, 0.0);
    for [g, tau] in BRANCHES {
        let rate = gamma / ramp;
        let (e, viscosity) = ((-ramp / tau).exp(), g * G * tau);
        let growing = viscosity * rate * rate * (ramp - 2.0 * tau * (1.0 - e) + 0.5 * tau * (1.0 - e * e));
        let peak = viscosity * rate * (1.0 - e);
        let left = (-(end - ramp) / tau).exp();
        dissipated += growing + 0.5 * peak * peak / (g * G) * (1.0 - left * left);
        stored += 0.5 * (peak * left).powi(2) / (g * G);
    }
    assert_close(last.viscous_j, dissipated, 2e-3, "dissipated by relaxation");
    assert_close(last.branches_j, stored, 2e-3, "stored in the branches");
    let elastic = 0.5 * G * gamma * gamma;
    assert_close(last.external_work_j, elastic + stored + dissipated, 2e-3, "work of whoever shears");
}

#[test]
fn finite_strains_relax_as_the_equations_say() {
    // Uniaxial strain to half as much again, then held; the equations by a fine sum.
    let (ramp, end, most) = (0.02, 0.06, 0.5);
    let table = [[0.0, 0.0], [ramp, most], [end, most]];
    let mut engine = Vec::new();
    run(&plan(&cube("full", [0.0, 0.0, 1.0], &table)), |frame| {
        at_points(frame, |points| engine.push((frame.time, points.von_mises[0].0[0])));
    });
    let isochoric = |stretch: f64| {
        let (C, mean) = ([1.0, 1.0, stretch * stretch], (2.0 + stretch * stretch) / 3.0);
        C.map(|C| G * stretch.powf(-2.0 / 3.0) * (1.0 - mean / C))
    };
    let (steps, mut worst) = (20_000, 0.0_f64);
    for (time, found) in engine {
        let mut H = [[0.0; 3]; 2];
        let mut before = isochoric(1.0);
        for i in 1..=steps {
            let t = time * f64::from(i) / f64::from(steps);
            let now = isochoric(1.0 + at(&table, t));
            for (H, [g, tau]) in H.iter_mut().zip(BRANCHES) {
                for axis in 0..3 {
                    let middle = (-(time - t + 0.5 * time / f64::from(steps)) / tau).exp();
                    H[axis] += g * middle * (now[axis] - before[axis]);
                }
            }
            before = now;
        }
        let stretch = 1.0 + at(&table, time);
        let C = [1.0, 1.0, stretch * stretch];
        let sum: [f64; 3] = std::array::from_fn(|axis| H[0][axis] + H[1][axis]);
        let along: f64 = sum.iter().zip(&C).map(|(H, C)| H * C).sum::<f64>() / 3.0;
        let cauchy = |axis: usize| (before[axis] + sum[axis] - along / C[axis]) * C[axis] / stretch;
        worst = worst.max(((cauchy(2) - cauchy(0)).abs() - found).abs() / G);
    }
    assert_at_most(worst, 2e-3, "von Mises stress in uniaxial strain, over G");
}

/// A column that shears across its length, held at one end.
fn column(elements: u32, end: f64) -> Value {
    let mut part = part("block", "mean_dilatation");
    part["prony_series"]["branches"] = json!([{"relative_modulus": 0.8, "relaxation_time_s": 0.02}]);
    json!({
        "name": "shear wave",
        "end_time_s": end,
        "bodies": [{
            "name": "column",
            "mesh": {"generator": {
                "kind": "block", "min_m": [0, 0, 0], "max_m": [0.01, 0.01, 0.1], "elements": [1, 1, elements]
            }},
            "fixed": [{"set": "z_min"}, {"set": "*", "axes": ["y", "z"]}],
            "parts": [part]
        }],
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Displacement over the initial speed [s] of `q̈ + ω² (q + g ∫ e^(−(t−s)/τ) q̇ ds) = 0`, by small steps.
fn damped_oscillator(omega: f64, [g, tau]: [f64; 2], end: f64) -> impl Fn(f64) -> f64 {
    let (steps, mut q, mut v, mut h) = (200_000, 0.0, 1.0, 0.0);
    let dt = end / f64::from(steps);
    let mut path = vec![0.0];
    for _ in 0..steps {
        // Heun's method.
        let slope = |q: f64, v: f64, h: f64| [v, -omega * omega * (q + g * h), v - h / tau];
        let a = slope(q, v, h);
        let b = slope(q + dt * a[0], v + dt * a[1], h + dt * a[2]);
        q += 0.5 * dt * (a[0] + b[0]);
        v += 0.5 * dt * (a[1] + b[1]);
        h += 0.5 * dt * (a[2] + b[2]);
        path.push(q);
    }
    move |t| path[((t / dt).round() as usize).min(path.len() - 1)]
}

/// Largest difference from the damped lowest mode, over its displacement without damping, and the largest error of the balance.
fn difference(elements: u32) -> (f64, f64) {
    let k = PI / (2.0 * 0.1);
    let omega = k * (G / 1000.0).sqrt();
    let end = 3.0 * PI / omega;
    let plan = plan(&column(elements, end));
    let exact = damped_oscillator(omega, [0.8, 0.02], end);
    // Strains of 10⁻⁸: what is not linear is of that size.
    difference_of_a_mode(&plan, (omega, 1e-9 * omega), |X| (k * X.z).sin(), exact)
}

#[test]
fn a_shear_wave_loses_what_its_loss_modulus_takes() {
    let (coarse, fine) = (difference(8), difference(16));
    assert_at_most(fine.0, 2e-3, "largest difference from the relaxing mode, 16 elements");
    assert_order(&[coarse.0, fine.0], 1.8, "relaxing shear wave, 8 to 16 elements");
    // Rounding in every step but the last, which has none behind it.
    assert_at_most(coarse.1.max(fine.1), 1e-7, "energy balance of the relaxing shear wave");
}

#[test]
fn a_copy_of_the_state_and_more_threads_give_the_same_bits() {
    let plan = plan(&column(64, 0.02));
    let start = || {
        let mut state = State::new(&plan);
        state.v.iter_mut().zip(&plan.X).for_each(|(v, X)| v.x = X.z);
        state
    };
    let one = run_on(&plan, start(), 1, |_| {}).1;
    let two = run_on(&plan, start(), 2, |_| {}).1;
    assert_eq!(one, two);
    assert!(one.history.iter().flatten().any(|row| row.0.iter().any(|x| *x != 0.0)));
}

#[test]
fn instantaneous_moduli_say_the_same_as_those_of_slow_loading() {
    let table = [[0.0, 0.0], [0.01, 0.3], [0.05, 0.3]];
    let slow = cube("mean_dilatation", [1.0, 0.0, 0.0], &table);
    let mut sudden = slow.clone();
    let part = &mut sudden["bodies"][0]["parts"][0];
    part["material"]["c10_pa"] = json!(2.5 * 0.5 * G);
    let branch = |[g, tau]: [f64; 2]| json!({"relative_modulus": g / 2.5, "relaxation_time_s": tau});
    part["prony_series"] = json!({"moduli": "instantaneous", "branches": BRANCHES.map(branch)});
    let work = |scene: &Value| {
        let mut work = 0.0;
        run(&plan(scene), |frame| work = frame.energy.bodies[0].external_work_j);
        work
    };
    assert_close(work(&sudden), work(&slow), 1e-12, "work by instantaneous and long-term moduli");
}
