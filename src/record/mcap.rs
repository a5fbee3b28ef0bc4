//! The MCAP recorder.
//!
//! | topic | when |
//! |---|---|
//! | `/reference/{body}` | once; not for rigid bodies |
//! | `/contact/forces`, `/energy`, `/pose/{body}` of a rigid body | every `every_steps` steps, and at the field times |
//! | `/stress/{body}`, `/mesh/{body}`, `/points/{body}` | at the field times, if any field is requested; for a rigid body `/mesh` |
//! | `/summary`, `/log` | at the field times and at the end; whenever there is a message |
//!
//! The numbers are those of the measured frames, as in the summary.

use super::metadata::{ENDING_METADATA, RUN_METADATA, RecordingInfo, ending_metadata, run_metadata};
use super::proto::foxglove::log::Level;
use super::writer::{RecordingWriter, TimeScale};
use super::{
    RecordError, colour, contact, energy, log, point_cloud, pose, reference, scene_update, stress, summary,
};
use crate::measure::fields::Fields;
use crate::measure::{MeasuredEnd, MeasuredFrame, Sink};
use crate::plan::{Plan, PlanBody};
use crate::step::{Ending, Frame, Outcome, RecorderError};
use std::path::{Path, PathBuf};

/// Minimum size at which a chunk is closed at a field time [bytes], so that little is lost in a crash or missing from a
/// snapshot, and small runs are not split into tiny chunks.
const FLUSH_BYTES: usize = 64 * 1024;

/// Channels of one deformable body.
struct BodyChannels {
    body: usize,
    stress: u16,
    mesh: u16,
    points: u16,
    boundary: scene_update::Boundary,
}

/// Channels of one rigid body.
struct RigidChannels {
    body: usize,
    pose: u16,
    /// Boundary surface and its channel, if any field is requested.
    mesh: Option<(u16, scene_update::RigidSurface)>,
}

/// The open file and the state of the recording.
struct Open {
    writer: RecordingWriter,
    contact: Option<u16>,
    energy: u16,
    summary: u16,
    log: u16,
    bodies: Vec<BodyChannels>,
    rigid: Vec<RigidChannels>,
    colour_top: f64,
    frames: u64,
    /// Time [s] and step of the latest frame.
    latest: (f64, u64),
    /// Whether the latest frame is in the file.
    is_latest_written: bool,
}

/// Writes a run to an MCAP file, `<path>.partial` until it is finished.
pub struct McapRecorder {
    path: PathBuf,
    info: RecordingInfo,
    open: Option<Open>,
}

impl McapRecorder {
    /// A recorder to `path`; nothing is written before the run starts.
    pub fn new(path: &Path, info: RecordingInfo) -> Self {
        Self { path: path.to_owned(), info, open: None }
    }

    fn open(&mut self, plan: &Plan) -> Result<Open, RecordError> {
        let scale = TimeScale::for_run(plan.end_time);
        let mut writer = RecordingWriter::create(&self.path, scale)?;
        let colour_top = colour::range(plan);
        // Before the first chunk, so that the recording of a killed run identifies its origin.
        writer.write_metadata(RUN_METADATA, run_metadata(&self.info, plan, scale, colour_top)?)?;
        writer.attach("scene.json", &self.info.document_json)?;
        writer.attach("plan_report.json", &serde_json::to_vec_pretty(&plan.report)?)?;
        // Channels of the global topics.
        let contact = if plan.contact.is_some() {
            Some(writer.add_channel(contact::TOPIC, contact::SCHEMA)?)
        } else {
            None
        };
        let energy = writer.add_channel(energy::TOPIC, energy::SCHEMA)?;
        let summary = writer.add_channel(summary::TOPIC, summary::SCHEMA)?;
        let log = writer.add_channel(log::TOPIC, log::SCHEMA)?;
        // Channels and reference meshes of the bodies.
        let names = topic_names(&plan.bodies);
        let (mut bodies, mut rigid) = (Vec::new(), Vec::new());
        for (body, name) in names.iter().enumerate() {
            if let Some(index) = plan.bodies[body].rigid {
                rigid.push(add_rigid_channels(&mut writer, plan, (body, index), name)?);
                continue;
            }
            let mesh = reference::message(plan, body);
            let channel =
                writer.add_channel(&format!("{}{name}", reference::TOPIC), reference::schema(&mesh))?;
            writer.write(channel, 0.0, &mesh)?;
            if plan.fields.is_empty() {
                continue;
            }
            bodies.push(BodyChannels {
                body,
                stress: writer.add_channel(&format!("{}{name}", stress::TOPIC), stress::SCHEMA)?,
                mesh: writer.add_channel(&format!("{}{name}", scene_update::TOPIC), scene_update::SCHEMA)?,
                points: writer.add_channel(&format!("{}{name}", point_cloud::TOPIC), point_cloud::SCHEMA)?,
                boundary: scene_update::Boundary::new(plan, body),
            });
        }
        let start =
            format!("{}: {} elements, {} nodes", plan.name, plan.element_count(), plan.mesh_node_count());
        writer.write(log, 0.0, &log::message(0.0, Level::Info, &start))?;
        // From here on the recording of a crashed run identifies its origin.
        writer.flush_if(0)?;
        Ok(Open {
            writer,
            contact,
            energy,
            summary,
            log,
            bodies,
            rigid,
            colour_top,
            frames: 0,
            latest: (0.0, 0),
            is_latest_written: true,
        })
    }

    fn write_frame(open: &mut Open, measured: &MeasuredFrame) -> Result<(), RecordError> {
        let MeasuredFrame { frame, measures } = *measured;
        let time = frame.time;
        open.latest = (time, frame.step);
        // Frames are due every so many steps and at the field times.
        let is_due = open.frames.is_multiple_of(u64::from(frame.plan.every_steps.max(1)));
        open.frames += 1;
        open.is_latest_written = is_due || frame.is_field_time;
        if !open.is_latest_written {
            return Ok(());
        }
        if let Some(channel) = open.contact {
            open.writer.write(channel, time, &contact::message(frame, measures))?;
        }
        open.writer.write(open.energy, time, &energy::message(frame.plan, measures))?;
        for channels in &open.rigid {
            if let Some(message) = pose::message(frame, channels.body) {
                open.writer.write(channels.pose, time, &message)?;
            }
            let mesh = channels.mesh.as_ref().filter(|_| frame.is_field_time);
            let mesh = mesh.map(|(channel, boundary)| {
                (channel, scene_update::rigid_message(frame, channels.body, boundary))
            });
            if let Some((channel, Some(message))) = mesh {
                open.writer.write(*channel, time, &message)?;
            }
        }
        if !frame.is_field_time {
            return Ok(());
        }
        Self::write_fields(open, frame, measures.fields.as_ref())?;
        open.writer.write(open.summary, time, &summary::message(&measured.summary(), time, frame.step)?)?;
        open.writer.flush_if(FLUSH_BYTES)
    }

    /// What is recorded of the deformable bodies at a field time. The steps before it, the fields, and what other programs display are
    /// in chunks of their own if they are large, so that a reader fetches only those that it needs.
    fn write_fields(open: &mut Open, frame: &Frame, fields: Option<&Fields>) -> Result<(), RecordError> {
        let Open { writer, bodies, colour_top: top, .. } = open;
        writer.flush_if(FLUSH_BYTES)?;
        for channels in &mut *bodies {
            writer.write(channels.stress, frame.time, &stress::message(frame, channels.body, fields))?;
        }
        writer.flush_if(FLUSH_BYTES)?;
        for BodyChannels { body, mesh, points, boundary, .. } in bodies {
            boundary.follow(frame, *body);
            let surface = scene_update::message(frame, *body, fields, boundary, *top);
            writer.write(*mesh, frame.time, &surface)?;
            writer.write(*points, frame.time, &point_cloud::message(frame, *body, fields, boundary, *top))?;
        }
        Ok(())
    }

    /// Writes the final messages and records, and closes the file.
    fn close(mut open: Open, end: &MeasuredEnd) -> Result<(), RecordError> {
        let MeasuredEnd { plan, measures, outcome, summary } = *end;
        let (time, step) = open.latest;
        if !open.is_latest_written {
            open.writer.write(open.energy, time, &energy::message(plan, measures))?;
        }
        open.writer.write(open.summary, time, &summary::message(summary, time, step)?)?;
        for warning in summary.warnings.iter() {
            open.writer.write(open.log, time, &log::message(time, Level::Warning, warning))?;
        }
        let (level, text) = last_words(outcome);
        open.writer.write(open.log, time, &log::message(time, level, &text))?;
        open.writer.attach("summary.json", summary.to_json()?.as_bytes())?;
        let ending = &outcome.ending;
        let metadata = ending_metadata(*ending == Ending::Finished, ending.name(), &text, time, step);
        open.writer.write_metadata(ENDING_METADATA, metadata)?;
        open.writer.finish()
    }
}

/// Log message on how the run ended.
fn last_words(outcome: &Outcome) -> (Level, String) {
    match &outcome.ending {
        Ending::Finished => {
            (Level::Info, format!("finished at {} s after {} steps", outcome.time_s, outcome.steps))
        }
        Ending::Cancelled => {
            (Level::Warning, format!("cancelled at {} s after {} steps", outcome.time_s, outcome.steps))
        }
        Ending::Failed { failure } => (Level::Error, failure.to_string()),
    }
}

/// Adds the channels of the rigid body `index`, number `body` among all.
fn add_rigid_channels(
    writer: &mut RecordingWriter,
    plan: &Plan,
    (body, index): (usize, usize),
    name: &str,
) -> Result<RigidChannels, RecordError> {
    let pose = writer.add_channel(&format!("{}{name}", pose::TOPIC), pose::SCHEMA)?;
    let mesh = if plan.fields.is_empty() {
        None
    } else {
        let channel = writer.add_channel(&format!("{}{name}", scene_update::TOPIC), scene_update::SCHEMA)?;
        Some((channel, scene_update::RigidSurface::new(&plan.rigid_bodies()[index].shape)))
    };
    Ok(RigidChannels { body, pose, mesh })
}

/// Names of the bodies in topics: letters, digits, `_`, `-`, `.`; numbered if two would be the same.
pub(super) fn topic_names(bodies: &[PlanBody]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        let plain = |c: char| if c.is_alphanumeric() || "_-.".contains(c) { c } else { '_' };
        let name: String = body.name.chars().map(plain).collect();
        let is_taken = name.is_empty() || names.contains(&name);
        names.push(if is_taken { format!("{name}_{index}") } else { name });
    }
    names
}

impl Sink for McapRecorder {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        self.open = Some(self.open(plan)?);
        Ok(())
    }

    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        let open = self.open.as_mut().ok_or(RecordError::NotOpen)?;
        Ok(Self::write_frame(open, measured)?)
    }

    fn finish(&mut self, end: &MeasuredEnd) -> Result<(), RecorderError> {
        // Taken before anything can fail, so that a file that cannot be written is not retried on drop.
        let open = self.open.take().ok_or(RecordError::NotOpen)?;
        Ok(Self::close(open, end)?)
    }

    fn discard(&mut self) {
        if let Some(open) = self.open.take() {
            open.writer.discard();
        }
    }
}

impl Drop for McapRecorder {
    /// Last resort after a panic: closes the file, marked as incomplete.
    fn drop(&mut self) {
        let Some(mut open) = self.open.take() else { return };
        let (time, step) = open.latest;
        let metadata =
            ending_metadata(false, "interrupted", "the run was dropped before its end", time, step);
        let closed =
            open.writer.write_metadata(ENDING_METADATA, metadata).and_then(|()| open.writer.finish());
        if let Err(error) = closed {
            tracing::error!(path = %self.path.display(), %error, "a dropped recording could not be closed");
        }
    }
}
