//! Meshes: reading, writing, generation, boundary surface, quality, refinement.
//!
//! A [`Mesh`] is plain data in metres: nodes, and [`Cells`] of the kinds in `cell`. `generate` makes one from a few numbers, `read` reads one from a file; `surface`
//! extracts its boundary surface; `quality` checks its elements; `refine` splits it; `distance` says how deep a point lies below its surface,
//! and `triangulated_surface` with `walk` where a ray meets it and where one gets to over it.

pub mod cell;
pub mod cells;
pub mod cracks;
pub(crate) mod defaults;
pub mod distance;
pub mod element_fields;
pub mod error;
pub mod generate;
pub mod hanging;
pub mod inspect;
pub mod laplace;
pub mod local_refinement;
pub mod locate;
pub mod mirror;
pub mod names;
pub mod quality;
pub mod read;
pub mod refine;
pub mod refinement_estimate;
pub mod refinement_region;
pub mod report;
pub mod section;
pub mod segmentation;
pub mod split;
pub mod surface;
pub mod triangulated_surface;
pub mod walk;
pub mod write;

pub use cell::CellKind;
pub use cells::{Cell, Cells};
pub use element_fields::{ElementField, ElementFields};
pub use error::{MeshError, ParameterProblem, Place};
pub use hanging::HangingNodes;

use crate::mechanics::tensor::Vec3;
use nalgebra::Rotation3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Elements that are looked at as one task: smaller meshes need no other thread.
pub(crate) const ELEMENTS_OF_A_TASK: usize = 1024;

/// A mesh of cells in named parts, with named node sets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions X [m], one per node.
    pub nodes: Vec<Vec3>,
    /// Elements: kind and nodes of each.
    pub cells: Cells,
    /// Part of each element, as an index into `parts`.
    pub part_of: Vec<u32>,
    /// Names of the parts ("muscle", "rubber", …).
    pub parts: Vec<String>,
    /// Node sets by name ("bone_surface", "bottom", …), each sorted and unique.
    pub node_sets: BTreeMap<String, Vec<u32>>,
    /// Material axes of each element, rows e1, e2, e3 (orthonormal, right-handed, in the reference frame); empty if the
    /// mesh has none (the axes are then x, y, z, or given by the scene).
    pub axes: Vec<[Vec3; 3]>,
    /// Further numbers of each element that were requested.
    pub fields: ElementFields,
    /// Hanging nodes between coarse and fine elements.
    pub hanging: HangingNodes,
    /// Remarks on the mesh, for reports ("faceted ball: 1.7 % below the exact volume").
    pub notes: Vec<String>,
}

impl Mesh {
    /// Volume of the mesh [m³], summed over the interpolated elements.
    pub fn volume_m3(&self) -> f64 {
        self.element_volumes_m3().iter().sum()
    }

    /// Volume of one element [m³]; negative when it is inverted.
    ///
    /// # Panics
    /// If the element does not exist.
    pub fn element_volume_m3(&self, element: usize) -> f64 {
        let cell = self.cells.get(element);
        cell.kind.volume_m3(&cell.points(&self.nodes))
    }

    /// Volume of every element [m³], on all threads.
    pub fn element_volumes_m3(&self) -> Vec<f64> {
        let elements = (0..self.cells.len()).into_par_iter().with_min_len(ELEMENTS_OF_A_TASK);
        elements.map(|element| self.element_volume_m3(element)).collect()
    }

    /// Volume of one part [m³]; zero when the mesh has no such part.
    pub fn part_volume_m3(&self, name: &str) -> f64 {
        let Some(part) = self.parts.iter().position(|p| p == name) else { return 0.0 };
        let elements = (0..self.cells.len()).into_par_iter().with_min_len(ELEMENTS_OF_A_TASK);
        let of_part = elements.filter(|&e| self.part_of[e] as usize == part);
        // In the order of the elements, whatever the threads.
        let volumes: Vec<f64> = of_part.map(|element| self.element_volume_m3(element)).collect();
        volumes.iter().sum()
    }

    /// Bounding box of all nodes: lower and upper corner [m]. `None` without nodes.
    pub fn bounding_box(&self) -> Option<[Vec3; 2]> {
        let first = *self.nodes.first()?;
        Some(self.nodes.iter().fold([first, first], |[low, high], x| [low.inf(x), high.sup(x)]))
    }

    /// The elements of the named parts, with the nodes that they use; node sets are restricted to these nodes, and empty
    /// sets removed. Nodes and elements keep their order; parts are in the order of `names`.
    ///
    /// # Errors
    /// `UnknownPart` if the mesh has no part of that name.
    pub fn select_parts(&self, names: &[&str]) -> Result<Mesh, MeshError> {
        let mut kept_parts: Vec<String> = Vec::new();
        let mut new_part: Vec<Option<u32>> = vec![None; self.parts.len()];
        for name in names {
            let index = self.parts.iter().position(|p| p == name).ok_or_else(|| MeshError::UnknownPart {
                name: (*name).to_owned(),
                known: self.parts.clone(),
            })?;
            if new_part[index].is_none() {
                new_part[index] = Some(kept_parts.len() as u32);
                kept_parts.push((*name).to_owned());
            }
        }
        let mut out = Mesh {
            nodes: self.nodes.clone(),
            parts: kept_parts,
            node_sets: self.node_sets.clone(),
            hanging: self.hanging.clone(),
            notes: self.notes.clone(),
            ..Mesh::default()
        };
        let is_kept = |e: &usize| new_part[self.part_of[*e] as usize].is_some();
        out.fields = self.fields.of_elements(&(0..self.cells.len()).filter(is_kept));
        for (e, cell) in self.cells.iter().enumerate() {
            if let Some(part) = new_part[self.part_of[e] as usize] {
                out.cells.push(cell.kind, cell.nodes);
                out.part_of.push(part);
                out.axes.extend(self.axes.get(e));
            }
        }
        out.drop_unused_nodes();
        Ok(out)
    }

    /// Removes nodes without elements (they have no mass) and returns their number. The others keep their order; node sets
    /// are updated, and empty sets removed.
    pub fn drop_unused_nodes(&mut self) -> usize {
        let mut used = vec![false; self.nodes.len()];
        self.cells.connectivity().iter().for_each(|&a| used[a as usize] = true);

        let mut new_index = vec![u32::MAX; self.nodes.len()];
        let mut kept = Vec::with_capacity(self.nodes.len());
        for (a, x) in self.nodes.iter().enumerate() {
            if used[a] {
                new_index[a] = kept.len() as u32;
                kept.push(*x);
            }
        }
        let dropped = self.nodes.len() - kept.len();
        if dropped == 0 {
            return 0;
        }
        self.nodes = kept;
        self.cells = self.cells.map(|a| new_index[a as usize]);
        for set in self.node_sets.values_mut() {
            set.retain(|&a| used[a as usize]);
            for a in set {
                *a = new_index[*a as usize];
            }
        }
        self.node_sets.retain(|_, set| !set.is_empty());
        self.hanging.renumber(|node| used[node as usize].then(|| new_index[node as usize]));
        dropped
    }

    /// The mesh scaled, rotated about the origin and translated: x' = R (s x) + t.
    ///
    /// `scale` [-] converts the unit of a file to metres (0.001 for millimetres); `translation` [m]. Material axes and vectors of
    /// the elements rotate with the mesh.
    ///
    /// # Errors
    /// `Transform` if the scale is not positive or a number is not finite: elements would be inverted.
    pub fn transformed(
        &self,
        rotation: &Rotation3<f64>,
        translation: &Vec3,
        scale: f64,
    ) -> Result<Mesh, MeshError> {
        let finite = rotation.matrix().iter().chain(translation.iter()).all(|x| x.is_finite());
        if !(scale > 0.0 && scale.is_finite() && finite) {
            return Err(MeshError::Transform { scale });
        }
        let mut out = self.clone();
        out.nodes.iter_mut().for_each(|x| *x = rotation * (*x * scale) + translation);
        out.axes.iter_mut().flatten().for_each(|e| *e = rotation * *e);
        out.fields.rotate(rotation);
        Ok(out)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::generate::block::Block;
    use super::*;

    /// Two stacked unit cubes, parts "low" and "high".
    fn two_cubes() -> Mesh {
        let mut mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(1.0, 1.0, 2.0), [1, 1, 2], "low").generate().unwrap();
        mesh.parts.push("high".into());
        mesh.part_of = vec![0, 1];
        mesh.axes = vec![[Vec3::x(), Vec3::y(), Vec3::z()], [Vec3::y(), Vec3::z(), Vec3::x()]];
        mesh
    }

    #[test]
    fn selected_part_keeps_only_its_nodes_sets_and_axes() {
        let high = two_cubes().select_parts(&["high"]).unwrap();
        assert_eq!((high.nodes.len(), high.cells.len()), (8, 1));
        assert_eq!(high.parts, ["high"]);
        assert_eq!(high.part_of, [0]);
        assert_eq!(high.axes, [[Vec3::y(), Vec3::z(), Vec3::x()]]);
        assert!(!high.node_sets.contains_key("z_min"), "a set without nodes goes");
        assert_eq!(high.node_sets["z_max"], [4, 5, 6, 7]);
        assert_eq!(high.node_sets["x_min"].len(), 4);
        assert_eq!(high.bounding_box().unwrap()[0], Vec3::new(0.0, 0.0, 1.0));
    }

    #[test]
    fn unknown_part_is_an_error_that_names_the_known_ones() {
        let error = two_cubes().select_parts(&["ball"]).unwrap_err();
        assert!(error.to_string().contains("low, high"), "{error}");
    }

    #[test]
    fn transformed_mesh_is_scaled_turned_and_moved() {
        let quarter_turn = Rotation3::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
        let mesh = two_cubes().transformed(&quarter_turn, &Vec3::new(0.0, 0.0, 5.0), 0.5).unwrap();
        assert!((mesh.volume_m3() - 2.0 / 8.0).abs() < 1e-14);
        let [low, high] = mesh.bounding_box().unwrap();
        assert!((low - Vec3::new(-0.5, 0.0, 5.0)).norm() < 1e-14);
        assert!((high - Vec3::new(0.0, 0.5, 6.0)).norm() < 1e-14);
        assert!((mesh.axes[0][0] - Vec3::y()).norm() < 1e-14);
        assert!(two_cubes().transformed(&quarter_turn, &Vec3::zeros(), -1.0).is_err());
    }
}
