//! The parts of the Foxglove schemas that Contuse writes, with Foxglove's names and numbers. Fields that are never
//! written are omitted, which makes no difference in the encoding.

pub use prost_types::Timestamp;

/// A vector in space.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector3 {
    /// Component along x [unit of the vector].
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Component along y [unit of the vector].
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Component along z [unit of the vector].
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// A point in space.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Point3 {
    /// Coordinate x in the frame of the scene [m].
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Coordinate y in the frame of the scene [m].
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Coordinate z in the frame of the scene [m].
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// A rotation as a unit quaternion.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Quaternion {
    /// Vector part along x.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Vector part along y.
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Vector part along z.
    #[prost(double, tag = "3")]
    pub z: f64,
    /// Scalar part w of the unit quaternion.
    #[prost(double, tag = "4")]
    pub w: f64,
}

/// Position and orientation of an object.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Pose {
    /// Position of the origin [m].
    #[prost(message, optional, tag = "1")]
    pub position: Option<Vector3>,
    /// Rotation about the origin.
    #[prost(message, optional, tag = "2")]
    pub orientation: Option<Quaternion>,
}

impl Pose {
    /// The identity: at the origin, not rotated.
    pub fn identity() -> Self {
        let orientation = Some(Quaternion { w: 1.0, ..Quaternion::default() });
        Self { position: Some(Vector3::default()), orientation }
    }
}

/// A colour with components from 0 to 1.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Color {
    /// Red component, 0 … 1.
    #[prost(double, tag = "1")]
    pub r: f64,
    /// Green component, 0 … 1.
    #[prost(double, tag = "2")]
    pub g: f64,
    /// Blue component, 0 … 1.
    #[prost(double, tag = "3")]
    pub b: f64,
    /// Opacity, from 0 transparent to 1 opaque.
    #[prost(double, tag = "4")]
    pub a: f64,
}

/// Metadata of an entity.
#[derive(Clone, PartialEq, prost::Message)]
pub struct KeyValuePair {
    /// Name of the entry.
    #[prost(string, tag = "1")]
    pub key: String,
    /// Value of the entry.
    #[prost(string, tag = "2")]
    pub value: String,
}

/// A coloured triangle mesh.
#[derive(Clone, PartialEq, prost::Message)]
pub struct TriangleListPrimitive {
    /// Pose of the mesh.
    #[prost(message, optional, tag = "1")]
    pub pose: Option<Pose>,
    /// Vertices of the triangles [m].
    #[prost(message, repeated, tag = "2")]
    pub points: Vec<Point3>,
    /// Uniform colour, unless there are colours per vertex.
    #[prost(message, optional, tag = "3")]
    pub color: Option<Color>,
    /// One colour per vertex.
    #[prost(message, repeated, tag = "4")]
    pub colors: Vec<Color>,
    /// Three vertex indices per triangle.
    #[prost(fixed32, repeated, tag = "5")]
    pub indices: Vec<u32>,
}

/// An object in the scene.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SceneEntity {
    /// Simulated time as a timestamp; 0 before the start.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Name of the frame of reference.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// Identifier; an entity replaces the earlier one with the same id.
    #[prost(string, tag = "3")]
    pub id: String,
    /// Additional information for display.
    #[prost(message, repeated, tag = "6")]
    pub metadata: Vec<KeyValuePair>,
    /// Triangle meshes of the entity.
    #[prost(message, repeated, tag = "12")]
    pub triangles: Vec<TriangleListPrimitive>,
}

/// A change of the scene.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SceneUpdate {
    /// Entities added or replaced.
    #[prost(message, repeated, tag = "2")]
    pub entities: Vec<SceneEntity>,
}

/// A field of the points in a cloud.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PackedElementField {
    /// Name of the field.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Offset in bytes from the beginning of the point.
    #[prost(fixed32, tag = "2")]
    pub offset: u32,
    /// Number type, see [`NumericType`].
    #[prost(enumeration = "NumericType", tag = "3")]
    pub r#type: i32,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum NumericType {
    /// Number type not specified (value 0 of the enumeration).
    Unknown = 0,
    /// 32-bit floating-point number, little-endian.
    Float32 = 7,
}

/// Points with field values.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PointCloud {
    /// Simulated time as a timestamp; 0 before the start.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Name of the frame of reference.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// Pose of the cloud.
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
    /// Bytes from one point to the next.
    #[prost(fixed32, tag = "4")]
    pub point_stride: u32,
    /// Fields of each point.
    #[prost(message, repeated, tag = "5")]
    pub fields: Vec<PackedElementField>,
    /// Points packed one after the other.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
}

/// A line of the log.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Log {
    /// Simulated time as a timestamp; 0 before the start.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Severity of the line, see [`Level`].
    #[prost(enumeration = "Level", tag = "2")]
    pub level: i32,
    /// Text of the message.
    #[prost(string, tag = "3")]
    pub message: String,
    /// Source of the message.
    #[prost(string, tag = "4")]
    pub name: String,
}

/// Severity of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Level {
    /// Severity not specified (value 0 of the enumeration).
    Unknown = 0,
    /// Information on the run.
    Info = 2,
    /// Warning to the user.
    Warning = 3,
    /// Failure of the run.
    Error = 4,
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
