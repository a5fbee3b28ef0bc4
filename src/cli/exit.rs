//! Exit codes and errors of commands.

use crate::mechanics::material::MaterialError;
use crate::scene::Problems;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

/// Exit codes of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// The command succeeded without reservations.
    Success = 0,
    /// Unexpected error: a full disk, a bug.
    Unexpected = 1,
    /// Invalid input: the scene, the material, the flags.
    InvalidInput = 2,
    /// The run failed with a diagnosis.
    RunFailed = 3,
    /// The run was cancelled.
    Cancelled = 4,
    /// The run finished, but its results are withheld: a check failed, or a law was used beyond the limits declared for it.
    Withheld = 5,
    /// `contuse worker --once`: the job returned to the queue, or another process has it.
    NotOver = 6,
    /// `contuse worker --once`: no job waits.
    NoJob = 7,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Output could not be written.
    #[error("cannot write the output")]
    Output(#[from] io::Error),
    /// An output file could not be written.
    #[error("cannot write {path}")]
    File {
        /// The file, as it was given on the command line.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// An input file could not be read.
    #[error("cannot read {path}")]
    Input {
        /// The file, as it was given on the command line.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The input is invalid.
    #[error(transparent)]
    Invalid(#[from] Problems),
    /// Invalid combination of flags.
    #[error("{0}")]
    Usage(String),
    /// A law has no stress at the requested deformation.
    #[error("{place}: {source}")]
    Material {
        /// JSON pointer to the question in the input.
        place: String,
        /// Error of the law.
        source: MaterialError,
    },
    /// A picture could not be drawn.
    #[error("cannot draw the picture: {0}")]
    Picture(String),
    /// Any other error, with its own message.
    #[error(transparent)]
    Other(#[from] Box<dyn std::error::Error + Send + Sync>),
}

impl CliError {
    /// Exit code for the error.
    pub fn exit(&self) -> Exit {
        match self {
            Self::Output(_) | Self::File { .. } | Self::Picture(_) | Self::Other(_) => Exit::Unexpected,
            Self::Material { source: MaterialError::NotConverged { .. }, .. } => Exit::RunFailed,
            Self::Input { .. } | Self::Invalid(_) | Self::Usage(_) | Self::Material { .. } => {
                Exit::InvalidInput
            }
        }
    }
    /// The message with its underlying causes, without repetition.
    pub fn in_full(&self) -> String {
        let mut text = self.to_string();
        let mut cause = std::error::Error::source(self);
        while let Some(reason) = cause {
            let said = reason.to_string();
            if !text.contains(&said) {
                text = format!("{text}: {said}");
            }
            cause = reason.source();
        }
        text
    }
    /// Whether the reader of the output has closed the pipe.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::RecordError;

    #[test]
    fn every_reason_is_reported_once() {
        let source = || io::Error::other("the disk is full");
        let silent = CliError::File { path: "a.csv".into(), source: source() };
        assert_eq!(silent.in_full(), "cannot write a.csv: the disk is full");
        let failure =
            crate::report::ReadError::File(RecordError::File { path: "a.mcap".into(), source: source() });
        assert_eq!(CliError::Other(Box::new(failure)).in_full(), "cannot read a.mcap: the disk is full");
    }
}
