//! Local refinement that a scene asks for: around the impact, a point or a node set; and what is refused.

use crate::rig::{MeshInMemory, assert_close, loaded, small_ball_on_block};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::plan::compile;
use contuse::scene::{Budget, Problem, load};
use serde_json::{Value, json};

fn scene(refinement: &Value) -> Value {
    let mut scene = small_ball_on_block([4, 1], [10, 10, 5], [0.0, 0.0, -40.0], 1e-4);
    scene["bodies"][1]["refinement"] = refinement.clone();
    scene
}

fn mesh(refinement: &Value, body: usize) -> Mesh {
    loaded(&scene(refinement), None).scene.bodies[body].mesh.clone()
}

/// Longest edge along x of the elements that have a corner at a point [m].
fn size_at(mesh: &Mesh, point: Vec3) -> f64 {
    let touches = |e: &usize| mesh.cells.points(*e, &mesh.nodes).iter().any(|x| (x - point).norm() < 1e-9);
    let edge = |e: usize| {
        let x: Vec<f64> = mesh.cells.points(e, &mesh.nodes).iter().map(|x| x.x).collect();
        x.iter().copied().fold(f64::MIN, f64::max) - x.iter().copied().fold(f64::MAX, f64::min)
    };
    (0..mesh.cells.len()).filter(touches).map(edge).fold(0.0, f64::max)
}

#[test]
fn elements_are_small_around_the_impact_and_nowhere_else() {
    let around = |around: Value| json!([{"around": around, "within_m": 0.008, "size_m": 0.003}]);
    let fine = mesh(&around(json!("impact")), 1);
    assert_close(size_at(&fine, Vec3::new(0.0, 0.0, 0.05)), 0.0025, 1e-9, "elements at the impact [m]");
    assert_close(size_at(&fine, Vec3::new(0.05, 0.05, 0.05)), 0.01, 1e-9, "elements at the corner [m]");
    assert!(
        fine == mesh(&around(json!({"point_m": [0, 0, 0.05]})), 1),
        "the impact is the point below the ball"
    );
    assert_close(fine.volume_m3(), 5e-4, 1e-12, "volume of the refined block [m³]");
}

#[test]
fn a_projectile_is_refined_where_it_hits() {
    let mut scene = scene(&json!([]));
    scene["bodies"][0]["role"] = json!("projectile");
    scene["bodies"][0]["refinement"] = json!([{"around": "impact", "within_m": 0.003, "size_m": 0.003}]);
    let loaded = loaded(&scene, None);
    let fine = loaded.scene.bodies[0].mesh.nodes.len();
    let coarse = small_ball_on_block([4, 1], [10, 10, 5], [0.0, 0.0, -40.0], 1e-4);
    let coarse = crate::rig::loaded(&coarse, None).scene.bodies[0].mesh.clone();
    let new = &loaded.scene.bodies[0].mesh.nodes[coarse.nodes.len()..fine];
    assert!(!new.is_empty() && new.iter().all(|x| x.z < 0.0652), "new nodes are below the centre");
}

#[test]
fn a_set_is_refined_along_all_of_it_and_sets_and_the_report_follow() {
    let refinement = json!([{"around": {"set": "z_max"}, "within_m": 0.0, "size_m": 0.005}]);
    let loaded = loaded(&scene(&refinement), None);
    let plan = compile(&loaded.scene).unwrap();
    let report = &plan.report.refinements[0];
    assert_eq!((report.elements_before, report.elements_split, report.elements), (500, 100, 1200));
    // The middles of the edges and faces of a plane of 10×10 faces.
    assert_eq!(report.hanging_nodes, 2 * 10 * 11 + 100);
    assert_eq!(plan.assembly.followers().len(), report.hanging_nodes);
    assert!(plan.report.kept.iter().any(|words| words.contains("100 of 500 hex8 locally refined")));
    let sets = &loaded.scene.bodies[1].mesh.node_sets;
    assert_eq!((sets["z_max"].len(), sets["z_min"].len()), (21 * 21, 11 * 11));
    assert_eq!(plan.report.nodes, plan.mesh_node_count());
    // Coarse faces of the sides have a hanging edge each, and are three triangles.
    let triangles = plan.bodies[1].boundary.faces.iter().filter(|face| face[2] == face[3]).count();
    assert_eq!(triangles, 3 * 40);
}

/// Codes of the problems of a scene.
fn codes(scene: &Value, budget: &Budget) -> Vec<String> {
    let bytes = serde_json::to_vec(scene).unwrap();
    let problems = load(&bytes, &MeshInMemory(None), budget).unwrap_err();
    problems.0.iter().filter(|problem| problem.is_error()).map(|problem| problem.code.to_string()).collect()
}

#[test]
fn what_cannot_be_refined_is_refused_with_a_reason() {
    let one = |around: Value, within: f64, size: f64| {
        scene(&json!([{"around": around, "within_m": within, "size_m": size}]))
    };
    let line = &Budget::COMMAND_LINE;
    assert_eq!(codes(&one(json!("impact"), 0.01, 0.0), line), ["not_positive"]);
    assert_eq!(codes(&one(json!("impact"), -0.01, 0.001), line), ["negative"]);
    assert_eq!(codes(&one(json!({"set": "top"}), 0.01, 0.001), line), ["unknown_set"]);
    let mut still = one(json!("impact"), 0.01, 0.001);
    still["bodies"][0]["velocity_m_per_s"] = json!([0, 0, 0]);
    assert_eq!(codes(&still, line), ["unknown_impact"]);
    let mut eroding = one(json!("impact"), 0.01, 0.005);
    eroding["bodies"][1]["parts"][0]["erosion"] = json!({"stretch": 2.0});
    assert_eq!(codes(&eroding, line), ["refinement_with_erosion"]);
    let mut mortar = one(json!("impact"), 0.01, 0.005);
    mortar["contact"]["discretisation"] = json!("mortar");
    assert_eq!(codes(&mortar, line), ["refinement_with_mortar"]);
    let small = Budget { elements: 2000, ..Budget::COMMAND_LINE };
    assert_eq!(codes(&one(json!("impact"), 0.05, 0.001), &small), ["budget_elements"]);
}

#[test]
fn elements_far_too_small_are_refused_with_their_estimated_number() {
    let tiny = scene(&json!([{"around": "impact", "within_m": 0.01, "size_m": 1e-5}]));
    let bytes = serde_json::to_vec(&tiny).unwrap();
    let problems = load(&bytes, &MeshInMemory(None), &Budget::COMMAND_LINE).unwrap_err();
    let problem = problems.first_error().unwrap();
    assert_eq!((&*problem.code, &*problem.pointer), ("budget_elements", "/bodies/1/refinement"));
    // Splitting level by level would be refused with at most eight times the budget.
    let estimated = problem.value.as_u64().unwrap();
    assert!(estimated > 8 * Budget::COMMAND_LINE.elements, "{problem}");
    assert!(problem.message.contains(&estimated.to_string()), "{problem}");
}

#[test]
fn a_refinement_that_splits_nothing_is_warned_of() {
    let warned = |around: Value, within: f64, size: f64| {
        let loaded = loaded(&scene(&json!([{"around": around, "within_m": within, "size_m": size}])), None);
        let is_it = |problem: &&Problem| problem.code == "refinement_without_effect";
        loaded.warnings.iter().filter(is_it).cloned().collect::<Vec<_>>()
    };
    let large = warned(json!("impact"), 0.008, 0.01);
    let [problem] = &large[..] else { panic!("{large:?}") };
    assert_eq!(problem.pointer, "/bodies/1/refinement/0/size_m");
    assert!(problem.limit.contains("smallest is 1.0000e-2 m"), "{problem}");
    assert!(problem.remedy.contains("5.0000e-3"), "{problem}");
    let beside = warned(json!({"point_m": [0, 0, 0.08]}), 0.01, 0.003);
    let [problem] = &beside[..] else { panic!("{beside:?}") };
    assert_eq!(problem.pointer, "/bodies/1/refinement/0/within_m");
    assert!(problem.limit.contains("3.0000e-2 m") && !problem.remedy.is_empty(), "{problem}");
    assert!(warned(json!("impact"), 0.008, 0.003).is_empty());
}
