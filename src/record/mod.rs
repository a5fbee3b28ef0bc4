//! Recorders: MCAP files, series of VTK files, memory.
//!
//! [`mcap`] writes the recording that readers open: one file per topic makes its messages ([`contact`], [`energy`],
//! [`stress`], [`scene_update`], [`point_cloud`], [`pose`], [`reference`], [`log`], [`summary`]), and [`proto`] is
//! their contract. [`reader`] reads a recording, however damaged, and [`salvage`] repairs what a killed writer left.
//! [`vtk`] writes the same messages for ParaView. [`contact_problems`] saves the contact problems of a run. [`on_own_thread`] runs any recorder without delaying the
//! steps.

pub mod colour;
pub mod contact;
pub mod contact_problem_file;
pub mod contact_problems;
pub mod energy;
pub mod log;
pub mod mcap;
pub mod memory;
pub mod metadata;
mod own_thread;
pub mod packed;
mod partial_file;
pub mod point_cloud;
pub mod pose;
pub mod proto;
pub mod reader;
pub mod reference;
pub mod salvage;
pub mod scene_update;
pub mod stress;
pub mod summary;
pub mod vtk;
mod writer;

pub use contact_problem_file::{NamedContactProblem, contact_problem_document, read_contact_problem};
pub use contact_problems::ContactProblemRecorder;
pub use mcap::McapRecorder;
pub use memory::MemoryRecorder;
pub use metadata::RecordingInfo;
pub use own_thread::on_own_thread;
pub use partial_file::is_what_was_found;
pub use salvage::{Salvaged, reindex_incomplete, snapshot};
pub use vtk::VtuRecorder;
pub use writer::{TimeScale, partial_path};

use std::path::PathBuf;

/// Why a recording could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Error of the file system.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// The file that could not be read or written.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Another run has the file open for its recording.
    #[error("{path} is being written by another run: name another file", path = path.display())]
    InUse {
        /// The file that is in use.
        path: PathBuf,
    },
    /// Error of the MCAP writer or reader.
    #[error(transparent)]
    Mcap(#[from] ::mcap::McapError),
    /// A document could not be serialised.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// The embedded schemas are not those that the program expects: a defect of the build.
    #[error("the schema {0} is missing from the descriptors")]
    MissingSchema(String),
    /// The recorder was used before it was started, or after it was finished.
    #[error("the recording is not open")]
    NotOpen,
    /// A message contradicts itself or the mesh: the file is damaged, or another program wrote it.
    #[error("{topic}: {reason}")]
    Unusable {
        /// Topic of the message.
        topic: String,
        /// What is wrong with it.
        reason: String,
    },
    /// There is nothing to show: no field was requested.
    #[error("the recording has no fields: name some in `record.fields` of the scene and run it again")]
    NoFields,
}

impl RecordError {
    /// The error of the operating system, if it is one.
    ///
    /// # Errors
    /// Any other error.
    pub fn into_io(self) -> Result<std::io::Error, Self> {
        match self {
            Self::File { source, .. } | Self::Mcap(::mcap::McapError::Io(source)) => Ok(source),
            other => Err(other),
        }
    }
}

impl From<RecordError> for crate::step::RecorderError {
    fn from(error: RecordError) -> Self {
        Self(Box::new(error))
    }
}
