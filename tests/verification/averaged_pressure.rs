//! Tetrahedra of four nodes with averaged nodal pressure: Cook's membrane and a cantilever at small strain, K/G = 5000 and 10⁴.
//!
//! The stiffness is that of differences of the internal forces at rest. The deflections expected were computed from the formulas of
//! `src/mechanics/force/nodal_pressure.rs` by another program: matrices of the linear theory, assembled and solved in Python. How much
//! pressure alternates is `(Σ V (p − p̄)² / Σ V p²)^½`, p̄ the mean of an element's neighbours by a face.

use crate::rig::{assert_at_most, assert_close, plan_with, run};
use contuse::mechanics::force::{ElementForces, ForceInput, StiffnessBatch, Threads};
use contuse::mechanics::sparse::{Cholesky, Definiteness, SymmetricMatrix, Unknowns};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use contuse::plan::Plan;
use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A problem of linear elasticity on tetrahedra.
struct Problem {
    mesh: Mesh,
    moduli: [f64; 2],
    /// Whether a node is held along an axis.
    is_held: fn(&Vec3, usize) -> bool,
    /// Nodes with a force along y, and its fraction of the total [-].
    load: Vec<(usize, f64)>,
    force: f64,
}

/// n × n × 1 hexahedra in six tetrahedra each.
fn cook(n: u32) -> Problem {
    let mut mesh = Block::uniform(Vec3::zeros(), Vec3::repeat(1.0), [n, n, 1], "block").generate().unwrap();
    for X in &mut mesh.nodes {
        *X = Vec3::new(48.0 * X.x, 44.0 * X.x + (44.0 - 28.0 * X.x) * X.y, X.z);
    }
    let at_end = nodes(&mesh, |X| X.x > 48.0 - 1e-9);
    let is_edge = |X: &Vec3| X.y < 44.0 + 1e-9 || X.y > 60.0 - 1e-9;
    let fraction = |a: &usize| if is_edge(&mesh.nodes[*a]) { 0.5 } else { 1.0 } / f64::from(2 * n);
    let load = at_end.iter().map(|a| (*a, fraction(a))).collect();
    Problem {
        mesh: mesh.split_to_tetrahedra(),
        moduli: [80.1938, 400_889.8],
        is_held: |X, axis| axis == 2 || X.x < 1e-9,
        load,
        force: 100.0,
    }
}

/// 10 × 2 × 1 with a force at its end that is 1 for the unit of a slender beam: n elements in its height.
fn cantilever(n: u32) -> Problem {
    let [high, wide] = [n, n / 2];
    let mesh = Block::uniform(Vec3::zeros(), Vec3::new(10.0, 2.0, 1.0), [5 * n, high, wide], "block")
        .generate()
        .unwrap();
    let fraction = |X: &Vec3| {
        let half = |is_edge: bool| if is_edge { 0.5 } else { 1.0 };
        half(X.y < 1e-9 || X.y > 2.0 - 1e-9) * half(X.z < 1e-9 || X.z > 1.0 - 1e-9) / f64::from(high * wide)
    };
    let load =
        nodes(&mesh, |X| X.x > 10.0 - 1e-9).into_iter().map(|a| (a, fraction(&mesh.nodes[a]))).collect();
    let (G, K) = (1.0, 1e4);
    let E = 9.0 * K * G / (3.0 * K + G);
    // Timoshenko: F L³/3EI + F L/(5/6 G A)
    let tip = 1000.0 / (3.0 * E * 8.0 / 12.0) + 10.0 / (5.0 / 6.0 * G * 2.0);
    Problem {
        mesh: mesh.split_to_tetrahedra(),
        moduli: [G, K],
        is_held: |X, _| X.x < 1e-9,
        load,
        force: 1.0 / tip,
    }
}

fn nodes(mesh: &Mesh, is_one: impl Fn(&Vec3) -> bool) -> Vec<usize> {
    (0..mesh.nodes.len()).filter(|a| is_one(&mesh.nodes[*a])).collect()
}

fn plan(problem: &Problem, formulation: &Value) -> Plan {
    let [mu, bulk] = problem.moduli;
    let material = json!({"law": "neo_hookean", "c10_pa": 0.5 * mu, "bulk_modulus_pa": bulk});
    let mut part = json!({"part": "block", "density_kg_per_m3": 1000, "material": material});
    if !formulation.is_null() {
        part["formulation"] = formulation.clone();
    }
    let scene = json!({
        "name": "tetrahedra", "end_time_s": 1e-3,
        "bodies": [{"name": "body", "mesh": {"file": {"name": "mesh.msh"}}, "parts": [part]}]
    });
    plan_with(&scene, Some(problem.mesh.clone()))
}

/// Weighted displacement along the load, and how much pressure alternates.
fn solve(problem: &Problem, formulation: &Value) -> (f64, f64) {
    let plan = plan(problem, formulation);
    let force = |u: &[Vec3]| internal_forces(&plan, u);
    // The free components, and the stiffness between them.
    let all = (0..plan.X.len()).flat_map(|a| (0..3).map(move |i| (a, i)));
    let free: Vec<(usize, usize)> = all.filter(|(a, i)| !(problem.is_held)(&plan.X[*a], *i)).collect();
    let step = 1e-6;
    let mut u = vec![Vec3::zeros(); plan.X.len()];
    let mut K = DMatrix::zeros(free.len(), free.len());
    for (column, (a, i)) in free.iter().enumerate() {
        u[*a][*i] = step;
        let high = force(&u);
        u[*a][*i] = -step;
        let low = force(&u);
        u[*a][*i] = 0.0;
        for (row, (b, j)) in free.iter().enumerate() {
            K[(row, column)] = (high[*b][*j] - low[*b][*j]) / (2.0 * step);
        }
    }
    assert!((&K - K.transpose()).norm() < 1e-7 * K.norm(), "not a gradient");
    let mut f = DVector::zeros(free.len());
    for (row, (a, i)) in free.iter().enumerate().filter(|(_, (_, i))| *i == 1) {
        debug_assert_eq!(*i, 1);
        f[row] =
            problem.load.iter().filter(|(b, _)| b == a).map(|(_, fraction)| fraction * problem.force).sum();
    }
    let found = K.cholesky().unwrap().solve(&f);
    for ((a, i), value) in free.iter().zip(found.iter()) {
        u[*a][*i] = *value;
    }
    let deflection = problem.load.iter().map(|(a, fraction)| fraction * u[*a].y).sum();
    (deflection, roughness(&plan, &u))
}

/// Of the pressure at small multiples of a displacement, which does not depend on its size.
fn roughness(plan: &Plan, u: &[Vec3]) -> f64 {
    let small: Vec<Vec3> = u.iter().map(|u| u * 1e-6).collect();
    let mut points = vec![(0.0, 0.0); plan.element_count()];
    plan.blocks[0].for_each_point(&plan.X, &small, &mut |element, _, point| {
        points[element as usize] = (point.volume, -point.cauchy.trace() / 3.0);
    });
    let mut faces: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
    for (e, cell) in plan.bodies[0].cells.iter().enumerate() {
        for without in 0..4 {
            let mut face: Vec<u32> =
                cell.nodes.iter().copied().filter(|n| *n != cell.nodes[without]).collect();
            face.sort_unstable();
            faces.entry(face.try_into().unwrap()).or_default().push(e);
        }
    }
    let mut beside = vec![(0.0, 0.0); points.len()];
    for pair in faces.values().filter(|elements| elements.len() == 2) {
        for (e, other) in [(pair[0], pair[1]), (pair[1], pair[0])] {
            beside[e] = (beside[e].0 + points[other].1, beside[e].1 + 1.0);
        }
    }
    let (mut rough, mut all) = (0.0, 0.0);
    for ((volume, p), (sum, count)) in points.iter().zip(beside) {
        rough += volume * (p - sum / count).powi(2);
        all += volume * p * p;
    }
    (rough / all).sqrt()
}

#[test]
fn nearly_incompressible_tetrahedra_do_not_lock_and_their_pressure_does_not_alternate() {
    // Of Python: deflection of the loaded end and roughness of the pressure, with averaged pressure and fully integrated. The unit of the
    // cantilever is the tip of a slender beam, which this one, with its clamp and its coarse mesh, need not reach.
    let cases = [
        ("Cook's membrane, 8 × 8", cook(8), [5.696_252, 0.344_951], [2.181_498, 1.289_606]),
        ("cantilever, 20 × 4 × 2", cantilever(4), [0.785_487, 0.336_392], [0.039_874, 1.185_003]),
    ];
    for (what, problem, averaged, full) in cases {
        for (how, formulation, expected) in
            [("averaged", Value::Null, averaged), ("full", json!("full"), full)]
        {
            let (deflection, roughness) = solve(&problem, &formulation);
            assert_close(deflection, expected[0], 1e-4, &format!("{what}, {how}: deflection"));
            assert_close(roughness, expected[1], 1e-3, &format!("{what}, {how}: roughness of the pressure"));
        }
    }
}

/// Internal forces at all nodes [N].
fn internal_forces(plan: &Plan, u: &[Vec3]) -> Vec<Vec3> {
    let mut forces = ElementForces::new(&plan.blocks);
    forces.evaluate(&Threads::ONE, &plan.blocks, &ForceInput::at(u));
    (0..u.len()).map(|a| forces.at_node(&plan.assembly, a)).collect()
}

/// The components that are not held, with the pattern of the tangent between them.
fn unknowns(problem: &Problem, plan: &Plan) -> Unknowns {
    let patches = plan.blocks[0].patches();
    let nodes = plan.bodies[0].cells.iter().map(|cell| cell.nodes).chain(patches.iter().map(Vec::as_slice));
    Unknowns::new(plan.node_count(), |a, i| !(problem.is_held)(&plan.X[a], i), nodes).unwrap()
}

/// The tangent between those components.
fn tangent(plan: &Plan, unknowns: &Unknowns, u: &[Vec3]) -> SymmetricMatrix {
    let block = &plan.blocks[0];
    let (mut matrix, mut batch) = (SymmetricMatrix::new(unknowns), StiffnessBatch::zeros());
    let tangent = block.tangent_at(u);
    for b in 0..block.batch_count() {
        tangent.eval_batch(b, &mut batch);
        matrix.add_batch(unknowns, block, b, &batch, 1.0);
    }
    tangent.for_each_nodal_term(&plan.X, &mut |term| matrix.add_square(unknowns, term.modulus, &term.patch));
    matrix
}

#[test]
fn the_tangent_is_the_derivative_of_the_forces_at_finite_strain() {
    for (what, problem) in [("Cook's membrane", cook(6)), ("cantilever", cantilever(4))] {
        let plan = plan(&problem, &Value::Null);
        let unknowns = unknowns(&problem, &plan);
        // A bent and stretched state, and a direction that is smooth nowhere.
        let size = plan.X.iter().map(|X| X.x).fold(0.0, f64::max);
        let state =
            |X: &Vec3| Vec3::new(0.1 * X.x + 0.05 * X.y, 0.2 * X.x * X.x / size, 0.1 * X.z * X.x / size);
        let u: Vec<Vec3> = plan.X.iter().map(state).collect();
        let mut w = vec![0.0; unknowns.count()];
        w.iter_mut().enumerate().for_each(|(i, w)| *w = (1.7 * (i * i) as f64).sin());
        let mut direction = vec![Vec3::zeros(); u.len()];
        unknowns.scatter(&w, &mut direction);

        let side = |h: f64| -> Vec<Vec3> {
            let moved: Vec<Vec3> = u.iter().zip(&direction).map(|(u, w)| u + w * h).collect();
            internal_forces(&plan, &moved)
        };
        // Fourth order.
        let h = 1e-4;
        let [far_low, low, high, far_high] = [-2.0, -1.0, 1.0, 2.0].map(|steps| side(steps * h));
        let slope: Vec<Vec3> = (0..u.len())
            .map(|a| ((high[a] - low[a]) * 8.0 - (far_high[a] - far_low[a])) / (12.0 * h))
            .collect();
        let (mut expected, mut found) = (vec![0.0; w.len()], vec![0.0; w.len()]);
        unknowns.gather(&slope, &mut expected);
        tangent(&plan, &unknowns, &u).multiply(&w, &mut found);
        let [expected, found] = [expected, found].map(DVector::from_vec);
        let error = (&found - &expected).norm() / expected.norm();
        assert_at_most(
            error,
            1e-8,
            &format!("{what}: difference of the tangent along a direction, of its size"),
        );
    }
}

#[test]
fn newton_converges_quadratically() {
    let problem = cook(8);
    let plan = plan(&problem, &Value::Null);
    let unknowns = unknowns(&problem, &plan);
    let mut load = vec![Vec3::zeros(); plan.node_count()];
    for (a, fraction) in &problem.load {
        load[*a].y = 0.02 * problem.force * fraction;
    }
    let mut u = vec![Vec3::zeros(); plan.node_count()];
    let mut step = vec![Vec3::zeros(); plan.node_count()];
    let mut residuals = Vec::new();
    for _ in 0..20 {
        let residual: Vec<Vec3> =
            load.iter().zip(internal_forces(&plan, &u)).map(|(load, f)| load - f).collect();
        let mut x = vec![0.0; unknowns.count()];
        unknowns.gather(&residual, &mut x);
        residuals.push(x.iter().map(|r| r * r).sum::<f64>().sqrt());
        if residuals.last().is_some_and(|last| *last < 1e-9 * residuals[0]) {
            break;
        }
        let matrix = tangent(&plan, &unknowns, &u);
        let mut factor = Cholesky::new(&matrix).unwrap();
        assert_eq!(factor.factorize(&matrix), Ok(Definiteness::Positive));
        factor.solve(&mut x);
        unknowns.scatter(&x, &mut step);
        u.iter_mut().zip(&step).for_each(|(u, step)| *u += step);
    }
    println!("residuals {residuals:?}");
    let [before, middle, last] = residuals[residuals.len() - 3..] else { panic!() };
    assert!(last < 1e-9 * residuals[0], "{residuals:?}");
    let order = (last / middle).ln() / (middle / before).ln();
    assert!(order > 1.7, "order {order} of {residuals:?}");
}

#[test]
fn the_ledger_of_an_explicit_run_closes() {
    let problem = cook(4);
    let [mu, bulk] = problem.moduli;
    let scene = json!({
        "name": "a stretched block of tetrahedra swings", "end_time_s": 20.0,
        "bodies": [{
            "name": "body", "mesh": {"file": {"name": "mesh.msh"}}, "fixed": [{"set": "x_min"}],
            "parts": [{"part": "block", "density_kg_per_m3": 1, "material": {
                "law": "neo_hookean", "c10_pa": 0.5 * mu, "bulk_modulus_pa": 1e-3 * bulk, "volumetric": "quadratic_ln"
            }}],
            "initial_deformation": {
                "kind": "affine", "center_m": [0, 0, 0], "deformation_gradient": [[1.2, 0.1, 0], [0, 0.9, 0], [0, 0, 0.95]]
            }
        }],
        "integrator": {"kind": "explicit", "safety_factor": 0.45}, "record": {"fields": [], "field_times_s": []}
    });
    let plan = plan_with(&scene, Some(problem.mesh));
    assert!(!plan.skip_inactive_elements);
    let mut strain = [f64::INFINITY, 0.0];
    let (outcome, _) = run(&plan, |frame| {
        let now = frame.energy.bodies[0].strain_j;
        strain = [strain[0].min(now), strain[1].max(now)];
    });
    assert!(strain[0] < 0.5 * strain[1], "{strain:?}");
    assert_at_most(outcome.balance_error, 1e-3, "error of the energy balance");
}
