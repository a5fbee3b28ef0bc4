//! Small patches of elements of each kind, with their forces, energies and matrices.

use crate::element::{ElementKind, ReferenceGeometry};
use crate::force::{
    Assembly, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation,
    StiffnessBatch, Threads, corner_pair,
};
use crate::material::Material;
use crate::tensor::{Mat3, Vec3};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use std::ops::Range;

pub const DENSITY: f64 = 1000.0;

pub fn parameters(material: Material) -> BlockParameters {
    BlockParameters::elastic(material, Formulation::Full, DENSITY)
}

/// Elements of one kind that fill a brick of 10 × 13 × 8 mm.
#[derive(Clone, Debug)]
pub struct Cells {
    pub kind: ElementKind,
    pub X: Vec<Vec3>,
    pub nodes: Vec<Vec<u32>>,
    /// Nodes that are not on the boundary.
    pub inner: Range<usize>,
    pub is_curved: bool,
}

/// A corner of the brick.
fn corner(a: usize) -> Vec3 {
    Vec3::new((a & 1) as f64, (a >> 1 & 1) as f64 * 1.3, (a >> 2) as f64 * 0.8) * 0.01
}

/// Patches of a kind; none of hexahedra, which other tests serve.
pub fn of_kind(kind: ElementKind) -> Vec<Cells> {
    match kind {
        ElementKind::Hex8 => Vec::new(),
        ElementKind::Tet4 => vec![tet4()],
        ElementKind::Wedge6 => vec![wedge6()],
        ElementKind::Tet10 => vec![tet10(0.0), tet10(1.0)],
    }
}

/// Two tetrahedra from each face of the brick to a node inside.
pub fn tet4() -> Cells {
    let X = (0..8).map(corner).chain([Vec3::new(4e-3, 7e-3, 3.5e-3)]).collect();
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let nodes = faces.iter().flat_map(|[a, b, c, d]| [vec![8, *a, *c, *b], vec![8, *a, *d, *c]]).collect();
    Cells { kind: ElementKind::Tet4, X, nodes, inner: 8..9, is_curved: false }
}

/// The same tetrahedra with nodes in the middle of the edges; those that end inside are moved from there by `bend` tenths of a millimetre.
pub fn tet10(bend: f64) -> Cells {
    let Cells { mut X, nodes: corners, .. } = tet4();
    let mut middles = BTreeMap::new();
    let mut nodes: Vec<Vec<u32>> = corners.clone();
    // Those of the boundary first.
    for inside in [false, true] {
        for (corners, nodes) in corners.iter().zip(&mut nodes) {
            nodes.resize(10, 0);
            for (edge, (a, b)) in [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)].into_iter().enumerate() {
                let [a, b] = [corners[a].min(corners[b]), corners[a].max(corners[b])];
                if inside != (b == 8) {
                    continue;
                }
                nodes[4 + edge] = *middles.entry((a, b)).or_insert_with(|| {
                    let i = X.len();
                    let off = if inside { bend * 1e-4 } else { 0.0 };
                    let off =
                        Vec3::new((i as f64).sin(), (2.0 * i as f64).cos(), (3.0 * i as f64).sin()) * off;
                    X.push((X[a as usize] + X[b as usize]) * 0.5 + off);
                    i as u32
                });
            }
        }
    }
    // The node inside is the 8th, those of the boundary follow.
    let inner = 8 + 1 + 18..X.len();
    Cells { kind: ElementKind::Tet10, X, nodes, inner, is_curved: bend > 0.0 }
}

/// Two layers of four wedges around a line inside, which is bent.
pub fn wedge6() -> Cells {
    let mut X = Vec::new();
    for level in 0..3 {
        let height = Vec3::z() * 4e-3 * f64::from(level);
        X.extend([0, 1, 3, 2].map(|a| corner(a) + height));
        X.push(Vec3::new(4e-3, 7e-3, 0.0) + height);
    }
    X[9] = Vec3::new(5.5e-3, 5.5e-3, 3.2e-3);
    let wedge = |level: u32, side: u32| {
        let bottom = [side, (side + 1) % 4, 4].map(|a| 5 * level + a);
        bottom.into_iter().chain(bottom.map(|a| a + 5)).collect()
    };
    let nodes = (0..2).flat_map(|level| (0..4).map(move |side| wedge(level, side))).collect();
    Cells { kind: ElementKind::Wedge6, X, nodes, inner: 9..10, is_curved: false }
}

/// Cells of one law and formulation.
#[derive(Debug)]
pub struct Patch {
    pub cells: Cells,
    pub blocks: [ElementBlock; 1],
    assembly: Assembly,
    pub mass: Vec<f64>,
}

impl Patch {
    pub fn new(cells: Cells, parameters: BlockParameters) -> Self {
        let mut mass = vec![0.0; cells.X.len()];
        let input = |(element, nodes): (usize, &Vec<u32>)| {
            let corners: Vec<Vec3> = nodes.iter().map(|node| cells.X[*node as usize]).collect();
            let geometry = ReferenceGeometry::new(cells.kind, &corners);
            assert!(geometry.smallest_jacobian > 0.0);
            for (node, volume) in nodes.iter().zip(&geometry.corner_volume) {
                mass[*node as usize] += DENSITY * volume;
            }
            let nodes = nodes.clone();
            BlockInput {
                element: element as u32,
                nodes: nodes.into(),
                corners: corners.into(),
                axes: Mat3::identity(),
                geometry,
            }
        };
        let inputs: Vec<BlockInput> = cells.nodes.iter().enumerate().map(input).collect();
        let blocks = [ElementBlock::new(0, parameters, 0, &inputs).unwrap()];
        let assembly = Assembly::new(cells.X.len(), &blocks);
        Self { cells, blocks, assembly, mass }
    }

    /// Of its elements, for messages.
    pub fn name(&self) -> String {
        let parameters = &self.blocks[0].parameters;
        format!("{:?} {:?} {}", self.cells.kind, parameters.formulation, parameters.material.name())
    }

    pub fn material(&self) -> Material {
        self.blocks[0].parameters.material
    }

    pub fn evaluated(&self, u: &[Vec3]) -> ElementForces {
        let mut forces = ElementForces::new(&self.blocks);
        forces.evaluate(&Threads::ONE, &self.blocks, &ForceInput::at(u));
        forces
    }

    pub fn force(&self, u: &[Vec3]) -> DVector<f64> {
        let forces = self.evaluated(u);
        DVector::from_fn(3 * u.len(), |i, _| forces.at_node(&self.assembly, i / 3)[i % 3])
    }

    pub fn energy(&self, u: &[Vec3]) -> f64 {
        self.evaluated(u).totals(0).strain
    }

    /// The tangent, assembled from those of the elements and of the nodes that average pressure.
    pub fn tangent(&self, u: &[Vec3]) -> DMatrix<f64> {
        let mut K = DMatrix::zeros(3 * u.len(), 3 * u.len());
        let mut batch = StiffnessBatch::zeros();
        let count = self.cells.kind.node_count();
        let tangent = self.blocks[0].tangent_at(u);
        for b in 0..self.blocks[0].batch_count() {
            tangent.eval_batch(b, &mut batch);
            for slot in 8 * b..(8 * b + 8).min(self.blocks[0].elements.len()) {
                let nodes = self.blocks[0].nodes_of(slot);
                for (a, b) in (0..count).flat_map(|a| (0..count).map(move |b| (a, b))) {
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
        tangent.for_each_nodal_term(&self.cells.X, &mut |term| {
            let mut g = DVector::zeros(3 * u.len());
            for (node, slope) in &term.patch {
                g.fixed_rows_mut::<3>(3 * *node as usize).copy_from(slope);
            }
            K.ger(term.modulus, &g, &g, 1.0);
        });
        K
    }

    /// F of a tetrahedron, by the matrices of its edges.
    pub fn gradient(&self, nodes: &[u32], u: &[Vec3]) -> (Mat3, Mat3, f64) {
        let X = &self.cells.X;
        let edges =
            |x: &dyn Fn(u32) -> Vec3| Mat3::from_columns(&[1, 2, 3].map(|a| x(nodes[a]) - x(nodes[0])));
        let at_rest = edges(&|a| X[a as usize]);
        let inverse = at_rest.try_inverse().unwrap();
        let F = edges(&|a| X[a as usize] + u[a as usize]) * inverse;
        (F, inverse, at_rest.determinant() / 6.0)
    }
}
