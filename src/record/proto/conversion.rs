//! Vectors, poses and times as messages.

use super::foxglove::{Point3, Pose, Quaternion, Vector3};
use prost_types::Timestamp;

impl Pose {
    /// The identity: at the origin, not rotated.
    pub fn identity() -> Self {
        let orientation = Some(Quaternion { w: 1.0, ..Quaternion::default() });
        Self { position: Some(Vector3::default()), orientation }
    }
}

/// A simulated time [s] as a timestamp; 0 before the start.
pub fn timestamp(time: f64) -> Timestamp {
    let nanoseconds = (time.max(0.0) * 1e9).round() as i64;
    Timestamp { seconds: nanoseconds / 1_000_000_000, nanos: (nanoseconds % 1_000_000_000) as i32 }
}

impl From<[f64; 3]> for Vector3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<crate::mechanics::tensor::Vec3> for Vector3 {
    fn from(v: crate::mechanics::tensor::Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<crate::mechanics::tensor::Vec3> for Point3 {
    fn from(v: crate::mechanics::tensor::Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}
