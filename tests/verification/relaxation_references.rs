//! A Prony series with instantaneous moduli by whole runs, explicit, implicit and quasi-static, against exact convolutions; and shear waves
//! that it or a viscosity damps, in implicit steps.

use crate::rig::{assert_at_most, assert_close, assert_order, difference_of_a_mode, plan, run, run_on};
use contuse::step::State;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// Instantaneous shear modulus [Pa]; relative moduli [-] and relaxation times [s].
const G0: f64 = 1e4;
const BRANCHES: [[f64; 2]; 2] = [[0.3, 1e-3], [0.2, 1e-2]];
const GAMMA: f64 = 1e-6;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Steps {
    Explicit,
    Implicit,
    QuasiStatic,
}

impl Steps {
    fn integrator(self, h: f64) -> Value {
        match self {
            Self::Explicit => json!({"kind": "explicit", "max_step_s": h}),
            Self::Implicit => {
                json!({"kind": "implicit", "step_s": h, "theta": 1.0, "newton_tolerance": 1e-11})
            }
            Self::QuasiStatic => {
                json!({"kind": "quasi_static", "step_s": h, "real_time": true, "newton_tolerance": 1e-11})
            }
        }
    }
}

fn series() -> Value {
    let branch = |[g, tau]: [f64; 2]| json!({"relative_modulus": g, "relaxation_time_s": tau});
    json!({"moduli": "instantaneous", "branches": BRANCHES.map(branch)})
}

/// σ/(G0 γ) over time of a cube of a millimetre that is sheared by γ times the factors at multiples of h [s].
fn stress(steps: Steps, h: f64, factors: &[f64]) -> Vec<f64> {
    // A layer of free nodes in implicit runs, too light to matter.
    let (layers, density) = if steps == Steps::Explicit { (1, 1000.0) } else { (2, 0.1) };
    let times: Vec<f64> = (0..factors.len()).map(|i| i as f64 * h).collect();
    let scene = json!({
        "name": "sheared cube",
        "end_time_s": times.last(),
        "bodies": [{
            "name": "cube",
            "mesh": {"generator": {
                "kind": "block", "min_m": [0, 0, 0], "max_m": [1e-3, 1e-3, 1e-3], "elements": [1, 1, layers]
            }},
            "fixed": [{"set": "z_min"}, {"set": "*", "axes": ["y", "z"]}],
            "prescribed": [{
                "set": "z_max", "axes": ["x"], "displacement_m": [GAMMA * 1e-3, 0, 0],
                "ramp": {"kind": "table", "times_s": times, "factors": factors}
            }],
            "parts": [{
                "part": "block", "density_kg_per_m3": density, "prony_series": series(),
                "material": {"law": "neo_hookean", "c10_pa": 0.5 * G0, "bulk_modulus_pa": 2.0 * G0}
            }]
        }],
        "integrator": steps.integrator(h),
        "record": {"fields": [], "field_interval_s": h}
    });
    let mut stress = Vec::new();
    run(&plan(&scene), |frame| {
        if frame.is_field_time {
            let mut found = 0.0;
            frame.plan.blocks[0].for_each_moved_batch(frame.points(), &mut |_, points| {
                found = points.cauchy[0][5].0[0] / (G0 * GAMMA);
            });
            stress.push(found);
        }
    });
    assert_eq!(stress.len(), factors.len(), "{steps:?}");
    stress
}

#[test]
fn a_held_strain_relaxes_as_the_series_says() {
    for steps in [Steps::Explicit, Steps::QuasiStatic] {
        let error = |n: u32| {
            // Strained within the first step: as of half of it.
            let h = 1e-3 / (f64::from(n) - 0.5);
            let mut factors = vec![1.0; n as usize + 1];
            factors[0] = 0.0;
            (stress(steps, h, &factors)[n as usize] - 0.791_331_316_0).abs()
        };
        let (coarse, fine) = (error(12), error(24));
        assert_at_most(fine, 2e-5, &format!("G(1 ms)/G0, {steps:?}"));
        assert_order(&[coarse, fine], 1.9, &format!("G(1 ms)/G0, {steps:?}"));
    }
}

#[test]
fn a_ramp_is_exact_however_long_the_steps() {
    // To 5 ms at a constant rate; at 100/s the strain would be 0.5 in a linear material.
    for steps in [Steps::Explicit, Steps::Implicit, Steps::QuasiStatic] {
        let n: u32 = if steps == Steps::QuasiStatic { 10 } else { 100 };
        let factors: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
        let found = *stress(steps, 5e-3 / f64::from(n), &factors).last().unwrap() * 0.5;
        // Free sides bulge by the square of the strain.
        assert_at_most((found - 0.358_491_729_6).abs(), 1e-7, &format!("σ/G0 after the ramp, {steps:?}"));
    }
}

#[test]
fn cycles_have_the_storage_and_the_loss_modulus() {
    let (frequency, cycles) = (100.0, 12);
    for steps in [Steps::Explicit, Steps::Implicit, Steps::QuasiStatic] {
        let errors = |n: u32| {
            let h = 1.0 / (frequency * f64::from(n));
            let phase = |i: u32| 2.0 * PI * f64::from(i) / f64::from(n);
            let factors: Vec<f64> = (0..=cycles * n).map(|i| phase(i).sin()).collect();
            let stress = stress(steps, h, &factors);
            // The first harmonic of the last cycle.
            let (mut storage, mut loss) = (0.0, 0.0);
            for i in (cycles - 1) * n..cycles * n {
                storage += 2.0 / f64::from(n) * stress[i as usize] * phase(i).sin();
                loss += 2.0 / f64::from(n) * stress[i as usize] * phase(i).cos();
            }
            [(storage - 0.779_972_055_3).abs(), (loss - 0.166_187_792_2).abs()]
        };
        let (coarse, fine) = (errors(40), errors(80));
        for (i, what) in ["storage", "loss"].into_iter().enumerate() {
            assert_at_most(fine[i], 3e-4, &format!("{what} modulus at 100 Hz over G0, {steps:?}"));
            assert_order(&[coarse[i], fine[i]], 1.8, &format!("{what} modulus at 100 Hz, {steps:?}"));
        }
    }
}

/// A column that shears across its length, held at one end, in implicit steps.
fn column(step: f64, end: f64, theta: f64, part: &Value) -> Value {
    json!({
        "name": "shear wave",
        "end_time_s": end,
        "bodies": [{
            "name": "column",
            "mesh": {"generator": {
                "kind": "block", "min_m": [0, 0, 0], "max_m": [0.01, 0.01, 0.1], "elements": [1, 1, 16]
            }},
            "fixed": [{"set": "z_min"}, {"set": "*", "axes": ["y", "z"]}],
            "parts": [part]
        }],
        "integrator": {"kind": "implicit", "step_s": step, "theta": theta, "newton_tolerance": 1e-11},
        "record": {"fields": [], "field_times_s": []}
    })
}

fn part(name: &str, extra: &Value) -> Value {
    let mut part = json!({
        "part": name, "density_kg_per_m3": 1000.0,
        "material": {"law": "neo_hookean", "c10_pa": 0.5 * G0, "bulk_modulus_pa": 2.0 * G0}
    });
    for (key, value) in extra.as_object().unwrap() {
        part[key] = value.clone();
    }
    part
}

/// Wave number [1/m] and angular frequency [1/s] of the lowest mode.
fn lowest_mode() -> (f64, f64) {
    let k = PI / (2.0 * 0.1);
    (k, k * (G0 / 1000.0).sqrt())
}

#[test]
fn a_viscous_shear_wave_dies_down_in_implicit_steps() {
    let (zeta, (k, omega)) = (0.2, lowest_mode());
    let (delta, damped) = (zeta * omega, omega * (1.0_f64 - zeta * zeta).sqrt());
    let part = part("block", &json!({"shear_viscosity_pa_s": 2.0 * zeta * omega * 1000.0 / (k * k)}));
    let exact = |t: f64| (-delta * t).exp() * (damped * t).sin() / damped;
    let end = 3.0 * PI / damped;
    let difference = |steps: f64| {
        let plan = plan(&column(end / steps, end, 0.5, &part));
        difference_of_a_mode(&plan, (omega, 1e-7 * omega), |X| (k * X.z).sin(), exact)
    };
    let (coarse, fine) = (difference(30.0), difference(60.0));
    assert_at_most(fine.0, 1e-2, "largest difference from the damped mode, 40 steps a period");
    assert_order(&[coarse.0, fine.0], 1.8, "damped shear wave, 20 to 40 steps a period");
    assert_at_most(coarse.1.max(fine.1), 1e-9, "energy balance of the damped shear wave");
}

#[test]
fn a_relaxing_shear_wave_dies_down_in_implicit_steps() {
    let (k, omega) = lowest_mode();
    let series = json!({"branches": [{"relative_modulus": 0.8, "relaxation_time_s": 0.02}]});
    let part = part("block", &json!({"prony_series": series}));
    let end = 3.0 * PI / omega;
    // q̈ + ω² (q + 0.8 ∫ e^(−(t−s)/τ) q̇ ds) = 0 by small steps of the midpoint.
    let fine_steps = 200_000;
    let dt = end / f64::from(fine_steps);
    let slope = |[q, v, h]: [f64; 3]| [v, -omega * omega * (q + 0.8 * h), v - h / 0.02];
    let mut path = vec![[0.0, 1.0, 0.0]];
    for i in 0..fine_steps as usize {
        let ahead = |x: [f64; 3], by: [f64; 3], dt: f64| std::array::from_fn(|i| x[i] + dt * by[i]);
        let middle = ahead(path[i], slope(path[i]), 0.5 * dt);
        path.push(ahead(path[i], slope(middle), dt));
    }
    let exact = |t: f64| path[((t / dt).round() as usize).min(fine_steps as usize)][0];
    let difference = |steps: f64| {
        let plan = plan(&column(end / steps, end, 0.5, &part));
        difference_of_a_mode(&plan, (omega, 1e-7 * omega), |X| (k * X.z).sin(), exact)
    };
    let (coarse, fine) = (difference(30.0), difference(60.0));
    assert_at_most(fine.0, 1e-2, "largest difference from the relaxing mode, 40 steps a period");
    assert_order(&[coarse.0, fine.0], 1.8, "relaxing shear wave, 20 to 40 steps a period");
    assert_at_most(coarse.1.max(fine.1), 1e-9, "energy balance of the relaxing shear wave");
}

/// A column in large shear, with viscosity and a series, which relaxes from a deformed start.
fn large_shear(step: f64) -> Value {
    let extra = json!({
        "shear_viscosity_pa_s": 50.0,
        "prony_series": {"branches": BRANCHES.map(|[g, tau]| json!({"relative_modulus": g, "relaxation_time_s": tau}))}
    });
    let mut scene = column(step, 0.05, 0.6, &part("block", &extra));
    scene["bodies"][0]["fixed"] = json!([{"set": "z_min"}]);
    // Met exactly, so that the steps are those of a run to there.
    scene["record"]["field_times_s"] = json!([0.025]);
    scene
}

#[test]
fn large_deformations_close_the_ledger_and_restart_with_the_same_bits() {
    let plan = plan(&large_shear(1e-3));
    let start = || {
        let mut state = State::new(&plan);
        state.v.iter_mut().zip(&plan.X).for_each(|(v, X)| v.x = 30.0 * X.z);
        state
    };
    let (mut balance, mut largest, mut last) = (0.0_f64, 0.0_f64, None);
    let (_, straight) = run_on(&plan, start(), 1, |frame| {
        balance = balance.max(frame.energy.balance_error);
        largest = largest.max(frame.u.iter().map(|u| u.x).fold(0.0, f64::max));
        last = Some(frame.energy.bodies[0]);
    });
    let last = last.unwrap();
    assert!(largest > 0.03, "the shear is large: {largest} m");
    assert!(last.viscous_j > 0.1 * (last.kinetic_j + last.strain_j), "{last:?}");
    assert_at_most(balance, 1e-9, "energy balance of a column in large shear");

    // The same on two threads, and from a copy in the middle.
    let (_, two) = run_on(&plan, start(), 2, |_| {});
    assert!(two == straight, "bits on two threads");
    assert!(straight.history.iter().flatten().any(|row| row.0.iter().any(|x| *x != 0.0)));
    let mut half = large_shear(1e-3);
    half["end_time_s"] = json!(0.025);
    let half = crate::rig::plan(&half);
    let (_, middle) = run_on(&half, start(), 1, |_| {});
    let (_, restarted) = run_on(&plan, middle, 1, |_| {});
    assert!(restarted == straight, "bits after a restart");
}

#[test]
fn load_steps_in_real_time_dissipate_what_the_series_takes() {
    // Sheared at a constant rate in 10 ms, then held for 30 ms.
    let (ramp, end) = (1e-2, 4e-2);
    let found = |n: u32| {
        let mut scene =
            column(ramp / f64::from(n), end, 0.5, &part("block", &json!({"prony_series": series()})));
        scene["integrator"] = Steps::QuasiStatic.integrator(ramp / f64::from(n));
        scene["bodies"][0]["prescribed"] = json!([{
            "set": "z_max", "axes": ["x"], "displacement_m": [GAMMA * 0.1, 0, 0],
            "ramp": {"kind": "table", "times_s": [0.0, ramp, end], "factors": [0.0, 1.0, 1.0]}
        }]);
        let mut last = None;
        run(&plan(&scene), |frame| {
            assert_at_most(frame.energy.balance_error, 1e-9, "energy balance of load steps in real time");
            last = Some(frame.energy.bodies[0]);
        });
        last.unwrap()
    };
    // Each branch: ∫ σ²/(g G0 τ) dt, in 1e-5 m³.
    let (mut dissipated, mut stored) = (0.0, 0.0);
    for [g, tau] in BRANCHES {
        let (e, viscosity, rate) = ((-ramp / tau).exp(), g * G0 * tau, GAMMA / ramp);
        let growing = viscosity * rate * rate * (ramp - 2.0 * tau * (1.0 - e) + 0.5 * tau * (1.0 - e * e));
        let (peak, left) = (viscosity * rate * (1.0 - e), (-(end - ramp) / tau).exp());
        dissipated += 1e-5 * (growing + 0.5 * peak * peak / (g * G0) * (1.0 - left * left));
        stored += 1e-5 * 0.5 * (peak * left).powi(2) / (g * G0);
    }
    let (coarse, fine) = (found(10), found(20));
    let error = |of: f64| (of / dissipated - 1.0).abs();
    assert_at_most(error(fine.viscous_j), 2e-3, "dissipated by relaxation, relative");
    assert_order(
        &[error(coarse.viscous_j), error(fine.viscous_j)],
        1.8,
        "dissipation of load steps in real time",
    );
    assert_close(fine.branches_j, stored, 1e-3, "stored in the branches");
}
