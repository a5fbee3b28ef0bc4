//! The contacts of a pair for VTK: a point at each of them, at a field time.

use super::array::Array;
use super::grid::{CellArrays, FieldValue};
use super::packed_data::{Reason, arrays, checked, triples};
use crate::record::proto::contuse::{PackedArray, PairForces};
use crate::record::proto::foxglove::Vector3;

/// VTK's type of a point.
const VERTEX: u8 = 1;

/// The contacts of a pair.
pub(super) struct PairContacts {
    /// Positions of the contacts [m].
    pub positions: Vec<[f32; 3]>,
    /// The other arrays of the recording, an entry each contact.
    pub point: Vec<Array>,
    /// One cell of VTK a contact, since filters take cells.
    pub cells: CellArrays,
}

impl PairContacts {
    /// From the message of a pair.
    pub fn of(pair: &PairForces) -> Result<Self, Reason> {
        let is_position = |array: &&PackedArray| array.name == "position_m";
        let positions = checked(pair.contacts.iter().find(is_position), "position_m", ("f32", 3))?;
        let positions = triples(positions);
        let others = pair.contacts.iter().filter(|array| !is_position(array));
        Ok(Self {
            point: arrays(others, positions.len())?,
            cells: CellArrays::new((0..positions.len() as u32).map(|point| (VERTEX, [point]))),
            positions,
        })
    }
}

/// Values of a pair as a whole.
pub(super) fn field_data(pair: &PairForces, time_s: f64) -> Vec<(&'static str, FieldValue)> {
    let vector = |v: Option<Vector3>| v.map_or(vec![0.0; 3], |v| vec![v.x, v.y, v.z]);
    let texts = [("pair", &pair.pair), ("slave_body", &pair.slave_body), ("master_body", &pair.master_body)];
    let numbers = [
        ("TimeValue", vec![time_s]),
        ("force_n", vector(pair.force_n)),
        ("impulse_n_s", vector(pair.impulse_n_s)),
        ("patch_area_m2", vec![pair.patch_area_m2]),
        ("patch_long_axis_m", vec![pair.patch_long_axis_m]),
        ("patch_short_axis_m", vec![pair.patch_short_axis_m]),
        ("peak_pressure_pa", vec![pair.peak_pressure_pa]),
        ("patch_nodes", vec![f64::from(pair.patch_nodes)]),
        ("nodes_across_patch", vec![f64::from(pair.nodes_across_patch)]),
    ];
    let texts = texts.map(|(name, text)| (name, FieldValue::Texts(vec![text.clone()])));
    let numbers = numbers.map(|(name, numbers)| (name, FieldValue::Numbers(numbers)));
    texts.into_iter().chain(numbers).collect()
}
