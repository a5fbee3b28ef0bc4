//! Elements other than hexahedra through the passes that blocks have: against matrices, closed forms and differences.

mod patch;

use crate::element::{
    Element, ElementKind, Hex8, OfElement, ReferenceGeometry, Tet4, Tet10, Wedge6, for_each_element,
};
use crate::force::{
    BlockError, BlockInput, BlockParameters, ElementBlock, ElementForces, Formulation, Threads, stretch_rate,
};
use crate::material::{CoupledNeoHookean, Material, MooneyRivlin, Volumetric};
use crate::tensor::{Mat3, Tensor, Vec3};
use nalgebra::{DMatrix, DVector, Rotation3};
use patch::{Cells, DENSITY, Patch, parameters};

fn laws() -> [Material; 2] {
    [
        Material::MooneyRivlin(MooneyRivlin { c10: 4e4, c01: 1e4, volumetric: Volumetric::QuadraticLn(1e6) }),
        Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1e5, lambda: 2e5 }),
    ]
}

/// Calls a function for every element.
macro_rules! of_each {
    ($function:ident $($Kind:ident, $N:literal, $Q:literal, $OnePoint:ident;)*) => {
        [$($function::<$Kind, $N, $Q>()),*]
    };
}

/// Every kind with every law and formulation that it has beside one point.
fn patches() -> Vec<Patch> {
    let mut all = Vec::new();
    for cells in ElementKind::ALL.into_iter().flat_map(patch::of_kind) {
        for material in laws() {
            for formulation in [Formulation::Full, Formulation::MeanDilatation, Formulation::NodalPressure] {
                let is_coupled = formulation == Formulation::NodalPressure && material.volumetric().is_none();
                if formulation.is_of(cells.kind) && !is_coupled {
                    all.push(Patch::new(
                        cells.clone(),
                        BlockParameters { formulation, ..parameters(material) },
                    ));
                }
            }
        }
    }
    all
}

/// Turned, stretched, and every node moved.
fn displaced(X: &[Vec3], strain: f64) -> Vec<Vec3> {
    let R = Rotation3::from_euler_angles(0.3, -0.5, 0.8).into_inner();
    let F = Mat3::new(1.2, 0.3, 0.1, 0.0, -0.7, 0.2, -0.1, 0.1, 0.4) * strain + Mat3::identity();
    let bend =
        |a: usize| Vec3::new((a as f64 * 2.3).sin(), (a as f64 * 1.7).cos(), (a as f64 * 0.9).sin()) * 1e-3;
    X.iter().enumerate().map(|(a, X)| R * F * (X + bend(a) * strain) - X).collect()
}

#[test]
fn the_scale_is_that_of_weight_and_derivative() {
    fn error<E: Element<N, Q>, const N: usize, const Q: usize>() -> f64 {
        (E::SCALE * (E::WEIGHT * E::DERIVATIVE.powi(3)).sqrt() - 1.0).abs()
    }
    let errors = for_each_element!(of_each error);
    assert!(errors.iter().all(|error| *error < 1e-15), "{errors:?}");
}

#[test]
fn shape_functions_are_a_partition_of_unity_and_their_gradients_are_those_of_the_kernels() {
    fn check<E: Element<N, Q>, const N: usize, const Q: usize>() {
        for q in 0..Q {
            assert!((E::shapes()[q].iter().sum::<f64>() - 1.0).abs() < 1e-15);
            for a in 0..N {
                let mut u = [[0.0; N]; 3];
                u[0][a] = 1.0;
                let g = E::local_gradient_at(&E::local_gradients(&u), q);
                let mut sums = E::no_stress(0.0);
                let P = Tensor::from_fn(|i, k| (1 + 3 * i + k) as f64);
                E::add_local_stress(&mut sums, q, &P, &Tensor::diagonal(1.0));
                let forces = E::nodal_forces(&sums);
                for k in 0..3 {
                    assert!((g.0[0][k] * E::DERIVATIVE - E::shape_gradients()[q][a][k]).abs() < 1e-14);
                }
                let power = (0..3).map(|k| P.0[0][k] * g.0[0][k]).sum::<f64>();
                assert!((forces[0][a] - power).abs() < 1e-13, "node {a} point {q}");
            }
        }
    }
    for_each_element!(of_each check);
}

#[test]
fn forces_and_energy_of_tetrahedra_are_those_of_matrices() {
    for material in laws() {
        let patch = Patch::new(patch::tet4(), parameters(material));
        let u = displaced(&patch.cells.X, 0.2);
        let (mut energy, mut expected) = (0.0, DVector::zeros(27));
        for nodes in &patch.cells.nodes {
            let (F, inverse, volume) = patch.gradient(nodes, &u);
            let point = material.eval_total(&Tensor::from(&(F - Mat3::identity())), &[]);
            energy += volume * point.psi;
            // f_a = V P ∇N_a
            let on_edges = Mat3::from(&point.P) * inverse.transpose() * volume;
            for (a, f) in on_edges.column_iter().enumerate() {
                let (near, far) = (3 * nodes[0] as usize, 3 * nodes[a + 1] as usize);
                for i in 0..3 {
                    expected[far + i] += f[i];
                    expected[near + i] -= f[i];
                }
            }
        }
        assert!((patch.energy(&u) / energy - 1.0).abs() < 1e-12);
        assert!((patch.force(&u) - &expected).norm() < 1e-11 * expected.norm());
    }
}

#[test]
fn a_linear_field_is_in_balance_and_has_one_stress() {
    let F = Mat3::new(1.1, 0.2, 0.0, -0.1, 0.95, 0.3, 0.0, 0.1, 1.05);
    for patch in patches().into_iter().filter(|patch| !patch.cells.is_curved) {
        let X = &patch.cells.X;
        let u: Vec<Vec3> = X.iter().map(|X| F * X - X).collect();
        let force = patch.force(&u);
        for a in patch.cells.inner.clone() {
            assert!(force.rows(3 * a, 3).norm() < 1e-12 * force.norm(), "{}", patch.name());
        }
        let point = patch.material().eval_total(&Tensor::from(&(F - Mat3::identity())), &[]);
        let cauchy = Mat3::from(&point.P) * F.transpose() / F.determinant();
        let (mut count, mut volume) = (0, 0.0);
        patch.blocks[0].for_each_point(X, &u, &mut |_, q, field| {
            assert!(q < patch.cells.kind.point_count());
            assert!((field.cauchy - cauchy).norm() < 1e-11 * cauchy.norm() && (field.F - F).norm() < 1e-12);
            (count, volume) = (count + 1, volume + field.volume);
        });
        assert_eq!(count, patch.cells.nodes.len() * patch.cells.kind.point_count());
        assert!((volume / 1.04e-6 - 1.0).abs() < 1e-13, "{volume}");
    }
}

#[test]
fn force_is_the_slope_of_the_energy_and_the_tangent_that_of_the_force() {
    for patch in patches() {
        let u = displaced(&patch.cells.X, 0.2);
        let (f, K) = (patch.force(&u), patch.tangent(&u));
        let h = 1e-8;
        for column in 0..f.len() {
            let side = |step: f64| {
                let mut u = u.clone();
                u[column / 3][column % 3] += step;
                u
            };
            let slope = (patch.energy(&side(h)) - patch.energy(&side(-h))) / (2.0 * h);
            assert!(
                (slope - f[column]).abs() < 1e-6 * f.norm(),
                "{slope} for {}, {}",
                f[column],
                patch.name()
            );
            let slope = (patch.force(&side(h)) - patch.force(&side(-h))) / (2.0 * h);
            assert!((slope - K.column(column)).norm() < 1e-6 * K.norm(), "{}", patch.name());
        }
    }
}

#[test]
fn a_rotation_changes_no_energy_and_turns_the_forces() {
    for patch in patches() {
        let X = &patch.cells.X;
        let u = displaced(X, 0.2);
        let R = Rotation3::from_euler_angles(-1.0, 2.0, 0.4).into_inner();
        let turned: Vec<Vec3> = u.iter().zip(X).map(|(u, X)| R * (X + u) - X).collect();
        assert!((patch.energy(&turned) / patch.energy(&u) - 1.0).abs() < 1e-12);
        let (f, g) = (patch.force(&u), patch.force(&turned));
        for a in 0..X.len() {
            assert!((R * f.fixed_rows::<3>(3 * a) - g.fixed_rows::<3>(3 * a)).norm() < 1e-11 * f.norm());
        }
        let rigid: Vec<Vec3> = X.iter().map(|X| R * X - X).collect();
        assert!(patch.force(&rigid).norm() < 1e-11 * f.norm());
    }
}

#[test]
fn the_stable_step_is_below_that_of_the_highest_frequency() {
    for patch in patches() {
        let mass = patch.mass.iter().sum::<f64>();
        assert!(patch.cells.is_curved || (mass / (1.04e-6 * DENSITY) - 1.0).abs() < 1e-13);
        assert!(patch.mass.iter().all(|m| *m > 0.0));
        for strain in [0.0, 0.1, 0.3] {
            let u = displaced(&patch.cells.X, strain);
            let K = patch.tangent(&u);
            let of = |r: usize| patch.mass[r / 3];
            let scaled = DMatrix::from_fn(K.nrows(), K.nrows(), |r, c| K[(r, c)] / (of(r) * of(c)).sqrt());
            let highest = scaled.symmetric_eigenvalues().max().sqrt();
            let ratio = 0.5 * patch.evaluated(&u).totals(0).stable_step.0 * highest;
            assert!((0.2..1.0).contains(&ratio), "{strain}: h ω/2 = {ratio}, {}", patch.name());
        }
    }
}

#[test]
fn corners_of_wedges_are_kept_from_folding() {
    // One wedge whose corner is pushed beyond the opposite edge of its triangle: the points hardly see it, the penalty does.
    let X = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
    ];
    let cells = Cells {
        kind: ElementKind::Wedge6,
        X: X.map(Vec3::from).to_vec(),
        nodes: vec![(0..6).collect()],
        inner: 0..0,
        is_curved: false,
    };
    let patch = Patch::new(
        cells,
        BlockParameters { formulation: Formulation::MeanDilatation, ..parameters(laws()[0]) },
    );
    let mut u = vec![Vec3::zeros(); 6];
    assert!(patch.evaluated(&u).totals(0).hourglass == 0.0);
    u[0] = Vec3::new(0.45, 0.45, 0.0);
    let totals = patch.evaluated(&u).totals(0);
    assert!(totals.smallest_j.0 > -1.0 && totals.hourglass > 0.0, "{totals:?}");
    let (f, K) = (patch.force(&u), patch.tangent(&u));
    let h = 1e-7;
    for column in 0..18 {
        let side = |step: f64| {
            let mut u = u.clone();
            u[column / 3][column % 3] += step;
            u
        };
        let slope = (patch.energy(&side(h)) - patch.energy(&side(-h))) / (2.0 * h);
        assert!((slope - f[column]).abs() < 1e-6 * f.norm(), "{slope} for {}", f[column]);
        let slope = (patch.force(&side(h)) - patch.force(&side(-h))) / (2.0 * h);
        assert!((slope - K.column(column)).norm() < 1e-6 * K.norm());
    }
    // s = 1: ½ κ μ + ¼ M a volume where every corner is flat.
    let flat: Vec<Vec3> = X.iter().map(|X| Vec3::new(0.0, 0.0, -X[2])).collect();
    let [a, b, _] = crate::element::corner_stiffness::<Wedge6, 6, 6>((3.0, 200.0), 0.5);
    let rows = |x: &[Vec3]| -> [[f64; 6]; 3] { std::array::from_fn(|i| std::array::from_fn(|a| x[a][i])) };
    let X: Vec<Vec3> = X.map(Vec3::from).to_vec();
    let energy =
        crate::element::eval_corner_penalty(Wedge6::CORNERS, &rows(&X), &rows(&flat), [a, b, 0.0]).energy;
    assert!((energy / (0.5 * 20.0 * 3.0 * 0.5) - 1.0).abs() < 1e-13, "{energy}");
}

#[test]
fn a_uniform_rate_is_seen_along_the_edges() {
    let D = Mat3::new(3.0, 1.0, 0.5, 1.0, -2.0, 0.2, 0.5, 0.2, 1.0);
    for patch in patches() {
        let X = &patch.cells.X;
        let v: Vec<Vec3> = X.iter().map(|X| D * X).collect();
        let mut expected = 0.0_f64;
        for nodes in &patch.cells.nodes {
            for &(a, b) in patch.cells.kind.lengths() {
                let [a, b] = [nodes[a], nodes[b]].map(|a| a as usize);
                let dX = X[b] - X[a];
                expected = expected.max(stretch_rate(&dX, &dX, &(v[b] - v[a])));
            }
        }
        let found = ElementForces::new(&patch.blocks).largest_stretch_rate(
            &Threads::ONE,
            &patch.blocks,
            &v,
            1.0,
            0.0,
        );
        assert!((found / expected - 1.0).abs() < 1e-13, "{found} for {expected}");
    }
}

#[test]
fn formulations_that_an_element_has_not_are_refused() {
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].into_iter().collect::<OfElement<_>>();
    let geometry = ReferenceGeometry::new(ElementKind::Tet4, &corners);
    let input = BlockInput { element: 0, nodes: (0..4).collect(), corners, axes: Mat3::identity(), geometry };
    let block = |formulation, inputs: &[BlockInput]| {
        ElementBlock::new(0, BlockParameters { formulation, ..parameters(laws()[0]) }, 0, inputs).map(|_| ())
    };
    assert_eq!(block(Formulation::Full, std::slice::from_ref(&input)), Ok(()));
    assert_eq!(block(Formulation::NodalPressure, std::slice::from_ref(&input)), Ok(()));
    for formulation in [Formulation::MeanDilatation, Formulation::Reduced] {
        let refused = Err(BlockError::Formulation(ElementKind::Tet4, formulation));
        assert_eq!(block(formulation, std::slice::from_ref(&input)), refused);
    }
    let short = BlockInput { nodes: vec![0, 1, 2].into(), ..input };
    assert_eq!(block(Formulation::Full, &[short]), Err(BlockError::Kinds));
    assert_eq!(block(Formulation::Full, &[]), Err(BlockError::Kinds));
}
