//! A hollow rubber ball strikes a soft block: one scene for every code, on three levels of mesh.
//!
//! Reference: an independent penalty-contact code on three mesh levels; with μ = 0.3 its finest gives an impulse of
//! 0.0244 N s at 25 µs and 0.0752 N s at 50 µs (2–3 %), see the scenario's README. Levels 0 and 1 are the shared meshes,
//! level 2 the same shapes from the generators.
//!
//! The levels are compared without bulk viscosity: its contribution falls with the element size as well, and with the default
//! coefficients it still adds 6 % to the impulse at 25 µs on level 2 (0.0259 against 0.0245 N s).

use super::rig;
use crate::record::assert_close;
use contuse::plan::{Plan, compile};
use contuse::scene::{Budget, FolderSource, load};
use contuse::step::{Ending, Energy, Outcome, State};
use serde_json::{Value, json};
use std::path::Path;

/// Impulses of the reference at 25 and 50 µs [N s].
const REFERENCE: [f64; 2] = [0.0244, 0.0752];

pub fn scenario(name: &str, change: impl FnOnce(&mut Value)) -> Plan {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ball_on_block");
    let mut document: Value = serde_json::from_slice(&std::fs::read(folder.join(name)).unwrap()).unwrap();
    change(&mut document);
    let bytes = serde_json::to_vec(&document).unwrap();
    let loaded = load(&bytes, &FolderSource::new(&folder), &Budget::COMMAND_LINE).unwrap();
    compile(&loaded.scene).unwrap()
}

/// Impulse on the slave at 25 and 50 µs [N s], the last energies, and how it ended.
fn impulses(plan: &Plan) -> ([f64; 2], Energy, Outcome) {
    let mut found = [0.0; 2];
    let mut energy = Energy::default();
    let (outcome, _) = rig::run_on(plan, State::new(plan), 2, |frame| {
        for (time, found) in [25e-6, 50e-6].into_iter().zip(&mut found) {
            if frame.time == time {
                *found = frame.energy.pairs[0].impulse_n_s.iter().map(|p| p * p).sum::<f64>().sqrt();
            }
        }
        energy = frame.energy.clone();
    });
    (found, energy, outcome)
}

#[test]
fn impulse_converges_to_the_reference() {
    let to_50_us = |document: &mut Value| {
        document["end_time_s"] = json!(50e-6);
        document["record"] = json!({"fields": [], "field_times_s": [0, 25e-6, 50e-6]});
        document["integrator"] =
            json!({"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0});
    };
    let levels = ["scene.json", "scene_L1.json", "scene_L2.json"].map(|name| {
        let (impulse, energy, outcome) = impulses(&scenario(name, to_50_us));
        assert_eq!(outcome.ending, Ending::Finished, "{name}");
        assert!(outcome.balance_error < 0.01, "{name}: {}", outcome.balance_error);
        (impulse, energy.numerical_contact_j() / energy.initial_total_j)
    });
    for (i, reference) in REFERENCE.into_iter().enumerate() {
        let error = levels.map(|(impulse, _)| (impulse[i] / reference - 1.0).abs());
        let what = format!("impulse at {} µs, finest mesh [N s]", 25 * (i + 1));
        assert_close(levels[2].0[i], reference, 0.05, &what);
        // The finest within the 5 % that the reference's own 2–3 % leaves room for; what is below 2 % on the way has converged.
        assert!(error[2] < error[0].max(0.02), "at {} µs: {error:?}", 25 * (i + 1));
    }
    // What lumped contact nodes lose is a matter of the mesh: about halved by each level.
    assert!(levels[0].1 > 1.5 * levels[1].1 && levels[1].1 > 1.5 * levels[2].1, "{levels:?}");
}

#[test]
fn runs_on_to_100_us_with_every_term_counted() {
    for name in ["scene.json", "scene_frictionless.json", "scene_L1.json", "scene_L1_frictionless.json"] {
        let (_, energy, outcome) = impulses(&scenario(name, |_| ()));
        assert_eq!(outcome.ending, Ending::Finished, "{name}");
        assert!(outcome.balance_error < 0.01, "{name}: {}", outcome.balance_error);
        // Its own line, and never creation.
        assert!(energy.numerical_contact_j() > 0.0, "{name}");
        let rubs = energy.pairs[0].friction_j > 0.0;
        assert_eq!(rubs, !name.contains("frictionless"), "{name}");
    }
}

#[test]
fn the_same_mesh_from_gmsh_and_abaqus_gives_the_same_run() {
    let runs = ["scene.json", "scene_L0_inp.json"].map(|name| impulses(&scenario(name, |_| ())));
    assert_eq!(runs[0].0, runs[1].0);
    assert_eq!(runs[0].1, runs[1].1);
}
