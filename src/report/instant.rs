//! The bodies of a recording at the field time nearest to an instant.

use crate::mesh::{CellKind, Cells};
use crate::record::proto::contuse::{PackedArray, ReferenceMesh, Stress};
use crate::record::proto::foxglove::SceneUpdate;
use crate::record::reader::for_each_record_of;
use crate::record::{RecordError, reference, scene_update, stress};
use ::mcap::records::Record;
use prost::Message as _;
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::Path;

/// VTK's type of a hexahedron.
const HEXAHEDRON: u8 = 12;

/// All bodies at one field time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instant {
    /// Field time [s].
    pub time_s: f64,
    /// Bodies with a mesh.
    pub bodies: Vec<Body>,
    /// Triangles of the rigid bodies: corners [m].
    pub rigid: Vec<[[f64; 3]; 3]>,
}

/// A body with a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// Role in the scene: `projectile`, `tissue` or `other`.
    pub role: String,
    /// Names of its parts.
    pub parts: Vec<String>,
    /// Its cells, by the numbers of its nodes.
    pub cells: Cells,
    /// Part of each cell, an index into `parts`.
    pub part_of: Vec<u32>,
    /// 1 for each eroded cell; empty if none can erode.
    pub eroded: Vec<u8>,
    /// Positions of the nodes at rest [m].
    pub rest: Vec<[f64; 3]>,
    /// Velocity of its flight [m/s].
    pub flight: [f64; 3],
    /// Positions of the nodes [m].
    pub positions: Vec<[f64; 3]>,
    /// Von Mises stress at the nodes [Pa]; empty if it was not recorded.
    pub stress: Vec<f64>,
}

/// Reads the bodies at the field time nearest to `time_s`; `None` if no fields were recorded. What a damaged recording
/// contradicts is omitted: the chunks have their own checksums.
///
/// # Errors
/// If the recording cannot be read.
pub fn instant(input: impl Read + Seek, name: &Path, time_s: f64) -> Result<Option<Instant>, RecordError> {
    let mut nearest = Nearest { wanted: time_s, ..Nearest::default() };
    let mut topics = BTreeMap::new();
    for_each_record_of(input, name, |record| {
        match record {
            Record::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                if let Some(topic) = topics.get(&header.channel_id) {
                    nearest.take(topic, header.publish_time, &data);
                }
            }
            _ => {}
        }
        Ok(())
    })?;
    Ok(nearest.finished())
}

/// The messages nearest to a time, by body.
#[derive(Default)]
struct Nearest {
    wanted: f64,
    meshes: BTreeMap<String, Body>,
    fields: BTreeMap<String, (f64, Vec<u8>)>,
    surfaces: BTreeMap<String, (f64, Vec<u8>)>,
}

impl Nearest {
    fn take(&mut self, topic: &str, publish_time: u64, data: &[u8]) {
        let time = 1e-9 * publish_time as f64;
        let wanted = self.wanted;
        let keep = |kept: &mut BTreeMap<String, (f64, Vec<u8>)>, body: &str| {
            let is_nearer =
                kept.get(body).is_none_or(|(other, _)| (time - wanted).abs() < (other - wanted).abs());
            if is_nearer {
                kept.insert(body.to_owned(), (time, data.to_vec()));
            }
        };
        if let Some(body) = topic.strip_prefix(stress::TOPIC) {
            keep(&mut self.fields, body);
        } else if let Some(body) = topic.strip_prefix(scene_update::TOPIC) {
            keep(&mut self.surfaces, body);
        } else if let Some(body) = topic.strip_prefix(reference::TOPIC) {
            let mesh = ReferenceMesh::decode(data).ok().and_then(|mesh| at_rest(&mesh));
            self.meshes.extend(mesh.map(|mesh| (body.to_owned(), mesh)));
        }
    }

    fn finished(self) -> Option<Instant> {
        let (time_s, _) = self.fields.values().next()?;
        let mut instant = Instant { time_s: *time_s, ..Instant::default() };
        let rigid = self.surfaces.iter().filter(|(name, _)| !self.meshes.contains_key(*name));
        for (_, (_, data)) in rigid {
            instant.rigid.extend(SceneUpdate::decode(&data[..]).iter().flat_map(triangles));
        }
        for (name, mut body) in self.meshes {
            let fields = self.fields.get(&name).and_then(|(_, data)| Stress::decode(&data[..]).ok());
            if fields.and_then(|fields| put_state(&mut body, &fields)).is_some() {
                instant.bodies.push(body);
            }
        }
        Some(instant)
    }
}

fn u32s(array: Option<&PackedArray>) -> Vec<u32> {
    let data = array.map_or(&[][..], |array| &array.data);
    data.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect()
}

/// A body at rest; `None` if its cells have nodes or types that do not exist.
fn at_rest(mesh: &ReferenceMesh) -> Option<Body> {
    let numbers: Vec<f64> =
        mesh.positions.as_ref()?.data.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let rest: Vec<[f64; 3]> = numbers.as_chunks().0.to_vec();
    let hexes = u32s(mesh.hexes.as_ref());
    let (types, nodes) = if mesh.hexes.is_some() {
        (vec![HEXAHEDRON; hexes.len() / 8], hexes)
    } else {
        (mesh.cell_types.as_ref()?.data.clone(), u32s(mesh.cell_nodes.as_ref()))
    };
    let (mut cells, mut left) = (Cells::default(), &nodes[..]);
    for number in types {
        let kind = CellKind::ALL.into_iter().find(|kind| kind.table().vtk.number == number)?;
        let (own, after) = left.split_at_checked(kind.node_count())?;
        let own: Vec<u32> = kind.table().vtk.order.iter().map(|&place| own[place]).collect();
        cells.push(kind, &own);
        left = after;
    }
    let part_of = u32s(mesh.part_of.as_ref());
    let is_whole = part_of.len() == cells.len() && nodes.iter().all(|&node| (node as usize) < rest.len());
    let flight = mesh.flight_velocity_m_per_s.unwrap_or_default();
    let body = Body {
        role: mesh.role.clone(),
        parts: mesh.parts.clone(),
        cells,
        part_of,
        rest,
        flight: [flight.x, flight.y, flight.z],
        ..Body::default()
    };
    is_whole.then_some(body)
}

/// Adds positions, stress and which cells have eroded; `None` if the fields are not those of the mesh.
fn put_state(body: &mut Body, fields: &Stress) -> Option<()> {
    body.positions = stress::positions(fields, &body.rest, body.flight)?;
    let stress = stress::f32s(fields, stress::VON_MISES).unwrap_or_default();
    body.eroded = stress::eroded(fields).to_vec();
    let is_of = |entries: usize, count: usize| entries == 0 || entries == count;
    let is_whole = is_of(stress.len(), body.rest.len()) && is_of(body.eroded.len(), body.cells.len());
    body.stress = stress.into_iter().map(f64::from).collect();
    is_whole.then_some(())
}

/// The triangles of a rigid body in space.
fn triangles(update: &SceneUpdate) -> Vec<[[f64; 3]; 3]> {
    let mut all = Vec::new();
    for list in update.entities.iter().flat_map(|entity| &entity.triangles) {
        let pose = list.pose.unwrap_or_default();
        let (at, q) = (pose.position.unwrap_or_default(), pose.orientation.unwrap_or_default());
        let place = |index: u32| {
            let p = list.points.get(index as usize)?;
            // p + 2 w (v × p) + 2 v × (v × p) for a unit quaternion (v, w).
            let cross = |a: [f64; 3], b: [f64; 3]| {
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
            };
            let (v, p) = ([q.x, q.y, q.z], [p.x, p.y, p.z]);
            let once = cross(v, p);
            let twice = cross(v, once);
            let moved = [at.x, at.y, at.z];
            Some(std::array::from_fn(|k| moved[k] + p[k] + 2.0 * (q.w * once[k] + twice[k])))
        };
        for corners in list.indices.as_chunks::<3>().0 {
            if let [Some(a), Some(b), Some(c)] = corners.map(place) {
                all.push([a, b, c]);
            }
        }
    }
    all
}
