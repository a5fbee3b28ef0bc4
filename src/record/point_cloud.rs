//! `/points/{body}`: the nodes with unscaled field values in a `foxglove.PointCloud`.

use super::proto::foxglove::packed_element_field::NumericType;
use super::proto::foxglove::{PackedElementField, PointCloud, Pose};
use super::proto::timestamp;
use super::scene_update::FRAME_ID;
use super::stress::{nodal_scalars, nodal_vectors};
use crate::measure::fields::Fields;
use crate::step::Frame;

/// Topic prefix, followed by the body's name.
pub const TOPIC: &str = "/points/";
/// Schema of the point cloud.
pub const SCHEMA: &str = "foxglove.PointCloud";

/// The message of one body at a field time: x, y, z, the nodal scalars, and the norms of the nodal vectors, as f32.
pub fn message(frame: &Frame, body: usize, fields: Option<&Fields>) -> PointCloud {
    let nodes = &frame.plan.bodies[body].nodes;
    let scalars = nodal_scalars(fields, nodes);
    let vectors = nodal_vectors(frame, body);
    // Layout of a point: coordinates, scalars, norms of the vectors.
    let names = ["x", "y", "z"]
        .into_iter()
        .chain(scalars.iter().map(|(name, ..)| *name))
        .chain(vectors.iter().map(|(name, ..)| *name));
    let fields: Vec<_> = names
        .enumerate()
        .map(|(i, name)| PackedElementField {
            name: name.into(),
            offset: 4 * i as u32,
            r#type: NumericType::Float32.into(),
        })
        .collect();
    // Interleaved data of all nodes.
    let mut data = Vec::with_capacity(4 * fields.len() * nodes.len());
    let mut put = |value: f64| data.extend((value as f32).to_le_bytes());
    for (i, node) in nodes.clone().enumerate() {
        frame.position_in(body, node).iter().for_each(|&x| put(x));
        for (.., values) in &scalars {
            put(values[i]);
        }
        for (.., values) in &vectors {
            put(values[i].norm());
        }
    }
    PointCloud {
        timestamp: Some(timestamp(frame.time)),
        frame_id: FRAME_ID.into(),
        pose: Some(Pose::identity()),
        point_stride: 4 * fields.len() as u32,
        fields,
        data,
    }
}
