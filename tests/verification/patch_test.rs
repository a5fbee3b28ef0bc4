//! Patch test: a block cut into distorted hexahedra, wedges or tetrahedra, under a linear field, has the one exact stress at every point and no
//! net force on its inner nodes, for every law and formulation.
//!
//! On the block of 3×3×3 elements the 8 inner nodes are moved at random (up to 20 % of an edge), so that no element is a
//! parallelepiped; F is far from the identity. The other cells are these hexahedra split.

use crate::rig::{assert_at_most, plan_with};
use contuse::mechanics::force::{ElementForces, ForceInput, Threads};
use contuse::mechanics::material::eval_point;
use contuse::mechanics::tensor::{Mat3, Vec3};
use contuse::mesh::generate::block::Block;
use contuse::mesh::{Cells, Mesh};
use contuse::plan::Plan;
use serde_json::{Value, json};

const GRADIENT: [[f64; 3]; 3] = [[1.15, 0.20, -0.05], [0.03, 0.90, 0.12], [-0.08, 0.02, 1.05]];

/// A unit cube of 3×3×3 elements with its inner nodes moved.
fn distorted_block() -> Mesh {
    let mut mesh = Block::uniform(Vec3::zeros(), Vec3::repeat(1.0), [3, 3, 3], "block").generate().unwrap();
    // A linear congruence is random enough, and the same everywhere.
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    };
    for x in mesh.nodes.iter_mut().filter(|x| is_inside(x)) {
        *x += Vec3::from_fn(|_, _| random()) * (0.2 / 3.0);
    }
    mesh
}

fn is_inside(X: &Vec3) -> bool {
    X.iter().all(|c| *c > 0.01 && *c < 0.99)
}

fn scene(material: &Value, formulation: &str) -> Value {
    let mut scene = json!({
        "name": "patch",
        "end_time_s": 1e-6,
        "bodies": [{
            "name": "patch",
            "mesh": {"file": {"name": "patch"}},
            "parts": [{
                "part": "block", "density_kg_per_m3": 1000.0, "material": material,
                "fibre_frame": {"kind": "constant", "axis": [1, 1, 0], "plane": [0, 0, 1]}
            }],
            "initial_deformation": {"kind": "affine", "center_m": [0.3, 0.2, 0.1], "deformation_gradient": GRADIENT}
        }]
    });
    if formulation != AVERAGED {
        scene["bodies"][0]["parts"][0]["formulation"] = json!(formulation);
    }
    scene
}

/// Averaged nodal pressure has no name in a scene: it is the default of its elements.
const AVERAGED: &str = "averaged pressure";

/// Internal forces of all nodes [N], strain energy [J].
fn evaluate(plan: &Plan, u: &[Vec3]) -> (Vec<Vec3>, f64) {
    let mut forces = ElementForces::new(&plan.blocks);
    let input = ForceInput::at(u);
    forces.evaluate(&Threads::ONE, &plan.blocks, &input);
    let of_nodes = (0..plan.node_count()).map(|node| forces.at_node(&plan.assembly, node)).collect();
    (of_nodes, (0..plan.blocks.len()).map(|block| forces.totals(block).strain).sum())
}

/// Checks a law and a formulation on a mesh with so many points.
fn check(mesh: &Mesh, count: usize, material: &Value, formulation: &str) {
    let plan = plan_with(&scene(material, formulation), Some(mesh.clone()));
    let F = Mat3::from_fn(|i, j| GRADIENT[i][j]);
    // The law in the axes of the part: rotate F into them and the stress back.
    let e1 = Vec3::new(1.0, 1.0, 0.0).normalize();
    let e2 = Vec3::z();
    let Q = Mat3::from_columns(&[e1, e2, e1.cross(&e2)]);
    let exact = eval_point(&plan.blocks[0].parameters.material, &(Q.transpose() * F * Q)).unwrap();
    let cauchy = Q * exact.cauchy * Q.transpose();
    let what = format!("{material} {formulation} {:?}", plan.blocks[0].kind);

    // Rounding only: a hundred roundings of the stress.
    let (mut points, mut worst) = (0, 0.0_f64);
    for block in &plan.blocks {
        block.for_each_point(&plan.X, &plan.initial_u, &mut |element, q, point| {
            let error = (point.cauchy - cauchy).norm() / cauchy.norm();
            assert!(error < 1e-12, "{what}, element {element}, point {q}: off by {error:.1e}");
            worst = worst.max(error);
            points += 1;
        });
    }
    assert_eq!(points, count);
    assert_at_most(worst, 1e-12, "stress at a point, of its size");

    let (forces, strain) = evaluate(&plan, &plan.initial_u);
    let scale = forces.iter().map(Vec3::norm).fold(0.0, f64::max);
    let mut inner = 0;
    for (X, f) in plan.X.iter().zip(&forces).filter(|(X, _)| is_inside(X)) {
        assert!(f.norm() < 1e-13 * scale, "{what}: {f:?} N at {X:?} against {scale} N on the surface");
        assert_at_most(f.norm() / scale, 1e-13, "force on an inner node, of those on the surface");
        inner += 1;
    }
    assert!(inner >= 8);
    assert_at_most(strain / exact.psi - 1.0, 1e-13, "strain energy, of its size");
}

#[test]
fn every_law_passes_in_every_formulation() {
    let mesh = distorted_block();
    let volumetrics = ["ln_squared", "quadratic", "quadratic_ln"];
    for volumetric in volumetrics {
        let laws = [
            json!({"law": "mooney_rivlin", "c10_pa": 4e4, "c01_pa": 1e4, "bulk_modulus_pa": 1e6, "volumetric": volumetric}),
            json!({"law": "neo_hookean", "c10_pa": 4e4, "bulk_modulus_pa": 1e6, "volumetric": volumetric}),
            json!({
                "law": "holzapfel_gasser_ogden", "c_pa": 3e4, "k1_pa": 2e4, "k2": 0.8, "kappa": 0.1,
                "fibres": {"angles_deg": [29.0, -29.0]}, "bulk_modulus_pa": 1e6, "volumetric": volumetric
            }),
            json!({
                "law": "holzapfel_gasser_ogden", "c_pa": 3e4, "k1_pa": 2e4, "k2": 0.8, "i4": "isochoric",
                "fibres": {"angles_deg": [29.0]}, "bulk_modulus_pa": 1e6, "volumetric": volumetric
            }),
        ];
        for law in &laws {
            check(&mesh, 27 * 8, law, "mean_dilatation");
            check(&mesh, 27 * 8, law, "full");
            check(&mesh, 27 * 8, law, "reduced");
        }
    }
    let coupled = json!({"law": "coupled_neo_hookean", "mu_pa": 1e5, "lambda_pa": 1e6});
    let unsplit = json!({
        "law": "holzapfel_gasser_ogden", "c_pa": 3e4, "k1_pa": 2e4, "k2": 0.8, "matrix": "coupled",
        "fibres": {"angles_deg": [29.0, -29.0]}, "bulk_modulus_pa": 1e6
    });
    for law in [&coupled, &unsplit] {
        check(&mesh, 27 * 8, law, "full");
        check(&mesh, 27 * 8, law, "reduced");
    }
}

#[test]
fn wedges_and_tetrahedra_pass_too() {
    let split = json!({
        "law": "holzapfel_gasser_ogden", "c_pa": 3e4, "k1_pa": 2e4, "k2": 0.8, "kappa": 0.1,
        "fibres": {"angles_deg": [29.0, -29.0]}, "bulk_modulus_pa": 1e6
    });
    let coupled = json!({"law": "coupled_neo_hookean", "mu_pa": 1e5, "lambda_pa": 1e6});
    let wedges = distorted_block().split_to_wedges();
    let quadratic = distorted_block().split_to_tetrahedra().to_quadratic_tetrahedra();
    for (mesh, count) in [(&wedges, 54 * 6), (&quadratic, 162 * 4), (&half_split(), 18 * 6 + 18 * 8)] {
        check(mesh, count, &split, "mean_dilatation");
        check(mesh, count, &split, "full");
        check(mesh, count, &coupled, "full");
    }
    let linear = distorted_block().split_to_tetrahedra();
    for (law, formulation) in [(&split, AVERAGED), (&split, "full"), (&coupled, "full")] {
        check(&linear, 162, law, formulation);
    }
}

/// A third of the hexahedra as wedges, in columns along z: kinds mixed in one part.
fn half_split() -> Mesh {
    let (hexahedra, wedges) = (distorted_block(), distorted_block().split_to_wedges());
    let mut mesh = Mesh { cells: Cells::default(), part_of: Vec::new(), ..hexahedra.clone() };
    for (element, cell) in hexahedra.cells.iter().enumerate() {
        if element % 3 == 1 {
            mesh.cells.extend([2 * element, 2 * element + 1].map(|wedge| wedges.cells.get(wedge)));
            mesh.part_of.extend([0, 0]);
        } else {
            mesh.cells.extend([cell]);
            mesh.part_of.push(0);
        }
    }
    mesh
}
