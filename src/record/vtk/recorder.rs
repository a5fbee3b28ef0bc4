//! The recorder of a series: the messages of the field times, assembled as an export of the recording assembles them.

use super::assemble::Assembler;
use super::folder::Folder;
use super::series::Series;
use crate::measure::{MeasuredEnd, MeasuredFrame, Sink};
use crate::plan::Plan;
use crate::record::mcap::topic_names;
use crate::record::scene_update::{RigidSurface, rigid_message};
use crate::record::{RecordError, contact, reference, stress};
use crate::step::RecorderError;
use std::path::{Path, PathBuf};

/// Writes the field times of a run as a series of `.vtu` files with a `.pvd` file.
#[derive(Debug)]
pub struct VtuRecorder {
    path: PathBuf,
    open: Option<Open>,
}

/// The series being written.
#[derive(Debug)]
struct Open {
    series: Series<Folder>,
    assembler: Assembler,
    /// Names of the bodies in topics, and the surfaces of the rigid ones.
    bodies: Vec<(String, Option<RigidSurface>)>,
}

impl VtuRecorder {
    /// A recorder to the `.pvd` file `path`; nothing is written before the run starts.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), open: None }
    }
}

impl Open {
    fn start(path: &Path, plan: &Plan) -> Result<Self, RecordError> {
        let mut open = Self {
            series: Series::new(Folder::create(path)?),
            assembler: Assembler::default(),
            bodies: Vec::new(),
        };
        for (body, name) in topic_names(&plan.bodies).into_iter().enumerate() {
            let rigid =
                plan.bodies[body].rigid.map(|index| RigidSurface::new(&plan.rigid_bodies()[index].shape));
            if rigid.is_none() {
                open.assembler.reference(&name, &reference::message(plan, body))?;
            }
            open.bodies.push((name, rigid));
        }
        Ok(open)
    }

    /// The messages of a field time, in the order of a recording.
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecordError> {
        let MeasuredFrame { frame, measures } = *measured;
        let (assembler, series) = (&mut self.assembler, &mut self.series);
        if frame.plan.contact.is_some() {
            assembler.contact(contact::message(frame, measures), series)?;
        }
        for (body, (name, surface)) in self.bodies.iter().enumerate() {
            let update = surface.as_ref().and_then(|surface| rigid_message(frame, body, surface));
            if let Some(update) = update {
                assembler.rigid(name, &update, series)?;
            }
        }
        let fields = measures.fields.as_ref();
        for (body, (name, _)) in self.bodies.iter().enumerate().filter(|(_, (_, surface))| surface.is_none())
        {
            assembler.stress(name, &stress::message(frame, body, fields), series)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), RecordError> {
        self.assembler.finish(&mut self.series)?;
        self.series.finish()
    }
}

impl Sink for VtuRecorder {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        if plan.fields.is_empty() {
            return Err(RecordError::NoFields.into());
        }
        self.open = Some(Open::start(&self.path, plan)?);
        Ok(())
    }

    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        let open = self.open.as_mut().ok_or(RecordError::NotOpen)?;
        if measured.frame.is_field_time {
            open.record(measured)?;
        }
        Ok(())
    }

    fn finish(&mut self, _: &MeasuredEnd) -> Result<(), RecorderError> {
        Ok(self.open.take().ok_or(RecordError::NotOpen)?.finish()?)
    }

    fn discard(&mut self) {
        if let Some(open) = self.open.take() {
            open.series.discard();
        }
    }
}
