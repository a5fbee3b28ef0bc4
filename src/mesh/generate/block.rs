//! A rectangular block of hexahedra, with uniform or graded cuts along each axis.

use super::grading::{Grading, graded};
use super::node_set;
use super::parameters::{Checks, refuse};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{CellKind, Mesh, MeshError, ParameterProblem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A block of one part along the coordinate axes, node sets `x_min`, `x_max`, `y_min`, `y_max`, `z_min` and `z_max`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Corner with the least coordinates [m].
    pub min_m: [f64; 3],
    /// Corner with the greatest coordinates [m].
    pub max_m: [f64; 3],
    /// Elements along x, y, z.
    pub elements: [u32; 3],
    /// Size ratio of the largest to the smallest element along x, y, z; the smallest are at `grading_center_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grading: Option<[f64; 3]>,
    /// Point towards which the elements are smallest [m]; by default the centre of the block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grading_center_m: Option<[f64; 3]>,
    /// Name of the only part; in documents `block`.
    #[serde(skip, default = "block")]
    pub part: String,
}

fn block() -> String {
    "block".into()
}

impl Block {
    /// A block of equal elements, from its lower corner and its size [m].
    pub fn uniform(origin: Vec3, size: Vec3, elements: [u32; 3], part: &str) -> Self {
        let (min_m, max_m) = (origin.into(), (origin + size).into());
        Self { min_m, max_m, elements, grading: None, grading_center_m: None, part: part.into() }
    }

    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("min_m", &self.min_m);
        checks.finite("max_m", &self.max_m);
        for axis in 0..3 {
            let (low, high) = (self.min_m[axis], self.max_m[axis]);
            checks.require(
                low < high,
                format!("max_m[{axis}]"),
                high,
                format!("> min_m[{axis}] = {low}"),
                "give the block a size along each axis",
            );
            checks.count(&format!("elements[{axis}]"), self.elements[axis], 1);
            let Some(ratio) = self.grading else { continue };
            checks.grading(&format!("grading[{axis}]"), ratio[axis]);
            let center = self.grading_center(axis);
            checks.require(
                (low..=high).contains(&center),
                format!("grading_center_m[{axis}]"),
                center,
                format!("between {low} and {high}"),
                "grade towards a position inside the block",
            );
        }
        checks.budget(self.element_count());
        checks.into_problems()
    }

    /// Number of elements of the mesh.
    pub fn element_count(&self) -> u64 {
        self.elements.iter().fold(1, |product, count| product.saturating_mul(u64::from(*count)))
    }

    /// For each count, whether even numbers keep elements from extending across the middle of the body.
    pub fn counts_across(&self) -> Vec<bool> {
        vec![true; 3]
    }

    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        self.elements.iter_mut().collect()
    }

    /// Generates the mesh; nodes and elements are numbered fastest along x, then y, then z.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("block", self.problems())?;
        let cuts = std::array::from_fn(|axis| {
            let (low, high) = (self.min_m[axis], self.max_m[axis]);
            let (focus, grading) = match self.grading {
                None => (low, Grading::UNIFORM),
                Some(ratio) => (self.grading_center(axis), Grading::from_point(ratio[axis])),
            };
            graded(low, high, focus, grading, self.elements[axis])
        });
        Ok(of_cuts(&cuts, &self.part))
    }

    fn grading_center(&self, axis: usize) -> f64 {
        self.grading_center_m.map_or(0.5 * (self.min_m[axis] + self.max_m[axis]), |center| center[axis])
    }
}

/// A block of one part from the positions of its nodes along x, y and z [m], ascending with both ends.
pub(super) fn of_cuts([xs, ys, zs]: &[Vec<f64>; 3], part: &str) -> Mesh {
    let [nx, ny, nz] = [xs, ys, zs].map(|cuts| (cuts.len() - 1) as u32);
    let mut mesh = Mesh { parts: vec![part.into()], ..Mesh::default() };
    for &z in zs {
        for &y in ys {
            mesh.nodes.extend(xs.iter().map(|&x| Vec3::new(x, y, z)));
        }
    }
    let node = |i: u32, j: u32, k: u32| i + (nx + 1) * (j + (ny + 1) * k);
    for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
        let square = |k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
        let ([a, b, c, d], [e, f, g, h]) = (square(k), square(k + 1));
        mesh.cells.push(CellKind::Hex8, &[a, b, c, d, e, f, g, h]);
    }
    mesh.part_of = vec![0; mesh.cells.len()];

    // Each side consists of the nodes whose lattice coordinate along that axis is the first or the last.
    let all = || (0..=nz).flat_map(|k| (0..=ny).flat_map(move |j| (0..=nx).map(move |i| [i, j, k])));
    for (axis, (name, last)) in [("x", nx), ("y", ny), ("z", nz)].into_iter().enumerate() {
        for (end, at) in [("min", 0), ("max", last)] {
            let side = all().filter(|p| p[axis] == at).map(|[i, j, k]| node(i, j, k));
            mesh.node_sets.insert(format!("{name}_{end}"), node_set(side));
        }
    }
    mesh
}
