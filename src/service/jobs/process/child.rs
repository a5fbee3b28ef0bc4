//! The process of a run, as the service sees it.

use super::group::{Group, Groups};
use super::pipe::Pipe;
use super::wire::{self, FromChild, Task, ToChild};
use crate::service::jobs::JobId;
use serde::Serialize;
#[cfg(unix)]
use signal_hook::consts::{SIGKILL, SIGXCPU};
use std::io::{self, BufRead, BufReader, BufWriter, Read};
use std::path::Path;
use std::process::{ChildStderr, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Messages that wait for the service; then the process waits.
const WAITING: usize = 64;
/// Time within which a process takes some of what is sent to it.
const PATIENCE: Duration = Duration::from_secs(20);
/// Longest line of the log that is forwarded [bytes].
const LONGEST_LINE: u64 = 4096;
/// Beginning of the last words of a process that was refused memory, as the standard library of Rust writes them.
const REFUSED_MEMORY: &str = "memory allocation of";

/// A process that waits for its task, does it, or has ended. Dropped, it is killed.
pub(super) struct Child {
    process: std::process::Child,
    input: BufWriter<Pipe>,
    /// Why it was ended, if its input failed.
    broken: Option<String>,
    messages: Receiver<(FromChild, Vec<u8>)>,
    log: Arc<Log>,
    logging: Option<JoinHandle<()>>,
    _alive: Arc<()>,
    /// Removed after its process has ended.
    group: Option<Group>,
}

/// What a process writes to its standard error.
#[derive(Debug, Default)]
struct Log {
    job: OnceLock<JobId>,
    was_refused_memory: Mutex<bool>,
}

/// What came from a process.
pub(super) enum Heard {
    /// A message with its bytes.
    Message(Box<FromChild>, Vec<u8>),
    /// No message within the time that was waited for one.
    Nothing,
    /// The process ended, or breaks the protocol.
    End,
}

/// How a process ended.
#[derive(Debug, Default)]
pub(super) struct Death {
    /// Status, if the system gave it.
    pub status: Option<ExitStatus>,
    /// Whether it was refused memory.
    pub was_refused_memory: bool,
    /// Why the service ended it, if its input failed.
    pub broken: Option<String>,
}

impl Death {
    /// How the process ended, as text.
    pub fn how(&self) -> String {
        let status =
            || self.status.map_or_else(|| "its end is unknown".to_owned(), |status| status.to_string());
        self.broken.clone().unwrap_or_else(status)
    }

    /// Whether it took more processor time than it may.
    #[cfg(unix)]
    pub fn is_out_of_time(&self) -> bool {
        self.signal() == Some(SIGXCPU)
    }

    /// Whether it was killed, and not because its input failed.
    #[cfg(unix)]
    pub fn is_by_kill(&self) -> bool {
        self.broken.is_none() && self.signal() == Some(SIGKILL)
    }

    #[cfg(unix)]
    fn signal(&self) -> Option<i32> {
        use std::os::unix::process::ExitStatusExt as _;
        self.status?.signal()
    }

    #[cfg(not(unix))]
    pub fn is_out_of_time(&self) -> bool {
        false
    }

    #[cfg(not(unix))]
    pub fn is_by_kill(&self) -> bool {
        false
    }
}

/// Variable of glibc: the size from which an allocation is a mapping of its own [bytes].
pub const MMAP_THRESHOLD: &str = "MALLOC_MMAP_THRESHOLD_";
/// Beginnings of the names of environment variables that a run does not get: secrets, and how the service allocates.
const NOT_FOR_RUNS: [&str; 5] = ["AWS_", "PG", "CONTUSE_DATABASE", "CONTUSE_BLOBS", MMAP_THRESHOLD];

impl Child {
    /// Starts a process that waits for its task, and counts as `alive` until it has ended.
    pub fn start(program: &Path, alive: &Arc<()>) -> io::Result<Self> {
        let mut command = Command::new(program);
        command.arg("job-process").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // A run reads what a client wrote, and needs no access to the stores.
        for (name, _) in std::env::vars_os() {
            if NOT_FOR_RUNS.iter().any(|start| name.as_encoded_bytes().starts_with(start.as_bytes())) {
                command.env_remove(name);
            }
        }
        // A Ctrl-C in a terminal is for the service, which stops its runs in order.
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt as _;
            command.arg0("contuse").process_group(0);
        }
        let mut process = command.spawn()?;
        let missing = || io::Error::other("a process without pipes");
        let input = BufWriter::new(Pipe::new(process.stdin.take().ok_or_else(missing)?, PATIENCE)?);
        let (output, errors) = (process.stdout.take(), process.stderr.take());
        let (output, errors) = (output.ok_or_else(missing)?, errors.ok_or_else(missing)?);
        let (sender, messages) = sync_channel(WAITING);
        let log = Arc::new(Log::default());
        let heard = Arc::clone(&log);
        std::thread::Builder::new().name("run-messages".into()).spawn(move || receive(output, &sender))?;
        let logging =
            std::thread::Builder::new().name("run-log".into()).spawn(move || heard.forward(errors))?;
        Ok(Self {
            process,
            input,
            broken: None,
            messages,
            log,
            logging: Some(logging),
            _alive: Arc::clone(alive),
            group: None,
        })
    }

    /// Gives the process its task with its bytes, of a job or of none, in a group if there are any.
    pub fn begin(
        &mut self,
        task: &Task,
        (count, bytes): (u64, &mut dyn Read),
        job: Option<JobId>,
        groups: Option<&Groups>,
    ) -> io::Result<()> {
        if let Some(groups) = groups {
            self.join(groups, task.limits.memory_bytes)?;
        }
        if let Some(job) = job {
            // A process has one task.
            let _ = self.log.job.set(job);
        }
        self.write(task, (count, bytes))
    }

    /// Puts the process into a group of its own; without it, it ends.
    fn join(&mut self, groups: &Groups, memory_bytes: u64) -> io::Result<()> {
        match groups.group(self.process.id(), memory_bytes) {
            Ok(group) => {
                self.group = Some(group);
                Ok(())
            }
            Err(error) => {
                tracing::error!(%error, "a process has no group, and is ended");
                self.reap();
                Err(error)
            }
        }
    }

    /// Sends a message with its bytes.
    pub fn send(&mut self, message: &ToChild, bytes: (u64, &mut dyn Read)) -> io::Result<()> {
        self.write(message, bytes)
    }

    /// Writes a message with its bytes. Without all of it the process would wait for ever, and is ended.
    fn write(&mut self, message: &impl Serialize, (count, bytes): (u64, &mut dyn Read)) -> io::Result<()> {
        wire::write(&mut self.input, message, count, bytes).inspect_err(|error| {
            self.broken = match error.kind() {
                // It has ended by itself.
                io::ErrorKind::BrokenPipe => return,
                io::ErrorKind::TimedOut => {
                    Some(format!("it took none of its input for {} s", PATIENCE.as_secs()))
                }
                _ => Some(format!("its input failed: {error}")),
            };
            let _ = self.process.kill();
        })
    }

    /// Waits for a message.
    pub fn hear(&self, within: Duration) -> Heard {
        match self.messages.recv_timeout(within) {
            Ok((message, bytes)) => Heard::Message(Box::new(message), bytes),
            Err(RecvTimeoutError::Timeout) => Heard::Nothing,
            Err(RecvTimeoutError::Disconnected) => Heard::End,
        }
    }

    /// Ends the process, if it has not ended, and says how it did.
    pub fn end(mut self) -> Death {
        let status = self.reap();
        if let Some(logging) = self.logging.take() {
            // It ends with the pipe, which no other process holds.
            let _ = logging.join();
        }
        let was_refused_memory = *self.log.was_refused_memory.lock().unwrap_or_else(PoisonError::into_inner)
            || self.group.as_ref().is_some_and(Group::was_refused_memory);
        Death { status, was_refused_memory, broken: self.broken.take() }
    }

    fn reap(&mut self) -> Option<ExitStatus> {
        // No effect on a process that has ended.
        let _ = self.process.kill();
        self.process.wait().ok()
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.reap();
    }
}

/// Receives messages until the process ends or breaks the protocol, or no one listens.
fn receive(output: ChildStdout, messages: &SyncSender<(FromChild, Vec<u8>)>) {
    let mut output = BufReader::new(output);
    loop {
        match wire::read(&mut output) {
            Ok(Some(message)) => {
                if messages.send(message).is_err() {
                    return;
                }
            }
            Ok(None) => return,
            Err(error) => {
                tracing::warn!(%error, "the process of a run was cut off");
                return;
            }
        }
    }
}

impl Log {
    /// Forwards lines to the log of the service, with the id of the job.
    fn forward(&self, errors: ChildStderr) {
        let mut errors = BufReader::new(errors);
        let mut line = Vec::new();
        while errors.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
            let text = String::from_utf8_lossy(&line);
            let text = text.trim();
            let job = self.job.get();
            if text.starts_with(REFUSED_MEMORY) {
                *self.was_refused_memory.lock().unwrap_or_else(PoisonError::into_inner) = true;
            }
            match text.split_once(' ') {
                Some(("ERROR", words)) => tracing::error!(job = job.map(tracing::field::display), "{words}"),
                Some(("WARN", words)) => tracing::warn!(job = job.map(tracing::field::display), "{words}"),
                Some(("INFO", words)) => tracing::info!(job = job.map(tracing::field::display), "{words}"),
                Some(("DEBUG" | "TRACE", words)) => {
                    tracing::debug!(job = job.map(tracing::field::display), "{words}");
                }
                _ if text.is_empty() => {}
                // Last words.
                _ => tracing::error!(job = job.map(tracing::field::display), "{text}"),
            }
            line.clear();
        }
    }
}
