//! From the messages of a recording to blocks, one at a time.
//!
//! A run gives the messages that it would record, an export those that it reads: both give the same blocks.

use super::block::{Block, BlockSurface, Blocks};
use super::body::{Body, points_array};
use super::contact::{PairContacts, field_data};
use super::grid::{FieldValue, Grid};
use super::packed_data::Reason;
use super::rigid::RigidSurface;
use crate::record::proto::contuse::{ContactForces, ReferenceMesh, Stress};
use crate::record::proto::foxglove::SceneUpdate;
use crate::record::{RecordError, contact, reference, scene_update, stress};
use prost::Message;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Assembles blocks from messages in the order of a recording.
#[derive(Debug, Default)]
pub struct Assembler {
    /// Deformable bodies by their names in topics.
    bodies: BTreeMap<String, Body>,
    /// Contacts that wait to follow the bodies of their time, if that is a field time.
    contact: Option<ContactForces>,
    /// Latest field time [s].
    time_s: Option<f64>,
    /// Bodies (true) and pairs that have been met, numbered.
    parts: Vec<(bool, String)>,
}

impl Assembler {
    /// Takes an encoded message; those of other topics are ignored.
    ///
    /// # Errors
    /// If the message contradicts itself or earlier ones, or a block cannot be written.
    pub fn take(&mut self, topic: &str, data: &[u8], to: &mut dyn Blocks) -> Result<(), RecordError> {
        if topic == contact::TOPIC {
            return self.contact(decoded(topic, data)?, to);
        }
        if let Some(name) = topic.strip_prefix(reference::TOPIC) {
            return self.reference(name, &decoded(topic, data)?);
        }
        if let Some(name) = topic.strip_prefix(stress::TOPIC) {
            return self.stress(name, &decoded(topic, data)?, to);
        }
        if let Some(name) =
            topic.strip_prefix(scene_update::TOPIC).filter(|name| !self.bodies.contains_key(*name))
        {
            return self.rigid(name, &decoded(topic, data)?, to);
        }
        Ok(())
    }

    /// Takes the reference mesh of a deformable body, under its name in topics.
    ///
    /// # Errors
    /// If the message contradicts itself.
    pub fn reference(&mut self, name: &str, mesh: &ReferenceMesh) -> Result<(), RecordError> {
        let body = Body::of(mesh).map_err(|reason| unusable(reference::TOPIC, name, reason))?;
        self.bodies.insert(name.to_owned(), body);
        Ok(())
    }

    /// Takes the contact forces of a time, of which only those of field times are needed.
    ///
    /// # Errors
    /// If earlier ones contradict themselves, or their blocks cannot be written.
    pub fn contact(&mut self, forces: ContactForces, to: &mut dyn Blocks) -> Result<(), RecordError> {
        self.finish(to)?;
        self.contact = Some(forces);
        Ok(())
    }

    /// Takes the fields of a body.
    ///
    /// # Errors
    /// If the message contradicts itself or the reference mesh, or the block cannot be written.
    pub fn stress(&mut self, name: &str, stress: &Stress, to: &mut dyn Blocks) -> Result<(), RecordError> {
        let wrong = |reason: Reason| unusable(stress::TOPIC, name, reason);
        self.time_s = Some(stress.time_s);
        let part = part(&mut self.parts, (true, name));
        if !to.wants(stress.time_s) {
            return Ok(());
        }
        let body = self.bodies.get(name).ok_or_else(|| wrong("the body has no reference mesh".into()))?;
        let state = body.state(stress).map_err(wrong)?;
        let grid = Grid {
            point_count: state.positions.len(),
            points: &state.points,
            cells: &state.cells.cells,
            point_data: state.nodal.iter().collect(),
            cell_data: state.cells.data.iter().chain(&state.cell).collect(),
            field_data: body.field_data(stress.time_s),
        };
        to.block(&Block {
            time_s: stress.time_s,
            part,
            name: Cow::Borrowed(&body.name),
            grid,
            positions: &state.positions,
            surface: BlockSurface::Cells(&body.cells, &state.eroded),
        })
    }

    /// Takes the surface of a rigid body.
    ///
    /// # Errors
    /// If the message contradicts itself, or the block cannot be written.
    pub fn rigid(
        &mut self,
        name: &str,
        update: &SceneUpdate,
        to: &mut dyn Blocks,
    ) -> Result<(), RecordError> {
        let surface =
            RigidSurface::of(update).map_err(|reason| unusable(scene_update::TOPIC, name, reason))?;
        self.time_s = Some(surface.time_s);
        let part = part(&mut self.parts, (true, name));
        if !to.wants(surface.time_s) {
            return Ok(());
        }
        let (points, cells) = (points_array(&surface.positions), surface.cells());
        let grid = Grid {
            point_count: surface.positions.len(),
            points: &points,
            cells: &cells,
            point_data: Vec::new(),
            cell_data: Vec::new(),
            field_data: vec![
                ("TimeValue", FieldValue::Numbers(vec![surface.time_s])),
                ("body", FieldValue::Texts(vec![surface.name.clone()])),
            ],
        };
        to.block(&Block {
            time_s: surface.time_s,
            part,
            name: Cow::Borrowed(&surface.name),
            grid,
            positions: &surface.positions,
            surface: BlockSurface::Triangles(&surface.triangles),
        })
    }

    /// Ends a time: its contacts follow its bodies. To be called after the last message.
    ///
    /// # Errors
    /// If the contacts contradict themselves, or their blocks cannot be written.
    pub fn finish(&mut self, to: &mut dyn Blocks) -> Result<(), RecordError> {
        let Some(forces) = self.contact.take().filter(|forces| Some(forces.time_s) == self.time_s) else {
            return Ok(());
        };
        if !to.wants(forces.time_s) {
            return Ok(());
        }
        for pair in &forces.pairs {
            let contacts = PairContacts::of(pair).map_err(|reason| unusable(contact::TOPIC, "", reason))?;
            let points = points_array(&contacts.positions);
            let grid = Grid {
                point_count: contacts.positions.len(),
                points: &points,
                cells: &contacts.cells,
                point_data: contacts.point.iter().collect(),
                cell_data: Vec::new(),
                field_data: field_data(pair, forces.time_s),
            };
            to.block(&Block {
                time_s: forces.time_s,
                part: part(&mut self.parts, (false, &pair.pair)),
                name: Cow::Owned(format!("contact {}", pair.pair)),
                grid,
                positions: &contacts.positions,
                surface: BlockSurface::None,
            })?;
        }
        Ok(())
    }
}

/// Number of a part: that of its first appearance.
fn part(parts: &mut Vec<(bool, String)>, (is_body, name): (bool, &str)) -> usize {
    let known = parts.iter().position(|known| (known.0, &known.1[..]) == (is_body, name));
    known.unwrap_or_else(|| {
        parts.push((is_body, name.to_owned()));
        parts.len() - 1
    })
}

fn decoded<M: Message + Default>(topic: &str, data: &[u8]) -> Result<M, RecordError> {
    M::decode(data).map_err(|error| unusable(topic, "", error.to_string()))
}

fn unusable(topic: &str, name: &str, reason: Reason) -> RecordError {
    RecordError::Unusable { topic: format!("{topic}{name}"), reason }
}
