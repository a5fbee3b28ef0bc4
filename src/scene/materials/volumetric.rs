//! Form of the volumetric energy in a scene document.

use crate::mechanics::material::Volumetric;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Form of the volumetric energy U(J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VolumetricDocument {
    /// Logarithmic: K/2 (ln J)²
    #[default]
    LnSquared,
    /// Quadratic: K/2 (J − 1)²
    Quadratic,
    /// Quadratic with logarithm: K/4 (J² − 1 − 2 ln J)
    QuadraticLn,
}

impl VolumetricDocument {
    /// The volumetric energy with bulk modulus K [Pa].
    pub fn with(self, K: f64) -> Volumetric {
        match self {
            Self::LnSquared => Volumetric::LnSquared(K),
            Self::Quadratic => Volumetric::Quadratic(K),
            Self::QuadraticLn => Volumetric::QuadraticLn(K),
        }
    }
}
