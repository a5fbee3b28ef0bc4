//! The critical time step of an assembled mesh: never above the exact one, 2/ω of the largest eigenvalue of M⁻¹ K, and closer to it than
//! that of the elements alone.
//!
//! The eigenvalue is found by power iteration with differences of the internal forces, which approaches it from below.

use crate::rig::{assert_at_most, assert_within, plan_with};
use contuse::mechanics::force::{AssembledBound, AssembledRows, ElementForces, ForceInput, Threads};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use contuse::plan::Plan;
use serde_json::{Value, json};

/// Density [kg/m³] and bulk modulus [Pa].
const DENSITY: f64 = 1000.0;
const BULK: f64 = 1e7;
/// Evaluations of the bound, by which its weights have converged.
const EVALUATIONS: usize = 8;

/// A block of `size` [m] with so many elements, its lowest face held.
fn block(size: [f64; 3], elements: [u32; 3], shear_modulus: f64, more: &Value) -> Value {
    let mut scene = json!({
        "name": "block", "end_time_s": 1e-3,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": size, "elements": elements}},
            "parts": [{"part": "*", "density_kg_per_m3": DENSITY, "material": {
                "law": "neo_hookean", "c10_pa": 0.5 * shear_modulus, "bulk_modulus_pa": BULK
            }}],
            "fixed": [{"set": "z_min"}]
        }],
        "record": {"fields": [], "field_times_s": []}
    });
    for (key, value) in more.as_object().unwrap() {
        scene["bodies"][0][key] = value.clone();
    }
    scene
}

/// Displacements that depend on the place alone, smooth over some elements, with gradients of at most some `size`.
fn waves(plan: &Plan, size: f64) -> Vec<Vec3> {
    let field = |X: &Vec3| {
        let k = 300.0;
        let phase = X * k;
        Vec3::new((phase.y + 2.0 * phase.z).sin(), (phase.z - phase.x).cos(), (1.5 * phase.x + phase.z).sin())
            * (size / k)
    };
    let mut u: Vec<Vec3> = plan.X.iter().map(field).collect();
    plan.assembly.followers().follow(&mut u);
    u
}

/// Smallest critical time step [s] and internal forces [N].
fn evaluate(
    plan: &Plan,
    forces: &mut ElementForces,
    u: &[Vec3],
    fractions: &[Vec<AssembledRows>],
) -> (f64, Vec<Vec3>) {
    forces.evaluate(&Threads::ONE, &plan.blocks, &ForceInput { fractions, ..ForceInput::at(u) });
    let of_block = |block: usize| forces.totals(block).stable_step.0;
    let step = (0..plan.blocks.len()).map(of_block).fold(f64::INFINITY, f64::min);
    (step, (0..u.len()).map(|node| forces.at_node(&plan.assembly, node)).collect())
}

/// Critical time steps at displacements [s]: of the elements alone; of the assembled mesh, the longest of some evaluations, each of which
/// is a bound; and 2/ω.
fn steps(plan: &Plan, u: &[Vec3]) -> [f64; 3] {
    let mut forces = ElementForces::new(&plan.blocks);
    let (alone, at_rest) = evaluate(plan, &mut forces, u, &[]);
    let mut bound = AssembledBound::new(&plan.blocks, u.len(), plan.bodies.len());
    let mesh = (&plan.blocks[..], &plan.assembly, &plan.own_inverse_mass[..]);
    let mut assembled: f64 = 0.0;
    for _ in 0..EVALUATIONS {
        let fractions = bound.fractions().to_vec();
        let input = ForceInput { fractions: &fractions, ..ForceInput::at(u) };
        bound.evaluate(&Threads::ONE, mesh, &forces, &input);
        assembled = assembled.max(evaluate(plan, &mut forces, u, bound.fractions()).0);
    }
    // Power iteration on M⁻¹ K.
    let number = |node: usize, axis: usize| (((node * 3 + axis) * 7919 % 1009) as f64) / 1009.0 - 0.5;
    let mut mode: Vec<Vec3> = (0..u.len()).map(|node| Vec3::from_fn(|axis, _| number(node, axis))).collect();
    let mut omega_squared = 0.0;
    for _ in 0..300 {
        mode.iter_mut().zip(&plan.inverse_mass).for_each(|(x, inverse)| {
            *x = Vec3::from_fn(|axis, _| if inverse[axis] > 0.0 { x[axis] } else { 0.0 });
        });
        let norm = mode.iter().zip(&plan.mass).map(|(x, m)| m * x.norm_squared()).sum::<f64>().sqrt();
        let largest = mode.iter().map(Vec3::norm).fold(0.0, f64::max);
        let small = 1e-9 / largest;
        let mut moved: Vec<Vec3> = u.iter().zip(&mode).map(|(u, x)| u + x * small).collect();
        plan.assembly.followers().follow(&mut moved);
        let (_, after) = evaluate(plan, &mut forces, &moved, &[]);
        let stiffness = |node: usize| (after[node] - at_rest[node]) / small;
        omega_squared =
            (0..u.len()).map(|node| stiffness(node).dot(&mode[node])).sum::<f64>() / (norm * norm);
        mode = (0..u.len())
            .map(|node| stiffness(node).component_mul(&plan.inverse_mass[node]) / omega_squared)
            .collect();
    }
    [alone, assembled, 2.0 / omega_squared.sqrt()]
}

/// The assembled step is below the exact one, and longer than that of the elements alone by `gain` at least.
fn check(what: &str, plan: &Plan, size: f64, gain: f64) {
    let [alone, assembled, exact] = steps(plan, &waves(plan, size));
    println!(
        "{what}, gradients of {size}: alone {alone:.3e} s, assembled {assembled:.3e} s, exact {exact:.3e} s"
    );
    assert_at_most(assembled / exact, 1.0 + 1e-3, &format!("assembled step of {what} over the exact one"));
    assert_at_most(gain, assembled / alone, &format!("least gain of {what}"));
}

/// Between held faces, so that no node has less mass than inside: 2/ω is that of a plane wave of two elements' length.
#[test]
fn the_margin_leaves_cubes_two_thirds_of_the_step_of_a_plane_wave() {
    let h = 0.005;
    let held = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"].map(|set| json!({"set": set}));
    let mut scene = block([0.04; 3], [8; 3], 1e3, &json!({"fixed": held}));
    scene["integrator"] =
        json!({"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0});
    let plan = plan_with(&scene, None);
    let [alone, assembled, exact] = steps(&plan, &vec![Vec3::zeros(); plan.node_count()]);
    let of_plane_wave = h / (BULK / DENSITY).sqrt();
    println!("{:.4} {:.4} {:.4}", alone / of_plane_wave, assembled / of_plane_wave, exact / of_plane_wave);
    assert_within(exact / of_plane_wave, 1.0, 0.1, "exact step over that of a plane wave");
    assert_within(
        assembled / of_plane_wave,
        0.63,
        0.05,
        "assembled step, with its margin, over that of a plane wave",
    );
    assert_within(alone / of_plane_wave, 1.0 / 3.0_f64.sqrt(), 0.03, "step of the elements alone");
}

#[test]
fn deformed_and_flat_elements_stay_below_the_exact_step() {
    let cubes = plan_with(&block([0.04, 0.04, 0.03], [8, 8, 6], 1e4, &json!({})), None);
    let flat = plan_with(&block([0.04, 0.04, 0.006], [8, 8, 6], 1e4, &json!({})), None);
    let stiff_in_shear = plan_with(&block([0.04; 3], [6; 3], 2e6, &json!({})), None);
    for (size, gain) in [(0.0, 1.0), (0.2, 1.0), (0.5, 1.0)] {
        check("cubes", &cubes, size, gain);
        check("flat elements", &flat, size, 1.0);
        check("shear modulus of a fifth of the bulk modulus", &stiff_in_shear, size, 1.0);
    }
}

/// One part resists the change of volume and the other the change of shape: at their interface both act on one layer of nodes.
#[test]
fn contrasts_of_stiffness_stay_below_the_exact_step() {
    let material = |shear_modulus: f64, bulk_modulus: f64| json!({"law": "neo_hookean", "c10_pa": 0.5 * shear_modulus, "bulk_modulus_pa": bulk_modulus});
    let layers = |below: &Value, above: &Value| {
        let layer =
            |name: &str, thickness: f64| json!({"part": name, "thickness_m": thickness, "elements": 3});
        let part = |name: &str, material: &Value| json!({"part": name, "density_kg_per_m3": DENSITY, "material": material});
        let generator = json!({
            "kind": "layered_block", "size_m": [0.03, 0.03], "elements": [6, 6],
            "layers": [layer("above", 0.015), layer("below", 0.015)]
        });
        let more =
            json!({"mesh": {"generator": generator}, "parts": [part("below", below), part("above", above)]});
        plan_with(&block([0.03; 3], [6; 3], 1e4, &more), None)
    };
    let (dilating, shearing) = (material(1e3, 1e7), material(3e6, 4e6));
    check("volume below, shape above", &layers(&dilating, &shearing), 0.0, 1.0);
    check("shape below, volume above", &layers(&shearing, &dilating), 0.2, 1.0);
    check("a hundred times stiffer above", &layers(&dilating, &material(1e5, 1e9)), 0.0, 1.0);
}

#[test]
fn hanging_nodes_and_other_cells_stay_below_the_exact_step() {
    let refinement = json!({"refinement": [{"around": {"point_m": [0.02, 0.02, 0.03]}, "within_m": 0.005, "size_m": 0.0025}]});
    let hanging = plan_with(&block([0.04, 0.04, 0.03], [8, 8, 6], 1e4, &refinement), None);
    assert!(!hanging.assembly.followers().is_empty());
    let mesh =
        Block::uniform(Vec3::zeros(), Vec3::new(0.03, 0.03, 0.02), [6, 6, 4], "block").generate().unwrap();
    let from_file = |mesh: Mesh| {
        let mut scene = block([0.03, 0.03, 0.02], [6, 6, 4], 1e4, &json!({}));
        scene["bodies"][0]["mesh"] = json!({"file": {"name": "block.msh"}});
        plan_with(&scene, Some(mesh))
    };
    let wedges = from_file(mesh.clone().split_to_wedges());
    let tetrahedra = from_file(mesh.split_to_tetrahedra().to_quadratic_tetrahedra());
    for size in [0.0, 0.2] {
        check("hanging nodes", &hanging, size, 1.0);
        check("wedges", &wedges, size, 1.0);
        check("ten-node tetrahedra", &tetrahedra, size, 1.0);
    }
}
