//! The engine of the service: each run is a process, and so is the validation of whatever is large.

use super::child::{Child, Death, Heard};
use super::group::Groups;
use super::limits::{LIMITS_MEMORY, Limits};
use super::wire::{FromChild, Task, ToChild, Work};
use crate::blobs::{BlobError, Draft};
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::mesh::section::{Plane, Section};
use crate::scene::first_impact::{Approach, FirstScene};
use crate::scene::{Problem, Problems, problem::Pointer};
use crate::service::config::RunConfig;
use crate::service::jobs::control::{RunControl, StopReason};
use crate::service::jobs::engine::{
    CheckedScene, Engine, JsonDocument, MeshFile, Meshes, NOT_VALIDATED, NamedUpload, OpenMesh, RunOrder,
    RunReport, ScenePreview,
};
use crate::service::jobs::failures::{beyond_deadline, killed, out_of_memory, panic_elsewhere};
use crate::service::jobs::simulator::Simulator;
use crate::service::jobs::store::Event;
use crate::service::jobs::{JobKind, JobsError, Phase, Progress};
use crate::service::meshes::{MeshRefusal, MeshShelf, is_id};
use crate::service::shelves::result_name;
use crate::step::{Ending, Failure};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time between two looks at whether a run has to stop.
const LOOK_INTERVAL: Duration = Duration::from_millis(20);
/// Time that a run has to stop by itself; then its process is killed.
const STOP_TIME: Duration = Duration::from_secs(4);
/// Time between two attempts to start a process.
const START_INTERVAL: Duration = Duration::from_secs(1);
/// Processor time of a process beyond that of all its threads until the deadline [s].
const SPARE_CPU_S: u64 = 60;
/// Largest number of elements that the service validates itself, in a moment and in little memory.
const OWN_ELEMENTS: u64 = 4_000;
/// Time, and processor time, that a validation may take: a question tries its scene for each parameter.
const LONGEST_VALIDATION: Duration = Duration::from_secs(300);
/// Time, and processor time, that reading any mesh may take [s].
const LEAST_READING_S: u64 = 20;
/// Bytes of a mesh for each further second: a tenth of what is read on a slow processor.
const BYTES_PER_S: u64 = 1 << 20;
/// Memory that a validation may take beyond that of the largest run [bytes].
const SPARE_MEMORY: u64 = 1 << 30;

/// Runs jobs in processes of a program.
#[derive(Debug)]
pub struct ProcessEngine {
    /// For what needs no process.
    simulator: Simulator,
    program: PathBuf,
    runs: RunConfig,
    groups: Option<Groups>,
    /// One more than there are processes.
    alive: Arc<()>,
}

/// A process that ended without an answer.
struct Lost {
    death: Death,
    most_memory: u64,
    /// Time that it might take.
    within: Duration,
    is_late: bool,
    /// Whether anyone waits for it.
    is_wanted: bool,
}

/// For how long an answer is waited for.
struct Patience<'a> {
    within: Duration,
    is_wanted: &'a dyn Fn() -> bool,
}

impl ProcessEngine {
    /// An engine that starts `program`, which is this one, each time in a group of its own if there are `groups`.
    pub fn new(runs: &RunConfig, program: &Path, groups: Option<Groups>) -> Self {
        if !LIMITS_MEMORY {
            tracing::warn!(
                "this system does not limit the memory of a process: a run may take what it needs"
            );
        }
        Self {
            simulator: Simulator::new(runs),
            program: program.to_owned(),
            runs: runs.clone(),
            groups,
            alive: Arc::default(),
        }
    }

    /// A task with its limits: memory [bytes], processor time [s].
    fn task(&self, work: Work, memory_bytes: u64, cpu_s: u64) -> Task {
        Task { limits: Limits { memory_bytes, cpu_s }, runs: self.runs.clone(), work }
    }

    /// Has a process validate a document, and another one if the first is killed: where memory is short, the system chooses whom it meets.
    /// `answer` selects the answer.
    fn validate<T>(
        &self,
        work: Work,
        document: &JsonDocument,
        (meshes, is_wanted): (&MeshShelf, &dyn Fn() -> bool),
        answer: impl Fn(FromChild) -> Option<T>,
    ) -> Result<T, Lost> {
        let within = LONGEST_VALIDATION.min(self.runs.deadline);
        let patience = Patience { within, is_wanted };
        let ask = |work| {
            let text = (document.text.len() as u64, &mut &*document.text as &mut dyn Read);
            self.ask(work, text, Some(meshes), &patience, &answer)
        };
        ask(work.clone()).or_else(|lost| if lost.was_killed() { ask(work) } else { Err(lost) })
    }

    /// Has a process read a mesh. `answer` selects the answer.
    fn read_mesh<T>(
        &self,
        work: Work,
        file: MeshFile<'_>,
        answer: impl Fn(FromChild) -> Option<Result<T, MeshRefusal>>,
    ) -> Result<T, MeshRefusal> {
        let MeshFile { content, bytes, is_wanted, .. } = file;
        let within = Duration::from_secs(LEAST_READING_S + bytes / BYTES_PER_S).min(self.runs.deadline);
        let asked = self.ask(work, (bytes, content), None, &Patience { within, is_wanted }, answer);
        asked.unwrap_or_else(|lost| {
            let refusal = if lost.was_killed() { MeshRefusal::Lost } else { MeshRefusal::Invalid };
            Err(refusal(lost.words()))
        })
    }

    /// Has a process do something, with its bytes, until its time is over or no one waits for it.
    fn ask<T>(
        &self,
        work: Work,
        (count, bytes): (u64, &mut dyn Read),
        meshes: Option<&MeshShelf>,
        Patience { within, is_wanted }: &Patience<'_>,
        answer: impl Fn(FromChild) -> Option<T>,
    ) -> Result<T, Lost> {
        let most_memory = self.runs.budget.memory_bytes.saturating_add(SPARE_MEMORY);
        let mut lost =
            Lost { death: Death::default(), most_memory, within: *within, is_late: false, is_wanted: true };
        let mut child = match Child::start(&self.program, &self.alive) {
            Ok(child) => child,
            Err(error) => {
                tracing::error!(%error, "a validation has no process");
                return Err(lost);
            }
        };
        let began = Instant::now();
        let task = self.task(work, most_memory, within.as_secs().max(1));
        let begun = child.begin(&task, (count, bytes), None, self.groups.as_ref());
        while begun.is_ok() {
            match child.hear(LOOK_INTERVAL) {
                Heard::Message(message, _) => match (*message, meshes) {
                    (FromChild::Mesh { name, limit }, Some(meshes)) => {
                        if give_mesh(&mut child, meshes, &name, limit).is_err() {
                            break;
                        }
                    }
                    (message, _) => match answer(message) {
                        Some(answer) => return Ok(answer),
                        None => break,
                    },
                },
                Heard::Nothing => {
                    (lost.is_late, lost.is_wanted) = (began.elapsed() > *within, is_wanted());
                    if lost.is_late || !lost.is_wanted {
                        break;
                    }
                }
                Heard::End => break,
            }
        }
        lost.death = child.end();
        lost.is_late |= lost.death.is_out_of_time();
        Err(lost)
    }

    /// A process for a run; waits until the system has one. `None` if the run has to stop before.
    fn child(&self, control: &RunControl) -> Option<Child> {
        loop {
            match Child::start(&self.program, &self.alive) {
                Ok(child) => return Some(child),
                Err(error) => tracing::error!(%error, "a run has no process, and waits for one"),
            }
            let waiting = Instant::now();
            while waiting.elapsed() < START_INTERVAL {
                control.interrupt().is_none().then_some(())?;
                std::thread::sleep(LOOK_INTERVAL);
            }
        }
    }
}

impl Engine for ProcessEngine {
    fn processes(&self) -> u64 {
        Arc::strong_count(&self.alive) as u64 - 1
    }

    fn elements(&self, kind: JobKind, document: &JsonDocument, meshes: &MeshShelf) -> u64 {
        self.simulator.elements(kind, document, meshes)
    }

    fn check(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &MeshShelf,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<CheckedScene, Problems> {
        if self.elements(kind, document, meshes) <= OWN_ELEMENTS {
            return self.simulator.check(kind, document, meshes, is_wanted);
        }
        let answer = |message| match message {
            FromChild::Checked(checked) => Some(checked),
            _ => None,
        };
        self.validate(Work::Check { kind }, document, (meshes, is_wanted), answer)
            .unwrap_or_else(Lost::refuse)
    }

    fn preview(
        &self,
        scene: &JsonDocument,
        with_geometry: bool,
        meshes: &MeshShelf,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<ScenePreview, Problems> {
        if self.elements(JobKind::Simulation, scene, meshes) <= OWN_ELEMENTS {
            return self.simulator.preview(scene, with_geometry, meshes, is_wanted);
        }
        let answer = |message| match message {
            FromChild::Previewed(preview) => Some(preview.map(|preview| *preview)),
            _ => None,
        };
        self.validate(Work::Preview { with_geometry }, scene, (meshes, is_wanted), answer)
            .unwrap_or_else(Lost::refuse)
    }

    fn run(&self, mut order: RunOrder<'_>) -> Result<RunReport, Failure> {
        let run = Conversation {
            reached: Progress::beginning(Phase::Loading),
            stopping: None,
            most_memory: order.most_memory,
        };
        let Some(mut child) = self.child(order.control) else { return run.stopped(order.control) };
        let threads =
            if order.kind == JobKind::WhatIf { self.runs.threads_per_what_if } else { order.threads };
        let work =
            Work::Run { kind: order.kind, recording: order.recording.to_owned(), threads: order.threads };
        let cpu_s = self.runs.deadline.as_secs().saturating_mul(threads as u64) + SPARE_CPU_S;
        let task = self.task(work, order.most_memory, cpu_s);
        let text = (order.document.len() as u64, &mut &*order.document as &mut dyn Read);
        // A process that does not take its task has ended, which is found below.
        let begun = child.begin(&task, text, Some(order.job), self.groups.as_ref());
        tracing::debug!(job = %order.job, is_begun = begun.is_ok(), "a process has the run");
        run.hold(child, &mut order)
    }

    fn mend_recording(&self, recording: &Path) -> Result<(), JobsError> {
        self.simulator.mend_recording(recording)
    }

    fn snapshot(&self, recording: &Path, target: &Path) -> Result<(), String> {
        self.simulator.snapshot(recording, target)
    }

    fn inspect_mesh(&self, file: MeshFile<'_>) -> Result<(MeshFormat, MeshReport), MeshRefusal> {
        self.read_mesh(Work::Inspect { format: file.format }, file, |message| match message {
            FromChild::Inspected(inspected) => Some(inspected),
            _ => None,
        })
    }

    fn first_scene(
        &self,
        file: MeshFile<'_>,
        uploads: &[NamedUpload],
        approach: &Approach,
    ) -> Result<FirstScene, MeshRefusal> {
        let (uploads, approach) = (uploads.to_vec(), approach.clone());
        let work = Work::FirstScene { format: file.format, uploads, approach };
        self.read_mesh(work, file, |message| match message {
            FromChild::Begun(begun) => Some(begun.map(|scene| *scene)),
            _ => None,
        })
    }

    fn section(&self, file: MeshFile<'_>, plane: Plane) -> Result<Section, MeshRefusal> {
        self.read_mesh(Work::Section { format: file.format, plane }, file, |message| match message {
            FromChild::Cut(section) => Some(section),
            _ => None,
        })
    }
}

impl Lost {
    /// Whether someone else killed it.
    fn was_killed(&self) -> bool {
        self.is_wanted && !self.is_late && !self.death.was_refused_memory && self.death.is_by_kill()
    }

    fn words(&self) -> String {
        if self.death.was_refused_memory {
            format!("reading it takes more than {} MB of memory", self.most_memory / 1_000_000)
        } else if self.is_late {
            format!("reading it takes more than {} s", self.within.as_secs())
        } else {
            format!("its validation was lost: {}", self.death.how())
        }
    }

    /// The problem of a scene that could not be validated.
    fn refuse<T>(self) -> Result<T, Problems> {
        if self.is_wanted {
            tracing::error!(how = self.death.how(), "a validation was lost");
        }
        let code = if self.was_killed() { NOT_VALIDATED } else { "too_expensive" };
        let problem = Problem::error(code, &Pointer::root(), self.words());
        Err(problem.remedy("take fewer or larger elements; if that does not help, report it").alone())
    }
}

/// The exchange with the process of a run.
struct Conversation {
    reached: Progress,
    /// When the process was asked to stop.
    stopping: Option<Instant>,
    most_memory: u64,
}

impl Conversation {
    /// Answers the process until it ends.
    fn hold(mut self, mut child: Child, order: &mut RunOrder<'_>) -> Result<RunReport, Failure> {
        loop {
            match child.hear(LOOK_INTERVAL) {
                Heard::Message(message, bytes) => match *message {
                    FromChild::Ran(result) => return result,
                    FromChild::Panicked => return Err(panic_elsewhere()),
                    message => {
                        if let Err(error) = self.answer(&mut child, order, message, &bytes) {
                            // The end of the process, which is found next, is why.
                            tracing::debug!(job = %order.job, %error, "a run takes no answer");
                        }
                    }
                },
                Heard::Nothing => {}
                Heard::End => return self.lost(&child.end(), order.control),
            }
            if order.control.interrupt().is_some() && !self.stop(&mut child, order.control) {
                tracing::warn!(job = %order.job, "a run did not stop in time, and is killed");
                drop(child);
                return self.stopped(order.control);
            }
        }
    }

    fn answer(
        &mut self,
        child: &mut Child,
        order: &mut RunOrder<'_>,
        message: FromChild,
        bytes: &[u8],
    ) -> io::Result<()> {
        match message {
            FromChild::Progress(progress) => {
                self.reached = progress;
                (order.progress)(progress);
                Ok(())
            }
            FromChild::Event { kind, data } => {
                (order.emit)(&Event { kind: &kind, data });
                Ok(())
            }
            FromChild::Mesh { name, limit } => give_mesh(child, order.meshes, &name, limit),
            FromChild::Result { key } => {
                let found = result(order, &key);
                let (is_found, bytes) = (found.is_some(), found.unwrap_or_default());
                child.send(&ToChild::Result(is_found), (bytes.len() as u64, &mut bytes.as_slice()))
            }
            FromChild::KeepResult { key } => {
                let kept = keep_result(order, &key, bytes);
                if let Err(error) = &kept {
                    tracing::warn!(job = %order.job, %error, "a result cannot be kept");
                }
                child.send(&ToChild::Result(kept.is_ok()), (0, &mut io::empty()))
            }
            _ => Err(io::Error::other("an answer that was not requested")),
        }
    }

    /// Asks the process to stop; false if it was asked long ago.
    fn stop(&mut self, child: &mut Child, control: &RunControl) -> bool {
        if let Some(requested) = self.stopping {
            return requested.elapsed() < STOP_TIME;
        }
        self.stopping = Some(Instant::now());
        let Some(reason) = control.reason() else { return true };
        // A process that does not listen is killed in time.
        drop(child.send(&ToChild::Stop(reason), (0, &mut io::empty())));
        true
    }

    /// How a run ends whose process has ended without a report.
    fn lost(self, death: &Death, control: &RunControl) -> Result<RunReport, Failure> {
        if control.reason().is_some() {
            return self.stopped(control);
        }
        if death.is_out_of_time() {
            return Err(beyond_deadline());
        }
        Err(if death.was_refused_memory { out_of_memory(self.most_memory) } else { killed(&death.how()) })
    }

    /// How a run ends that had to stop.
    fn stopped(self, control: &RunControl) -> Result<RunReport, Failure> {
        match control.reason() {
            Some(StopReason::Deadline) => Err(beyond_deadline()),
            _ => Ok(RunReport { ending: Ending::Cancelled, summary: None, progress: self.reached }),
        }
    }
}

/// Sends a mesh to a process.
fn give_mesh(child: &mut Child, meshes: &dyn Meshes, name: &str, limit: u64) -> io::Result<()> {
    match meshes.open(name, limit) {
        Ok(OpenMesh { file_name, bytes, mut content }) => {
            child.send(&ToChild::Mesh(Ok(file_name)), (bytes, &mut content))
        }
        Err(error) => child.send(&ToChild::Mesh(Err(error)), (0, &mut io::empty())),
    }
}

/// The result with a key, which is noted as used. One that cannot be read is computed again.
fn result(order: &RunOrder<'_>, key: &str) -> Option<Vec<u8>> {
    is_id(key).then_some(())?;
    (order.note_result)(key);
    let mut bytes = Vec::new();
    order.blobs.open(&result_name(key)).ok()??.read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

fn keep_result(order: &RunOrder<'_>, key: &str, bytes: &[u8]) -> Result<(), BlobError> {
    if !is_id(key) {
        return Err(BlobError::of("a result")(io::ErrorKind::InvalidInput.into()));
    }
    let mut draft = Draft::new(order.blobs.unnamed()?, u64::MAX);
    draft.append(bytes)?;
    draft.keep(&result_name(key)).map(drop)
}
