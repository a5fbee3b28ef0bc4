//! Report on a mesh file: contents, size, and the quality of its elements.

use super::Mesh;
use super::quality::{Quality, quality};
use super::read::stl::ClosedSurface;
use super::segmentation::{LabelCount, LabelVolume, ScanInspection};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Contents and quality of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct MeshReport {
    /// Number of nodes in the file.
    pub nodes: u64,
    /// Number of elements in the file.
    pub elements: u64,
    /// Number of elements of each part.
    pub parts: BTreeMap<String, u64>,
    /// Number of nodes of each node set.
    pub node_sets: BTreeMap<String, u64>,
    /// Lower corner of the bounding box, in the unit of the file.
    pub bounding_box_min: [f64; 3],
    /// Upper corner of the bounding box.
    pub bounding_box_max: [f64; 3],
    /// Quality of the elements; absent for a scan and for a surface, which have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<MeshQualityReport>,
    /// Notes of the reader.
    pub notes: Vec<String>,
}

/// Quality of the elements of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct MeshQualityReport {
    /// Smallest scaled Jacobian at corners and quadrature points [-], 1 for bricks; not positive: the mesh cannot run.
    pub min_scaled_jacobian: f64,
    /// Element with that Jacobian.
    pub worst_element: u32,
    /// Number of elements with a non-positive Jacobian at a quadrature point.
    pub negative_elements: u64,
    /// The first of these elements.
    pub first_negative_elements: Vec<u32>,
    /// Number of elements that are valid inside but folded at a corner: they can run, with poor accuracy.
    pub folded_elements: u64,
    /// Largest ratio of longest to shortest edge in one element [-]; null if an edge has zero length.
    pub max_aspect_ratio: Option<f64>,
    /// Number of nodes at exactly the position of an earlier one.
    pub coincident_nodes: u64,
    /// Shortest edge, in the unit of the file.
    pub min_edge: f64,
    /// Longest edge, in the unit of the file.
    pub max_edge: f64,
    /// Volume, in the cube of that unit.
    pub volume: f64,
}

impl MeshReport {
    /// Report on a mesh; `None` without elements.
    pub fn of(mesh: &Mesh) -> Option<Self> {
        let quality = quality(mesh)?;
        let mut elements_of_part = vec![0_u64; mesh.parts.len()];
        mesh.part_of.iter().for_each(|&part| elements_of_part[part as usize] += 1);
        let [low, high] = quality.bounding_box_m;
        Some(Self {
            nodes: mesh.nodes.len() as u64,
            elements: mesh.cells.len() as u64,
            parts: mesh.parts.iter().cloned().zip(elements_of_part).collect(),
            node_sets: mesh.node_sets.iter().map(|(name, set)| (name.clone(), set.len() as u64)).collect(),
            bounding_box_min: low.into(),
            bounding_box_max: high.into(),
            quality: Some(quality.into()),
            notes: mesh.notes.clone(),
        })
    }

    /// Report on a scan: voxels count as elements, those of label n as a part `label_<n>`.
    pub fn of_scan(volume: &LabelVolume) -> Self {
        let found = ScanInspection::of(volume);
        let [low, high] = found.bounding_box_m;
        let labelled = || found.labels.iter().filter(|label| label.label != 0);
        let name =
            |label: &LabelCount| label.name.as_ref().map_or(String::new(), |name| format!(" ({name})"));
        let volumes = labelled()
            .map(|label| format!("label {}{}: {:.4e} m³", label.label, name(label), label.volume_m3));
        Self {
            nodes: found.voxels.iter().map(|n| *n as u64 + 1).product(),
            elements: labelled().map(|label| label.voxels).sum(),
            parts: labelled().map(|label| (format!("label_{}", label.label), label.voxels)).collect(),
            node_sets: BTreeMap::new(),
            bounding_box_min: low,
            bounding_box_max: high,
            quality: None,
            notes: found.notes.iter().cloned().chain(volumes).collect(),
        }
    }

    /// Report on a closed surface: triangles count as elements.
    pub fn of_surface(surface: &ClosedSurface) -> Self {
        let [low, high] = surface.bounding_box();
        let volume = format!("it encloses {:.4e}, in the cube of the unit of the file", surface.volume());
        Self {
            nodes: surface.points.len() as u64,
            elements: surface.triangles.len() as u64,
            parts: BTreeMap::new(),
            node_sets: BTreeMap::new(),
            bounding_box_min: low.into(),
            bounding_box_max: high.into(),
            quality: None,
            notes: vec![
                "a closed surface of triangles, for a rigid body or the outside of a tissue".into(),
                volume,
            ],
        }
    }
}

impl From<Quality> for MeshQualityReport {
    fn from(quality: Quality) -> Self {
        Self {
            min_scaled_jacobian: quality.min_scaled_jacobian,
            worst_element: quality.worst_element,
            negative_elements: quality.negative.count as u64,
            first_negative_elements: quality.negative.first,
            folded_elements: quality.folded_corners.count as u64,
            max_aspect_ratio: finite(quality.max_aspect_ratio),
            coincident_nodes: quality.coincident_nodes.count as u64,
            min_edge: quality.min_edge_m,
            max_edge: quality.max_edge_m,
            volume: quality.volume_m3,
        }
    }
}

/// A ratio of edges; `None` where an edge has no length.
pub(super) fn finite(ratio: f64) -> Option<f64> {
    ratio.is_finite().then_some(ratio)
}
