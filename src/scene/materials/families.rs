//! Fibre families in a scene document.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fibre families, in the material axes e1, e2, e3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Families {
    /// Angles from e1 towards e2, one per family [degree]; two families at ±β are `[β, −β]`.
    AnglesDeg(Vec<f64>),
    /// Directions of any length, one per family.
    Directions(Vec<[f64; 3]>),
}

impl Families {
    /// Number of fibre families.
    pub fn count(&self) -> usize {
        match self {
            Self::AnglesDeg(angles) => angles.len(),
            Self::Directions(directions) => directions.len(),
        }
    }

    /// Directions in the material axes, of any length.
    pub fn directions(&self) -> Vec<[f64; 3]> {
        match self {
            Self::AnglesDeg(angles) => {
                let direction = |angle: &f64| [angle.to_radians().cos(), angle.to_radians().sin(), 0.0];
                angles.iter().map(direction).collect()
            }
            Self::Directions(directions) => directions.clone(),
        }
    }
}
