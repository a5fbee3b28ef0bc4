//! A number of the summary, with what is known of its error.

use serde::Serialize;

/// Whether the run passed its gates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GateResult {
    /// It did.
    Passed,
    /// It did not.
    Failed,
}

/// A number of the summary; its unit is the end of its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Its numerical error.
    pub error: ErrorEstimate,
    /// Whether the run that it comes from passed its gates.
    pub gate: GateResult,
}

/// What is known of a number's numerical error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ErrorEstimate {
    /// Nobody looked.
    #[serde(rename = "not estimated")]
    NotEstimated,
    /// Nothing touched: there is no impact that the number could be of.
    #[serde(rename = "nothing touched")]
    NothingTouched,
    /// So much.
    #[serde(untagged)]
    Estimated(Estimate),
}

impl ErrorEstimate {
    /// Of the number times a factor that is exact.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Estimated(estimate) => Self::Estimated(estimate.scaled(factor)),
            other => other.clone(),
        }
    }
    /// Whether the error was estimated, and the number is larger than it: only then it is shown as a plain number.
    pub fn is_resolved(&self) -> bool {
        matches!(self, Self::Estimated(estimate) if estimate.resolved)
    }
    /// Whether the number was estimated to be off by as much as itself.
    pub fn is_unresolved(&self) -> bool {
        matches!(self, Self::Estimated(estimate) if !estimate.resolved)
    }
}

/// A number's numerical error, in the number's own unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The sum of all.
    pub total: f64,
    /// Of the mesh.
    pub mesh: f64,
    /// Of the time step.
    pub step: f64,
    /// Of the contact solver's tolerance.
    pub contact: f64,
    /// What cannot be told apart: a time within its steps, a depth within two quadrature points, a sum within its rounding.
    pub resolution: f64,
    /// Whether the number is larger than its error, or both are zero. A peak at a point never is on two meshes, which cannot tell
    /// whether it converges.
    pub resolved: bool,
}

impl Estimate {
    /// Of the number times a factor that is exact.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let [total, mesh, step, contact, resolution] =
            [self.total, self.mesh, self.step, self.contact, self.resolution].map(|e| factor * e);
        Self { total, mesh, step, contact, resolution, ..*self }
    }
}
