//! Frames that outlive their step, for a recorder on another thread: copies into reusable memory.

use super::energy::Energy;
use super::frame::Frame;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::Erosion;
use crate::mechanics::lanes::Row;
use crate::mechanics::rigid::Rotation;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use std::sync::Arc;

/// Contacts that a copy has memory for from the start. There are some copies, and far more contacts are possible than ever close: with
/// half a gigabyte for all of them at 28 000 elements, runs met their limit of memory.
const RESERVED_CONTACTS: usize = 4096;

/// A frame by value. Data needed only at field times is stored separately, so that a queue of copies stays small:
/// between them the displacement is kept at boundary nodes only, a small part of a large mesh.
#[derive(Clone, Debug, Default)]
pub struct FrameCopy {
    time: f64,
    step: u64,
    mean_step: f64,
    /// Displacement of the boundary nodes, or of all nodes if elements may erode [m], body after body; empty at a look
    /// time.
    boundary_u: Vec<Vec3>,
    is_field_time: bool,
    field: Option<Box<FieldCopy>>,
    erosion: Arc<Erosion>,
    orientations: Vec<Rotation>,
    contacts: Vec<Contact>,
    reactions: Vec<Reaction>,
    energy: Energy,
}

/// Data of all nodes, at look times.
#[derive(Clone, Debug, Default)]
pub struct FieldCopy {
    /// Displacement [m], nodes × 3.
    u: Vec<Vec3>,
    /// Velocities of the half steps before and after [m/s], nodes × 3; empty if neither the plan requests them nor a
    /// part is viscous.
    v: Vec<Vec3>,
    v_after: Vec<Vec3>,
    /// History of the elements, chunk by chunk; empty if no material relaxes.
    history: Vec<Vec<Row>>,
}

impl FrameCopy {
    /// Allocates memory for a frame of a plan, without its fields; that of very many contacts is allocated when they come.
    pub fn new(plan: &Plan) -> Self {
        let most = plan.most_contacts().min(RESERVED_CONTACTS);
        Self {
            boundary_u: Vec::with_capacity(plan.nodes_to_keep().count()),
            orientations: Vec::with_capacity(plan.rigid_bodies().len()),
            contacts: Vec::with_capacity(most),
            reactions: Vec::with_capacity(most),
            energy: Energy::with_capacity(plan),
            ..Self::default()
        }
    }

    /// Copies a frame into the existing buffers. `field` is the memory for the fields: `Some` at look times and only
    /// then.
    pub fn take(&mut self, frame: &Frame, mut field: Option<Box<FieldCopy>>) {
        (self.time, self.step, self.mean_step) = (frame.time, frame.step, frame.mean_step);
        self.is_field_time = frame.is_field_time;
        self.boundary_u.clear();
        if let Some(field) = &mut field {
            field.take(frame);
        } else {
            self.boundary_u.extend(frame.plan.nodes_to_keep().map(|node| frame.u[node as usize]));
        }
        self.field = field;
        self.erosion.clone_from(frame.erosion);
        self.orientations.clear();
        self.orientations.extend_from_slice(frame.orientations);
        self.contacts.clear();
        self.contacts.extend_from_slice(frame.contacts);
        self.reactions.clear();
        self.reactions.extend_from_slice(frame.reactions);
        self.energy.copy_from(frame.energy);
    }

    /// Reconstructs the frame. `u` [m], nodes × 3, receives the displacement; it belongs to one run.
    pub fn frame<'a>(&'a mut self, plan: &'a Plan, u: &'a mut Vec<Vec3>) -> Frame<'a> {
        // Displacement: of all nodes at a look time, otherwise of the kept nodes.
        let (is_field_time, is_look_time) = (self.is_field_time, self.field.is_some());
        if let Some(field) = &mut self.field {
            std::mem::swap(u, &mut field.u);
        } else {
            if cfg!(debug_assertions) {
                // Makes access to missing data visible in tests.
                u.fill(Vec3::repeat(f64::NAN));
            }
            for (node, value) in plan.nodes_to_keep().zip(&self.boundary_u) {
                u[node as usize] = *value;
            }
        }
        let velocities = self.field.as_ref().map_or((&[][..], &[][..]), |f| (&f.v[..], &f.v_after[..]));
        let history = self.field.as_ref().map_or(&[][..], |f| &f.history[..]);
        Frame {
            plan,
            time: self.time,
            step: self.step,
            u,
            v: velocities.0,
            v_after: velocities.1,
            history,
            erosion: &self.erosion,
            orientations: &self.orientations,
            contacts: &self.contacts,
            reactions: &self.reactions,
            mean_step: self.mean_step,
            energy: &self.energy,
            is_field_time,
            is_look_time,
        }
    }

    /// Returns the memory for the fields.
    pub fn take_field(&mut self) -> Option<Box<FieldCopy>> {
        self.field.take()
    }
}

impl FieldCopy {
    /// Allocates memory for the fields of a plan.
    pub fn new(plan: &Plan) -> Self {
        let room = |count| Vec::with_capacity(count);
        let velocities = if plan.reads_velocities() { plan.node_count() } else { 0 };
        let history = plan.room_for_history();
        Self { u: room(plan.node_count()), v: room(velocities), v_after: room(velocities), history }
    }

    fn take(&mut self, frame: &Frame) {
        self.u.clear();
        self.u.extend_from_slice(frame.u);
        if frame.plan.reads_velocities() {
            self.v.clear();
            self.v.extend_from_slice(frame.v);
            self.v_after.clear();
            self.v_after.extend_from_slice(frame.v_after);
        }
        for (to, from) in self.history.iter_mut().zip(frame.history) {
            to.copy_from_slice(from);
        }
    }
}
