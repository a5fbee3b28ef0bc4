//! Relaxation of the stress of a part, in a scene document.

use crate::mechanics::material::{Branch, Material, PronySeries};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A Prony series on the isochoric stress of the law: for small strains the relaxation modulus is G(t) = G∞ (1 + Σ gᵢ e^(−t/τᵢ)). What a
/// run starts from (initial deformation, settling, preload) has relaxed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PronyDocument {
    /// At which rate the constants of the law were measured. The moduli of the branches are relative to the same.
    #[serde(default, skip_serializing_if = "Moduli::is_default")]
    pub moduli: Moduli,
    /// One term each, six at most.
    pub branches: Vec<BranchDocument>,
}

/// Which moduli the constants of a law are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Moduli {
    /// Those of slow loading, G∞: G(t) = G∞ (1 + Σ gᵢ e^(−t/τᵢ)).
    #[default]
    LongTerm,
    /// Those of sudden loading, G₀: G(t) = G₀ (1 − Σ gᵢ (1 − e^(−t/τᵢ))), Σ gᵢ < 1.
    Instantaneous,
}

impl Moduli {
    #[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// One term of a series.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BranchDocument {
    /// Modulus gᵢ over that of the law [-].
    pub relative_modulus: f64,
    /// Relaxation time τᵢ [s].
    pub relaxation_time_s: f64,
}

impl PronyDocument {
    /// Sum of the relative moduli as they are given [-].
    pub fn sum(&self) -> f64 {
        self.branches.iter().map(|branch| branch.relative_modulus).sum()
    }

    /// What is left of the law's isochoric stress under slow loading [-].
    fn slow(&self) -> f64 {
        match self.moduli {
            Moduli::LongTerm => 1.0,
            Moduli::Instantaneous => 1.0 - self.sum(),
        }
    }

    /// The law under slow loading; `None` if it is coupled.
    pub fn slow_law(&self, material: Material) -> Option<Material> {
        if self.moduli == Moduli::LongTerm {
            Some(material)
        } else {
            material.with_isochoric_scaled(self.slow())
        }
    }

    /// The series relative to slow loading; without branches where there are too many, which validation refuses.
    pub fn series(&self) -> PronySeries {
        let slow = self.slow();
        let branch = |b: &BranchDocument| Branch {
            relative_modulus: b.relative_modulus / slow,
            relaxation_time: b.relaxation_time_s,
        };
        PronySeries::new(&self.branches.iter().map(branch).collect::<Vec<_>>()).unwrap_or_default()
    }
}
