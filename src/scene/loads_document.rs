//! Loads besides contact: prescribed displacements, face loads, load curves, and a quasi-static preload.

use super::axis::{Axis, all_axes};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Load curve: factor by which the value of a load is multiplied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum RampDocument {
    /// 1 at all times.
    // With braces: serde lets unknown fields pass in a tagged unit variant.
    Constant {},
    /// From 0 to 1, then constant.
    Linear {
        /// Start of the ramp [s].
        #[serde(default)]
        from_s: f64,
        /// End of the ramp, where the factor is 1 [s].
        to_s: f64,
    },
    /// Piecewise linear, constant before the first and after the last point.
    Table {
        /// Times of the points [s], ascending.
        times_s: Vec<f64>,
        /// The factor at each time [-].
        factors: Vec<f64>,
    },
}

/// Nodes with prescribed displacement, relative to the placed mesh; a body with such nodes has no velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedDocument {
    /// Name of a node set of the body; `*` for all nodes.
    pub set: String,
    /// Displacement where the factor is 1 [m].
    pub displacement_m: [f64; 3],
    /// Prescribed components; the nodes are free along the others.
    #[serde(default = "all_axes")]
    pub axes: Vec<Axis>,
    /// Load curve; by default from 0 to 1 over a quasi-static run, and constant after a preload. Required in a scene with
    /// neither.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<RampDocument>,
}

/// A load on the boundary faces whose corners are all in a node set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FaceLoadDocument {
    /// A pressure that follows the faces, positive inwards.
    Pressure {
        /// Name of a node set of the body; `*` for its whole boundary.
        set: String,
        /// Pressure where the factor is 1 [Pa].
        pressure_pa: f64,
        /// Load curve; constant by default, from 0 to 1 over a quasi-static run.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ramp: Option<RampDocument>,
    },
    /// A dead load: force per area at rest with constant direction.
    Traction {
        /// Name of a node set of the body; `*` for its whole boundary.
        set: String,
        /// Force per area at rest where the factor is 1 [Pa].
        traction_pa: [f64; 3],
        /// Load curve; constant by default, from 0 to 1 over a quasi-static run.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ramp: Option<RampDocument>,
    },
}

impl FaceLoadDocument {
    /// Name of the node set that is loaded.
    pub fn set(&self) -> &str {
        match self {
            Self::Pressure { set, .. } | Self::Traction { set, .. } => set,
        }
    }
    /// Load curve, if one is given.
    pub fn ramp(&self) -> Option<&RampDocument> {
        match self {
            Self::Pressure { ramp, .. } | Self::Traction { ramp, .. } => ramp.as_ref(),
        }
    }
}

/// Apply the loads quasi-statically before the clock starts: gravity, face loads and prescribed displacements grow to their
/// values at the start of the run, with the friction of the scene and without velocities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PreloadDocument {
    /// Number of load steps; a step that does not converge is halved, and later ones grow again.
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
    1e-8
}
