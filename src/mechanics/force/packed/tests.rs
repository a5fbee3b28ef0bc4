//! Tetrahedra through the passes that blocks have: against matrices, closed forms and differences.

use crate::mechanics::element::{Element, ElementKind, Hex8, ReferenceGeometry, Tet4};
use crate::mechanics::force::{
    Assembly, BlockError, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation,
    StiffnessBatch, Threads, corner_pair, stretch_rate,
};
use crate::mechanics::material::{CoupledNeoHookean, Material, Memories, MooneyRivlin, Volumetric};
use crate::mechanics::tensor::{Mat3, Tensor, Vec3};
use nalgebra::{DMatrix, DVector, Rotation3};

const DENSITY: f64 = 1000.0;

fn laws() -> [Material; 2] {
    [
        Material::MooneyRivlin(MooneyRivlin { c10: 4e4, c01: 1e4, volumetric: Volumetric::QuadraticLn(1e6) }),
        Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1e5, lambda: 2e5 }),
    ]
}

fn parameters(material: Material) -> BlockParameters {
    BlockParameters {
        material,
        formulation: Formulation::Full,
        density: DENSITY,
        linear_viscosity: 0.0,
        quadratic_viscosity: 0.0,
        shear_viscosity: 0.0,
        memory: Memories::NONE,
        erosion: None,
    }
}

/// The corners of a brick and a node inside.
fn nodes() -> Vec<Vec3> {
    let corner =
        |a: usize| Vec3::new((a & 1) as f64, (a >> 1 & 1) as f64 * 1.3, (a >> 2) as f64 * 0.8) * 0.01;
    (0..8).map(corner).chain([Vec3::new(4e-3, 7e-3, 3.5e-3)]).collect()
}

/// Two tetrahedra from each face of the brick to the node inside.
fn tetrahedra() -> Vec<[u32; 4]> {
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    faces.iter().flat_map(|[a, b, c, d]| [[8, *a, *c, *b], [8, *a, *d, *c]]).collect()
}

struct Patch {
    X: Vec<Vec3>,
    blocks: [ElementBlock; 1],
    assembly: Assembly,
    mass: Vec<f64>,
}

impl Patch {
    fn new(material: Material) -> Self {
        let X = nodes();
        let mut mass = vec![0.0; X.len()];
        let input = |(element, nodes): (usize, [u32; 4])| {
            let corners = nodes.map(|node| X[node as usize]).to_vec();
            let geometry = ReferenceGeometry::new(ElementKind::Tet4, &corners);
            assert!(geometry.smallest_jacobian > 0.0);
            for (node, volume) in nodes.iter().zip(&geometry.corner_volume) {
                mass[*node as usize] += DENSITY * volume;
            }
            BlockInput {
                element: element as u32,
                nodes: nodes.to_vec(),
                corners,
                axes: Mat3::identity(),
                geometry,
            }
        };
        let inputs: Vec<BlockInput> = tetrahedra().into_iter().enumerate().map(input).collect();
        let blocks = [ElementBlock::new(0, parameters(material), 0, &inputs).unwrap()];
        let assembly = Assembly::new(X.len(), &blocks);
        Self { X, blocks, assembly, mass }
    }

    fn evaluated(&self, u: &[Vec3]) -> ElementForces {
        let mut forces = ElementForces::new(&self.blocks);
        forces.evaluate(&Threads::ONE, &self.blocks, &ForceInput { u, inverse_step: 0.0, history: &[] });
        forces
    }

    fn force(&self, u: &[Vec3]) -> DVector<f64> {
        let forces = self.evaluated(u);
        DVector::from_fn(3 * u.len(), |i, _| forces.at_node(&self.assembly, i / 3)[i % 3])
    }

    fn energy(&self, u: &[Vec3]) -> f64 {
        self.evaluated(u).totals(0).strain
    }

    /// Assembled from the tangents of the elements.
    fn stiffness(&self, u: &[Vec3]) -> DMatrix<f64> {
        let mut K = DMatrix::zeros(3 * u.len(), 3 * u.len());
        let mut batch = StiffnessBatch::zeros();
        for b in 0..self.blocks[0].batch_count() {
            self.blocks[0].eval_stiffness(b, u, &mut batch);
            for slot in 8 * b..(8 * b + 8).min(self.blocks[0].elements.len()) {
                let nodes = self.blocks[0].nodes_of(slot);
                for (a, b) in (0..4).flat_map(|a| (0..4).map(move |b| (a, b))) {
                    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                        let entry = if a >= b {
                            batch.0[corner_pair(a, b)][3 * i + j]
                        } else {
                            batch.0[corner_pair(b, a)][3 * j + i]
                        };
                        K[(3 * nodes[a] as usize + i, 3 * nodes[b] as usize + j)] += entry[slot % 8];
                    }
                }
            }
        }
        K
    }

    /// F of an element, by the matrices of its edges.
    fn gradient(&self, nodes: [u32; 4], u: &[Vec3]) -> (Mat3, Mat3, f64) {
        let edges =
            |x: &dyn Fn(u32) -> Vec3| Mat3::from_columns(&[1, 2, 3].map(|a| x(nodes[a]) - x(nodes[0])));
        let at_rest = edges(&|a| self.X[a as usize]);
        let inverse = at_rest.try_inverse().unwrap();
        let F = edges(&|a| self.X[a as usize] + u[a as usize]) * inverse;
        (F, inverse, at_rest.determinant() / 6.0)
    }
}

/// Turned, stretched, and every node moved.
fn displaced(X: &[Vec3], strain: f64) -> Vec<Vec3> {
    let R = Rotation3::from_euler_angles(0.3, -0.5, 0.8).into_inner();
    let F = Mat3::new(1.2, 0.3, 0.1, 0.0, -0.7, 0.2, -0.1, 0.1, 0.4) * strain + Mat3::identity();
    let bend =
        |a: usize| Vec3::new((a as f64 * 2.3).sin(), (a as f64 * 1.7).cos(), (a as f64 * 0.9).sin()) * 3e-3;
    X.iter().enumerate().map(|(a, X)| R * F * (X + bend(a) * strain) - X).collect()
}

#[test]
fn the_scale_is_that_of_weight_and_derivative() {
    fn error<E: Element<N, Q>, const N: usize, const Q: usize>() -> f64 {
        E::SCALE * (E::WEIGHT * E::DERIVATIVE.powi(3)).sqrt() - 1.0
    }
    assert!(error::<Hex8, 8, 8>().abs() < 1e-15 && error::<Tet4, 4, 1>().abs() < 1e-15);
}

#[test]
fn forces_and_energy_are_those_of_matrices() {
    for material in laws() {
        let patch = Patch::new(material);
        let u = displaced(&patch.X, 0.2);
        let (mut energy, mut expected) = (0.0, DVector::zeros(27));
        for nodes in tetrahedra() {
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
    let patch = Patch::new(laws()[0]);
    let F = Mat3::new(1.1, 0.2, 0.0, -0.1, 0.95, 0.3, 0.0, 0.1, 1.05);
    let u: Vec<Vec3> = patch.X.iter().map(|X| F * X - X).collect();
    let force = patch.force(&u);
    assert!(force.rows(24, 3).norm() < 1e-12 * force.norm());
    let point = laws()[0].eval_total(&Tensor::from(&(F - Mat3::identity())), &[]);
    let cauchy = Mat3::from(&point.P) * F.transpose() / F.determinant();
    let (mut count, mut volume) = (0, 0.0);
    patch.blocks[0].for_each_point(&patch.X, &u, &mut |element, q, field| {
        assert_eq!(q, 0);
        assert!((field.cauchy - cauchy).norm() < 1e-11 * cauchy.norm() && (field.F - F).norm() < 1e-13);
        let centre = tetrahedra()[element as usize].map(|a| patch.X[a as usize]).iter().sum::<Vec3>() / 4.0;
        assert!((field.position - centre).norm() < 1e-15);
        (count, volume) = (count + 1, volume + field.volume);
    });
    assert!(count == 12 && (volume / 1.04e-6 - 1.0).abs() < 1e-13);
}

#[test]
fn force_is_the_slope_of_the_energy_and_the_tangent_that_of_the_force() {
    for material in laws() {
        let patch = Patch::new(material);
        let u = displaced(&patch.X, 0.2);
        let (f, K) = (patch.force(&u), patch.stiffness(&u));
        let h = 1e-8;
        for column in 0..27 {
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
    }
}

#[test]
fn a_rotation_changes_no_energy_and_turns_the_forces() {
    let patch = Patch::new(laws()[0]);
    let u = displaced(&patch.X, 0.2);
    let R = Rotation3::from_euler_angles(-1.0, 2.0, 0.4).into_inner();
    let turned: Vec<Vec3> = u.iter().zip(&patch.X).map(|(u, X)| R * (X + u) - X).collect();
    assert!((patch.energy(&turned) / patch.energy(&u) - 1.0).abs() < 1e-12);
    let (f, g) = (patch.force(&u), patch.force(&turned));
    for a in 0..9 {
        let (f, g) = (f.fixed_rows::<3>(3 * a), g.fixed_rows::<3>(3 * a));
        assert!((R * f - g).norm() < 1e-11 * patch.force(&u).norm());
    }
    let rigid: Vec<Vec3> = patch.X.iter().map(|X| R * X - X).collect();
    assert!(patch.force(&rigid).norm() < 1e-11 * patch.force(&u).norm());
}

#[test]
fn the_stable_step_is_below_that_of_the_highest_frequency() {
    for material in laws() {
        let patch = Patch::new(material);
        assert!((patch.mass.iter().sum::<f64>() / (1.04e-6 * DENSITY) - 1.0).abs() < 1e-13);
        for strain in [0.0, 0.1, 0.3] {
            let u = displaced(&patch.X, strain);
            let K = patch.stiffness(&u);
            let scaled =
                DMatrix::from_fn(27, 27, |r, c| K[(r, c)] / (patch.mass[r / 3] * patch.mass[c / 3]).sqrt());
            let highest = scaled.symmetric_eigenvalues().max().sqrt();
            let share = 0.5 * patch.evaluated(&u).totals(0).stable_step.0 * highest;
            assert!((0.2..1.0).contains(&share), "{strain}: h ω/2 = {share}");
        }
    }
}

#[test]
fn a_uniform_rate_is_seen_along_the_edges() {
    let patch = Patch::new(laws()[0]);
    let D = Mat3::new(3.0, 1.0, 0.5, 1.0, -2.0, 0.2, 0.5, 0.2, 1.0);
    let v: Vec<Vec3> = patch.X.iter().map(|X| D * X).collect();
    let mut expected = 0.0_f64;
    for nodes in tetrahedra() {
        for &(a, b) in ElementKind::Tet4.lengths() {
            let [a, b] = [nodes[a], nodes[b]].map(|a| a as usize);
            let dX = patch.X[b] - patch.X[a];
            expected = expected.max(stretch_rate(&dX, &dX, &(v[b] - v[a])));
        }
    }
    let found =
        ElementForces::new(&patch.blocks).largest_stretch_rate(&Threads::ONE, &patch.blocks, &v, 1.0, 0.0);
    assert!((found / expected - 1.0).abs() < 1e-13, "{found} for {expected}");
}

#[test]
fn formulations_that_an_element_has_not_are_refused() {
    let corners = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let geometry = ReferenceGeometry::new(ElementKind::Tet4, &corners);
    let input = BlockInput { element: 0, nodes: (0..4).collect(), corners, axes: Mat3::identity(), geometry };
    let block = |formulation, inputs: &[BlockInput]| {
        ElementBlock::new(0, BlockParameters { formulation, ..parameters(laws()[0]) }, 0, inputs).map(|_| ())
    };
    assert_eq!(block(Formulation::Full, std::slice::from_ref(&input)), Ok(()));
    for formulation in [Formulation::MeanDilatation, Formulation::Reduced] {
        let refused = Err(BlockError::Formulation(ElementKind::Tet4, formulation));
        assert_eq!(block(formulation, std::slice::from_ref(&input)), refused);
    }
    let short = BlockInput { nodes: vec![0, 1, 2], ..input };
    assert_eq!(block(Formulation::Full, &[short]), Err(BlockError::Kinds));
    assert_eq!(block(Formulation::Full, &[]), Err(BlockError::Kinds));
}
