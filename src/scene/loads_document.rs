//! What acts on bodies besides contact: prescribed displacements, loads on faces, how they grow, and a quasi-static preload.

use super::document::Axis;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a load grows: the factor that its value is multiplied by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum RampDocument {
    /// 1 at all times.
    // With braces: serde lets unknown fields pass in a tagged unit variant.
    Constant {},
    /// From 0 to 1, and 1 from then on.
    Linear {
        /// When it begins [s].
        #[serde(default)]
        from_s: f64,
        /// When it has grown to 1 [s].
        to_s: f64,
    },
    /// Straight from point to point, constant before the first and after the last.
    Table {
        /// Times [s], ascending.
        times_s: Vec<f64>,
        /// The factor at each time [-].
        factors: Vec<f64>,
    },
}

/// Nodes whose displacement is given. It acts in the body's mesh as it is placed; a body with such nodes does not fly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedDocument {
    /// Name of a node set of the body; `*` for all nodes.
    pub set: String,
    /// Displacement where the factor is 1 [m].
    pub displacement_m: [f64; 3],
    /// Which of its components are prescribed; the nodes are free along the others.
    #[serde(default = "all_axes")]
    pub axes: Vec<Axis>,
    /// How it grows; by default from 0 to 1 over a quasi-static run, and constant after a preload. A scene with neither has
    /// to give it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<RampDocument>,
}

fn all_axes() -> Vec<Axis> {
    vec![Axis::X, Axis::Y, Axis::Z]
}

/// A load on the faces of the skin whose corners are all in a node set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FaceLoadDocument {
    /// A pressure that follows the faces, positive where it pushes inwards.
    Pressure {
        /// Name of a node set of the body; `*` for its whole skin.
        set: String,
        /// Pressure where the factor is 1 [Pa].
        pressure_pa: f64,
        /// How it grows; constant by default, over a quasi-static run from 0 to 1.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ramp: Option<RampDocument>,
    },
    /// A force per area at rest that keeps its direction.
    Traction {
        /// Name of a node set of the body; `*` for its whole skin.
        set: String,
        /// Force per area at rest where the factor is 1 [Pa].
        traction_pa: [f64; 3],
        /// How it grows; constant by default, over a quasi-static run from 0 to 1.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ramp: Option<RampDocument>,
    },
}

impl FaceLoadDocument {
    /// Name of the node set.
    pub fn set(&self) -> &str {
        match self {
            Self::Pressure { set, .. } | Self::Traction { set, .. } => set,
        }
    }
    /// How it grows.
    pub fn ramp(&self) -> Option<&RampDocument> {
        match self {
            Self::Pressure { ramp, .. } | Self::Traction { ramp, .. } => ramp.as_ref(),
        }
    }
}

/// Load quasi-statically before the clock starts: gravity, face loads and prescribed displacements grow to what they are at
/// the start of the run, with the friction of the scene and without flight or spin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PreloadDocument {
    /// In how many load steps; one that does not converge is halved, and what follows grows again.
    #[serde(default = "default_preload_steps")]
    pub steps: u32,
    /// Largest residual of the equilibrium, relative to the forces [-].
    #[serde(default = "default_preload_tolerance")]
    pub newton_tolerance: f64,
}

fn default_preload_steps() -> u32 {
    10
}
fn default_preload_tolerance() -> f64 {
    1e-10
}
