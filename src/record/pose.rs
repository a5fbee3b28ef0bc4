//! `/pose/{body}`: position and orientation of a rigid body.

use super::proto::contuse::RigidPose;
use super::proto::foxglove::{Pose, Quaternion};
use super::reference::role_name;
use crate::mechanics::rigid;
use crate::step::Frame;

/// Topic prefix, followed by the body's name.
pub const TOPIC: &str = "/pose/";
/// Schema of the pose.
pub const SCHEMA: &str = "contuse.v1.RigidPose";

/// The message of one body; `None` for a deformable one.
pub fn message(frame: &Frame, body: usize) -> Option<RigidPose> {
    let Pose { position, orientation } = on_the_wire(&frame.pose(body)?);
    let plan_body = &frame.plan.bodies[body];
    Some(RigidPose {
        time_s: frame.time,
        step: frame.step,
        body: plan_body.name.clone(),
        position_m: position,
        orientation,
        role: role_name(plan_body.role).into(),
    })
}

/// Converts a pose to Foxglove's message.
pub(super) fn on_the_wire(pose: &rigid::Pose) -> Pose {
    let q = pose.orientation.coords;
    Pose {
        position: Some(pose.centre.into()),
        orientation: Some(Quaternion { x: q.x, y: q.y, z: q.z, w: q.w }),
    }
}
