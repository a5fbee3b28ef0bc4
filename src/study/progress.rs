//! How far a run has come: alone, or as a job.

use serde::{Deserialize, Serialize};

/// What a job does at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// It waits for a worker.
    Waiting,
    /// Meshes are made or read, the scene is compiled.
    Loading,
    /// Cheaper runs of the scene give the error bars.
    EstimatingErrors,
    /// It settles before the clock starts.
    Settling,
    /// It steps through time.
    Stepping,
    /// The recording is closed and its digest computed.
    Closing,
    /// Nothing any more.
    Done,
}

impl Phase {
    const ALL: [Self; 7] = [
        Self::Waiting,
        Self::Loading,
        Self::EstimatingErrors,
        Self::Settling,
        Self::Stepping,
        Self::Closing,
        Self::Done,
    ];

    /// The name on the wire and in the store.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Loading => "loading",
            Self::EstimatingErrors => "estimating_errors",
            Self::Settling => "settling",
            Self::Stepping => "stepping",
            Self::Closing => "closing",
            Self::Done => "done",
        }
    }

    /// The phase of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.as_str() == name)
    }
}

/// How far a run has come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// What it does.
    pub phase: Phase,
    /// Share of the run that is done, 0 … 1.
    pub progress: f64,
    /// Steps done.
    pub step: u64,
    /// Steps expected in all.
    pub expected_steps: Option<u64>,
    /// Simulated time reached [s]; negative while settling.
    pub simulated_time_s: f64,
    /// Expected time to the end on the wall clock [s].
    pub eta_s: Option<f64>,
}

impl Progress {
    /// A run that has only begun something.
    pub fn beginning(phase: Phase) -> Self {
        Self::at(phase, 0.0, 0, 0.0)
    }

    /// A run that has come so far; what is expected of the rest, others may say.
    pub fn at(phase: Phase, progress: f64, step: u64, simulated_time_s: f64) -> Self {
        Self { phase, progress, step, expected_steps: None, simulated_time_s, eta_s: None }
    }
}
