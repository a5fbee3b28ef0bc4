//! Energies of the branches of a Prony series, branch by branch.

use crate::relaxation::{BRANCHES, G, cube};
use crate::rig::{assert_at_most, assert_close, plan, run, run_on};
use contuse::step::{BranchEnergy, Interrupt, RunOptions, State, run_from};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Steps of the last of the cases below, one for each way of stepping.
fn integrators(step: f64) -> [(&'static str, Value); 3] {
    [
        (
            "explicit",
            json!({"kind": "explicit", "max_step_s": step, "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0}),
        ),
        ("implicit", json!({"kind": "implicit", "step_s": step, "theta": 0.5})),
        ("quasi-static", json!({"kind": "quasi_static", "step_s": step, "real_time": true})),
    ]
}

/// Per cycle of γ₀ sin ω t, in the steady state, a branch of modulus g G and time τ dissipates π g G γ₀² ωτ/(1 + ω²τ²) [J/m³], and
/// stores at the end of a cycle ½ g G γ₀² (ωτ)²/(1 + ω²τ²)².
#[test]
fn a_cycle_dissipates_in_each_branch_what_maxwell_says() {
    let (omega, gamma, cycles, n) = (2.0 * PI * 5.0, 1e-3, 8, 100);
    let table: Vec<[f64; 2]> = (0..=cycles * n)
        .map(|i| f64::from(i) / f64::from(n))
        .map(|cycle| [2.0 * PI * cycle / omega, gamma * (2.0 * PI * cycle).sin()])
        .collect();
    let period = 2.0 * PI / omega;
    for formulation in ["mean_dilatation", "reduced"] {
        let mut scene = cube(formulation, [1.0, 0.0, 0.0], &table);
        scene["integrator"] = integrators(1e-4)[0].1.clone();
        let (mut before_last, mut last) = (Vec::<BranchEnergy>::new(), Vec::new());
        run(&plan(&scene), |frame| {
            if frame.time <= (f64::from(cycles) - 1.0) * period * (1.0 + 1e-9) {
                before_last.clone_from(&frame.energy.branches);
            }
            last.clone_from(&frame.energy.branches);
        });
        assert_eq!(last.len(), BRANCHES.len());
        for (i, [g, tau]) in BRANCHES.into_iter().enumerate() {
            let x = omega * tau;
            let loss = PI * g * G * gamma * gamma * x / (1.0 + x * x);
            let stored = 0.5 * g * G * gamma * gamma * (x / (1.0 + x * x)).powi(2);
            assert!(last[i].relaxation_time_s == tau && last[i].body == 0);
            let found = last[i].dissipated_j - before_last[i].dissipated_j;
            assert_close(
                found,
                loss,
                5e-3,
                &format!("dissipated in a cycle by the branch of {tau} s, {formulation}"),
            );
            assert_close(
                last[i].stored_j,
                stored,
                2e-2,
                &format!("stored by the branch of {tau} s, {formulation}"),
            );
        }
    }
}

/// With relaxation alone the sums over the branches are the totals of the body, also of large strains.
#[test]
fn branches_add_up_to_the_totals() {
    let table = [[0.0, 0.0], [0.02, 0.4], [0.05, -0.3], [0.1, 0.2]];
    for formulation in ["mean_dilatation", "full", "reduced"] {
        for (name, integrator) in integrators(1e-3) {
            let mut scene = cube(formulation, [1.0, 0.0, 0.3], &table);
            scene["integrator"] = integrator;
            let (mut worst, mut largest) = ([0.0_f64; 2], 0.0_f64);
            run(&plan(&scene), |frame| {
                let (body, branches) = (&frame.energy.bodies[0], &frame.energy.branches);
                let stored: f64 = branches.iter().map(|b| b.stored_j).sum();
                let dissipated: f64 = branches.iter().map(|b| b.dissipated_j).sum();
                worst[0] = worst[0].max((stored - body.branches_j).abs());
                worst[1] = worst[1].max((dissipated - body.viscous_j).abs());
                largest = largest.max(body.viscous_j);
            });
            assert!(largest > 100.0, "{largest} J");
            assert_at_most(
                worst[0] / largest,
                1e-13,
                &format!("stored, branches less body, {name} {formulation}"),
            );
            assert_at_most(
                worst[1] / largest,
                1e-12,
                &format!("dissipated, branches less body, {name} {formulation}"),
            );
        }
    }
}

#[test]
fn a_copy_of_the_state_and_more_threads_give_the_same_branches() {
    let table = [[0.0, 0.0], [0.02, 0.2], [0.04, -0.1]];
    let whole = plan(&cube("mean_dilatation", [1.0, 0.0, 0.0], &table));
    let branches = |threads: usize| {
        let mut last = Vec::new();
        run_on(&whole, State::new(&whole), threads, |frame| last.clone_from(&frame.energy.branches));
        last
    };
    let straight = branches(1);
    assert!(straight == branches(2) && straight.iter().all(|b| b.dissipated_j > 0.0), "{straight:?}");
    // Stopped after a hundred steps, and resumed.
    let requested = AtomicUsize::new(0);
    let after_hundred = || (requested.fetch_add(1, Ordering::Relaxed) >= 100).then_some(Interrupt::Cancel);
    let options = RunOptions { threads: 1, interrupt: &after_hundred };
    let (_, middle) = run_from(&whole, State::new(&whole), &options, &mut []);
    assert!(middle.step == 100 && middle.time < 0.04);
    let mut last = Vec::new();
    run_on(&whole, middle, 1, |frame| last.clone_from(&frame.energy.branches));
    assert!(last == straight, "{last:?} {straight:?}");
}

/// Without relaxation there are no branches, and nothing of them is remembered.
#[test]
fn there_are_no_branches_without_relaxation() {
    let mut scene = cube("mean_dilatation", [1.0, 0.0, 0.0], &[[0.0, 0.0], [0.01, 0.1]]);
    scene["bodies"][0]["parts"][0].as_object_mut().unwrap().remove("prony_series");
    let plan = plan(&scene);
    assert_eq!(plan.blocks[0].branch_count(), 0);
    run(&plan, |frame| assert!(frame.energy.branches.is_empty()));
}
