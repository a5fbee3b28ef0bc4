//! `/points/{body}`: the vertices of `/mesh/{body}` with its colours in a `foxglove.PointCloud`, for programs that display no
//! surfaces.

use super::colour::viridis;
use super::proto::foxglove::packed_element_field::NumericType;
use super::proto::foxglove::{PackedElementField, PointCloud, Pose};
use super::proto::timestamp;
use super::scene_update::{Boundary, FRAME_ID, PLAIN};
use crate::measure::fields::Fields;
use crate::step::Frame;

/// Topic prefix, followed by the body's name.
pub const TOPIC: &str = "/points/";
/// Schema of the point cloud.
pub const SCHEMA: &str = "foxglove.PointCloud";

/// Bytes of a point: three coordinates as f32, four parts of a colour as u8.
const STRIDE: u32 = 16;

/// The message of one body at a field time; colours range from 0 to `top` [Pa] of von Mises stress.
#[allow(clippy::cast_sign_loss)] // parts of colours are between 0 and 1
pub fn message(
    frame: &Frame,
    body: usize,
    fields: Option<&Fields>,
    boundary: &Boundary,
    top: f64,
) -> PointCloud {
    let stress = boundary.stress(fields);
    let mut data = Vec::with_capacity(STRIDE as usize * boundary.nodes().len());
    for &node in boundary.nodes() {
        boundary.vertex(frame, body, node).iter().for_each(|&x| data.extend((x as f32).to_le_bytes()));
        let colour = stress.map_or(PLAIN, |stress| viridis(stress[node as usize], top));
        data.extend([colour.r, colour.g, colour.b, colour.a].map(|part| (255.0 * part).round() as u8));
    }
    PointCloud {
        timestamp: Some(timestamp(frame.time)),
        frame_id: FRAME_ID.into(),
        pose: Some(Pose::identity()),
        point_stride: STRIDE,
        fields: layout(),
        data,
    }
}

/// Names, places and types of the numbers of a point.
fn layout() -> Vec<PackedElementField> {
    let coordinates = (0..).step_by(4).zip(["x", "y", "z"]).map(|named| (named, NumericType::Float32));
    let colours = (12..).zip(["red", "green", "blue", "alpha"]).map(|named| (named, NumericType::Uint8));
    coordinates
        .chain(colours)
        .map(|((offset, name), number)| PackedElementField {
            name: name.into(),
            offset,
            r#type: number.into(),
        })
        .collect()
}
