//! Rigid bodies smaller than the faces that they touch: contact between the nodes, with faces and edges alone.

use crate::rig::{assert_at_most, plan, run};
use contuse::mechanics::contact::detection::closest_point::{Feature, Patch};
use contuse::mechanics::rigid::triangulated;
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::step::Frame;
use serde_json::{Value, json};

#[allow(clippy::needless_pass_by_value)] // literals are handed over
fn gel(generator: Value, fixed: Value) -> Value {
    json!({
        "name": "gel", "role": "tissue", "mesh": {"generator": generator}, "fixed": fixed,
        "parts": [{"part": "*", "density_kg_per_m3": 1000, "material":
            {"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 5e7}}]
    })
}

fn block(elements: [u32; 3]) -> Value {
    json!({"kind": "block", "min_m": [-0.02, -0.02, -0.02], "max_m": [0.02, 0.02, 0], "elements": elements})
}

fn scene(shape: &Value, mass: f64, centre: [f64; 3], velocity: [f64; 3], gel: &Value, end: f64) -> Value {
    json!({
        "name": "between nodes", "end_time_s": end,
        "bodies": [
            {
                "name": "body", "role": "projectile", "velocity_m_per_s": velocity,
                "rigid": {"shape": shape, "mass_kg": mass, "center_m": centre}
            },
            gel
        ],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// How deep points of the surface of the body lie below faces of the mesh, over the size of the face [-].
fn depth(plan: &Plan, frame: &Frame) -> f64 {
    let pose = frame.pose(0).unwrap();
    let (vertices, _) = triangulated(&plan.rigid_bodies()[0].shape);
    let places: Vec<Vec3> = vertices.iter().map(|vertex| pose.place(vertex)).collect();
    let mut deepest = 0.0_f64;
    for face in &plan.bodies[1].boundary.faces {
        let patch = Patch { corners: face.map(|a| frame.position(a)), triangle: false };
        let size = patch.area().sqrt();
        for place in places.iter().filter(|place| (*place - patch.corners[0]).norm() < 2.0 * size) {
            let closest = patch.closest(place);
            let below = -patch.normal(&closest.weights).dot(&(place - closest.point));
            let is_in_front = patch.normal(&closest.weights).dot(&(pose.centre - closest.point)) > 0.0;
            if closest.feature == Feature::Interior && is_in_front && below < size {
                deepest = deepest.max(below / size);
            }
        }
    }
    deepest
}

/// Runs a scene; the deepest fraction of a face, and the velocity of the body at the end.
fn run_with_depth(scene: &Value) -> (f64, Vec3) {
    let plan = plan(scene);
    let (mut deepest, mut last) = (0.0_f64, Vec3::zeros());
    let flight = plan.bodies[0].flight_velocity;
    let (outcome, _) = run(&plan, |frame| {
        deepest = deepest.max(depth(&plan, frame));
        last = frame.v_after[plan.rigid_bodies()[0].centre as usize] + flight;
    });
    assert_at_most(outcome.balance_error, 0.01, "error of the energy balance");
    (deepest, last)
}

#[test]
fn a_ball_of_ten_millimetres_does_not_pass_a_thin_plate() {
    for (elements, [x, y]) in [(4, [0.0, 0.0]), (4, [0.002, 0.0025]), (11, [0.0, 0.0])] {
        for speed in [20.0, 100.0] {
            let generator = json!({
                "kind": "block", "min_m": [-0.01, -0.01, 0], "max_m": [0.01, 0.01, 0.001], "elements": [elements, elements, 1]
            });
            let plate = gel(generator, json!([{"set": "x_min"}, {"set": "x_max"}]));
            let ball = json!({"kind": "ball", "radius_m": 0.005});
            let scene = scene(&ball, 5e-4, [x, y, 0.0061], [0.0, 0.0, -speed], &plate, 0.012 / speed);
            let plan = plan(&scene);
            let (mut deepest, mut lowest, mut slowest) = (0.0_f64, 0.0_f64, f64::NEG_INFINITY);
            let (outcome, _) = run(&plan, |frame| {
                let centre = frame.pose(0).unwrap().centre;
                for face in &plan.bodies[1].boundary.faces {
                    let patch = Patch { corners: face.map(|a| frame.position(a)), triangle: false };
                    let closest = patch.closest(&centre);
                    let fraction = (0.005 - (closest.point - centre).norm()) / patch.area().sqrt();
                    deepest = deepest.max(fraction);
                }
                lowest = lowest.min(centre.z);
                slowest = slowest.max(frame.v_after[plan.rigid_bodies()[0].centre as usize].z);
            });
            assert_at_most(outcome.balance_error, 0.01, "error of the energy balance");
            // Its bow is left to the nodes, up to 7.5 % of the size at rest.
            assert_at_most(deepest, 0.08, "how deep a face is inside the ball, of its size");
            assert!(slowest > -0.9 * speed, "the plate hardly slows the ball: {slowest} m/s, {lowest} m");
        }
    }
}

#[test]
fn small_bodies_are_held_in_the_middle_of_faces_on_edges_and_at_nodes() {
    let gel = gel(block([4, 4, 2]), json!([{"set": "z_min"}]));
    let shapes = [
        json!({"kind": "box", "half_extents_m": [0.001, 0.0015, 0.002]}),
        json!({"kind": "capsule", "radius_m": 0.001, "half_length_m": 0.002, "axis": [1, 0.5, 0]}),
        json!({"kind": "cylinder", "radius_m": 0.0015, "half_length_m": 0.002, "axis": [0.3, 0.1, 1]}),
        json!({"kind": "ball", "radius_m": 0.0015}),
    ];
    for shape in &shapes {
        for at in [[0.005, 0.005], [0.0002, 0.005], [0.005, 0.0], [0.0, 0.0]] {
            let mut scene = scene(shape, 2e-4, [at[0], at[1], 0.0045], [0.0, 0.0, -5.0], &gel, 4e-3);
            if shape["kind"] == "box" {
                // Corner, edge and face first.
                scene["bodies"][0]["rigid"]["rotation"] =
                    json!({"axis": [1, -0.7, 0.2], "angle_deg": 9000.0 * at[0]});
            }
            let (deepest, v) = run_with_depth(&scene);
            assert_at_most(deepest, 0.03, "depth in a face, of its size");
            assert!(v.z > -3.0, "{shape} at {at:?} is not slowed: {v}");
        }
    }
}

#[test]
fn nothing_small_tunnels_at_a_thousand_metres_a_second() {
    let plate = json!({"kind": "block", "min_m": [-0.02, -0.02, -0.001], "max_m": [0.02, 0.02, 0], "elements": [4, 4, 1]});
    for shape in [
        json!({"kind": "ball", "radius_m": 0.001}),
        json!({"kind": "box", "half_extents_m": [0.0007, 0.0007, 0.0007]}),
        json!({"kind": "capsule", "radius_m": 0.0005, "half_length_m": 0.0005, "axis": [1, 0, 0]}),
    ] {
        for at in [[0.005, 0.005], [0.0, 0.005]] {
            let mut scene = scene(
                &shape,
                1e-5,
                [at[0], at[1], 0.005],
                [100.0, 50.0, -1000.0],
                &gel(plate.clone(), json!([{"set": "x_min"}, {"set": "x_max"}])),
                1e-5,
            );
            // Shocks of this strength are beyond gel: all that is requested is that it is met.
            scene["integrator"] = json!({"kind": "explicit", "energy_gate": 1.0});
            let plan = plan(&scene);
            let mut impulse = 0.0_f64;
            let (outcome, _) = crate::rig::run_on(&plan, contuse::step::State::new(&plan), 1, |frame| {
                impulse = impulse
                    .max(Vec3::from(frame.energy.pairs.values().next_back().unwrap().impulse_n_s).norm());
            });
            assert!(impulse > 1e-5 * 100.0, "{shape} at {at:?} passes: {impulse} N s, {:?}", outcome.ending);
        }
    }
}

#[test]
fn a_box_smaller_than_a_face_comes_to_rest_on_it() {
    let stiff = json!({
        "name": "gel", "role": "tissue", "mesh": {"generator": block([2, 2, 2])}, "fixed": [{"set": "z_min"}],
        "parts": [{"part": "*", "density_kg_per_m3": 1000, "material":
            {"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 1e6}}]
    });
    let shape = json!({"kind": "box", "half_extents_m": [0.004, 0.005, 0.003]});
    for at in [[0.01, 0.01], [0.0, 0.01]] {
        let mut scene = scene(&shape, 1e-3, [at[0], at[1], 0.0031], [0.0; 3], &stiff, 0.3);
        scene["gravity_m_per_s2"] = json!([0, 0, -9.81]);
        scene["contact"]["friction"] = json!(0.5);
        let plan = plan(&scene);
        let (body, mut deepest, mut fastest) = (plan.rigid_bodies()[0].clone(), 0.0_f64, [0.0_f64; 2]);
        let (outcome, state) = run(&plan, |frame| {
            deepest = deepest.max(depth(&plan, frame));
            if frame.time > 0.25 {
                fastest[0] = fastest[0].max(frame.v_after[body.centre as usize].norm());
                fastest[1] = fastest[1].max(frame.v_after[body.spin as usize].norm() * 0.005);
            }
        });
        assert_at_most(outcome.balance_error, 0.01, "error of the energy balance");
        assert_at_most(deepest, 0.01, "depth in a face, of its size");
        // It fell 0.1 mm, at 44 mm/s; the block goes on vibrating under it.
        assert_at_most(fastest[0], 5e-3, "velocity in the end [m/s]");
        assert_at_most(fastest[1], 5e-3, "velocity of its corners by rotation in the end [m/s]");
        let tilt = (state.orientations[0] * Vec3::z() - Vec3::z()).norm();
        assert_at_most(tilt, 0.01, "tilt in the end [rad]");
    }
}

#[test]
fn a_ball_that_falls_in_a_plane_of_symmetry_leaves_in_it() {
    let gel = gel(block([4, 4, 2]), json!([{"set": "z_min"}]));
    let shape = json!({"kind": "ball", "radius_m": 0.004});
    // Over a node, the middle of an edge, and the middle of a face: planes of symmetry x = 0, and x = y.
    for [x, y] in [[0.0, 0.0], [0.0, 0.005], [0.005, 0.005]] {
        let scene = scene(&shape, 2e-3, [x, y, 0.0041], [0.0, 0.0, -15.0], &gel, 3e-3);
        let (deepest, v) = run_with_depth(&scene);
        assert_at_most(deepest, 0.02, "depth in a face, of its size");
        assert!(v.z > 0.0, "it has not left: {v}");
        let across = if x == y { v.x - v.y } else { v.x };
        assert_at_most(
            across.abs() / 15.0,
            1e-3,
            "velocity across the plane of symmetry, of that of the impact",
        );
        if [x, y] == [0.0, 0.0] {
            assert_at_most(v.x.hypot(v.y) / 15.0, 1e-3, "velocity across, dead centre");
        }
    }
}

#[test]
fn a_small_box_and_a_free_block_keep_their_momenta() {
    let gel = gel(block([3, 3, 2]), json!([]));
    let shape = json!({"kind": "box", "half_extents_m": [0.002, 0.0015, 0.001]});
    let mut scene = scene(&shape, 1e-3, [0.001, 0.002, 0.003], [1.0, 0.3, -5.0], &gel, 1.2e-3);
    scene["bodies"][0]["rigid"]["rotation"] = json!({"axis": [1, 0.3, 0], "angle_deg": 40});
    let plan = plan(&scene);
    let (mut first, mut worst, mut impulse) = (None, [0.0_f64; 2], 0.0);
    run(&plan, |frame| {
        let now =
            [frame.energy.momentum_kg_m_per_s, frame.energy.angular_momentum_kg_m2_per_s].map(Vec3::from);
        let start = *first.get_or_insert(now);
        worst = [0, 1].map(|i| worst[i].max((now[i] - start[i]).norm() / start[i].norm()));
        impulse = Vec3::from(frame.energy.pairs.values().next_back().unwrap().impulse_n_s).norm();
    });
    assert!(impulse > 1e-3, "{impulse}");
    assert_at_most(worst[0], 1e-12, "relative change of the momentum");
    assert_at_most(worst[1], 1e-3, "relative change of the angular momentum");
}
