//! Stress relaxation of a part, in a scene document.

use crate::mechanics::material::{Branch, Material, PronySeries};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A Prony series on the isochoric stress of the law: for small strains the relaxation modulus is G(t) = G∞ (1 + Σ gᵢ
/// e^(−t/τᵢ)). The initial state of a run (initial deformation, dynamic relaxation, preload) is fully relaxed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PronyDocument {
    /// Loading rate that the constants of the law refer to. The relative moduli of the branches refer to the same.
    #[serde(default, skip_serializing_if = "Moduli::is_default")]
    pub moduli: Moduli,
    /// Terms of the series, one to six.
    pub branches: Vec<BranchDocument>,
}

/// The moduli given by the constants of a law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Moduli {
    /// Long-term moduli G∞ (slow loading): G(t) = G∞ (1 + Σ gᵢ e^(−t/τᵢ)).
    #[default]
    LongTerm,
    /// Instantaneous moduli G₀ (sudden loading): G(t) = G₀ (1 − Σ gᵢ (1 − e^(−t/τᵢ))), Σ gᵢ < 1.
    Instantaneous,
}

impl Moduli {
    #[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// One term of a Prony series.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BranchDocument {
    /// Modulus gᵢ relative to that of the law [-].
    pub relative_modulus: f64,
    /// Relaxation time τᵢ [s].
    pub relaxation_time_s: f64,
}

impl PronyDocument {
    /// Sum of the given relative moduli [-].
    pub fn sum(&self) -> f64 {
        self.branches.iter().map(|branch| branch.relative_modulus).sum()
    }

    /// Fraction of the law's isochoric stress that remains under slow loading [-].
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

    /// The series relative to slow loading; empty if it has too many branches, which validation refuses.
    pub fn series(&self) -> PronySeries {
        let slow = self.slow();
        let branch = |b: &BranchDocument| Branch {
            relative_modulus: b.relative_modulus / slow,
            relaxation_time: b.relaxation_time_s,
        };
        PronySeries::new(&self.branches.iter().map(branch).collect::<Vec<_>>()).unwrap_or_default()
    }
}
