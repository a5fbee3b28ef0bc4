//! The bodies of a scene.

use crate::mechanics::rigid::{Pose, Shape};
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::Mesh;
use crate::mesh::surface::boundary;

/// Properties of a rigid body derived from its document.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidSceneBody {
    /// Geometry, in principal axes.
    pub shape: Shape,
    /// Mass of the body [kg].
    pub mass: f64,
    /// Principal moments of inertia [kg m²].
    pub inertia: Vec3,
    /// Initial position and orientation.
    pub pose: Pose,
    /// Axes along which it cannot move, and about which it cannot rotate.
    pub held: [[bool; 3]; 2],
}

/// A body of a validated scene.
#[derive(Clone, Debug, Default)]
pub struct SceneBody {
    /// Its properties, if it is rigid.
    pub rigid: Option<RigidSceneBody>,
    /// Mesh in place; empty for a rigid body.
    pub mesh: Mesh,
    /// Number of elements before local refinement, and how many of them were split.
    pub refined: Option<[usize; 2]>,
    /// Law of each entry of the body's `parts`, then the laws of elements whose stiffness differs from that.
    pub materials: Vec<crate::mechanics::material::Material>,
    /// For every element, the index of its law in `materials`.
    pub law_of: Vec<u32>,
    /// For every element, the index of its entry in the body's `parts`.
    pub part_entry: Vec<u32>,
    /// Material axes of every element (columns e1, e2, e3 in reference axes, oblique where arrays give two families); empty when no law of
    /// the body has fibres.
    pub axes: Vec<Mat3>,
    /// Nodes on planes of symmetry normal to x, y and z, sorted, if the body is the part on their upper sides.
    pub mirrored: [Vec<u32>; 3],
}

impl SceneBody {
    /// Faces of the boundary surface; those in planes of symmetry are inside the body that its mirror images complete.
    pub fn boundary(&self) -> Vec<[u32; 4]> {
        let is_cut = |face: &[u32; 4]| {
            let has = |on: &Vec<u32>| face.iter().all(|node| on.binary_search(node).is_ok());
            self.mirrored.iter().any(has)
        };
        let mut faces = self.mesh.hanging.boundary(boundary(&self.mesh.cells));
        faces.retain(|face| !is_cut(face));
        faces
    }
}
