//! A rigid body of a triangulated surface behaves as the same body in closed form.

use crate::rig::{assert_at_most, run};
use contuse::mechanics::rigid::{Shape, triangulated};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::compile;
use contuse::scene::{Budget, MeshBytes, MeshSource, MeshSourceError, load};
use serde_json::{Value, json};

const HALF: [f64; 3] = [0.012, 0.009, 0.007];

/// The brick as ASCII STL, whatever the name.
struct Brick;

impl MeshSource for Brick {
    fn read(&self, _: &str, _: u64) -> Result<MeshBytes, MeshSourceError> {
        let (x, triangles) = triangulated(&Shape::Box { half: HALF.into() });
        let vertex = |node: &u32| {
            let x = x[*node as usize];
            format!("vertex {} {} {} ", x.x, x.y, x.z)
        };
        let facet = |corners: &[u32; 3]| {
            let corners: String = corners.iter().map(vertex).collect();
            format!("facet normal 0 0 0 outer loop {corners} endloop endfacet\n")
        };
        let facets: String = triangles.iter().map(facet).collect();
        let bytes = format!("solid brick\n{facets}endsolid brick\n").into_bytes();
        Ok(MeshBytes { file_name: "brick.stl".into(), bytes })
    }
}

/// A tumbling brick falls on a soft block, or on a plane.
fn scene(shape: &Value, on_block: bool) -> Value {
    let mut scene = json!({
        "name": "brick", "end_time_s": if on_block { 2e-3 } else { 0.05 },
        "bodies": [{
            "name": "brick", "role": "projectile", "velocity_m_per_s": [0.5, 0, -3], "spin_rad_per_s": [20, -35, 10],
            "rigid": {"shape": shape, "center_m": [0.002, 0.001, 0.0465], "density_kg_per_m3": 7850,
                      "rotation": {"axis": [1, 0.4, 0.2], "angle_deg": 35}}
        }],
        "contact": {"friction": 0.2},
        "record": {"fields": [], "field_times_s": []}
    });
    if on_block {
        scene["bodies"].as_array_mut().unwrap().push(json!({
            "name": "block", "role": "tissue", "fixed": [{"set": "z_min"}],
            "mesh": {"generator": {"kind": "block", "min_m": [-0.03, -0.03, 0], "max_m": [0.03, 0.03, 0.03], "elements": [12, 12, 6]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1060,
                       "material": {"law": "mooney_rivlin", "c10_pa": 20000, "c01_pa": 5000, "bulk_modulus_pa": 2e6}}]
        }));
    } else {
        scene["planes"] = json!([{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}]);
        scene["integrator"] = json!({"kind": "explicit", "max_step_s": 2e-5});
    }
    scene
}

/// Velocity at the end [m/s], impulse of the contact [N s], and the largest depth of a node in the brick [m].
fn end(shape: &Value, on_block: bool) -> (Vec3, Vec3, f64) {
    let bytes = scene(shape, on_block).to_string().into_bytes();
    let loaded = load(&bytes, &Brick, &Budget::COMMAND_LINE).unwrap_or_else(|p| panic!("{p}"));
    let plan = compile(&loaded.scene).unwrap();
    let brick = plan.rigid_bodies()[0].clone();
    let (mut impulse, mut deepest) = (Vec3::zeros(), 0.0_f64);
    let (outcome, state) = run(&plan, |frame| {
        impulse = Vec3::from(frame.energy.pairs.values().next_back().unwrap().impulse_n_s);
        let pose = frame.pose(0).unwrap();
        for node in plan.bodies.iter().skip(1).flat_map(|body| &body.boundary.nodes) {
            deepest = deepest.max(-brick.shape.eval_distance(&pose.local(&frame.position(*node))).0);
        }
    });
    assert_at_most(outcome.balance_error, 1e-3, "error of the energy balance");
    (state.v[brick.centre as usize], impulse, deepest)
}

#[test]
fn a_brick_of_triangles_hits_soft_tissue_as_a_box_does() {
    let boxed = json!({"kind": "box", "half_extents_m": HALF});
    let surface = json!({"kind": "stl", "name": "brick.stl"});
    let (_, impulse_of_box, _) = end(&boxed, true);
    let (_, impulse, deepest) = end(&surface, true);
    assert!(impulse_of_box.norm() > 1e-3, "{impulse_of_box}");
    // Faces may enter the hull a little deeper than the box at its far ends.
    let change = (impulse - impulse_of_box).norm() / impulse_of_box.norm();
    assert_at_most(change, 0.01, "difference of the impulse from that of the box");
    // A thousandth of a face of 5 mm.
    assert_at_most(deepest, 5e-6, "how deep a node is inside the brick [m]");
}

#[test]
fn a_brick_of_triangles_bounces_off_a_plane_as_a_box_does() {
    let boxed = json!({"kind": "box", "half_extents_m": HALF});
    let surface = json!({"kind": "stl", "name": "brick.stl"});
    let (of_box, impulse_of_box, _) = end(&boxed, false);
    let (of_surface, impulse, _) = end(&surface, false);
    assert!(impulse_of_box.norm() > 0.01, "{impulse_of_box}");
    assert_at_most(
        (impulse - impulse_of_box).norm() / impulse_of_box.norm(),
        1e-6,
        "difference of the impulse",
    );
    assert_at_most((of_surface - of_box).norm(), 1e-6, "difference of the velocity [m/s]");
}
