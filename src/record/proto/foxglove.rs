//! The parts of the Foxglove schemas that Contuse writes; names and numbers are Foxglove's. Fields that are never written
//! are left out: on the wire that is the same.

pub use prost_types::Timestamp;

/// Three numbers.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector3 {
    /// x
    #[prost(double, tag = "1")]
    pub x: f64,
    /// y
    #[prost(double, tag = "2")]
    pub y: f64,
    /// z
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// A point.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Point3 {
    /// x [m]
    #[prost(double, tag = "1")]
    pub x: f64,
    /// y [m]
    #[prost(double, tag = "2")]
    pub y: f64,
    /// z [m]
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// A rotation.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Quaternion {
    /// x
    #[prost(double, tag = "1")]
    pub x: f64,
    /// y
    #[prost(double, tag = "2")]
    pub y: f64,
    /// z
    #[prost(double, tag = "3")]
    pub z: f64,
    /// w
    #[prost(double, tag = "4")]
    pub w: f64,
}

/// Position and orientation.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Pose {
    /// Position [m].
    #[prost(message, optional, tag = "1")]
    pub position: Option<Vector3>,
    /// Orientation.
    #[prost(message, optional, tag = "2")]
    pub orientation: Option<Quaternion>,
}

impl Pose {
    /// At the origin, not rotated.
    pub fn identity() -> Self {
        let orientation = Some(Quaternion { w: 1.0, ..Quaternion::default() });
        Self { position: Some(Vector3::default()), orientation }
    }
}

/// A colour, 0 … 1.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Color {
    /// Red.
    #[prost(double, tag = "1")]
    pub r: f64,
    /// Green.
    #[prost(double, tag = "2")]
    pub g: f64,
    /// Blue.
    #[prost(double, tag = "3")]
    pub b: f64,
    /// Opacity.
    #[prost(double, tag = "4")]
    pub a: f64,
}

/// A word about an entity.
#[derive(Clone, PartialEq, prost::Message)]
pub struct KeyValuePair {
    /// Name.
    #[prost(string, tag = "1")]
    pub key: String,
    /// Value.
    #[prost(string, tag = "2")]
    pub value: String,
}

/// A coloured triangle mesh.
#[derive(Clone, PartialEq, prost::Message)]
pub struct TriangleListPrimitive {
    /// Where it stands.
    #[prost(message, optional, tag = "1")]
    pub pose: Option<Pose>,
    /// Vertices [m].
    #[prost(message, repeated, tag = "2")]
    pub points: Vec<Point3>,
    /// One colour for all, when there are none a vertex.
    #[prost(message, optional, tag = "3")]
    pub color: Option<Color>,
    /// One colour a vertex.
    #[prost(message, repeated, tag = "4")]
    pub colors: Vec<Color>,
    /// Three vertices a triangle.
    #[prost(fixed32, repeated, tag = "5")]
    pub indices: Vec<u32>,
}

/// A thing in the scene.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SceneEntity {
    /// Simulated time.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Frame of reference.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// It replaces the earlier entity with the same id.
    #[prost(string, tag = "3")]
    pub id: String,
    /// What else there is to say.
    #[prost(message, repeated, tag = "6")]
    pub metadata: Vec<KeyValuePair>,
    /// Its meshes.
    #[prost(message, repeated, tag = "12")]
    pub triangles: Vec<TriangleListPrimitive>,
}

/// A change of the scene.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SceneUpdate {
    /// Added or replaced.
    #[prost(message, repeated, tag = "2")]
    pub entities: Vec<SceneEntity>,
}

/// One number of a point of a cloud.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PackedElementField {
    /// Name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Bytes from the beginning of the point.
    #[prost(fixed32, tag = "2")]
    pub offset: u32,
    /// Type.
    #[prost(enumeration = "NumericType", tag = "3")]
    pub r#type: i32,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum NumericType {
    /// Not said.
    Unknown = 0,
    /// 32-bit float.
    Float32 = 7,
}

/// Points with numbers.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PointCloud {
    /// Simulated time.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Frame of reference.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// Where it stands.
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
    /// Bytes a point.
    #[prost(fixed32, tag = "4")]
    pub point_stride: u32,
    /// What a point is made of.
    #[prost(message, repeated, tag = "5")]
    pub fields: Vec<PackedElementField>,
    /// The points.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
}

/// A line of the log.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Log {
    /// Simulated time.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// How serious.
    #[prost(enumeration = "Level", tag = "2")]
    pub level: i32,
    /// The message.
    #[prost(string, tag = "3")]
    pub message: String,
    /// Who says it.
    #[prost(string, tag = "4")]
    pub name: String,
}

/// How serious a line of the log is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Level {
    /// Not said.
    Unknown = 0,
    /// To know.
    Info = 2,
    /// To heed.
    Warning = 3,
    /// Failed.
    Error = 4,
}

/// A simulated time [s] as a timestamp; before the start it is 0.
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
