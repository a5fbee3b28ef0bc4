//! The what-if question as a JSON document: a base, the parameters, and the cases.

use crate::measure::QuantityOfInterest;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// A what-if question. One of `scene` and `job` is the base; on the command line the base is a file, and both are absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct WhatIfDocument {
    /// Base given as a scene document.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub scene: Option<Value>,
    /// Base given as the id of a job, whose scene is used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<String>,
    /// Parameters that vary, with ranges or distributions.
    pub parameters: Vec<ParameterDocument>,
    /// Cases with explicit values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cases: Vec<CaseDocument>,
    /// One-at-a-time sensitivities: every parameter at its low and its high end, the others as in the base.
    #[serde(default)]
    pub one_at_a_time: bool,
    /// Sampled cases over all parameters: spread and, if requested, Sobol indices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample: Option<SampleDocument>,
    /// "Up to which value of a parameter does a number stay below a limit?"
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<LimitDocument>,
    /// Source of the error bars.
    #[serde(default)]
    pub error_bars: ErrorSource,
}

/// One parameter: what it changes, and over which range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ParameterDocument {
    /// Unique name by which cases and limits refer to it.
    pub name: String,
    /// What the parameter changes in the scene.
    pub change: Change,
    /// Low end of its range, in the unit of the change; by default the 5th percentile of the distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// High end of its range; by default the 95th percentile of the distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Distribution for sampling; uniform from `low` to `high` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
}

/// A change of the scene by one number; the suffix of its name is the unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Change {
    /// Speed of a body at constant direction [m/s].
    #[serde(rename = "speed_m_per_s")]
    Speed {
        /// Name of the body; the projectile by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
    },
    /// Mass of a body, changed by its densities at constant shape [kg].
    #[serde(rename = "mass_kg")]
    Mass {
        /// Name of the body; the projectile by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
    },
    /// Rotation of a body's velocity about an axis, right-handed, relative to the base [degree].
    #[serde(rename = "angle_deg")]
    Angle {
        /// Name of the body; the projectile by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// Axis of rotation, of any length.
        about: [f64; 3],
    },
    /// Translation of a body along a direction, relative to the base [m].
    #[serde(rename = "offset_m")]
    Offset {
        /// Name of the body; the projectile by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// Direction of translation, of any length.
        along: [f64; 3],
    },
    /// Impact point on the boundary surface of any mesh: distance over the surface from the impact point of the base,
    /// straight ahead in a direction [m]. The projectile moves along and meets the surface there as it did in the base.
    #[serde(rename = "impact_offset_m")]
    ImpactOffset {
        /// Name of the projectile, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// Name of the body that is hit; by default the first body with a mesh in the path of the projectile.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        target: Option<String>,
        /// Direction, of any length; its component normal to the surface is ignored.
        along: [f64; 3],
    },
    /// Impact point around a limb segment: its `impact_angle_deg`, from +z towards +x [degree]. The projectile moves
    /// along and meets the surface there as it did in the base.
    #[serde(rename = "impact_around_deg")]
    ImpactAround {
        /// Name of the projectile, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// Name of the limb, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limb: Option<String>,
    },
    /// Impact point along a limb segment: its `impact_along_m` [m]. The projectile moves along.
    #[serde(rename = "impact_along_m")]
    ImpactAlong {
        /// Name of the projectile, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// Name of the limb, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limb: Option<String>,
    },
    /// Thickness of a layer of a limb segment at constant outline: the muscle fills the remainder [m].
    #[serde(rename = "layer_thickness_m")]
    LayerThickness {
        /// Layer whose thickness changes.
        layer: Layer,
        /// Name of the limb, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limb: Option<String>,
    },
    /// Coefficient of Coulomb friction [-].
    Friction {
        /// One pair of the scene's list; every pair by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        between: Option<[String; 2]>,
    },
    /// Factor on all stiffnesses of a part except its bulk modulus (or λ) [-].
    StiffnessFactor {
        /// Name of the body.
        body: String,
        /// Name of the part's entry in the scene.
        part: String,
    },
    /// Stiffness as a percentile of a population: log-normal with the scene's value as the median [%].
    StiffnessPercentile {
        /// Name of the body.
        body: String,
        /// Name of the part's entry in the scene.
        part: String,
        /// Coefficient of variation of the population: standard deviation over mean [-].
        coefficient_of_variation: f64,
    },
    /// Any number of the scene document, in its own unit.
    Number {
        /// JSON pointer to the number (RFC 6901).
        pointer: String,
    },
}

/// A layer outside the muscle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// Subcutaneous fat outside the muscle.
    Fat,
    /// Skin outside the fat.
    Skin,
}

/// Probability distribution of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Distribution {
    /// Normal distribution of the values.
    Normal {
        /// Mean, in the unit of the change.
        mean: f64,
        /// Standard deviation, in the unit of the change.
        standard_deviation: f64,
    },
    /// Log-normal distribution of the values.
    LogNormal {
        /// Median, in the unit of the change.
        median: f64,
        /// Standard deviation over mean [-].
        coefficient_of_variation: f64,
    },
    /// Between the smallest and the largest value of the sources of a set of the library, evenly in the logarithm. Of
    /// `stiffness_factor`, and of a `number` of the part whose spread the set states.
    Library {
        /// Name of the set, that of the part's material.
        set: String,
    },
}

/// One case with explicit values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct CaseDocument {
    /// Name of the case; its values by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Values of parameters by name; all others are as in the base.
    pub set: BTreeMap<String, f64>,
}

/// A sample of cases over all parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct SampleDocument {
    /// Method by which the points are chosen.
    #[serde(default)]
    pub method: SampleMethod,
    /// Number of points; Sobol indices of k parameters take (k + 2) times as many runs.
    pub count: u32,
    /// Seed of the random numbers: the same seed gives the same points on every machine.
    #[serde(default)]
    pub seed: u64,
    /// Whether to compute Sobol indices.
    #[serde(default)]
    pub indices: bool,
}

/// Method by which the points of a sample are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum SampleMethod {
    /// Randomly shifted Sobol sequence; best with a power of two.
    #[default]
    Sobol,
    /// Latin hypercube: one point per slice of every parameter.
    LatinHypercube,
}

/// "Up to which value of the parameter, from low to high, does the number stay at or below the limit?"
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct LimitDocument {
    /// Name of the parameter; all others are as in the base.
    pub parameter: String,
    /// Number that the limit applies to.
    pub measure: LimitMeasure,
    /// Limit, in the unit of the number.
    pub at_most: f64,
    /// Width of the final bracket as a fraction of the range [-].
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
}

fn default_tolerance() -> f64 {
    1e-3
}

/// A number that can be limited.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum LimitMeasure {
    /// A number of the results table.
    #[cfg_attr(feature = "service", schema(value_type = String))]
    Quantity(QuantityOfInterest),
    /// Largest von Mises stress [Pa] at any field time in the tissue below this depth below the surface [m].
    VonMisesPaBelowDepthM(f64),
}

/// Source of the error bars of the cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum ErrorSource {
    /// The relative errors of the base apply to all cases: three cheaper runs in total.
    #[default]
    Base,
    /// Individual error bars: three cheaper runs for each case, about a third more time.
    Full,
    /// No error bars, and no additional runs.
    None,
}

impl LimitMeasure {
    /// Depth below which the stress is requested [m].
    pub fn depth(self) -> Option<f64> {
        match self {
            Self::Quantity(_) => None,
            Self::VonMisesPaBelowDepthM(depth) => Some(depth),
        }
    }
    /// Unit of the limited number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Quantity(quantity) => quantity.unit(),
            Self::VonMisesPaBelowDepthM(_) => "Pa",
        }
    }
}
