//! A block of layers, such as skin, fat, muscle and deeper tissue, one part each.

use super::block::of_cuts;
use super::grading::{Grading, graded, subdivided};
use super::parameters::{Checks, refuse};
use crate::mesh::defaults::{is_one, is_zero_length};
use crate::mesh::{Mesh, MeshError, ParameterProblem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Least thickness of an element, relative to the largest coordinate: positions are rounded.
const LEAST_THICKNESS: f64 = 1e-12;

/// A layer of a layered block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "LayerDocument")]
pub struct Layer {
    /// Name of its part; layers with the same name form one part.
    pub part: String,
    /// Thickness along z [m].
    pub thickness_m: f64,
    /// Layers of elements through the thickness.
    pub elements: u32,
}

/// A block with layers along z, the first on top; one part per name, node sets as for a [`Block`](super::block::Block).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayeredBlock {
    /// Centre of the top surface [m].
    #[serde(default)]
    pub top_center_m: [f64; 3],
    /// Size along x and y [m].
    pub size_m: [f64; 2],
    /// Layers from the top (`z_max`) down.
    pub layers: Vec<Layer>,
    /// Elements along x and y.
    pub elements: [u32; 2],
    /// Size ratio of the largest to the smallest element along x and y; the smallest are at the centre.
    #[serde(default = "uniform", skip_serializing_if = "is_uniform")]
    pub grading: [f64; 2],
    /// Distance from the centre along x and y within which the elements are uniform and smallest [m].
    #[serde(default, skip_serializing_if = "is_zero_length")]
    pub uniform_within_m: f64,
}

fn uniform() -> [f64; 2] {
    [1.0; 2]
}

fn is_uniform(grading: &[f64; 2]) -> bool {
    grading.iter().all(is_one)
}

impl LayeredBlock {
    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("top_center_m", &self.top_center_m);
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
        let depth: f64 = self.layers.iter().map(|layer| layer.thickness_m).sum();
        let least = LEAST_THICKNESS * (self.top_center_m[2].abs() + depth);
        for (i, layer) in self.layers.iter().enumerate() {
            let field = format!("layers[{i}].thickness_m");
            checks.positive_length(&field, layer.thickness_m);
            checks.count(&format!("layers[{i}].elements"), layer.elements, 1);
            let is_thin = layer.thickness_m > 0.0 && layer.thickness_m < least * f64::from(layer.elements);
            checks.require(
                !is_thin,
                &field,
                layer.thickness_m,
                "enough that its nodes differ in position",
                "give a thickness in metres, or place the block nearer to the origin",
            );
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

    /// For each count, whether even numbers keep elements from extending across the middle of the body.
    pub fn counts_across(&self) -> Vec<bool> {
        self.elements.iter().map(|_| true).chain(self.layers.iter().map(|_| false)).collect()
    }

    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        let through = self.layers.iter_mut().map(|layer| &mut layer.elements);
        self.elements.iter_mut().chain(through).collect()
    }

    /// Generates the mesh; nodes and elements are numbered fastest along x, then y, then z.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("layered_block", self.problems())?;
        // From the bottom up: positions of the nodes along z, and the part of each layer of elements.
        let (mut parts, mut part_of_row): (Vec<String>, Vec<u32>) = Default::default();
        let [x, y, top] = self.top_center_m;
        let mut low = top - self.layers.iter().map(|layer| layer.thickness_m).sum::<f64>();
        let mut zs = vec![low];
        parts.extend(self.layers.iter().map(|layer| layer.part.clone()));
        parts.sort_by_key(|name| self.layers.iter().position(|layer| layer.part == *name));
        parts.dedup();
        for layer in self.layers.iter().rev() {
            let part = parts.iter().position(|name| *name == layer.part).unwrap_or(0) as u32;
            let ends = subdivided(&[low, low + layer.thickness_m], layer.elements);
            zs.extend(&ends[1..]);
            part_of_row.extend(std::iter::repeat_n(part, layer.elements as usize));
            low += layer.thickness_m;
        }
        // The sum of the thicknesses is rounded.
        zs.pop();
        zs.push(top);
        let across = |axis: usize, center: f64| {
            let half = 0.5 * self.size_m[axis];
            let grading = Grading { ratio: self.grading[axis], uniform_within: self.uniform_within_m };
            graded(center - half, center + half, center, grading, self.elements[axis])
        };
        let block = of_cuts(&[across(0, x), across(1, y), zs], "");
        let row = (self.elements[0] * self.elements[1]) as usize;
        let part_of = part_of_row.iter().flat_map(|part| std::iter::repeat_n(*part, row)).collect();
        Ok(Mesh { part_of, parts, ..block })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Generator;
    use super::*;
    use crate::mechanics::tensor::Vec3;

    fn plate() -> LayeredBlock {
        let layer = |part: &str, thickness_m, elements| Layer { part: part.into(), thickness_m, elements };
        LayeredBlock {
            top_center_m: [0.1, -0.2, 0.05],
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
        let fine = Generator::LayeredBlock(plate()).refined(2).generate().unwrap();
        let nested = |x: &Vec3| fine.nodes.iter().any(|y| (x - y).norm() < 1e-12);
        assert!(plate().generate().unwrap().nodes.iter().all(nested));
        let mut bad = plate();
        bad.layers[1].thickness_m = 0.0;
        bad.layers[2].elements = 0;
        bad.size_m[1] = f64::NAN;
        let fields: Vec<String> = bad.problems().into_iter().map(|p| p.field).collect();
        assert_eq!(fields, ["size_m[1]", "layers[1].thickness_m", "layers[2].elements"]);
        // Its nodes would be at one position.
        let mut far = plate();
        (far.top_center_m[2], far.layers[1].thickness_m) = (1.0, 1e-20);
        assert_eq!(far.problems()[0].field, "layers[1].thickness_m");
        let none = LayeredBlock { layers: Vec::new(), ..plate() };
        assert_eq!(none.problems()[0].field, "layers");
    }
}
