//! A block of layers, such as skin, fat, muscle and deeper tissue, one part each.

use super::block::{Block, Cuts};
use super::grading::{Grading, subdivided};
use super::parameters::{Checks, refuse};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Mesh, MeshError, ParameterProblem};

/// One layer of a [`LayeredBlock`].
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name of the part; layers with the same name form one part.
    pub part: String,
    /// Thickness along z [m].
    pub thickness_m: f64,
    /// Number of elements through the layer.
    pub elements: u32,
}

/// A block with layers along z, the first on top; one part per name, node sets as for a [`Block`].
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredBlock {
    /// Centre of the top surface [m].
    pub top_center: Vec3,
    /// Size along x and y [m].
    pub size_m: [f64; 2],
    /// Layers from the top down.
    pub layers: Vec<Layer>,
    /// Elements along x and y.
    pub elements: [u32; 2],
    /// Size ratio of the largest to the smallest element along x and y; the smallest are at the centre.
    pub grading: [f64; 2],
    /// Distance from the centre along x and y within which the elements are smallest [m].
    pub uniform_within_m: f64,
}

impl LayeredBlock {
    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("top_center", &self.top_center);
        for axis in 0..2 {
            checks.positive_length(&format!("size_m[{axis}]"), self.size_m[axis]);
            checks.count(&format!("elements[{axis}]"), self.elements[axis], 1);
            checks.grading(&format!("grading[{axis}]"), self.grading[axis]);
        }
        checks.distance("uniform_within_m", self.uniform_within_m);
        let count = self.layers.len();
        checks.require(
            count > 0,
            "layers",
            count as f64,
            "at least one layer",
            "give the layers from the top down",
        );
        for (i, layer) in self.layers.iter().enumerate() {
            checks.positive_length(&format!("layers[{i}].thickness_m"), layer.thickness_m);
            checks.count(&format!("layers[{i}].elements"), layer.elements, 1);
        }
        checks.budget(self.element_count());
        checks.into_problems()
    }

    /// Number of elements of the mesh.
    pub fn element_count(&self) -> u64 {
        let through =
            self.layers.iter().fold(0_u64, |sum, layer| sum.saturating_add(u64::from(layer.elements)));
        self.elements.iter().fold(through, |product, count| product.saturating_mul(u64::from(*count)))
    }

    /// The same block with all element counts multiplied by `factor`.
    #[must_use]
    pub fn refined(&self, factor: u32) -> Self {
        let layers = self.layers.iter();
        let finer =
            |layer: &Layer| Layer { elements: layer.elements.saturating_mul(factor), ..layer.clone() };
        let elements = self.elements.map(|count| count.saturating_mul(factor));
        Self { layers: layers.map(finer).collect(), elements, ..self.clone() }
    }

    /// Generates the mesh; nodes and elements are numbered fastest along x, then y, then z.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("layered_block", self.problems())?;
        // From the bottom up: end and part of each layer of elements.
        let (mut parts, mut part_of_row, mut cuts): (Vec<String>, Vec<u32>, Vec<f64>) = Default::default();
        let depth: f64 = self.layers.iter().map(|layer| layer.thickness_m).sum();
        let mut low = self.top_center.z - depth;
        let (bottom, top) = (low, self.top_center.z);
        parts.extend(self.layers.iter().map(|layer| layer.part.clone()));
        parts.sort_by_key(|name| self.layers.iter().position(|layer| layer.part == *name));
        parts.dedup();
        for layer in self.layers.iter().rev() {
            let part = parts.iter().position(|name| *name == layer.part).unwrap_or(0) as u32;
            let ends = subdivided(&[low, low + layer.thickness_m], layer.elements);
            cuts.extend(&ends[1..]);
            part_of_row.extend(std::iter::repeat_n(part, layer.elements as usize));
            low += layer.thickness_m;
        }
        // The last cut is the top.
        cuts.pop();
        let half = Vec3::new(0.5 * self.size_m[0], 0.5 * self.size_m[1], 0.0);
        let along = |axis: usize| Cuts::Towards {
            count: self.elements[axis],
            position_m: self.top_center[axis],
            grading: Grading { ratio: self.grading[axis], uniform_within: self.uniform_within_m },
        };
        let block = Block {
            min_corner_m: Vec3::new(self.top_center.x - half.x, self.top_center.y - half.y, bottom),
            max_corner_m: Vec3::new(self.top_center.x + half.x, self.top_center.y + half.y, top),
            cuts: [along(0), along(1), Cuts::Positions { inner_m: cuts }],
            part: String::new(),
        };
        let row = (self.elements[0] * self.elements[1]) as usize;
        let part_of = part_of_row.iter().flat_map(|part| std::iter::repeat_n(*part, row)).collect();
        Ok(Mesh { part_of, parts, ..block.generate()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate() -> LayeredBlock {
        let layer = |part: &str, thickness_m, elements| Layer { part: part.into(), thickness_m, elements };
        LayeredBlock {
            top_center: Vec3::new(0.1, -0.2, 0.05),
            size_m: [0.16, 0.12],
            layers: vec![
                layer("skin", 0.002, 1),
                layer("fat", 0.008, 2),
                layer("muscle", 0.01, 2),
                layer("fat", 0.004, 1),
            ],
            elements: [4, 3],
            grading: [3.0, 1.0],
            uniform_within_m: 0.0,
        }
    }

    #[test]
    fn layers_have_their_thickness_and_their_part() {
        let (block, mesh) = (plate(), plate().generate().unwrap());
        assert_eq!(mesh.parts, ["skin", "fat", "muscle"]);
        assert_eq!(mesh.cells.len() as u64, block.element_count());
        let [low, high] = mesh.bounding_box().unwrap();
        assert!(
            (high - Vec3::new(0.18, -0.14, 0.05)).norm() < 1e-15
                && (low - Vec3::new(0.02, -0.26, 0.026)).norm() < 1e-15
        );
        for (part, thickness) in [0.002, 0.012, 0.01].into_iter().enumerate() {
            let of_part = (0..mesh.cells.len()).filter(|e| mesh.part_of[*e] == part as u32);
            let volume: f64 = of_part.map(|e| mesh.element_volume_m3(e)).sum();
            assert!((volume / (0.16 * 0.12 * thickness) - 1.0).abs() < 1e-12, "{part}");
        }
        // The skin is on top.
        let top =
            mesh.node_sets["z_max"].iter().all(|node| (mesh.nodes[*node as usize].z - 0.05).abs() < 1e-15);
        let skin = (0..mesh.cells.len()).filter(|e| mesh.part_of[*e] == 0);
        assert!(
            top && skin.flat_map(|e| mesh.cells.nodes(e)).all(|a| mesh.nodes[*a as usize].z > 0.048 - 1e-12)
        );
    }

    #[test]
    fn refined_meshes_are_nested_and_nonsense_is_refused_with_its_places() {
        let fine = plate().refined(2).generate().unwrap();
        let nested = |x: &Vec3| fine.nodes.iter().any(|y| (x - y).norm() < 1e-12);
        assert!(plate().generate().unwrap().nodes.iter().all(nested));
        let mut bad = plate();
        bad.layers[1].thickness_m = 0.0;
        bad.layers[2].elements = 0;
        bad.size_m[1] = f64::NAN;
        let fields: Vec<String> = bad.problems().into_iter().map(|p| p.field).collect();
        assert_eq!(fields, ["size_m[1]", "layers[1].thickness_m", "layers[2].elements"]);
        let none = LayeredBlock { layers: Vec::new(), ..plate() };
        assert_eq!(none.problems()[0].field, "layers");
    }
}
