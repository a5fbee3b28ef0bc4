//! How the run that is summed up stands.

use crate::step::{Ending, Failure, Outcome};
use serde::Serialize;

/// State of the run that is summed up.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "ending", rename_all = "snake_case")]
pub enum RunState {
    /// It still runs.
    Running,
    /// It reached the end time.
    Finished,
    /// Somebody stopped it.
    Cancelled,
    /// It went wrong, and this is why.
    Failed {
        /// The diagnosis.
        failure: Failure,
    },
}

impl RunState {
    /// Of a run that has ended, or goes on (`None`).
    pub fn of(outcome: Option<&Outcome>) -> Self {
        match outcome.map(|o| &o.ending) {
            None => Self::Running,
            Some(Ending::Finished) => Self::Finished,
            Some(Ending::Cancelled) => Self::Cancelled,
            Some(Ending::Failed { failure }) => Self::Failed { failure: failure.clone() },
        }
    }
}
