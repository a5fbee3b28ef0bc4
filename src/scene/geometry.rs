//! The bodies of a scene as they are when it begins, to be drawn before anything runs.

use super::checked_scene::Scene;
use super::scene_body::{RigidSceneBody, SceneBody};
use crate::mechanics::rigid::triangulated;
use crate::mechanics::tensor::Vec3;
use serde::{Deserialize, Serialize};

// The docs of these types are part of the service's contract.

/// A body where it begins: elements, or the surface of a rigid body. Lists are flat: three numbers a node, and so on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct BodyGeometry {
    /// Name of the body.
    pub body: String,
    /// Positions of the nodes, x, y, z of each, in single precision [m].
    pub positions_m: Vec<f32>,
    /// VTK type of each element; none for a rigid body.
    pub cell_types: Vec<u8>,
    /// Nodes of the elements, one element after the other, in the order of VTK.
    pub cell_nodes: Vec<u32>,
    /// Names of the parts.
    pub parts: Vec<String>,
    /// Part of each element, as an index into `parts`.
    pub part_of: Vec<u32>,
    /// Corners of the triangles of a rigid body; none for others.
    pub triangles: Vec<u32>,
}

impl Scene {
    /// All bodies; `None` if they have more than `most_elements`.
    pub fn geometry(&self, most_elements: usize) -> Option<Vec<BodyGeometry>> {
        let of = |(document, body): (&super::document::BodyDocument, &SceneBody)| match &body.rigid {
            Some(rigid) => of_rigid(&document.name, rigid),
            None => of_mesh(&document.name, body),
        };
        let is_small = self.element_count() <= most_elements;
        is_small.then(|| self.document.bodies.iter().zip(&self.bodies).map(of).collect())
    }
}

fn of_mesh(name: &str, SceneBody { mesh, .. }: &SceneBody) -> BodyGeometry {
    let (cell_types, cell_nodes) = mesh.cells.in_vtk();
    BodyGeometry {
        body: name.to_owned(),
        positions_m: coordinates(&mesh.nodes),
        cell_types,
        cell_nodes,
        parts: mesh.parts.clone(),
        part_of: mesh.part_of.clone(),
        triangles: Vec::new(),
    }
}

fn of_rigid(name: &str, RigidSceneBody { shape, pose, .. }: &RigidSceneBody) -> BodyGeometry {
    let (corners, triangles) = triangulated(shape);
    let placed: Vec<Vec3> = corners.iter().map(|x| pose.centre + pose.orientation * x).collect();
    BodyGeometry {
        body: name.to_owned(),
        positions_m: coordinates(&placed),
        triangles: triangles.concat(),
        ..BodyGeometry::default()
    }
}

fn coordinates(points: &[Vec3]) -> Vec<f32> {
    points.iter().flat_map(|x| [x.x, x.y, x.z].map(|c| c as f32)).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use crate::scene::{Budget, NoFiles, load};
    use serde_json::json;

    #[test]
    fn bodies_are_drawn_where_they_begin() {
        let scene = json!({
            "name": "a", "end_time_s": 1e-3,
            "bodies": [
                {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -1],
                 "rigid": {"shape": {"kind": "ball", "radius_m": 0.02}, "center_m": [0.5, 0, 0.08], "mass_kg": 0.1}},
                {"name": "gel", "role": "tissue",
                 "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [1, 1, 0.05], "elements": [2, 1, 1]}},
                 "parts": [{"part": "block", "density_kg_per_m3": 1000,
                            "material": {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 5e7}}]}
            ]
        });
        let loaded = load(scene.to_string().as_bytes(), &NoFiles, &Budget::COMMAND_LINE).unwrap();
        assert_eq!(loaded.scene.geometry(1), None);
        let [ball, gel] = &loaded.scene.geometry(2).unwrap()[..] else { panic!() };
        let [x, y, z] = [0, 1, 2].map(|k| {
            let along = ball.positions_m.iter().skip(k).step_by(3);
            along.fold([f32::MAX, f32::MIN], |[low, high], &c| [low.min(c), high.max(c)])
        });
        assert!((x[0] + x[1] - 1.0).abs() < 1e-5 && (y[0] + y[1]).abs() < 1e-5, "{x:?} {y:?}");
        assert!((z[0] - 0.06).abs() < 1e-6 && (z[1] - 0.1).abs() < 1e-6, "{z:?}");
        assert!(ball.cell_types.is_empty() && ball.triangles.len() > 100);
        assert_eq!((gel.cell_types.as_slice(), gel.cell_nodes.len()), ([12, 12].as_slice(), 16));
        assert_eq!((gel.positions_m.len(), gel.part_of.as_slice()), (36, [0, 0].as_slice()));
    }
}
