//! State of the run that is summarised.

use crate::step::{Ending, Failure, Outcome};
use serde::Serialize;

/// State of the run that is summarised.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "ending", rename_all = "snake_case")]
pub enum RunState {
    /// The run is in progress.
    Running,
    /// It reached the end time.
    Finished,
    /// The run was cancelled by the user.
    Cancelled,
    /// The run failed with a diagnosis.
    Failed {
        /// Diagnosis of the failure.
        failure: Failure,
    },
}

impl RunState {
    /// State for an outcome; running if there is none.
    pub fn of(outcome: Option<&Outcome>) -> Self {
        match outcome.map(|o| &o.ending) {
            None => Self::Running,
            Some(Ending::Finished) => Self::Finished,
            Some(Ending::Cancelled) => Self::Cancelled,
            Some(Ending::Failed { failure }) => Self::Failed { failure: failure.clone() },
        }
    }
}
