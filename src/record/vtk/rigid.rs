//! A rigid body for VTK: its triangulated surface at a field time.

use super::grid::CellArrays;
use super::packed_data::Reason;
use crate::mechanics::rigid::{Pose, Rotation};
use crate::mechanics::tensor::Vec3;
use crate::record::proto::foxglove::{Point3, SceneUpdate, TriangleListPrimitive};
use nalgebra::Quaternion;

/// VTK's type of a triangle.
const TRIANGLE: u8 = 5;

/// The surface of a rigid body at a field time.
pub(super) struct RigidSurface {
    /// Field time [s].
    pub time_s: f64,
    /// Name of the body.
    pub name: String,
    /// Positions of the corners in space [m].
    pub positions: Vec<[f32; 3]>,
    /// Corners of the triangles.
    pub triangles: Vec<u32>,
}

impl RigidSurface {
    /// Reads the message of a rigid body, which has one surface of triangles.
    pub fn of(message: &SceneUpdate) -> Result<Self, Reason> {
        let [entity] = &message.entities[..] else { return Err("there is not one entity".into()) };
        let [mesh] = &entity.triangles[..] else { return Err("there is not one surface".into()) };
        let time = entity.metadata.iter().find(|pair| pair.key == "time_s");
        let time = time.and_then(|pair| pair.value.parse().ok()).filter(|time: &f64| time.is_finite());
        let corners = mesh.points.len();
        if !mesh.indices.len().is_multiple_of(3) || mesh.indices.iter().any(|&i| i as usize >= corners) {
            return Err(format!("the triangles are not triples of {corners} corners"));
        }
        Ok(Self {
            time_s: time.ok_or("time_s is missing")?,
            name: entity.id.clone(),
            positions: placed(mesh)?,
            triangles: mesh.indices.clone(),
        })
    }

    /// Its triangles for VTK.
    pub fn cells(&self) -> CellArrays {
        CellArrays::new(self.triangles.chunks(3).map(|corners| (TRIANGLE, corners.iter().copied())))
    }
}

/// Corners of a surface in space.
fn placed(mesh: &TriangleListPrimitive) -> Result<Vec<[f32; 3]>, Reason> {
    let pose = mesh.pose.as_ref().and_then(|pose| pose.position.zip(pose.orientation));
    let (centre, q) = pose.ok_or("the pose is missing")?;
    // Not normalised again: the bits of the run.
    let orientation = Rotation::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z));
    let pose = Pose { centre: Vec3::new(centre.x, centre.y, centre.z), orientation };
    let in_space = |x: &Point3| {
        let x = pose.place(&Vec3::new(x.x, x.y, x.z));
        [x.x as f32, x.y as f32, x.z as f32]
    };
    Ok(mesh.points.iter().map(in_space).collect())
}
