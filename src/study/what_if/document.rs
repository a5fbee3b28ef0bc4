//! The question as it is written (JSON): a base, what varies, and in which cases.

use super::super::error::Quantity;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// A what-if question. One of `scene` and `job` is the base; on the command line the base is a file, and both are absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct WhatIfDocument {
    /// The base: a scene document.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub scene: Option<Value>,
    /// The base: the scene of a job, by its id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<String>,
    /// What varies.
    pub parameters: Vec<ParameterDocument>,
    /// Cases by hand.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cases: Vec<CaseDocument>,
    /// Every parameter at its low and its high end, the others as in the base: sensitivities.
    #[serde(default)]
    pub one_at_a_time: bool,
    /// Many cases spread over all parameters: spread and, if asked, Sobol indices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample: Option<SampleDocument>,
    /// "Up to which value of a parameter does a number stay below a limit?"
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<LimitDocument>,
    /// Where the error bars come from.
    #[serde(default)]
    pub error_bars: ErrorSource,
}

/// One parameter: what it changes, and over which range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ParameterDocument {
    /// Name by which cases and limits speak of it, unique.
    pub name: String,
    /// What it changes.
    pub change: Change,
    /// Low end of its range, in the unit of the change; by default the 5th percentile of the distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// High end of its range; by default the 95th percentile of the distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// How samples are spread; by default evenly from `low` to `high`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
}

/// A change of the scene by one number, whose unit is the end of its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Change {
    /// Speed of a body, its direction kept [m/s].
    #[serde(rename = "speed_m_per_s")]
    Speed {
        /// The body; by default the projectile.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
    },
    /// Mass of a body, by its densities, its shape kept [kg].
    #[serde(rename = "mass_kg")]
    Mass {
        /// The body; by default the projectile.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
    },
    /// The velocity of a body turned about an axis, right-handed, from that of the base [degree].
    #[serde(rename = "angle_deg")]
    Angle {
        /// The body; by default the projectile.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// The axis, of any length.
        about: [f64; 3],
    },
    /// A body moved along a direction, from where it is in the base [m].
    #[serde(rename = "offset_m")]
    Offset {
        /// The body; by default the projectile.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// The direction, of any length.
        along: [f64; 3],
    },
    /// Impact point on the skin of any mesh: how far it goes over the skin from that of the base, straight ahead in a direction [m].
    /// The projectile goes with it and meets the skin there as it did in the base.
    #[serde(rename = "impact_offset_m")]
    ImpactOffset {
        /// The projectile, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// The body that is hit; by default the first with a mesh on the way of the projectile.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        target: Option<String>,
        /// The direction, of any length; what of it points into the skin or out of it does not count.
        along: [f64; 3],
    },
    /// Impact point around a limb segment: its `impact_angle_deg`, from +z towards +x [degree]. The projectile goes with it
    /// and meets the skin there as it did in the base.
    #[serde(rename = "impact_around_deg")]
    ImpactAround {
        /// The projectile, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// The limb, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limb: Option<String>,
    },
    /// Impact point along a limb segment: its `impact_along_m` [m]. The projectile goes with it.
    #[serde(rename = "impact_along_m")]
    ImpactAlong {
        /// The projectile, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        body: Option<String>,
        /// The limb, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limb: Option<String>,
    },
    /// Thickness of a layer of a limb segment, its outline kept: the muscle takes what is left [m].
    #[serde(rename = "layer_thickness_m")]
    LayerThickness {
        /// The layer.
        layer: Layer,
        /// The limb, unless there is only one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limb: Option<String>,
    },
    /// Coefficient of Coulomb friction [-].
    Friction {
        /// One pair of the scene's list; by default every pair.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        between: Option<[String; 2]>,
    },
    /// Factor on all stiffnesses of a part but its bulk modulus (or λ) [-].
    StiffnessFactor {
        /// The body.
        body: String,
        /// The part, as its entry in the scene is called.
        part: String,
    },
    /// The same as a percentile of a population: stiffness is log-normal about the scene's, which is the median [%].
    StiffnessPercentile {
        /// The body.
        body: String,
        /// The part, as its entry in the scene is called.
        part: String,
        /// Coefficient of variation of the population: standard deviation over mean [-].
        coefficient_of_variation: f64,
    },
    /// Any number of the scene document, in the unit that it has there.
    Number {
        /// Where it is (RFC 6901).
        pointer: String,
    },
}

/// A layer over the muscle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// Fat.
    Fat,
    /// Skin.
    Skin,
}

/// How the values of a parameter are spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Distribution {
    /// Normal.
    Normal {
        /// Mean, in the unit of the change.
        mean: f64,
        /// Standard deviation.
        standard_deviation: f64,
    },
    /// Log-normal.
    LogNormal {
        /// Median, in the unit of the change.
        median: f64,
        /// Standard deviation over mean [-].
        coefficient_of_variation: f64,
    },
}

/// One case by hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct CaseDocument {
    /// What it is called; by default its values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Values of parameters, by name; the others are those of the base.
    pub set: BTreeMap<String, f64>,
}

/// A sampled design.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct SampleDocument {
    /// How points are chosen.
    #[serde(default)]
    pub method: SampleMethod,
    /// Points; Sobol indices of k parameters take (k + 2) times as many runs.
    pub count: u32,
    /// Seed: the same gives the same points on every machine.
    #[serde(default)]
    pub seed: u64,
    /// Whether Sobol indices are wanted.
    #[serde(default)]
    pub indices: bool,
}

/// How points are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum SampleMethod {
    /// The sequence of Sobol, shifted at random; best with a power of two.
    #[default]
    Sobol,
    /// Latin hypercube.
    LatinHypercube,
}

/// "Up to which value of the parameter, from low to high, does the number stay at or below the limit?"
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct LimitDocument {
    /// Name of the parameter; the others are those of the base.
    pub parameter: String,
    /// The number.
    pub measure: LimitMeasure,
    /// The limit, in the unit of the number.
    pub at_most: f64,
    /// The answer is bracketed to this share of the range [-].
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
}

fn default_tolerance() -> f64 {
    1e-3
}

/// A number that may have a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum LimitMeasure {
    /// A number of the table.
    #[cfg_attr(feature = "service", schema(value_type = String))]
    Quantity(Quantity),
    /// Largest von Mises stress [Pa] at any field time in the tissue from this depth below the skin on [m].
    VonMisesPaBelowDepthM(f64),
}

/// Where the error bars of the cases come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum ErrorSource {
    /// From the base: its relative errors are those of all cases. Three cheaper runs in all.
    #[default]
    Base,
    /// Each case has its own: three cheaper runs each, about a third more time.
    Full,
    /// There are none.
    None,
}

impl LimitMeasure {
    /// The depth that stresses are wanted below [m].
    pub fn depth(self) -> Option<f64> {
        match self {
            Self::Quantity(_) => None,
            Self::VonMisesPaBelowDepthM(depth) => Some(depth),
        }
    }
    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Quantity(quantity) => quantity.title().1,
            Self::VonMisesPaBelowDepthM(_) => "Pa",
        }
    }
}
