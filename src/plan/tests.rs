//! Tests of plans, their reports and what they omit.
#![allow(clippy::unwrap_used)] // tests say what they expect by panicking, their own functions too

use super::*;
use crate::mechanics::contact::ContactLaw;
use crate::mechanics::force::ElementBlock;
use crate::scene::document::Keep;
use crate::scene::{Budget, FolderSource, load};
use serde_json::{Value, json};

/// A block of tissue with two laws, and a smaller block that falls onto it.
fn scene() -> Value {
    let block = |name: &str, min: [f64; 3], max: [f64; 3], elements: [u32; 3], material: Value| {
        json!({
            "name": name,
            "mesh": {"generator": {"kind": "block", "min_m": min, "max_m": max, "elements": elements}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": material}]
        })
    };
    let tissue = json!({"law": "holzapfel_gasser_ogden", "c_pa": 1e4, "k1_pa": 0.0, "k2": 1.0,
                        "fibres": {"angles_deg": [15, -15]}, "bulk_modulus_pa": 2e6});
    let rubber = json!({"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7});
    let mut ground = block("ground", [0.0, 0.0, -0.02], [0.04, 0.04, 0.0], [4, 4, 2], tissue);
    ground["role"] = json!("tissue");
    let mut stone = block("stone", [0.01, 0.01, 0.001], [0.02, 0.02, 0.011], [2, 2, 2], rubber);
    stone["velocity_m_per_s"] = json!([0, 0, -10]);
    json!({
        "name": "stone on ground", "end_time_s": 2e-4, "bodies": [ground, stone],
        "planes": [{"name": "ceiling", "point_m": [0, 0, 1], "normal": [0, 0, -1]}],
        "contact": {"pairs": [{"between": ["stone", "ground"]}, {"between": ["stone", "stone"]}]},
        "record": {"fields": ["von_mises"]}
    })
}

fn compiled(document: &Value) -> Plan {
    let bytes = serde_json::to_vec(document).unwrap();
    compile(&load(&bytes, &FolderSource::new("."), &Budget::COMMAND_LINE).unwrap().scene).unwrap()
}

fn keeping(mut document: Value, keep: &[Keep]) -> Plan {
    document["solver"] = json!({"keep": keep});
    compiled(&document)
}

fn switches(plan: &Plan) -> Vec<Keep> {
    plan.report.omitted.iter().filter_map(|l| l.switch).collect()
}

#[test]
fn each_switch_restores_its_item_and_nothing_else() {
    let plan = compiled(&scene());
    let all = [
        Keep::InactiveElements,
        Keep::IdleSelfContact,
        Keep::TangentialReactions,
        Keep::IdleFibres,
        Keep::UnrequestedFields,
    ];
    assert_eq!(switches(&plan), all);
    assert_eq!(plan.report.restored, []);
    for keep in all {
        let other = keeping(scene(), &[keep]);
        let expected: Vec<Keep> = all.into_iter().filter(|k| *k != keep).collect();
        assert_eq!((switches(&other), &other.report.restored[..]), (expected, &[keep][..]));
        let families = |plan: &Plan| plan.blocks[0].parameters.material.family_count();
        assert_eq!(other.skip_inactive_elements, keep != Keep::InactiveElements);
        assert_eq!(families(&other), if keep == Keep::IdleFibres { 2 } else { 0 });
        assert_eq!(other.fields.len(), if keep == Keep::UnrequestedFields { 6 } else { 1 });
        let contact = other.contact.as_ref().unwrap();
        assert_eq!(contact.always_searches_self_contact, keep == Keep::IdleSelfContact);
        let law = contact.pairs.get(0).law;
        let expected = if keep == Keep::TangentialReactions {
            ContactLaw::Coulomb(0.0)
        } else {
            ContactLaw::Frictionless
        };
        assert_eq!(law, expected);
    }
    assert_eq!(switches(&keeping(scene(), &Keep::ALL)), []);
}

#[test]
fn a_far_plane_is_omitted_unless_the_body_may_be_thrown_at_it() {
    let mut document = scene();
    document["contact"] = json!({"pairs": [{"between": ["stone", "ceiling"]}]});
    let plan = compiled(&document);
    assert!(plan.contact.is_none() && plan.distant_pairs[0].name == "stone–ceiling");
    assert!(!plan.distant_pairs[0].on_tissue);
    assert!(switches(&plan).contains(&Keep::DistantPairs));
    let plan = keeping(document.clone(), &[Keep::DistantPairs]);
    assert!(plan.contact.is_some() && plan.distant_pairs.is_empty());

    document["contact"] = json!({"pairs": "all"});
    let plan = compiled(&document);
    assert_eq!((plan.contact.as_ref().unwrap().pairs.len(), plan.distant_pairs.len()), (5, 0));
    // Bodies that start deformed or spinning, or fall, are not bounded.
    document["contact"] = json!({"pairs": [{"between": ["stone", "ceiling"]}]});
    document["bodies"][1]["spin_rad_per_s"] = json!([0, 0, 1]);
    assert!(compiled(&document).contact.is_some());
    document["bodies"][1]["spin_rad_per_s"] = json!([0, 0, 0]);
    document["gravity_m_per_s2"] = json!([0, 0, -9.81]);
    assert!(compiled(&document).contact.is_some());
}

#[test]
fn bodies_that_deform_meet_themselves_unless_the_scene_says_otherwise() {
    let requested = |contact: Value| {
        let mut document = scene();
        document["contact"] = contact;
        let plan = compiled(&document);
        let of_itself: Vec<String> = plan.bodies_that_meet_themselves().map(|b| b.name.clone()).collect();
        let words = plan.report.omitted.iter().find(|l| l.what == "self-contact").map(|l| l.why.clone());
        (of_itself, words.unwrap_or_default())
    };
    assert_eq!(requested(json!({"pairs": "all"})), (vec!["ground".into(), "stone".into()], String::new()));
    let (of_itself, words) = requested(json!({"pairs": "all", "self_contact": "none"}));
    assert!(of_itself.is_empty() && words.contains("disabled in the scene"), "{words}");
    let list = json!([{"between": ["stone", "ground"]}]);
    assert_eq!(requested(json!({"pairs": list})), (vec!["ground".into(), "stone".into()], String::new()));
    let list = json!([{"between": ["stone", "ground"]}, {"between": ["stone", "stone"]}]);
    assert_eq!(requested(json!({"pairs": list})), (vec!["stone".into(), "ground".into()], String::new()));
    assert_eq!(requested(json!({"pairs": list, "self_contact": "none"})).0, Vec::<String>::new());
    let (of_itself, words) = requested(json!({"pairs": []}));
    assert!(of_itself.is_empty() && words.contains("lists no pair"), "{words}");
}

#[test]
fn nothing_is_inactive_under_gravity_or_where_all_moves_from_the_start() {
    let mut document = scene();
    document["gravity_m_per_s2"] = json!([0, 0, -9.81]);
    let plan = compiled(&document);
    assert!(
        !plan.skip_inactive_elements && plan.report.kept.iter().any(|k| k.starts_with("inactive elements"))
    );
    let mut document = scene();
    document["contact"]["pairs"] = json!([]);
    document["bodies"] = json!([document["bodies"][1]]);
    document["bodies"][0]["initial_deformation"] = json!({"kind": "affine", "center_m": [9, 9, 9], "deformation_gradient": [[1.01, 0, 0], [0, 1.01, 0], [0, 0, 1.01]]});
    let plan = compiled(&document);
    assert!(!plan.skip_inactive_elements && !switches(&plan).contains(&Keep::InactiveElements));
}

#[test]
fn the_report_counts_what_the_plan_holds() {
    let plan = compiled(&scene());
    let report = &plan.report;
    assert_eq!((report.nodes, report.elements), (75 + 27, 32 + 8));
    assert_eq!(report.blocks.iter().map(|b| b.elements).sum::<usize>(), report.elements);
    let [ground, stone] = &report.blocks[..] else { panic!() };
    assert_eq!((ground.law.as_str(), ground.fibre_families), ("Holzapfel–Gasser–Ogden", 0));
    assert_eq!((stone.law.as_str(), stone.formulation.as_str()), ("Mooney–Rivlin", "mean dilatation"));
    assert_eq!((stone.body.as_str(), &stone.parts[..]), ("stone", &["block".to_owned()][..]));
    let pair = &report.pairs[0];
    assert_eq!((pair.unknowns_per_contact, pair.friction), (1, 0.0));
    assert_eq!(report.memory_bytes, report.memory.total_bytes());
    let of_elements = report.memory.bytes_per_element * report.elements as f64;
    let total = of_elements + report.memory.program_bytes as f64;
    assert!((total - report.memory_bytes as f64).abs() < 1.0);

    // √(K/ρ) is 224 m/s in the stone and 45 m/s in the ground, over elements of 5 and 10 mm: the stone is critical.
    let step = &report.stable_step;
    assert_eq!((step.body.as_str(), step.part.as_str()), ("stone", "block"));
    assert!((step.smallest_s - stone.smallest_stable_step_s).abs() == 0.0);
    assert!(ground.smallest_stable_step_s > 5.0 * step.smallest_s);
    assert!((report.stable_step_s - 0.9 * step.smallest_s).abs() < 1e-12 * step.smallest_s);
    // Fifty equal intervals between the field times, each of whole steps.
    assert_eq!(report.expected_steps, 50 * (2e-4 / 50.0 / report.stable_step_s).ceil() as u64);
    // Its eight elements are equal, and the others are far from critical.
    let counts: Vec<usize> = step.distribution.iter().map(|w| w.elements).collect();
    assert_eq!(counts, [8, 8, 8]);
    assert!((step.distribution[0].fraction - 0.2).abs() < 1e-15);
}

#[test]
fn costs_grow_with_families_and_restored_fibres() {
    let (without, with) = (compiled(&scene()), keeping(scene(), &[Keep::IdleFibres]));
    let rate = |plan: &Plan| plan.report.blocks[0].element_steps_per_s;
    assert!(rate(&with) < rate(&without));
    assert!(with.report.expected_run_time_s > without.report.expected_run_time_s);
    assert!(without.report.expected_run_time_s > 0.0);
}

/// A steel bar under slow tension: a second of vibration, in steps of a microsecond.
fn slow_and_stiff() -> Value {
    json!({
        "name": "slow bar", "end_time_s": 1.0,
        "bodies": [{
            "name": "bar",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.2, 0.02, 0.02], "elements": [20, 2, 2]}},
            "fixed": [{"set": "x_min"}],
            "parts": [{"part": "block", "density_kg_per_m3": 7850, "material": {
                "law": "neo_hookean", "c10_pa": 4e10, "bulk_modulus_pa": 1.6e11
            }}]
        }],
        "gravity_m_per_s2": [0, 0, -9.81],
        "integrator": {"kind": "auto"}
    })
}

#[test]
fn a_slow_stiff_scene_is_stepped_implicitly_and_a_shot_explicitly() {
    let slow = compiled(&slow_and_stiff());
    let choice = slow.report.integrator.choice.clone().unwrap();
    let implicit = choice.implicit.clone().unwrap();
    assert_eq!((choice.chosen.as_str(), slow.report.integrator.kind.as_str()), ("implicit", "implicit"));
    assert!(implicit.run_time_s < choice.explicit.run_time_s, "{choice:#?}");
    assert!(
        (implicit.step_s - 0.01).abs() < 1e-15 && slow.report.kept[0].contains(&choice.why),
        "{choice:#?}"
    );

    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/flashball_thigh");
    let mut shot: Value = serde_json::from_slice(&std::fs::read(folder.join("scene.json")).unwrap()).unwrap();
    shot["integrator"] = json!({"kind": "auto"});
    let bytes = serde_json::to_vec(&shot).unwrap();
    let loaded = load(&bytes, &FolderSource::new(&folder), &Budget::COMMAND_LINE).unwrap();
    let choice = loaded.scene.choice.unwrap();
    assert_eq!(choice.chosen, "explicit");
    // A body moves by at most half an edge in a step: the default holds even where no matrix is analysed.
    assert!(loaded.scene.document.integrator == crate::scene::document::IntegratorDocument::default());
}

#[test]
fn what_auto_chose_has_the_bits_and_the_hash_of_its_document() {
    // The choice does not change the problem, and depends on a given step.
    let mut document = slow_and_stiff();
    let auto = load(&serde_json::to_vec(&document).unwrap(), &FolderSource::new("."), &Budget::COMMAND_LINE)
        .unwrap();
    document["integrator"] = json!({"kind": "implicit", "step_s": 0.01, "theta": 0.6});
    let own = load(&serde_json::to_vec(&document).unwrap(), &FolderSource::new("."), &Budget::COMMAND_LINE)
        .unwrap();
    assert_eq!(auto.scene.document.integrator, own.scene.document.integrator);
    assert_ne!(auto.scene.content_hash, own.scene.content_hash);
    document["integrator"] = json!({"kind": "auto", "step_s": 1e-7});
    let plan = compiled(&document);
    assert_eq!(plan.report.integrator.kind, "explicit", "{:#?}", plan.report.integrator);
}

#[test]
fn branch_forces_are_omitted_where_no_stress_relaxes() {
    let is_omitted = |document: &Value| {
        let omitted = compiled(document).report.omitted;
        omitted.iter().any(|line| line.what.starts_with("history of branch forces"))
    };
    let mut document = scene();
    assert!(!is_omitted(&document), "there is no history at all");
    document["bodies"][1]["parts"][0]["softening"] =
        json!({"onset_j_per_m3": 1e5, "fracture_energy_j_per_m2": 1e4});
    assert!(is_omitted(&document));
    document["bodies"][1]["parts"][0]["prony_series"] =
        json!({"branches": [{"relative_modulus": 0.5, "relaxation_time_s": 1e-3}]});
    assert!(!is_omitted(&document));
}

#[test]
fn history_is_omitted_where_nothing_is_remembered() {
    let line_and_rows = |document: &Value| {
        let plan = compiled(document);
        let line = plan.report.omitted.iter().find(|l| l.what.starts_with("history")).map(|l| l.what.clone());
        (line.unwrap_or_default(), plan.blocks.iter().map(ElementBlock::history_rows).max())
    };
    let mut document = scene();
    let line = "history variables except those of bulk viscosity".to_owned();
    assert_eq!(line_and_rows(&document), (line, Some(2)));
    document["integrator"] =
        json!({"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0});
    assert_eq!(line_and_rows(&document), ("history variables".to_owned(), Some(0)));
    document["bodies"][1]["parts"][0]["prony_series"] =
        json!({"branches": [{"relative_modulus": 0.5, "relaxation_time_s": 1e-3}]});
    assert_eq!(line_and_rows(&document), (String::new(), Some(8 * (6 * 2 + 2) + 3 * 8 * 2)));
}

#[test]
fn the_skin_of_generated_layers_is_their_top_not_where_they_are_cut() {
    let mut scene = scene();
    let layers = json!([{"part": "skin", "thickness_m": 0.002, "elements": 1}, {"part": "fat", "thickness_m": 0.01, "elements": 2}]);
    let part = |name: &str| {
        let law = json!({"law": "neo_hookean", "c10_pa": 1e4, "bulk_modulus_pa": 2e6});
        json!({"part": name, "density_kg_per_m3": 1000, "material": law})
    };
    scene["bodies"][0]["parts"] = json!([part("skin"), part("fat")]);
    // One element across has all nodes of its top on the sides, too.
    for across in [1, 4] {
        let generator = json!({"kind": "layered_block", "top_center_m": [0.02, 0.02, 0.0], "size_m": [0.04, 0.04],
                               "layers": layers, "elements": [across, across]});
        scene["bodies"][0]["mesh"] = json!({"generator": generator});
        let plan = compiled(&scene);
        assert_eq!(plan.measures.tissue_skin.len(), across * across);
        assert!(
            plan.measures.tissue_skin.iter().flatten().all(|node| plan.X[*node as usize].z.abs() < 1e-15)
        );
        let ends: Vec<&str> = plan.measures.tissue_ends.iter().map(|end| end.name.as_str()).collect();
        assert_eq!(ends, ["the back or a side of the model"]);
    }
}

/// The sentence on bulk moduli below that of water: stone of some modulus [Pa] and c10 [Pa] that falls on water-like tissue at a speed [m/s].
fn capped_bulk_moduli(bulk_modulus_pa: f64, c10_pa: f64, speed: f64) -> Option<String> {
    let law = |K: f64| json!({"law": "neo_hookean", "c10_pa": c10_pa, "bulk_modulus_pa": K});
    let mut scene = scene();
    scene["bodies"][0]["parts"][0]["material"] = law(2.2e9);
    scene["bodies"][1]["parts"][0]["material"] = law(bulk_modulus_pa);
    scene["bodies"][1]["velocity_m_per_s"] = json!([0, 0, -speed]);
    compiled(&scene).report.capped_bulk_moduli
}

#[test]
fn the_effect_to_be_expected_of_a_capped_bulk_modulus_depends_on_the_speed_and_is_no_bound() {
    assert_eq!(capped_bulk_moduli(2.2e9, 1e4, 10.0), None);
    // Waves at 224 m/s.
    let fast = capped_bulk_moduli(5e7, 1e4, 100.0).unwrap();
    assert!(fast.starts_with("Bulk modulus capped: block (stone) 50.000 MPa; that of water"), "{fast}");
    assert!(fast.contains("Effect on peak force ≤ 7 %, impulse ≤ 2 %"), "{fast}");
    assert!(fast.contains("(here 0.45 of the speed") && fast.contains("K/G of 2500"), "{fast}");
    assert!(fast.contains("no bound") && fast.contains("coarsest mesh"), "{fast}");
    let slow = capped_bulk_moduli(5e7, 1e4, 20.0).unwrap();
    assert!(slow.contains("impulse ≤ 1 %") && slow.contains("depth of stress ≤ 7 %"), "{slow}");
    // Fewer results were compared for stiff rubber.
    let rubber = capped_bulk_moduli(5e7, 1e6, 20.0).unwrap();
    assert!(rubber.contains("peak force ≤ 12 %") && !rubber.contains("contact patch"), "{rubber}");
    // Faster, stiffer in shear, and without a velocity.
    for (c10_pa, speed) in [(1e4, 250.0), (4e6, 20.0), (1e4, 0.0)] {
        let unknown = capped_bulk_moduli(5e7, c10_pa, speed).unwrap();
        assert!(unknown.contains("not known before the run") && !unknown.contains('≤'), "{unknown}");
    }
}
