//! What is said of scenes that were judged and of runs that ended: by engines, and kept in the job store.

use super::{JobFailure, JobState};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Something that is wrong, or odd, in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SceneProblem {
    /// `error` or `warning`.
    pub severity: String,
    /// Kind of the problem, stable, for programs.
    pub code: String,
    /// Where in the document, as a JSON pointer (RFC 6901); empty for the whole document.
    pub pointer: String,
    /// What is wrong.
    pub message: String,
    /// The value found; null when there is none.
    pub value: serde_json::Value,
    /// What the value must keep to.
    pub limit: String,
    /// What to do about it.
    pub remedy: String,
}

impl SceneProblem {
    /// An error about the document as a whole.
    pub fn of_document(message: &str) -> Self {
        Self {
            severity: "error".into(),
            code: "not_compilable".into(),
            pointer: String::new(),
            message: message.to_owned(),
            value: serde_json::Value::Null,
            limit: String::new(),
            remedy: String::new(),
        }
    }
}

/// The ways a run ends.
#[derive(Clone, Debug, PartialEq)]
pub enum RunEnding {
    /// It reached the end time.
    Finished,
    /// It was stopped.
    Stopped,
    /// It went wrong, and this is why.
    Failed(JobFailure),
}

impl RunEnding {
    /// The state that a job ends in.
    pub fn state(&self) -> JobState {
        match self {
            Self::Finished => JobState::Succeeded,
            Self::Stopped => JobState::Cancelled,
            Self::Failed(_) => JobState::Failed,
        }
    }

    /// What went wrong.
    pub fn failure(&self) -> Option<&JobFailure> {
        match self {
            Self::Failed(failure) => Some(failure),
            Self::Finished | Self::Stopped => None,
        }
    }
}
