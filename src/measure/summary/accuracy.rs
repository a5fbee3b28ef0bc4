//! Comparison of the error bars with the requested accuracy.

use super::of_interest::QuantityOfInterest;
use super::quantity::ErrorEstimate;
use super::results::Results;
use crate::scene::document::RequestedNumber;
use serde::{Deserialize, Serialize};

/// Requested accuracy, and the mesh of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct RequestedAccuracy {
    /// Largest admissible error bar, as a fraction of the number [-].
    pub relative: f64,
    /// Numbers to which it applies.
    pub of: Vec<RequestedNumber>,
    /// Number of elements in each direction relative to the scene's own mesh [-].
    pub mesh_factor: f64,
    /// Expected run time on the next finer mesh [s].
    pub next_s: Option<f64>,
    /// Whether that is an estimate for one core, rather than by the clock.
    pub is_estimated: bool,
}

/// Accuracy of a run compared with the request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Whether every number is accurate enough.
    pub reached: bool,
    /// Largest admissible error bar, as a fraction of the number [-].
    pub requested: f64,
    /// Accuracy of each requested number that the scene has.
    pub numbers: Vec<AccuracyOf>,
    /// Number of elements in each direction relative to the scene's own mesh [-].
    pub mesh_factor: f64,
    /// Expected run time on the next finer mesh, with its error bars [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_mesh_s: Option<f64>,
    /// Whether that is an estimate for one core, rather than by the clock of this machine.
    pub is_estimated: bool,
}

/// Accuracy of one number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyOf {
    /// The number in question.
    pub number: RequestedNumber,
    /// Error bar as a fraction of `of` [-]; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative: Option<f64>,
    /// What the error bar is a fraction of.
    pub of: AccuracyScale,
}

/// What an error bar is a fraction of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AccuracyScale {
    /// The magnitude of the number.
    Number,
    /// The largest energy that the tissue absorbed, which an elastic rebound takes back: the energy given to the tissue is
    /// the small difference of two large ones then.
    PeakAbsorbedEnergy,
}

impl Accuracy {
    /// Compares the error bars of the results with the request; results that are withheld have none.
    pub(super) fn of(requested: &RequestedAccuracy, results: &Results, is_withheld: bool) -> Self {
        let of = |number: RequestedNumber| {
            let quantity = QuantityOfInterest::from(number).number(results)?;
            let (scale, of) = scale(number, quantity.value, results);
            let relative = match &quantity.error {
                _ if is_withheld => None,
                ErrorEstimate::Estimated(error) if error.total == 0.0 => Some(0.0),
                ErrorEstimate::Estimated(error) => Some(error.total / scale).filter(|r| r.is_finite()),
                ErrorEstimate::NotEstimated | ErrorEstimate::NothingTouched => None,
            };
            Some(AccuracyOf { number, relative, of })
        };
        let numbers: Vec<AccuracyOf> = requested.of.iter().filter_map(|number| of(*number)).collect();
        let is_within = |of: &AccuracyOf| of.relative.is_some_and(|relative| relative <= requested.relative);
        Self {
            reached: numbers.iter().all(is_within),
            requested: requested.relative,
            numbers,
            mesh_factor: requested.mesh_factor,
            next_mesh_s: requested.next_s,
            is_estimated: requested.is_estimated,
        }
    }

    /// The outcome in one sentence.
    pub fn words(&self) -> String {
        let percent = |of: &AccuracyOf| {
            let title = QuantityOfInterest::from(of.number).title();
            of.relative.map_or_else(
                || format!("{title}: no error bar"),
                |relative| format!("{title} ± {:.1} %{}", 100.0 * relative, of.of.words()),
            )
        };
        let numbers: Vec<String> = self.numbers.iter().map(percent).collect();
        let verdict = if self.reached { "reached" } else { "NOT reached" };
        let next = match self.next_mesh_s.filter(|_| !self.reached) {
            Some(seconds) => {
                let on = if self.is_estimated { " on one core, by the estimates of the plan" } else { "" };
                format!("; the next finer mesh would take about {seconds:.0} s{on}")
            }
            None => String::new(),
        };
        format!(
            "accuracy of {} % {verdict} with {:.2} times the numbers of elements: {}{next}",
            (1e5 * self.requested).round() / 1e3,
            self.mesh_factor,
            numbers.join(", ")
        )
    }
}

impl AccuracyScale {
    /// Text after the percentage.
    fn words(self) -> &'static str {
        match self {
            Self::Number => "",
            Self::PeakAbsorbedEnergy => " of the largest absorbed energy",
        }
    }
}

/// What the error bar of a number is compared with: its magnitude, or for an energy the largest that was exchanged.
fn scale(number: RequestedNumber, value: f64, results: &Results) -> (f64, AccuracyScale) {
    let exchanged = match (number, &results.tissue) {
        (RequestedNumber::EnergyGiven, Some(tissue)) => tissue.peak_absorbed_energy_j.value.abs(),
        _ => 0.0,
    };
    if value.abs() < 0.5 * exchanged {
        (exchanged, AccuracyScale::PeakAbsorbedEnergy)
    } else {
        (value.abs(), AccuracyScale::Number)
    }
}
