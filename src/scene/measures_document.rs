//! What the measures need to know, in a scene document.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the measures need to know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuresDocument {
    /// Thresholds of von Mises stress for "depth of significant stress" [Pa].
    #[serde(default = "default_thresholds")]
    pub stress_thresholds_pa: Vec<f64>,
    /// Thresholds of strain energy density: the volume above each is told [J/m³].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strain_energy_density_thresholds_j_per_m3: Vec<f64>,
    /// Thresholds of the largest principal Green–Lagrange strain: the volume above each is told [-].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub principal_strain_thresholds: Vec<f64>,
    /// Window τ of the peak force: the maximum of ΔI/τ [s].
    #[serde(default = "default_force_window")]
    pub force_window_s: f64,
    /// Node set of the tissue that is its skin, from which depth is measured; by default the whole outer surface that is
    /// not fixed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skin_set: Option<String>,
    /// Who is hit, and where: what published injury criteria ask for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub person: Option<PersonDocument>,
}

/// Who is hit, and where.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PersonDocument {
    /// Where the tissue of the scene is.
    pub region: Region,
    /// Mass of the person [kg].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body_mass_kg: Option<f64>,
    /// Thickness of the body wall where it is hit [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_thickness_m: Option<f64>,
    /// Depth of the chest, front to back [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chest_depth_m: Option<f64>,
}

/// A region of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Region {
    /// Head or neck.
    Head,
    /// Chest.
    Thorax,
    /// Belly.
    Abdomen,
    /// Arm or leg.
    Limb,
}

fn default_thresholds() -> Vec<f64> {
    vec![10e3, 30e3, 100e3]
}
fn default_force_window() -> f64 {
    5e-6
}

impl Default for MeasuresDocument {
    fn default() -> Self {
        Self {
            stress_thresholds_pa: default_thresholds(),
            strain_energy_density_thresholds_j_per_m3: Vec::new(),
            principal_strain_thresholds: Vec::new(),
            force_window_s: default_force_window(),
            skin_set: None,
            person: None,
        }
    }
}
