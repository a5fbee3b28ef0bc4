//! The process of a run: does one task, and ends.

use super::host::{Host, HostMeshes, HostResults};
use super::limits;
use super::wire::{self, FromChild, Task, ToChild, Work};
use crate::blobs::BlobStore;
use crate::mesh::read::MeshFormat;
use crate::scene::Problems;
use crate::service::jobs::control::RunControl;
use crate::service::jobs::engine::{Engine, JsonDocument, MeshFile, RunOrder, RunReport, not_json};
use crate::service::jobs::simulator::Simulator;
use crate::service::jobs::store::Event;
use crate::service::jobs::{JobId, JobKind, Progress, Stage};
use crate::step::Failure;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

/// Least time between two reports of progress.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Does the task that `input` holds and writes its messages to `output`; nothing if `input` ends before. A process whose service is
/// lost ends with it.
///
/// # Errors
/// If the pipes fail, or the limits cannot be set.
pub fn serve_one(input: impl Read + Send + 'static, output: impl Write + Send + 'static) -> io::Result<()> {
    let mut input = BufReader::new(input);
    let Some((task, bytes)) = wire::read::<Task>(&mut input)? else { return Ok(()) };
    limits::prefer_for_killing();
    limits::apply(task.limits)?;
    // Clients wait for everything else.
    if matches!(task.work, Work::Run { .. }) {
        limits::yield_to_requests()?;
    }
    // The service has the deadline.
    let control = Arc::new(RunControl::new(Duration::MAX));
    let (sender, answers) = channel();
    let host = Arc::new(Host::new(Box::new(output), answers));
    let heard = Arc::clone(&control);
    std::thread::Builder::new().name("service".into()).spawn(move || listen(&mut input, &heard, &sender))?;
    let worked = catch_unwind(AssertUnwindSafe(|| work(&task, bytes, &host, &control)));
    host.send(&worked.unwrap_or(FromChild::Panicked), &[])
}

/// Receives messages until the service is gone, and then ends the process: no one wants its result.
fn listen(input: &mut impl BufRead, control: &RunControl, answers: &Sender<(ToChild, Vec<u8>)>) {
    loop {
        match wire::read(input) {
            Ok(Some((ToChild::Stop(reason), _))) => control.stop(reason),
            // No one waits for an answer after the end.
            Ok(Some(answer)) => drop(answers.send(answer)),
            Ok(None) | Err(_) => std::process::exit(1),
        }
    }
}

fn work(task: &Task, bytes: Vec<u8>, host: &Arc<Host>, control: &RunControl) -> FromChild {
    let simulator = Simulator::new(&task.runs);
    let meshes = HostMeshes(Arc::clone(host));
    match &task.work {
        Work::Run { kind, recording, threads } => {
            let run =
                Run { kind: *kind, recording, threads: *threads, most_memory: task.limits.memory_bytes };
            FromChild::Ran(run.with(&simulator, &bytes, host, control))
        }
        Work::Check { kind } => FromChild::Checked(
            document(bytes).and_then(|document| simulator.check_on(*kind, &document, &meshes)),
        ),
        Work::Preview { with_geometry } => FromChild::Previewed(
            document(bytes)
                .and_then(|scene| simulator.preview_on(&scene, *with_geometry, &meshes))
                .map(Box::new),
        ),
        Work::Inspect { format } => {
            FromChild::Inspected(simulator.inspect_mesh(whole(&mut bytes.as_slice(), *format)))
        }
        Work::FirstScene { format, uploads, approach } => {
            let begun = simulator.first_scene(whole(&mut bytes.as_slice(), *format), uploads, approach);
            FromChild::Begun(begun.map(Box::new))
        }
        Work::Section { format, plane } => {
            FromChild::Cut(simulator.section(whole(&mut bytes.as_slice(), *format), *plane))
        }
    }
}

/// A file that was received completely; the service ends a process whose answer no one waits for.
fn whole<'a>(bytes: &'a mut &[u8], format: Option<MeshFormat>) -> MeshFile<'a> {
    MeshFile { bytes: bytes.len() as u64, content: bytes, format, is_wanted: &|| true }
}

/// Reads a document, which the service has read before.
fn document(text: Vec<u8>) -> Result<JsonDocument, Problems> {
    JsonDocument::read(text.into()).map_err(|error| not_json(&error))
}

/// The run of a job.
struct Run<'a> {
    kind: JobKind,
    recording: &'a Path,
    threads: usize,
    most_memory: u64,
}

impl Run<'_> {
    fn with(
        &self,
        simulator: &Simulator,
        document: &[u8],
        host: &Arc<Host>,
        control: &RunControl,
    ) -> Result<RunReport, Failure> {
        let mut last: Option<(Instant, Stage)> = None;
        let mut progress = |p: Progress| {
            if last.is_none_or(|(at, stage)| at.elapsed() >= PROGRESS_INTERVAL || stage != p.stage()) {
                last = Some((Instant::now(), p.stage()));
                // A service that is gone ends the process.
                drop(host.send(&FromChild::Progress(p), &[]));
            }
        };
        let mut emit = |event: &Event<'_>| {
            let message = FromChild::Event { kind: event.kind.to_owned(), data: event.data.clone() };
            drop(host.send(&message, &[]));
        };
        let blobs: Arc<dyn BlobStore> = Arc::new(HostResults(Arc::clone(host)));
        simulator.run(RunOrder {
            job: JobId::nil(),
            kind: self.kind,
            document,
            most_memory: self.most_memory,
            meshes: &HostMeshes(Arc::clone(host)),
            recording: self.recording,
            threads: self.threads,
            control,
            progress: &mut progress,
            emit: &mut emit,
            blobs: &blobs,
            // The service notes what the process asks for.
            note_result: Arc::new(|_| {}),
        })
    }
}
