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
    /// Whether it is a lower bound, because the model or the run ends before what it measures: see `lower_bounds.rs`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_lower_bound: bool,
    /// Least and largest value that is possible, where they are known: its [interval](Self::interval) ends there.
    #[serde(default, skip_serializing_if = "is_unlimited")]
    pub possible: [Option<f64>; 2],
}

/// The interval of a number with its error, within what is possible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interval {
    /// The value ± this half width.
    Around(f64),
    /// Between two ends, of which the upper one is what is possible.
    Between([f64; 2]),
    /// From the least possible value to this one.
    UpTo(f64),
    /// From this value on: only the lower end of a lower bound is uncertain.
    From(f64),
}

impl Quantity {
    /// A value without an error.
    pub(super) fn new(value: f64, gate: GateResult) -> Self {
        let (error, possible) = (ErrorEstimate::NotEstimated, [None; 2]);
        Self { value, error, gate, is_lower_bound: false, possible }
    }

    /// The same of a number that cannot be less than this.
    #[must_use]
    pub(super) fn no_less_than(self, least: f64) -> Self {
        Self { possible: [Some(least), self.possible[1]], ..self }
    }

    /// The same of a number that cannot be negative, and no more than `most`, if that is known.
    #[must_use]
    pub(super) fn within_zero_and(self, most: Option<f64>) -> Self {
        Self { possible: [Some(0.0), most], ..self }
    }

    /// Ends of the interval, the upper one of a lower bound being the value itself; those of the value alone without an estimate.
    pub fn ends(&self) -> [f64; 2] {
        match self.interval() {
            Some(Interval::Around(error)) => [self.value - error, self.value + error],
            Some(Interval::Between(ends)) => ends,
            Some(Interval::UpTo(high)) => [self.possible[0].unwrap_or(self.value), high],
            Some(Interval::From(low)) => [low, self.value],
            None => [self.value; 2],
        }
    }

    /// The value with its estimated error: the intersection of value ± error with what is possible, in which the value itself always is.
    /// `None` without an estimate.
    pub fn interval(&self) -> Option<Interval> {
        let (value, error) = (self.value, self.error.half_width()?);
        let [least, most] = self.possible;
        let [low, high] = [value - error, value + error];
        let upper = most.map_or(high, |most| high.min(most.max(value)));
        let below = least.filter(|least| low < *least && *least <= value);
        if self.is_lower_bound {
            return Some(Interval::From(below.unwrap_or(low)));
        }
        Some(match [below.is_some(), upper < high] {
            [true, _] => Interval::UpTo(upper),
            [false, true] => Interval::Between([low, upper]),
            [false, false] => Interval::Around(error),
        })
    }
}

#[cfg(test)]
impl Quantity {
    /// A number of a run that passed, with an error of the mesh alone.
    pub(super) fn with_mesh_error(value: f64, mesh: f64, resolved: bool) -> Self {
        let (step, contact, bulk_modulus, resolution) = (0.0, 0.0, 0.0, 0.0);
        let error = Estimate { total: mesh, mesh, step, contact, bulk_modulus, resolution, resolved };
        Self { error: ErrorEstimate::Estimated(error), ..Self::new(value, GateResult::Passed) }
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

fn is_unlimited(possible: &[Option<f64>; 2]) -> bool {
    *possible == [None; 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_ends_where_the_number_does() {
        let interval = |value, error, possible| {
            let quantity = Quantity::with_mesh_error(value, error, error < value);
            Quantity { possible, ..quantity }.interval()
        };
        assert_eq!(interval(7.5, 9.0, [None; 2]), Some(Interval::Around(9.0)));
        assert_eq!(interval(7.5, 9.0, [Some(0.0), None]), Some(Interval::UpTo(16.5)));
        assert_eq!(interval(7.5, 9.0, [Some(0.0), Some(8.0)]), Some(Interval::UpTo(8.0)));
        assert_eq!(interval(7.5, 2.0, [Some(0.0), Some(8.0)]), Some(Interval::Between([5.5, 8.0])));
        assert_eq!(interval(7.5, 0.5, [Some(0.0), Some(8.0)]), Some(Interval::Around(0.5)));
        // A value beyond the end by its own error stays in its interval.
        assert_eq!(interval(8.25, 0.5, [Some(0.0), Some(8.0)]), Some(Interval::Between([7.75, 8.25])));
        assert_eq!(interval(-0.5, 1.0, [Some(0.0), None]), Some(Interval::Around(1.0)));
        assert_eq!(interval(0.0, 0.0, [Some(0.0), Some(8.0)]), Some(Interval::Around(0.0)));
        assert_eq!(Quantity::new(1.0, GateResult::Passed).interval(), None);
    }

    #[test]
    fn a_lower_bound_has_a_lower_end_alone() {
        let bound = |error: f64| {
            let quantity = Quantity::with_mesh_error(7.5, error, error < 7.5);
            Quantity { is_lower_bound: true, possible: [Some(0.0), Some(8.0)], ..quantity }
        };
        assert_eq!(bound(2.0).interval(), Some(Interval::From(5.5)));
        assert_eq!(bound(9.0).interval(), Some(Interval::From(0.0)));
        let [low, high] = bound(2.0).ends();
        assert!((low - 5.5).abs() < 1e-12 && (high - 7.5).abs() < 1e-12, "{low} {high}");
    }
}
