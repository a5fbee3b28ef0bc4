//! Nodes that follow others: hanging nodes between coarse and fine hexahedra.
//!
//! The constrained field is continuous, so that linear fields pass the patch test; forces and masses go to the masters by the transpose, so
//! that momenta and energy are kept as without followers.

use crate::rig::{
    assert_at_most, assert_close, assert_within, loaded, order, run, run_on, small_ball_on_block, summary,
};
use contuse::measure::summary::GateResult;
use contuse::mechanics::force::{ElementForces, ForceInput, Threads};
use contuse::mechanics::tensor::{Mat3, Vec3};
use contuse::mesh::Mesh;
use contuse::mesh::local_refinement::refined_in;
use contuse::mesh::refinement_region::{Place, Region};
use contuse::plan::{Plan, compile};
use contuse::scene::Loaded;
use contuse::step::State;
use nalgebra::{DMatrix, Rotation3};
use serde_json::{Value, json};

const GRADIENT: [[f64; 3]; 3] = [[1.15, 0.20, -0.05], [0.03, 0.90, 0.12], [-0.08, 0.02, 1.05]];

fn gradient() -> Mat3 {
    Mat3::from_fn(|i, j| GRADIENT[i][j])
}

/// A cube of one part, `elements` along each edge of 3 cm, with more in its document.
fn cube(elements: u32, more: &Value) -> Value {
    let mut scene = json!({
        "name": "cube",
        "end_time_s": 1e-6,
        "bodies": [{
            "name": "cube",
            "mesh": {"generator": {
                "kind": "block", "min_m": [0, 0, 0], "max_m": [0.03, 0.03, 0.03], "elements": [elements, elements, elements]
            }},
            "parts": [{"part": "block", "density_kg_per_m3": 1000.0, "material": {
                "law": "mooney_rivlin", "c10_pa": 4e4, "c01_pa": 1e4, "bulk_modulus_pa": 1e6
            }}]
        }],
        "record": {"fields": [], "field_times_s": []}
    });
    for (key, value) in more.as_object().unwrap() {
        let place = if ["end_time_s", "integrator", "gravity_m_per_s2", "solver"].contains(&key.as_str()) {
            &mut scene[key]
        } else {
            &mut scene["bodies"][0][key]
        };
        *place = value.clone();
    }
    scene
}

/// The scene with the mesh of a body refined near a point; the inner nodes are moved first if `distorted`.
fn refined(scene: &Value, body: usize, at: [f64; 3], within: f64, size: f64, distorted: bool) -> Loaded {
    let mut loaded = loaded(scene, None);
    let scene_body = &mut loaded.scene.bodies[body];
    if distorted {
        distort(&mut scene_body.mesh);
    }
    let region = Region { places: Place::on_all(&scene_body.mesh, &[at.into()]), within, size };
    let (mesh, _) = refined_in(&scene_body.mesh, &[region], 1_000_000).unwrap();
    assert!(!mesh.hanging.is_empty());
    scene_body.part_entry = vec![0; mesh.cells.len()];
    scene_body.law_of = vec![0; mesh.cells.len()];
    if let Some(axes) = scene_body.axes.first().copied() {
        scene_body.axes = vec![axes; mesh.cells.len()];
    }
    scene_body.mesh = mesh;
    loaded
}

/// Moves the inner nodes by up to 20 % of an edge of 1 cm.
fn distort(mesh: &mut Mesh) {
    let inside = |x: &&mut Vec3| x.iter().all(|c| *c > 1e-4 && *c < 0.0299);
    for (i, x) in mesh.nodes.iter_mut().filter(inside).enumerate() {
        let i = i as f64;
        *x += Vec3::new((3.1 * i).sin(), (5.3 * i + 1.0).cos(), (7.7 * i + 2.0).sin()) * 0.002;
    }
}

/// A distorted cube of 3×3×3 elements, refined twice at a corner: two interfaces of 2:1.
fn patch() -> Plan {
    compile(&refined(&cube(3, &json!({})), 0, [0.03; 3], 0.004, 0.003, true).scene).unwrap()
}

/// Internal forces at displacements, handed over to the masters [N].
fn forces(plan: &Plan, u: &[Vec3]) -> Vec<Vec3> {
    let mut forces = ElementForces::new(&plan.blocks);
    forces.evaluate(&Threads::ONE, &plan.blocks, &ForceInput::at(u));
    (0..plan.node_count()).map(|node| forces.at_node(&plan.assembly, node)).collect()
}

fn field(plan: &Plan, F: &Mat3) -> Vec<Vec3> {
    plan.X.iter().map(|X| F * X - X).collect()
}

#[test]
fn a_linear_field_passes_the_patch_test_through_hanging_nodes() {
    let plan = patch();
    let followers = plan.assembly.followers();
    assert!(followers.len() > 10);
    let mut u = field(&plan, &gradient());
    let exact = u.clone();
    followers.follow(&mut u);
    let off = u.iter().zip(&exact).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert_at_most(off / 0.006, 1e-14, "followers in a linear field, of the displacement");
    let forces = forces(&plan, &u);
    let scale = forces.iter().map(Vec3::norm).fold(0.0, f64::max);
    let is_inside = |X: &Vec3| X.iter().all(|c| *c > 1e-4 && *c < 0.0299);
    let inner: Vec<f64> =
        plan.X.iter().zip(&forces).filter(|(X, _)| is_inside(X)).map(|(_, f)| f.norm() / scale).collect();
    assert!(inner.len() > 20);
    assert_at_most(
        inner.into_iter().fold(0.0, f64::max),
        1e-13,
        "force on an inner node beside hanging ones in a linear field, of those on the surface",
    );
}

#[test]
fn a_rigid_motion_makes_no_forces() {
    let plan = patch();
    let scale = forces(&plan, &field(&plan, &gradient())).iter().map(Vec3::norm).fold(0.0, f64::max);
    let R = Rotation3::from_scaled_axis(Vec3::new(0.7, -1.9, 0.4)).into_inner();
    let mut u = field(&plan, &R);
    for u in &mut u {
        *u += Vec3::new(0.3, -0.1, 0.2);
    }
    plan.assembly.followers().follow(&mut u);
    let largest = forces(&plan, &u).iter().map(Vec3::norm).fold(0.0, f64::max);
    assert_at_most(
        largest / scale,
        1e-12,
        "force after a rigid motion of a mesh with hanging nodes, of that under strain",
    );
}

#[test]
fn uniaxial_tension_is_homogeneous_in_a_quasi_static_step() {
    let more = json!({
        "fixed": [{"set": "x_min", "axes": ["x"]}, {"set": "y_min", "axes": ["y"]}, {"set": "z_min", "axes": ["z"]}],
        "prescribed": [{"set": "z_max", "axes": ["z"], "displacement_m": [0, 0, 0.003]}],
        "integrator": {"kind": "quasi_static", "step_s": 0.5, "newton_tolerance": 1e-12}, "end_time_s": 1.0
    });
    let scene = refined(&cube(3, &more), 0, [0.03; 3], 0.004, 0.003, false).scene;
    let plan = compile(&scene).unwrap();
    let (_, state) = run(&plan, |_| {});
    // One element knows the lateral stretch.
    let one = compile(&loaded(&cube(1, &more), None).scene).unwrap();
    let (_, single) = run(&one, |_| {});
    let lateral = single.u.iter().map(|u| u.x).fold(0.0, f64::min) / 0.03;
    let exact = |X: &Vec3| Vec3::new(lateral * X.x, lateral * X.y, 0.1 * X.z);
    let worst = plan.X.iter().zip(&state.u).map(|(X, u)| (u - exact(X)).norm()).fold(0.0, f64::max);
    assert_at_most(worst / 0.003, 1e-9, "quasi-static tension through hanging nodes, of the displacement");
}

#[test]
fn momenta_and_energy_of_a_vibrating_block_are_kept_in_flight() {
    let errors = |step: f64| {
        let more = json!({
            "initial_deformation": {"kind": "affine", "center_m": [0, 0, 0], "deformation_gradient":
                [[1.05, 0.0, 0.02], [0.0, 0.97, 0.0], [0.0, 0.0, 1.0]]},
            "velocity_m_per_s": [3.0, -2.0, 1.0], "spin_rad_per_s": [200.0, 100.0, -300.0], "end_time_s": 0.004,
            "integrator": {"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0, "max_step_s": step}
        });
        let scene = refined(&cube(3, &more), 0, [0.03; 3], 0.004, 0.003, false).scene;
        let plan = compile(&scene).unwrap();
        assert_close(plan.mass.iter().sum::<f64>(), 0.027, 1e-12, "mass of a refined block [kg]");
        let (mut start, mut linear, mut angular) = (None, 0.0_f64, 0.0_f64);
        let (outcome, state) = run(&plan, |frame| {
            let p = Vec3::from(frame.energy.momentum_kg_m_per_s);
            let L = Vec3::from(frame.energy.angular_momentum_kg_m2_per_s);
            let (p0, L0) = *start.get_or_insert((p, L));
            linear = linear.max((p - p0).norm() / p0.norm());
            angular = angular.max((L - L0).norm() / L0.norm());
        });
        assert_at_most(linear, 1e-12, "relative change of the momentum of a refined block");
        assert_at_most(angular, 1e-12, "relative change of the angular momentum of a refined block");
        let mut followed = state.u.clone();
        plan.assembly.followers().follow(&mut followed);
        assert!(followed == state.u, "followers are where their masters say, to the last bit");
        outcome.balance_error
    };
    let (coarse, fine) = (errors(4e-6), errors(2e-6));
    assert_at_most(fine, 1e-4, "error of the energy balance of a refined block that spins and vibrates");
    assert_within(order(coarse, fine), 2.0, 0.2, "order of that error in the step");
}

#[test]
fn the_ledger_of_a_nearly_linear_block_is_exact() {
    let more = json!({
        "initial_deformation": {"kind": "affine", "center_m": [0, 0, 0], "deformation_gradient":
            [[1.0 + 1e-7, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
        "end_time_s": 0.002, "fixed": [{"set": "z_min"}]
    });
    for integrator in [
        json!({"kind": "explicit", "max_step_s": 1e-5}),
        json!({"kind": "implicit", "step_s": 2e-5, "newton_tolerance": 1e-12}),
    ] {
        let mut more = more.clone();
        more["integrator"] = integrator.clone();
        let plan = compile(&refined(&cube(3, &more), 0, [0.03; 3], 0.004, 0.003, false).scene).unwrap();
        let (outcome, _) = run(&plan, |_| {});
        // The laws are not linear: of the order of the strain is left.
        assert_at_most(
            outcome.balance_error,
            1e-7,
            &format!("balance of a refined block at strains of 1e-7, {integrator}"),
        );
    }
}

#[test]
fn a_refined_block_falls_as_one() {
    let more = json!({
        "gravity_m_per_s2": [0, 0, -9.81], "end_time_s": 1e-3, "integrator": {"kind": "explicit", "max_step_s": 1e-5}
    });
    let plan = compile(&refined(&cube(3, &more), 0, [0.03; 3], 0.004, 0.003, false).scene).unwrap();
    let mut lost = 0.0_f64;
    let (_, state) = run(&plan, |frame| {
        let energy = frame.energy;
        let moved = energy.external_work_j.abs().max(f64::MIN_POSITIVE);
        if frame.step > 0 {
            lost = lost.max((energy.total_j - energy.initial_total_j - energy.external_work_j).abs() / moved);
        }
    });
    let fallen = -0.5 * 9.81 * 1e-6;
    let worst = state.u.iter().map(|u| (u - Vec3::new(0.0, 0.0, fallen)).norm()).fold(0.0, f64::max);
    assert_at_most(worst / fallen.abs(), 1e-10, "free fall of a refined block");
    assert_at_most(lost, 1e-12, "its energy that work does not account for, of the work of gravity");
}

#[test]
fn the_step_bound_holds_against_the_exact_eigenvalue() {
    let plan = compile(&refined(&cube(2, &json!({})), 0, [0.03; 3], 0.004, 0.0076, false).scene).unwrap();
    let followers = plan.assembly.followers();
    let free: Vec<usize> = (0..plan.node_count()).filter(|node| !followers.contains(*node)).collect();
    let (n, small) = (3 * free.len(), 1e-8);
    let mut K = DMatrix::zeros(n, n);
    for (column, node) in free.iter().enumerate() {
        for axis in 0..3 {
            let at = |sign: f64| {
                let mut u = vec![Vec3::zeros(); plan.node_count()];
                u[*node][axis] = sign * small;
                followers.follow(&mut u);
                forces(&plan, &u)
            };
            let (plus, minus) = (at(1.0), at(-1.0));
            for (row, other) in free.iter().enumerate() {
                for i in 0..3 {
                    let slope = (plus[*other][i] - minus[*other][i]) / (2.0 * small);
                    K[(3 * row + i, 3 * column + axis)] =
                        slope / (plan.mass[*other] * plan.mass[*node]).sqrt();
                }
            }
        }
    }
    let asymmetry = (&K - K.transpose()).norm() / K.norm();
    assert_at_most(asymmetry, 1e-6, "asymmetry of the stiffness with followers, by differences");
    let largest = ((&K + K.transpose()) * 0.5).symmetric_eigenvalues().max();
    let exact = 2.0 / largest.sqrt();
    let bound = plan.report.stable_step.smallest_s;
    assert!(bound <= exact, "{bound:e} {exact:e}");
    assert_within(bound / exact, 0.75, 0.25, "step bound of a refined block, of the exact critical step");
}

/// A ball that strikes a block of tissue which nothing holds, refined around the impact.
fn impact(end: f64, more: &Value) -> Loaded {
    let mut scene = small_ball_on_block([4, 1], [10, 10, 5], [5.0, 0.0, -40.0], end);
    scene["bodies"][1]["fixed"] = json!([]);
    for (key, value) in more.as_object().unwrap() {
        scene[key] = value.clone();
    }
    refined(&scene, 1, [0.0, 0.0, 0.05], 0.01, 0.005, false)
}

#[test]
fn contact_on_a_refined_surface_keeps_momentum_and_loses_no_node() {
    let loaded = impact(6e-4, &json!({}));
    let plan = compile(&loaded.scene).unwrap();
    let mut start = None;
    let (mut linear, mut angular, mut followed) = (0.0_f64, 0.0_f64, 0);
    let (outcome, _) = run(&plan, |frame| {
        let p = Vec3::from(frame.energy.momentum_kg_m_per_s);
        let L = Vec3::from(frame.energy.angular_momentum_kg_m2_per_s);
        let (p0, L0) = *start.get_or_insert((p, L));
        linear = linear.max((p - p0).norm() / p0.norm());
        angular = angular.max((L - L0).norm() / L0.norm());
        let pressed = frame.contacts.iter().zip(frame.reactions).filter(|(_, r)| r.impulse[0] > 0.0);
        let nodes = pressed.flat_map(|(c, _)| c.stencil.nodes());
        followed += nodes.filter(|node| plan.assembly.followers().contains(**node as usize)).count();
    });
    assert_eq!(followed, 0, "no reaction acts on a follower");
    assert_at_most(linear, 1e-12, "change of the momentum of an impact on a refined block");
    // Tangential impulses of the nodes against faces have the moment of their gap.
    assert_at_most(angular, 1e-3, "change of the angular momentum of an impact on a refined block");
    let coarse = small_ball_on_block([4, 1], [10, 10, 5], [5.0, 0.0, -40.0], 6e-4);
    let (coarse, _) = run(&crate::rig::plan(&coarse), |_| {});
    let ratio = outcome.balance_error / coarse.balance_error;
    assert_at_most(ratio, 1.0, "energy balance of an impact on a refined block, of that on the coarse one");
    let summary = summary(&loaded);
    let failed = summary.gates.iter().filter(|gate| gate.result == GateResult::Failed);
    assert_eq!((summary.gates.len() > 5, failed.count()), (true, 0), "{:#?}", summary.gates);
}

#[test]
fn inactive_elements_and_threads_change_no_bit_of_a_refined_mesh() {
    let end = 3e-4;
    let state = |more: &Value, threads: usize| {
        let plan = compile(&impact(end, more).scene).unwrap();
        assert_eq!(plan.skip_inactive_elements, more.get("solver").is_none());
        run_on(&plan, State::new(&plan), threads, |_| {}).1
    };
    let lazy = state(&json!({}), 1);
    assert!(lazy.step > 20);
    let busy = state(&json!({"solver": {"keep": ["inactive_elements"]}}), 1);
    assert!(lazy == busy, "inactive elements");
    assert!(lazy == state(&json!({}), 3), "threads");
}

#[test]
fn an_implicit_impact_on_a_refined_surface_keeps_momentum() {
    let plan =
        compile(&impact(2e-4, &json!({"integrator": {"kind": "implicit", "step_s": 1e-5}})).scene).unwrap();
    let (mut start, mut linear) = (None, 0.0_f64);
    let (outcome, state) = run(&plan, |frame| {
        let p = Vec3::from(frame.energy.momentum_kg_m_per_s);
        let p0 = *start.get_or_insert(p);
        linear = linear.max((p - p0).norm() / p0.norm());
    });
    assert!(state.ledger.pairs.values().any(|pair| pair.impulse_n_s[2].abs() > 1e-3), "they touch");
    assert_at_most(linear, 1e-8, "change of the momentum of an implicit impact on a refined block");
    assert_at_most(outcome.balance_error, 1e-3, "energy balance of an implicit impact on a refined block");
}
