//! The clinical summary: a few numbers, each with its unit, its estimated numerical error, and the gate that it passed.
//!
//! A run that fails a gate gives no plain numbers: what it computed stands under `withheld`, with the reason.

mod error_bars;
mod from_measures;
mod gates;
mod injury;
mod laws;
mod listed;
mod results;
mod table;
mod words;

pub use error_bars::{Cheaper, CheaperRuns, ErrorEstimate, Estimate};
pub use injury::InjuryMeasure;
pub use laws::LawRange;
pub use results::{
    DoseVolume, Headline, Impact, Located, Peaks, Results, SignificantStress, Split, StressedLayer, Tissue,
};
pub use table::{number, render_table, rounded};

use super::measures::Measures;
use crate::plan::Plan;
use crate::step::{Ending, Failure, FailureCause, Outcome};
use from_measures::{Mint, results};
use gates::{Withholding, gates, numerics, own_warnings, withholding};
use injury::injury_measures;
use laws::left_laws;
use serde::Serialize;
use words::plain_words;

/// Said with every answer.
pub const NOTICE: &str = "For research use only. Contuse is no medical device, and its results are no diagnosis and no medical advice.";

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

/// Where error bars come from.
#[derive(Clone, Debug, Default)]
pub enum ErrorBars {
    /// Nobody asked for any.
    #[default]
    NotAsked,
    /// There are none, and why.
    Unknown(String),
    /// Cheaper runs of the same scene.
    From(Box<CheaperRuns>),
}

impl std::fmt::Display for ErrorBars {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotAsked => f.write_str("not estimated: nobody asked for error bars"),
            Self::Unknown(why) => write!(f, "not estimated: {why}"),
            Self::From(runs) if runs.coarser.is_some() => f.write_str(
                "estimated from runs on two coarser meshes (numbers of elements divided by 2 and 4): three levels, order observed, \
                 factor of safety 1.25; of the steps first order assumed, factor of safety 3",
            ),
            Self::From(runs) => write!(
                f,
                "estimated from runs on a coarser mesh (numbers of elements divided by {:.2} to 2, layers of one element kept): \
                 two levels, first order assumed, factor of safety 3",
                runs.refinement
            ),
        }
    }
}

/// A check that decides whether numbers may be shown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gate {
    /// Name.
    pub name: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Measured value [-].
    pub value: f64,
    /// Limit of the value [-].
    pub limit: f64,
    /// The verdict.
    pub result: GateResult,
}

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

/// The summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// No medical device, no diagnosis.
    pub notice: &'static str,
    /// Version of the engine.
    pub engine_version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// How the run ended.
    #[serde(flatten)]
    pub state: RunState,
    /// Simulated time reached [s].
    pub time_s: f64,
    /// Simulated time asked for [s].
    pub end_time_s: f64,
    /// Steps done.
    pub steps: u64,
    /// The numbers, or why there are none.
    #[serde(flatten)]
    pub results: Shown,
    /// The numbers in plain words.
    pub plain_words: Vec<String>,
    /// Published injury criteria, each with its source and whether it covers this scene.
    pub injury_measures: Vec<InjuryMeasure>,
    /// How good the computation was.
    pub numerics: Numerics,
    /// Parts whose law was taken beyond what it is fitted to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub law_ranges: Vec<LawRange>,
    /// The gates.
    pub gates: Vec<Gate>,
    /// Sentences to read before the numbers are used.
    pub warnings: Vec<String>,
    /// Where the error bars come from, or why there are none.
    pub error_bars: String,
}

/// Numbers, plain or withheld.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// The gates were passed.
    Results(Results),
    /// A gate was failed.
    Withheld {
        /// Which, and by how much.
        reason: String,
        /// What to do about it.
        remedy: &'static str,
        /// What was computed; not to be used as results.
        values: Results,
    },
}

/// How good the computation was.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Numerics {
    /// Smallest Jacobian J at any time [-]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_jacobian: Option<f64>,
    /// Smallest step [s]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_step_s: Option<f64>,
    /// Elements that were swept over all elements, summed over the steps [-]: the rest were quiet, nothing had reached them
    /// yet; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swept_element_share: Option<f64>,
    /// Energy at the start [J].
    pub initial_energy_j: f64,
    /// Energy that errors are compared with [J].
    pub energy_scale_j: f64,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// What lumped contact nodes lost when they were caught, all pairs [J]: a discretisation error.
    pub numerical_contact_dissipation_j: f64,
    /// The same over the energy scale, or over all that was dissipated where that is more [-].
    pub numerical_contact_dissipation_share: f64,
    /// Dissipated by friction, all pairs [J].
    pub friction_dissipation_j: f64,
    /// Peak energy of the stabilisation of one-point elements over peak strain energy, of the body where it is largest [-]:
    /// what the mesh does not resolve.
    pub hourglass_energy_share: f64,
    /// The deepest point of one side of a pair inside the other at a field time [m].
    pub deepest_penetration_m: f64,
    /// The same over the size of the nearest face [-].
    pub deepest_penetration_share: f64,
    /// The largest volume that both sides of a pair share at a field time [m³].
    pub overlapped_volume_m3: f64,
    /// The same over the volume of the smaller body [-].
    pub overlapped_volume_share: f64,
    /// Largest difference of the absorbed energy's two computations over the energy scale [-].
    pub absorbed_energy_disagreement: f64,
    /// Largest share of a body's strain energy that was beyond the limits of its laws [-]; 1 where elements have turned over.
    pub energy_share_beyond_law: f64,
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

impl Summary {
    /// Of what was measured; `outcome` is `None` while the run goes on.
    pub fn compose(measures: &Measures, plan: &Plan, outcome: Option<&Outcome>) -> Self {
        let state = RunState::of(outcome);
        let numerics = numerics(measures, outcome);
        let gates = gates(&measures.energy, &numerics, plan.energy_gate, plan.is_static());
        let mut withheld = withholding(&gates, &state, measures, &numerics);
        let verdict = if withheld.is_some() { GateResult::Failed } else { GateResult::Passed };
        let mut values = results(measures, plan, &state, Mint(verdict));
        if withheld.is_none() && !values.is_finite() {
            let reason = "a result is infinite or not a number".to_owned();
            withheld = Some(Withholding { reason, remedy: FailureCause::NotFinite.remedy() });
            values = results(measures, plan, &state, Mint(GateResult::Failed));
        }
        let mut error_bars = measures.error_bars.to_string();
        if let ErrorBars::From(runs) = &measures.error_bars {
            // The cheaper runs came to the end: a run that did not has other numbers.
            match outcome {
                Some(outcome) if outcome.ending == Ending::Finished => {
                    values.estimate_errors(runs, outcome.steps, outcome.time_s);
                }
                _ => error_bars = "not estimated: the run has not come to its end".into(),
            }
        }
        if outcome.is_some() {
            values.mark_misses();
        }
        // At a point beyond the limit of its law they are no results.
        if let Some(tissue) = values.tissue.as_mut().filter(|_| measures.laws.worst().is_some()) {
            tissue.peaks = Peaks::default();
        }
        let mut warnings = measures.scene_warnings.clone();
        warnings.extend(outcome.iter().flat_map(|outcome| outcome.warnings.clone()));
        warnings.extend(
            own_warnings(measures, plan, &numerics, outcome.is_some())
                .into_iter()
                .filter(|w| !warnings.contains(w))
                .collect::<Vec<_>>(),
        );
        let law_ranges = left_laws(&measures.laws);
        let time_s = outcome.map_or(measures.time, |o| o.time_s);
        let results = match withheld {
            None => Shown::Results(values),
            Some(Withholding { reason, remedy }) => Shown::Withheld { reason, remedy, values },
        };
        Self {
            notice: NOTICE,
            engine_version: env!("CARGO_PKG_VERSION"),
            scene: plan.name.clone(),
            time_s,
            end_time_s: plan.end_time,
            steps: outcome.map_or(measures.step, |o| o.steps),
            plain_words: plain_words(&results, &state, time_s, &law_ranges),
            injury_measures: injury_measures(measures, plan, &state, &results),
            state,
            results,
            numerics,
            law_ranges,
            gates,
            warnings,
            error_bars,
        }
    }

    /// Whether it sums up a run with this ending.
    pub fn is_of(&self, outcome: &Outcome) -> bool {
        self.state == RunState::of(Some(outcome))
    }

    /// The numbers, whether withheld or not.
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
