//! Inputs of the measures, in a scene document.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Inputs of the measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuresDocument {
    /// Thresholds of von Mises stress for "depth of significant stress" [Pa].
    #[serde(default = "default_thresholds")]
    pub stress_thresholds_pa: Vec<f64>,
    /// Thresholds of strain energy density; the volume above each is reported [J/m³].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strain_energy_density_thresholds_j_per_m3: Vec<f64>,
    /// Thresholds of the largest principal Green–Lagrange strain; the volume above each is reported [-].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub principal_strain_thresholds: Vec<f64>,
    /// Volume of tissue for which the largest principal strain and the von Mises stress exceeded in it are reported [m³];
    /// by default 1e-7, which is 100 mm³.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exceeded_in_volume_m3: Option<f64>,
    /// Window τ of the peak force, the maximum of ΔI/τ [s]; by default 1/10 of the duration of contact, but at least ten
    /// steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_window_s: Option<f64>,
    /// Filter the force as in crash tests instead, and report its maximum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_filter: Option<ForceFilter>,
    /// Node set of the tissue's surface from which depth is measured; by default the whole boundary that is not fixed,
    /// without the cut sections of a generated limb, and of generated layers their top.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skin_set: Option<String>,
    /// Person and place of impact, required by published injury criteria.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub person: Option<PersonDocument>,
}

/// Channel frequency classes of SAE J211-1 (ISO 6487): a low-pass filter without delay, −3 dB at class / 0.6 Hz.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ForceFilter {
    /// CFC 60: 100 Hz.
    #[serde(rename = "cfc_60")]
    Cfc60,
    /// CFC 180: 300 Hz.
    #[serde(rename = "cfc_180")]
    Cfc180,
    /// CFC 600: 1000 Hz.
    #[serde(rename = "cfc_600")]
    Cfc600,
    /// CFC 1000: 1650 Hz.
    #[serde(rename = "cfc_1000")]
    Cfc1000,
}

impl ForceFilter {
    /// All classes, in ascending order.
    pub const ALL: [Self; 4] = [Self::Cfc60, Self::Cfc180, Self::Cfc600, Self::Cfc1000];

    /// The channel frequency class [Hz].
    pub fn class(self) -> f64 {
        match self {
            Self::Cfc60 => 60.0,
            Self::Cfc180 => 180.0,
            Self::Cfc600 => 600.0,
            Self::Cfc1000 => 1000.0,
        }
    }
    /// Name in engineering notation, such as "CFC 60".
    pub fn name(self) -> &'static str {
        match self {
            Self::Cfc60 => "CFC 60",
            Self::Cfc180 => "CFC 180",
            Self::Cfc600 => "CFC 600",
            Self::Cfc1000 => "CFC 1000",
        }
    }
    /// The class with a given name, as from [`Self::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|filter| filter.name() == name)
    }
}

/// The person who is hit, and where.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PersonDocument {
    /// Body region represented by the tissue of the scene.
    pub region: Region,
    /// Mass of the person [kg].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body_mass_kg: Option<f64>,
    /// Thickness of the body wall at the impact [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_thickness_m: Option<f64>,
    /// Depth of the chest from front to back [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chest_depth_m: Option<f64>,
}

/// A region of the human body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Region {
    /// Head or neck.
    Head,
    /// Chest (thorax), where criteria of its deflection apply.
    Thorax,
    /// Belly (abdomen).
    Abdomen,
    /// Arm or leg.
    Limb,
}

fn default_thresholds() -> Vec<f64> {
    vec![10e3, 30e3, 100e3]
}

impl MeasuresDocument {
    /// Default of [`Self::exceeded_in_volume_m3`]: 100 mm³.
    pub const EXCEEDED_IN_VOLUME: f64 = 1e-7;
}

impl Default for MeasuresDocument {
    fn default() -> Self {
        Self {
            stress_thresholds_pa: default_thresholds(),
            strain_energy_density_thresholds_j_per_m3: Vec::new(),
            principal_strain_thresholds: Vec::new(),
            exceeded_in_volume_m3: None,
            force_window_s: None,
            force_filter: None,
            skin_set: None,
            person: None,
        }
    }
}
