//! Counts, mass and mesh quality of a body, for users and for the service.

use super::document::BodyDocument;
use super::scene_body::RigidSceneBody;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::mesh::quality::Quality;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

// The docs of these types are part of the service's contract. A rigid body has no mesh: volume and mass are those of its shape.

/// A body of a scene, with its mesh in place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = BodyPreview))]
pub struct BodySummary {
    /// Name of the body.
    pub name: String,
    /// Number of nodes of the body.
    #[cfg_attr(feature = "service", schema(value_type = u64))]
    pub nodes: usize,
    /// Number of elements of the body.
    #[cfg_attr(feature = "service", schema(value_type = u64))]
    pub elements: usize,
    /// Volume of the mesh [m³].
    pub volume_m3: f64,
    /// Mass of the mesh [kg].
    pub mass_kg: f64,
    /// Lower and upper corner of the bounding box [m].
    pub bounding_box_m: [[f64; 3]; 2],
    /// Quality of its elements; absent for a rigid body, which has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<BodyQuality>,
    /// Parts of the body.
    pub parts: Vec<PartSummary>,
    /// Remarks of the mesh reader or generator.
    pub notes: Vec<String>,
}

/// Quality of the elements of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct BodyQuality {
    /// Smallest scaled Jacobian over all corners and quadrature points, 1 for a brick [-].
    pub min_scaled_jacobian: f64,
    /// Index of the element with that Jacobian.
    pub worst_element: u32,
    /// Largest ratio of longest to shortest edge of an element [-]; null where an edge has no length.
    #[cfg_attr(feature = "service", schema(value_type = Option<f64>))]
    pub max_aspect_ratio: f64,
    /// Length of the shortest edge [m].
    pub min_edge_m: f64,
}

/// A part of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = PartPreview))]
pub struct PartSummary {
    /// Name of the part.
    pub name: String,
    /// Number of elements of the part.
    #[cfg_attr(feature = "service", schema(value_type = u64))]
    pub elements: usize,
    /// Mass of the part [kg].
    pub mass_kg: f64,
}

impl BodySummary {
    /// Summary of a rigid body, with the bounding box of its initial position.
    pub fn rigid(body: &BodyDocument, rigid: &RigidSceneBody) -> Self {
        let centre = rigid.pose.centre;
        let axes = rigid.pose.orientation.to_rotation_matrix().into_inner();
        let half = rigid.shape.half_extent(&axes);
        Self {
            name: body.name.clone(),
            nodes: 0,
            elements: 0,
            volume_m3: rigid.shape.volume(),
            mass_kg: rigid.mass,
            bounding_box_m: [(centre - half).into(), (centre + half).into()],
            quality: None,
            parts: Vec::new(),
            notes: vec![format!("a rigid {}, without a mesh", rigid.shape.name())],
        }
    }

    /// Summary of a deformable body.
    pub fn new(body: &BodyDocument, mesh: &Mesh, part_entry: &[u32], quality: &Quality) -> Self {
        let empty = |name: &String| PartSummary { name: name.clone(), elements: 0, mass_kg: 0.0 };
        let mut parts: Vec<PartSummary> = mesh.parts.iter().map(empty).collect();
        let volumes = mesh.element_volumes_m3();
        for (element, &entry) in part_entry.iter().enumerate() {
            let part = &mut parts[mesh.part_of[element] as usize];
            part.elements += 1;
            part.mass_kg += body.parts[entry as usize].density_kg_per_m3 * volumes[element];
        }
        let corner = |x: &Vec3| [x.x, x.y, x.z];
        Self {
            name: body.name.clone(),
            nodes: mesh.nodes.len(),
            elements: mesh.cells.len(),
            volume_m3: quality.volume_m3,
            mass_kg: parts.iter().map(|p| p.mass_kg).sum(),
            bounding_box_m: [corner(&quality.bounding_box_m[0]), corner(&quality.bounding_box_m[1])],
            quality: Some(BodyQuality {
                min_scaled_jacobian: quality.min_scaled_jacobian,
                worst_element: quality.worst_element,
                max_aspect_ratio: quality.max_aspect_ratio,
                min_edge_m: quality.min_edge_m,
            }),
            parts,
            notes: mesh.notes.clone(),
        }
    }
}
