//! The clinical summary: a few numbers, each with its unit, its estimated numerical error, and the verdict of the
//! gates.
//!
//! A run that fails a gate has no plain numbers: its computed values are listed under `withheld`, with the reason.

mod accuracy;
mod erosion;
mod error_bars;
mod from_measures;
mod gates;
mod injury;
mod laws;
mod listed;
mod listing;
mod lower_bounds;
mod numerics;
mod of_interest;
mod quantity;
mod relaxation;
mod results;
mod softening;
mod squeezed;
mod table;
mod warning_list;
mod warnings;
mod words;
mod written;

pub use accuracy::{Accuracy, AccuracyOf, AccuracyScale, RequestedAccuracy};
pub use error_bars::{BulkModulusChange, Compared, ComparedRuns, ErrorBars, Level};
pub use gates::Gate;
pub use injury::InjuryMeasure;
pub use laws::{LawRange, LawRate};
pub use listing::{Group, Row, listing};
pub use lower_bounds::lower_bounds;
pub use numerics::{Numerics, numerics_group};
pub use of_interest::{QuantityOfInterest, QuantityTitle};
pub use quantity::{ErrorEstimate, Estimate, GateResult, Interval, Quantity};
pub use relaxation::RelaxationOfBody;
pub use results::{
    DoseMeasure, DoseVolume, Exceeded, ExceededInVolume, Headline, Impact, Located, Peaks, Percentiles,
    Results, Shown, SignificantStress, Split, StressedLayer, Tissue,
};
pub use table::render_table;
pub use warning_list::Warnings;
pub use written::{interval, marked, number, rounded, seconds, short, unit_of_time, within};

use super::measures::Measures;
use crate::plan::Plan;
use crate::step::{Ending, FailureCause, Outcome};
use erosion::{ErosionOfPart, erosion};
use from_measures::{Mint, results};
use gates::{Withholding, excess, gates, withholding};
use injury::injury_measures;
use laws::{law_rates, left_laws};
use numerics::numerics;
use relaxation::relaxation;
use serde::{Serialize, Serializer};
use softening::{SofteningOfPart, softening};
use warnings::{doubtful_numbers, warnings};
use words::plain_words;

/// Disclaimer included in every answer.
pub const NOTICE: &str = "For research use only. Contuse is no medical device, and its results are no diagnosis and no medical advice.";

#[allow(clippy::ref_option)] // serde's signature
fn ended_or_running<S: Serializer>(ending: &Option<Ending>, serializer: S) -> Result<S::Ok, S::Error> {
    match ending {
        Some(ending) => ending.serialize(serializer),
        None => serializer.collect_map([("ending", "running")]),
    }
}

/// Clinical summary of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// What the numbers must not be used for, [`NOTICE`].
    pub notice: &'static str,
    /// Version of the engine.
    pub engine_version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// How the run ended; `None` while it is in progress.
    #[serde(flatten, serialize_with = "ended_or_running")]
    pub ending: Option<Ending>,
    /// Simulated time reached [s].
    pub time_s: f64,
    /// Requested simulated time [s].
    pub end_time_s: f64,
    /// Number of steps completed.
    pub steps: u64,
    /// The numbers, or why they are withheld.
    #[serde(flatten)]
    pub results: Shown,
    /// The main numbers and the gravest warning as plain sentences.
    pub plain_words: Vec<String>,
    /// Published injury criteria, each with its source and whether it applies to this scene.
    pub injury_measures: Vec<InjuryMeasure>,
    /// Quality of the computation.
    pub numerics: Numerics,
    /// Parts whose law was used beyond the range that it was fitted to, or usually is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub law_ranges: Vec<LawRange>,
    /// Strain rates of the parts whose law says at which its parameters were tested.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub law_rates: Vec<LawRate>,
    /// Energy of the branches of relaxation of each body.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub relaxation: Vec<RelaxationOfBody>,
    /// Parts whose stress softened.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub softening: Vec<SofteningOfPart>,
    /// Parts that lost elements.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub erosion: Vec<ErosionOfPart>,
    /// Checks that the run passed or failed.
    pub gates: Vec<Gate>,
    /// Caveats to read before the numbers are used, most severe first.
    pub warnings: Warnings,
    /// Source of the error bars, or why there are none.
    pub error_bars: String,
    /// Whether the numbers have the requested accuracy; absent if none was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
}

impl Summary {
    /// The largest value of a failed check over its limit [-]; `None` if none failed.
    pub fn excess(&self) -> Option<f64> {
        excess(&self.gates)
    }

    /// Composes the summary of the measures; `outcome` is `None` while the run is in progress.
    pub fn compose(measures: &Measures, plan: &Plan, outcome: Option<&Outcome>) -> Self {
        // Gates decide whether the numbers are shown.
        let ending = outcome.map(|outcome| &outcome.ending);
        let numerics = numerics(measures, outcome);
        let gates = gates(&measures.energy, &numerics, plan.energy_gate, plan.is_static());
        let mut withheld = withholding(&gates, ending, measures);
        let verdict = if withheld.is_some() { GateResult::Failed } else { GateResult::Passed };
        let mut values = results(measures, plan, ending, Mint(verdict));
        if withheld.is_none() && !values.is_finite() {
            let reason = "a result is infinite or not a number".to_owned();
            withheld = Some(Withholding { reason, remedy: FailureCause::NotFinite.remedy() });
            values = results(measures, plan, ending, Mint(GateResult::Failed));
        }
        // Error bars.
        let mut error_bars = measures.error_bars.to_string();
        if let ErrorBars::From(runs) = &measures.error_bars {
            // The compared runs were completed: an incomplete run has numbers of another time span.
            match outcome {
                Some(outcome) if outcome.ending == Ending::Finished => {
                    values.estimate_errors(runs, outcome.steps, outcome.time_s);
                }
                _ => error_bars = "not estimated: the run is not complete".into(),
            }
        }
        if outcome.is_some() {
            values.mark_misses();
        }
        // Values at points beyond the limit of their law are no results.
        if let Some(tissue) = values.tissue.as_mut().filter(|_| measures.laws.worst().is_some()) {
            tissue.peaks = Peaks::default();
        }
        let accuracy =
            measures.accuracy.as_ref().map(|requested| Accuracy::of(requested, &values, withheld.is_some()));
        let law_ranges = left_laws(&measures.laws);
        let erosion = erosion(&measures.eroded, plan);
        let softening = softening(&measures.laws);
        let time_s = outcome.map_or(measures.time, |o| o.time_s);
        let results = match withheld {
            None => Shown::Results(values),
            Some(Withholding { reason, remedy }) => Shown::Withheld { reason, remedy, values },
        };
        let torn = softening.iter().map(SofteningOfPart::in_words);
        let torn = torn.chain(erosion.iter().map(ErosionOfPart::in_words));
        let mut warnings = warnings(measures, plan, &numerics, outcome);
        let is_finished = ending == Some(&Ending::Finished);
        if let Shown::Results(values) = &results
            && is_finished
            && !values.nothing_touched
        {
            doubtful_numbers(&mut warnings, values);
        }
        let plain_words = plain_words(&results, (ending, time_s), torn, warnings.worst());
        Self {
            notice: NOTICE,
            engine_version: env!("CARGO_PKG_VERSION"),
            scene: plan.name.clone(),
            time_s,
            end_time_s: plan.end_time,
            steps: outcome.map_or(measures.step, |o| o.steps),
            plain_words,
            injury_measures: injury_measures(measures, plan, ending, &results),
            warnings,
            ending: ending.cloned(),
            results,
            numerics,
            law_ranges,
            law_rates: law_rates(&measures.laws),
            relaxation: relaxation(&measures.energy, plan),
            softening,
            erosion,
            gates,
            error_bars,
            accuracy,
        }
    }

    /// The numbers, withheld or not.
    pub fn values(&self) -> &Results {
        match &self.results {
            Shown::Results(values) | Shown::Withheld { values, .. } => values,
        }
    }

    /// The summary as indented JSON.
    ///
    /// # Errors
    /// Never for a summary made by [`Summary::compose`]; the type is that of the serialiser.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_run_in_progress_has_an_ending_in_documents_too() {
        #[derive(Serialize)]
        struct Of {
            #[serde(flatten, serialize_with = "ended_or_running")]
            ending: Option<Ending>,
        }
        let written = |ending| serde_json::to_value(Of { ending }).unwrap();
        assert_eq!(written(None), json!({"ending": "running"}));
        assert_eq!(written(Some(Ending::Cancelled)), json!({"ending": "cancelled"}));
    }
}
