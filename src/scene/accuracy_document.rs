//! An accuracy that is asked for instead of a mesh, in a scene document.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How exact the numbers shall be, and how long that may take. The scene is run on finer and finer meshes until each number that is asked for
/// is known well enough, or the next mesh would take too long; the coarser ones give the error bars.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccuracyDocument {
    /// Largest error bar, as a fraction of the number [-].
    #[serde(default = "a_tenth")]
    pub relative: f64,
    /// The numbers that it holds for.
    #[serde(default = "AskedNumber::usual")]
    pub of: Vec<AskedNumber>,
    /// What all meshes together may take [s].
    #[serde(default = "a_minute")]
    pub time_budget_s: f64,
}

fn a_tenth() -> f64 {
    0.1
}

fn a_minute() -> f64 {
    60.0
}

impl Default for AccuracyDocument {
    fn default() -> Self {
        Self { relative: a_tenth(), of: AskedNumber::usual(), time_budget_s: a_minute() }
    }
}

/// A number of the summary that an accuracy is asked of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AskedNumber {
    /// Peak impact force.
    PeakForce,
    /// Impulse of the contact.
    Impulse,
    /// Largest contact patch.
    ContactPatch,
    /// Depth of the first threshold of stress.
    StressDepth,
    /// Energy that the impact has given the tissue at the end.
    EnergyGiven,
    /// Largest deflection of the skin.
    Deflection,
}

impl AskedNumber {
    /// Those that are asked for where nothing is said: what is done to the tissue as a whole.
    fn usual() -> Vec<Self> {
        vec![Self::PeakForce, Self::Impulse, Self::EnergyGiven]
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::PeakForce => "peak force",
            Self::Impulse => "impulse",
            Self::ContactPatch => "contact patch",
            Self::StressDepth => "depth of stress",
            Self::EnergyGiven => "energy given to the tissue",
            Self::Deflection => "deflection",
        }
    }
}
