//! Messages between the service and the process of a run: a line of JSON each, and the bytes that belong to it.

use super::limits::Limits;
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::mesh::section::{Plane, Section};
use crate::scene::first_impact::{Approach, FirstScene};
use crate::scene::{MeshSourceError, Problems};
use crate::service::config::RunConfig;
use crate::service::jobs::control::StopReason;
use crate::service::jobs::engine::{CheckedScene, NamedUpload, RunReport, ScenePreview};
use crate::service::jobs::{JobKind, Progress};
use crate::service::meshes::MeshRefusal;
use crate::step::Failure;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::{self, BufRead, Read, Write};
use std::path::PathBuf;

/// Longest line of a message [bytes]: a summary is the longest part of one.
const LONGEST_LINE: u64 = 256 << 20;

/// The first message to a process: its one task. The document, or the mesh, follows as bytes.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Task {
    /// Limits of the process.
    pub limits: Limits,
    /// Threads and limits of scenes and runs.
    pub runs: RunConfig,
    /// What it has to do.
    pub work: Work,
}

/// One call of an engine.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Work {
    /// Run a job of this kind into this recording, on so many threads.
    Run { kind: JobKind, recording: PathBuf, threads: usize },
    /// Validate the document of a job.
    Check { kind: JobKind },
    /// Validate a scene and preview its plan.
    Preview { with_geometry: bool },
    /// Read and check a mesh.
    Inspect { format: Option<MeshFormat> },
    /// Begin a scene of a mesh, or of surfaces one after the other.
    FirstScene { format: Option<MeshFormat>, uploads: Vec<NamedUpload>, approach: Approach },
    /// Cut a mesh by a plane.
    Section { format: Option<MeshFormat>, plane: Plane },
}

/// A message to a process after its task.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum ToChild {
    /// The run has to stop.
    Stop(StopReason),
    /// The mesh that it requested: its file name, and its content as bytes.
    Mesh(Result<String, MeshSourceError>),
    /// The result that it requested, as bytes; or the result was kept. False if there is none.
    Result(bool),
}

/// A message from a process.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum FromChild {
    /// How far the run is.
    Progress(Progress),
    /// A part of the result of the job.
    Event { kind: String, data: Value },
    /// It needs a mesh of at most so many bytes.
    Mesh { name: String, limit: u64 },
    /// It needs the result with a key.
    Result { key: String },
    /// It has computed the result with a key, which follows as bytes.
    KeepResult { key: String },
    /// The run ended, as its report says, or could not begin.
    Ran(Result<RunReport, Failure>),
    /// The document was validated.
    Checked(Result<CheckedScene, Problems>),
    /// The scene was validated.
    Previewed(Result<Box<ScenePreview>, Problems>),
    /// The mesh was read.
    Inspected(Result<(MeshFormat, MeshReport), MeshRefusal>),
    /// The scene was begun.
    Begun(Result<Box<FirstScene>, MeshRefusal>),
    /// The mesh was cut.
    Cut(Result<Section, MeshRefusal>),
    /// The call panicked: this job fails, and no other.
    Panicked,
}

/// Writes a message and the bytes that belong to it, of which there are `count`.
pub(super) fn write(
    output: &mut impl Write,
    message: &impl Serialize,
    count: u64,
    bytes: &mut dyn Read,
) -> io::Result<()> {
    let mut line = serde_json::to_vec(&(message, count))?;
    line.push(b'\n');
    output.write_all(&line)?;
    if io::copy(&mut bytes.take(count), output)? != count {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "fewer bytes than announced"));
    }
    output.flush()
}

/// Reads a message and the bytes that belong to it; `None` at the end of the input.
pub(super) fn read<T: DeserializeOwned>(input: &mut impl BufRead) -> io::Result<Option<(T, Vec<u8>)>> {
    let mut line = Vec::new();
    input.take(LONGEST_LINE).read_until(b'\n', &mut line)?;
    if line.is_empty() {
        return Ok(None);
    }
    let (message, count): (T, u64) = serde_json::from_slice(&line)?;
    let mut bytes = Vec::new();
    if input.take(count).read_to_end(&mut bytes)? as u64 != count {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(Some((message, bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::jobs::Phase;

    #[test]
    fn messages_and_their_bytes_are_read_back_in_order() {
        let progress = Progress::beginning(Phase::Stepping);
        let mut pipe = Vec::new();
        write(&mut pipe, &FromChild::Progress(progress), 0, &mut io::empty()).unwrap();
        write(&mut pipe, &FromChild::KeepResult { key: "a".into() }, 3, &mut &b"\n{}"[..]).unwrap();
        let mut input = pipe.as_slice();
        let (first, bytes) = read::<FromChild>(&mut input).unwrap().unwrap();
        assert!(matches!(first, FromChild::Progress(read) if read == progress) && bytes.is_empty());
        let (second, bytes) = read::<FromChild>(&mut input).unwrap().unwrap();
        assert!(matches!(second, FromChild::KeepResult { key } if key == "a"));
        assert_eq!(bytes, b"\n{}");
        assert!(read::<FromChild>(&mut input).unwrap().is_none());
    }

    #[test]
    fn what_is_cut_off_is_an_error() {
        let mut pipe = Vec::new();
        write(&mut pipe, &ToChild::Result(true), 3, &mut &b"abc"[..]).unwrap();
        for length in 1..pipe.len() {
            assert!(read::<ToChild>(&mut &pipe[..length]).is_err(), "{length}");
        }
        assert!(write(&mut Vec::new(), &ToChild::Result(true), 4, &mut &b"abc"[..]).is_err());
    }
}
