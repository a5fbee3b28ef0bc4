//! A rectangular block of hexahedra, with uniform or graded cuts along each axis.

use super::grading::{Grading, graded, subdivided};
use super::node_set;
use super::parameters::{Checks, refuse};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{CellKind, Mesh, MeshError, ParameterProblem};

/// Division of a block into elements along one axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Cuts {
    /// Elements of equal size.
    Uniform {
        /// Elements along the axis.
        count: u32,
    },
    /// Elements smallest at a position, growing on both sides.
    Towards {
        /// Elements along the axis.
        count: u32,
        /// Position of the smallest elements [m], inside the block.
        position_m: f64,
        /// Growth of the element size.
        grading: Grading,
    },
    /// Element boundaries at these positions [m], ascending, strictly inside the block.
    Positions {
        /// The positions [m]; k cuts make k + 1 elements.
        inner_m: Vec<f64>,
    },
}

impl Cuts {
    /// Number of elements along the axis.
    pub fn count(&self) -> u64 {
        match self {
            Self::Uniform { count } | Self::Towards { count, .. } => u64::from(*count),
            Self::Positions { inner_m } => inner_m.len() as u64 + 1,
        }
    }

    /// Positions of all nodes along the axis [m], including both ends.
    fn positions(&self, low: f64, high: f64) -> Vec<f64> {
        match self {
            Self::Uniform { count } => graded(low, high, low, Grading::UNIFORM, *count),
            Self::Towards { count, position_m, grading } => graded(low, high, *position_m, *grading, *count),
            Self::Positions { inner_m } => {
                std::iter::once(low).chain(inner_m.iter().copied()).chain(std::iter::once(high)).collect()
            }
        }
    }

    /// Checks the division of the axis named `field` between its ends.
    fn check(&self, checks: &mut Checks, field: &str, low: f64, high: f64) {
        match self {
            Self::Uniform { count } => checks.count(&format!("{field}.count"), *count, 1),
            Self::Towards { count, position_m, grading } => {
                checks.count(&format!("{field}.count"), *count, 1);
                checks.grading(&format!("{field}.ratio"), grading.ratio);
                checks.require(
                    (low..=high).contains(position_m),
                    format!("{field}.position_m"),
                    *position_m,
                    format!("between {low} and {high}"),
                    "grade towards a position inside the block",
                );
            }
            Self::Positions { inner_m } => {
                let mut before = low;
                for (i, &cut) in inner_m.iter().enumerate() {
                    checks.require(
                        cut > before && cut < high,
                        format!("{field}.inner_m[{i}]"),
                        cut,
                        format!("> {before} and < {high}"),
                        "give ascending cuts inside the block, without its ends",
                    );
                    before = before.max(cut);
                }
            }
        }
    }
}

/// A block of one part along the coordinate axes, node sets `x_min`, `x_max`, `y_min`, `y_max`, `z_min` and `z_max`.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Corner with the least coordinates [m].
    pub min_corner_m: Vec3,
    /// Corner with the greatest coordinates [m].
    pub max_corner_m: Vec3,
    /// Division along x, y and z.
    pub cuts: [Cuts; 3],
    /// Name of the only part.
    pub part: String,
}

impl Block {
    /// A block of equal elements, from its lower corner and its size [m].
    pub fn uniform(origin: Vec3, size: Vec3, counts: [u32; 3], part: &str) -> Self {
        Self {
            min_corner_m: origin,
            max_corner_m: origin + size,
            cuts: counts.map(|count| Cuts::Uniform { count }),
            part: part.into(),
        }
    }

    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("min_corner_m", &self.min_corner_m);
        checks.finite("max_corner_m", &self.max_corner_m);
        for (axis, name) in ["cuts_x", "cuts_y", "cuts_z"].into_iter().enumerate() {
            let (low, high) = (self.min_corner_m[axis], self.max_corner_m[axis]);
            checks.require(
                low < high,
                format!("max_corner_m[{axis}]"),
                high,
                format!("> min_corner_m[{axis}] = {low}"),
                "give the block a size along each axis",
            );
            self.cuts[axis].check(&mut checks, name, low, high);
        }
        checks.budget(self.element_count());
        checks.into_problems()
    }

    /// Number of elements of the mesh.
    pub fn element_count(&self) -> u64 {
        self.cuts.iter().fold(1, |product, cuts| product.saturating_mul(cuts.count()))
    }

    /// The same block with all element counts multiplied by `factor`; listed positions are kept and the elements between
    /// them divided evenly.
    #[must_use]
    pub fn refined(&self, factor: u32) -> Self {
        let cuts = std::array::from_fn(|axis| match &self.cuts[axis] {
            Cuts::Uniform { count } => Cuts::Uniform { count: count.saturating_mul(factor) },
            Cuts::Towards { count, position_m, grading } => Cuts::Towards {
                count: count.saturating_mul(factor),
                position_m: *position_m,
                grading: *grading,
            },
            listed @ Cuts::Positions { .. } => {
                let all = listed.positions(self.min_corner_m[axis], self.max_corner_m[axis]);
                let fine = subdivided(&all, factor);
                Cuts::Positions { inner_m: fine[1..fine.len() - 1].to_vec() }
            }
        });
        Self { cuts, ..self.clone() }
    }

    /// Generates the mesh; nodes and elements are numbered fastest along x, then y, then z.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("block", self.problems())?;
        let [xs, ys, zs]: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            self.cuts[axis].positions(self.min_corner_m[axis], self.max_corner_m[axis])
        });
        let [nx, ny, nz] = [&xs, &ys, &zs].map(|cuts| (cuts.len() - 1) as u32);
        let mut mesh = Mesh { parts: vec![self.part.clone()], ..Mesh::default() };
        for &z in &zs {
            for &y in &ys {
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
        Ok(mesh)
    }
}
