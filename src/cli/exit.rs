//! How a command ends.

use crate::mechanics::material::MaterialError;
use crate::scene::Problems;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

/// Exit codes of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All went well.
    Success = 0,
    /// Something unexpected: a disk that is full, a bug.
    Unexpected = 1,
    /// The input is invalid: the scene, the material, the flags.
    InvalidInput = 2,
    /// The run failed with a diagnosis.
    RunFailed = 3,
    /// The run was cancelled.
    Cancelled = 4,
    /// The run came to its end, but its results are withheld: a gate failed, or a law was beyond its limits.
    Withheld = 5,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a command did not do what was asked.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Output could not be written.
    #[error("cannot write the output")]
    Output(#[from] io::Error),
    /// An output file could not be written.
    #[error("cannot write {path}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// An input file could not be read.
    #[error("cannot read {path}")]
    Input {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The input is invalid.
    #[error(transparent)]
    Invalid(#[from] Problems),
    /// Flags that do not go together.
    #[error("{0}")]
    Usage(String),
    /// A law has no stress to give there.
    #[error("{place}: {source}")]
    Material {
        /// Pointer to the question in the input.
        place: String,
        /// Why.
        source: MaterialError,
    },
    /// A picture could not be drawn.
    #[error("cannot draw the picture: {0}")]
    Picture(String),
    /// Anything else.
    #[error(transparent)]
    Other(#[from] Box<dyn std::error::Error + Send + Sync>),
}

impl CliError {
    /// The exit code that belongs to it.
    pub fn exit(&self) -> Exit {
        match self {
            Self::Output(_) | Self::File { .. } | Self::Picture(_) | Self::Other(_) => Exit::Unexpected,
            Self::Material { source: MaterialError::NotConverged { .. }, .. } => Exit::RunFailed,
            Self::Input { .. } | Self::Invalid(_) | Self::Usage(_) | Self::Material { .. } => {
                Exit::InvalidInput
            }
        }
    }
    /// The message with the reasons behind it, each told once.
    pub fn in_full(&self) -> String {
        let mut text = self.to_string();
        let mut cause = std::error::Error::source(self);
        while let Some(reason) = cause {
            let told = reason.to_string();
            if !text.contains(&told) {
                text = format!("{text}: {told}");
            }
            cause = reason.source();
        }
        text
    }
    /// Whether the reader of the output has gone.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::RecordError;

    #[test]
    fn every_reason_is_told_once() {
        let source = || io::Error::other("the disk is full");
        let silent = CliError::File { path: "a.csv".into(), source: source() };
        assert_eq!(silent.in_full(), "cannot write a.csv: the disk is full");
        let told =
            crate::report::ReadError::File(RecordError::File { path: "a.mcap".into(), source: source() });
        assert_eq!(CliError::Other(Box::new(told)).in_full(), "cannot read a.mcap: the disk is full");
    }
}
