//! Why a run went wrong, where, when, and what to do about it.

use serde::Serialize;

/// The cause, as a code that programs can match.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureCause {
    /// An element's Jacobian became zero or negative.
    ElementInverted,
    /// The stable step fell below what can finish.
    StepCollapsed,
    /// A fibre was stretched beyond what its exponential can represent.
    FibreOverstretched,
    /// The contact solver did not reach its tolerance.
    ContactNotConverged,
    /// The energy balance failed its gate.
    EnergyGate,
    /// A number became infinite or not a number.
    NotFinite,
    /// The wall-clock budget ran out.
    Deadline,
    /// The recording could not be written.
    RecordingFailed,
}

/// An element of the scene, in the words of the user.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ElementPlace {
    /// Name of the body.
    pub body: String,
    /// Name of the part.
    pub part: String,
    /// Index of the element in the body, from 0.
    pub element: u32,
    /// Its centre at that time [m].
    pub position_m: [f64; 3],
}

/// A diagnosis: never a panic, never a bare code.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[error("{message} {remedy}")]
pub struct Failure {
    /// The cause.
    pub cause: FailureCause,
    /// What happened, with values and limits, in a sentence.
    pub message: String,
    /// What the user can do.
    pub remedy: String,
    /// Simulated time [s].
    pub time_s: f64,
    /// Step.
    pub step: u64,
    /// Where, when it is about an element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<ElementPlace>,
}
