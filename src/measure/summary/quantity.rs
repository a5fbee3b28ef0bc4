//! A number of the summary, with its numerical error.

use serde::{Deserialize, Serialize};

/// Whether the run passed its acceptance checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GateResult {
    /// The run passed all acceptance checks.
    Passed,
    /// At least one acceptance check failed.
    Failed,
}

/// A number of the summary; the suffix of its name is the unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The value in that unit.
    pub value: f64,
    /// Estimate of its numerical error.
    pub error: ErrorEstimate,
    /// Whether the run that produced it passed its acceptance checks.
    pub gate: GateResult,
}

#[cfg(test)]
impl Quantity {
    /// A number of a run that passed, with an error of the mesh alone.
    pub(super) fn with_mesh_error(value: f64, mesh: f64, resolved: bool) -> Self {
        let (step, contact, bulk_modulus, resolution) = (0.0, 0.0, 0.0, 0.0);
        let error = Estimate { total: mesh, mesh, step, contact, bulk_modulus, resolution, resolved };
        Self { value, error: ErrorEstimate::Estimated(error), gate: GateResult::Passed }
    }
}

/// Status of a number's numerical error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ErrorEstimate {
    /// No estimate was made.
    #[serde(rename = "not estimated")]
    NotEstimated,
    /// Nothing touched: there is no impact that the number could describe.
    #[serde(rename = "nothing touched")]
    NothingTouched,
    /// The error was estimated: its half-width and its contributions.
    #[serde(untagged)]
    Estimated(Estimate),
}

impl ErrorEstimate {
    /// Status for the number times an exact factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Estimated(estimate) => Self::Estimated(estimate.scaled(factor)),
            other => other.clone(),
        }
    }
    /// Half width of the estimated error.
    pub fn half_width(&self) -> Option<f64> {
        match self {
            Self::Estimated(estimate) => Some(estimate.total),
            Self::NotEstimated | Self::NothingTouched => None,
        }
    }
    /// Whether the error was estimated and the number exceeds it: only then is it shown as a plain number.
    pub fn is_resolved(&self) -> bool {
        matches!(self, Self::Estimated(estimate) if estimate.resolved)
    }
    /// Whether the estimated error is at least as large as the number.
    pub fn is_unresolved(&self) -> bool {
        matches!(self, Self::Estimated(estimate) if !estimate.resolved)
    }
}

/// Numerical error of a number, in the number's own unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Total error, the sum of all contributions.
    pub total: f64,
    /// Contribution of the mesh.
    pub mesh: f64,
    /// Contribution of the time step.
    pub step: f64,
    /// Contribution of the contact solver's tolerance.
    pub contact: f64,
    /// Contribution of lowered bulk moduli.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub bulk_modulus: f64,
    /// Limit of resolution: a time within its steps, a volume within the spacing of its points, a sum within its rounding.
    pub resolution: f64,
    /// Whether the number exceeds its error, or both are zero. A pointwise peak is never resolved on two meshes, which
    /// cannot show convergence.
    pub resolved: bool,
}

impl Estimate {
    /// Estimate for the number times an exact factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let parts = [self.total, self.mesh, self.step, self.contact, self.bulk_modulus, self.resolution];
        let [total, mesh, step, contact, bulk_modulus, resolution] = parts.map(|e| factor * e);
        Self { total, mesh, step, contact, bulk_modulus, resolution, ..*self }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_zero(error: &f64) -> bool {
    *error == 0.0
}
