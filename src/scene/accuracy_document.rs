//! A required accuracy in place of a mesh, in a scene document.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Required accuracy of the results, and the time it may take. The scene is run on finer and finer meshes until each
/// requested result is accurate enough, or the next mesh would take too long; the coarser meshes give the error bars.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccuracyDocument {
    /// Largest error bar, as a fraction of the result [-].
    #[serde(default = "a_tenth")]
    pub relative: f64,
    /// Results that the accuracy is required of.
    #[serde(default = "RequestedNumber::usual")]
    pub of: Vec<RequestedNumber>,
    /// Time limit for all meshes together [s].
    #[serde(default = "a_minute")]
    pub time_budget_s: f64,
    /// Whether the limit applies to estimated run times on one core rather than to wall time: every machine then uses the same
    /// meshes, and the results are the same to the last bit.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reproducible: bool,
    /// Whether the bulk moduli are lowered, from those of the scene or, where these are below it, from that of water, as far as this changes
    /// the required results by less than a third of the accuracy, by runs on the coarsest mesh: the time step grows as their square root
    /// falls. The change is part of the error bars.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub lower_bulk_modulus: bool,
}

fn a_tenth() -> f64 {
    0.1
}

fn a_minute() -> f64 {
    60.0
}

impl Default for AccuracyDocument {
    fn default() -> Self {
        Self {
            relative: a_tenth(),
            of: RequestedNumber::usual(),
            time_budget_s: a_minute(),
            reproducible: false,
            lower_bulk_modulus: false,
        }
    }
}

/// A result of the summary whose accuracy can be required.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RequestedNumber {
    /// Peak force of the impact.
    PeakForce,
    /// Impulse of the contact force.
    Impulse,
    /// Largest area of the contact patch.
    ContactPatch,
    /// Depth of the first stress threshold.
    StressDepth,
    /// Energy transferred to the tissue by the end of the run.
    EnergyGiven,
    /// Largest deflection of the tissue's surface.
    Deflection,
}

impl RequestedNumber {
    /// All results, in the order of a summary.
    pub const ALL: [Self; 6] = [
        Self::PeakForce,
        Self::Impulse,
        Self::ContactPatch,
        Self::StressDepth,
        Self::EnergyGiven,
        Self::Deflection,
    ];
    /// Default results: those that describe the load on the tissue as a whole.
    pub(super) fn usual() -> Vec<Self> {
        vec![Self::PeakForce, Self::Impulse, Self::EnergyGiven]
    }
}
