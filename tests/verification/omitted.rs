//! What a plan omits changes no bit: the same scene with it restored ends in the same state.
//!
//! Equality is of every component as a number, so that the sign of a zero does not count.

use crate::rig::{plan, run};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::scene::document::Keep;
use contuse::step::{Outcome, State};
use serde_json::{Value, json};

fn keeping(document: &Value, keep: &[Keep]) -> Plan {
    let mut document = document.clone();
    document["solver"] = json!({"keep": keep});
    plan(&document)
}

/// Runs the scene with everything omitted and with `keep` restored; every step must be the same to the last bit.
fn assert_same(document: &Value, keep: &[Keep]) -> (Plan, Outcome, State) {
    let motion = |plan: &Plan| {
        let mut steps: Vec<(f64, Vec<Vec3>, Vec<f64>)> = Vec::new();
        let (outcome, state) = run(plan, |frame| {
            let energies = frame.energy.bodies.iter();
            let energies = energies.flat_map(|b| [b.kinetic_j, b.strain_j, b.viscous_j, b.contact_work_j]);
            let sums = [frame.energy.total_j, frame.energy.scale_j, frame.energy.balance_error];
            steps.push((frame.time, frame.v_after.to_vec(), energies.chain(sums).collect()));
        });
        (steps, outcome, state)
    };
    let (without, with) = (plan(document), keeping(document, keep));
    let (expected, outcome, state) = motion(&without);
    let (got, _, other) = motion(&with);
    assert_eq!(expected.len(), got.len());
    for (step, (a, b)) in expected.iter().zip(&got).enumerate() {
        assert!(a == b, "step {step} differs");
    }
    assert!(state.u == other.u && state.v == other.v && state.projected == other.projected);
    (without, outcome, state)
}

fn block(name: &str, low: [f64; 3], size: f64, elements: u32, velocity: [f64; 3]) -> Value {
    let (high, counts) = (low.map(|x| x + size), [elements; 3]);
    json!({
        "name": name,
        "mesh": {"generator": {"kind": "block", "min_m": low, "max_m": high, "elements": counts}},
        "velocity_m_per_s": velocity,
        "parts": [{"part": "block", "density_kg_per_m3": 1000,
            "material": {"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 2e7}}]
    })
}

/// A ball that strikes a block askew.
fn oblique(friction: f64) -> Value {
    let rubber = json!({"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 2e7});
    json!({
        "name": "oblique", "end_time_s": 2e-4,
        "bodies": [
            {"name": "ball",
             "mesh": {"generator": {"kind": "hollow_ball", "center_m": [0, 0, 0.0152], "outer_radius_m": 0.015,
                                    "inner_radius_m": 0.012, "elements_around": 4, "elements_through": 1}},
             "velocity_m_per_s": [25, 7, -40],
             "parts": [{"part": "ball", "density_kg_per_m3": 1100, "material": rubber}]},
            {"name": "block",
             "mesh": {"generator": {"kind": "block", "min_m": [-0.03, -0.03, -0.03], "max_m": [0.03, 0.03, 0],
                                    "elements": [7, 7, 3]}},
             "sets": [{"name": "bottom", "min_m": [-1, -1, -0.0301], "max_m": [1, 1, -0.0299]}],
             "fixed": [{"set": "bottom"}],
             "parts": [{"part": "block", "density_kg_per_m3": 1000,
                "material": {"law": "neo_hookean", "c10_pa": 5e4, "bulk_modulus_pa": 2e7}}]}
        ],
        "contact": {"friction": friction},
        "record": {"field_times_s": []}
    })
}

#[test]
fn one_unknown_a_contact_without_friction() {
    let (plan, outcome, _) = assert_same(&oblique(0.0), &[Keep::TangentialReactions]);
    assert!(outcome.most_contacts > 5, "{outcome:?}");
    assert_eq!(plan.report.pairs[0].unknowns_per_contact, 1);
}

#[test]
fn pairs_without_friction_beside_pairs_with_it() {
    let mut scene = oblique(0.3);
    scene["bodies"][1]["fixed"] = json!([]);
    scene["planes"] = json!([{"name": "floor", "point_m": [0, 0, -0.03], "normal": [0, 0, 1]}]);
    scene["contact"] = json!({"pairs": [
        {"between": ["ball", "block"], "friction": 0.3}, {"between": ["block", "floor"], "friction": 0}
    ]});
    let (plan, ..) = assert_same(&scene, &[Keep::TangentialReactions]);
    let unknowns: Vec<u32> = plan.report.pairs.iter().map(|p| p.unknowns_per_contact).collect();
    // Those that a list names, then each with itself.
    assert_eq!(unknowns, [3, 1, 1, 1]);
}

#[test]
fn elements_that_nothing_has_reached() {
    // Many chunks, of which most are inactive at the end; the ball flies until it touches, inactive in its own frame.
    for formulation in ["mean_dilatation", "full", "reduced"] {
        let mut scene = oblique(0.3);
        scene["bodies"][1] = block("block", [-0.02, -0.02, -0.04], 0.04, 20, [0.0, 0.0, 0.0]);
        for body in 0..2 {
            scene["bodies"][body]["parts"][0]["formulation"] = json!(formulation);
        }
        scene["end_time_s"] = json!(6e-5);
        let (plan, outcome, _) = assert_same(&scene, &[Keep::InactiveElements]);
        assert!(plan.skip_inactive_elements && plan.element_count() > 8000);
        let evaluated = outcome.evaluated_element_steps as f64 / outcome.element_steps as f64;
        assert!((0.001..0.6).contains(&evaluated), "{formulation}: {evaluated}");
        let (outcome, _) = run(&keeping(&scene, &[Keep::InactiveElements]), |_| {});
        assert_eq!(outcome.evaluated_element_steps, outcome.element_steps);
    }
}

#[test]
fn fibres_that_do_not_pull() {
    let mut scene = oblique(0.3);
    for i4 in ["full", "isochoric"] {
        scene["bodies"][1]["parts"][0]["material"] = json!({"law": "holzapfel_gasser_ogden", "c_pa": 1e5, "k1_pa": 0.0,
            "k2": 1.0, "kappa": 0.1, "fibres": {"angles_deg": [15, -15]}, "bulk_modulus_pa": 2e7, "i4": i4});
        let (plan, ..) = assert_same(&scene, &[Keep::IdleFibres]);
        assert_eq!(plan.report.blocks[1].fibre_families, 0);
    }
}

#[test]
fn fields_that_are_not_requested() {
    let (plan, ..) = assert_same(&oblique(0.3), &[Keep::UnrequestedFields]);
    assert_eq!(plan.fields.len(), 3);
}

#[test]
fn pairs_that_cannot_meet() {
    // An impact; a block that flies past another one closely; a third that flies to a wall that it does not reach.
    let scene = json!({
        "name": "passing", "end_time_s": 3e-4,
        "bodies": [
            block("striker", [0.0, 0.0, 0.0], 0.01, 2, [0.0, 0.0, -30.0]),
            block("target", [-0.005, -0.005, -0.0202], 0.02, 3, [0.0; 3]),
            block("passing", [0.2, 0.0, 0.0], 0.01, 2, [100.0, 0.0, 0.0]),
            block("still", [0.213, 0.0105, 0.0], 0.01, 2, [0.0; 3])
        ],
        "planes": [{"name": "wall", "point_m": [0.25, 0, 0], "normal": [-1, 0, 0]}],
        "contact": {"pairs": [
            {"between": ["striker", "target"]}, {"between": ["passing", "still"]}, {"between": ["passing", "wall"]}
        ]},
        "record": {"field_times_s": []}
    });
    let (without, outcome, state) = assert_same(&scene, &[Keep::DistantPairs]);
    let names: Vec<&str> = without.distant_pairs.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["passing–still", "passing–wall", "passing–passing", "still–still"]);
    assert!(outcome.most_contacts > 0 && state.ledger.pairs.len() == 3);
    let moved = &state.u[without.bodies[2].nodes.start as usize..];
    assert!(moved.iter().flatten().all(|u| u.to_bits() == 0), "nothing has touched them");

    // The pair with the wall stays when the gap between the two is within the reach of detection.
    let mut near = scene;
    near["bodies"][3]["mesh"]["generator"]["min_m"][1] = json!(0.0102);
    let kept = plan(&near);
    assert!(kept.distant_pairs.is_empty() && kept.contact.unwrap().pairs.len() == 7);
}

#[test]
fn strongly_stretched_fibres_that_do_not_pull() {
    // Their exponent would be beyond the limit, but without stiffness it is the exponent of nothing.
    let document = json!({
        "name": "stretched", "end_time_s": 1e-5,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.01, 0.01, 0.01], "elements": [1, 1, 1]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000,
                "fibre_frame": {"kind": "constant", "axis": [1, 0, 0], "plane": [0, 1, 0]},
                "material": {"law": "holzapfel_gasser_ogden", "c_pa": 1e5, "k1_pa": 0, "k2": 50, "kappa": 0,
                             "bulk_modulus_pa": 2e6, "fibres": {"angles_deg": [0]}}}],
            "initial_deformation": {"kind": "affine", "center_m": [0, 0, 0],
                "deformation_gradient": [[4, 0, 0], [0, 0.5, 0], [0, 0, 0.5]]}
        }],
        "integrator": {"kind": "explicit", "safety_factor": 0.2}
    });
    assert_same(&document, &[Keep::IdleFibres]);
}

#[test]
fn field_times_a_rounding_apart_are_one() {
    let mut document = oblique(0.0);
    let (_, without) = run(&plan(&document), |_| {});
    // As a loop over fiftieths leaves them: the last is one rounding before the end.
    let end = document["end_time_s"].as_f64().unwrap();
    let fiftieths = (0..50).map(|i| f64::from(i) * (end / 50.0));
    let times: Vec<f64> = fiftieths.chain([end.next_down()]).collect();
    document["record"] = json!({"field_times_s": times});
    let (outcome, state) = run(&plan(&document), |_| {});
    assert!(state.time == without.time && outcome.steps < 400, "{} steps", outcome.steps);
    // A gap that is no rounding costs steps, but is no collapse.
    document["record"] = json!({"field_times_s": [0.5 * end, 0.5 * end + 1e-12]});
    run(&plan(&document), |_| {});
}
