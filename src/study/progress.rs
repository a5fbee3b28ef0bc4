//! Progress of a run, alone or as a job.

use serde::{Deserialize, Serialize};

/// Current phase of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Waiting for a worker.
    Waiting,
    /// Meshes are generated or read, and the scene is compiled.
    Loading,
    /// Other runs of the scene, for the error bars.
    EstimatingErrors,
    /// Dynamic relaxation before the clock starts (`dynamic_relaxation` of the scene).
    DynamicRelaxation,
    /// Quasi-static load steps before the clock starts (`preload` of the scene).
    Preload,
    /// Time stepping of the run itself.
    Stepping,
    /// The recording is closed and its digest computed.
    Closing,
    /// The job has ended.
    Done,
}

impl Phase {
    const ALL: [Self; 8] = [
        Self::Waiting,
        Self::Loading,
        Self::EstimatingErrors,
        Self::DynamicRelaxation,
        Self::Preload,
        Self::Stepping,
        Self::Closing,
        Self::Done,
    ];

    /// Name in documents and in the store.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Loading => "loading",
            Self::EstimatingErrors => "estimating_errors",
            Self::DynamicRelaxation => "dynamic_relaxation",
            Self::Preload => "preload",
            Self::Stepping => "stepping",
            Self::Closing => "closing",
            Self::Done => "done",
        }
    }

    /// The phase with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.as_str() == name)
    }
}

/// Phase of a run, and number of the mesh in a run to a requested accuracy.
pub type Stage = (Phase, Option<u32>);

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Current phase of the run.
    pub phase: Phase,
    /// Completed fraction of the run, 0 … 1.
    pub progress: f64,
    /// Number of steps completed.
    pub step: u64,
    /// Expected total number of steps.
    pub expected_steps: Option<u64>,
    /// Simulated time reached [s]; negative during dynamic relaxation.
    pub simulated_time_s: f64,
    /// Expected time to the end on the wall clock [s].
    pub eta_s: Option<f64>,
    /// Where a run to a requested accuracy stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyProgress>,
}

/// Where a run to a requested accuracy stands: it runs on finer and finer meshes, and how many is not known in advance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyProgress {
    /// Number of the mesh that is run now, from 1.
    pub run: u32,
    /// Number of elements in each direction relative to the scene's own mesh [-].
    pub mesh_factor: f64,
    /// Largest admissible error bar, as a fraction of the number [-].
    pub requested: f64,
    /// Largest error bar of the requested numbers on the mesh before, as such a fraction [-]; none where one has no error bar yet.
    pub before: Option<f64>,
}

impl Progress {
    /// A run that has just entered a phase.
    pub fn beginning(phase: Phase) -> Self {
        Self::at(phase, 0.0, 0, 0.0)
    }

    /// A run at this point; the estimates of the remainder are left to others.
    pub fn at(phase: Phase, progress: f64, step: u64, simulated_time_s: f64) -> Self {
        Self { phase, progress, step, expected_steps: None, simulated_time_s, eta_s: None, accuracy: None }
    }

    /// What a change of is reported at once: the phase, and the number of the mesh in a run to an accuracy.
    pub fn stage(&self) -> Stage {
        (self.phase, self.accuracy.map(|accuracy| accuracy.run))
    }
}
