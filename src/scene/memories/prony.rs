//! Stress relaxation of a part, in a scene document.

use super::{MemoryDocument, Rules};
use crate::mechanics::material::{Branch, MAX_BRANCHES, Material, Memories, PronySeries};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Usual relaxation times in impacts [s].
const USUAL_TIMES: [f64; 2] = [1e-6, 1e4];

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

impl MemoryDocument for PronyDocument {
    fn rules(&self) -> Rules {
        Rules {
            name: "relaxation",
            without_explicit_steps: None,
            needs_pressure_of_element: false,
            damages: false,
            depends_on_rate: true,
        }
    }

    fn code_with_coupled_law(&self) -> &'static str {
        "coupled_law_with_prony_series"
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        let branches = here.key("branches");
        let count = self.branches.len();
        out.require((1..=MAX_BRANCHES).contains(&count), || {
            Problem::error("number_of_branches", &branches, format!("the series has {count} branches"))
                .value(count as u64)
                .limit(format!("1 to {MAX_BRANCHES}"))
                .remedy("one branch per decade of time is enough; omit the series where nothing relaxes")
        });
        // Relaxation time and relative modulus of each branch.
        for (i, branch) in self.branches.iter().enumerate() {
            let here = branches.index(i);
            let time = here.key("relaxation_time_s");
            let remedy = "soft tissue relaxes over milliseconds to minutes; a branch slower than the run is part of the law";
            out.positive(&time, "a relaxation time", branch.relaxation_time_s, remedy);
            if branch.relaxation_time_s > 0.0 {
                out.usual(&time, "the relaxation time", branch.relaxation_time_s, USUAL_TIMES, remedy);
            }
            let remedy = "moduli are relative to the constants of the law, see moduli";
            out.not_negative(
                &here.key("relative_modulus"),
                "a relative modulus",
                branch.relative_modulus,
                remedy,
            );
            out.at_most(
                &here.key("relative_modulus"),
                "the relative modulus",
                branch.relative_modulus,
                1e4,
                remedy,
            );
        }
        // Instantaneous constants: 1 − Σ g must remain under slow loading.
        out.require(self.moduli == Moduli::LongTerm || self.sum() < 1.0, || {
            Problem::error("nothing_is_left", &branches, "relaxation leaves no stress under slow loading")
                .value(self.sum())
                .limit("relative moduli that sum up to less than 1, since the law's constants are the instantaneous ones")
                .remedy("check the moduli, or say \"long_term\" where they are relative to slow loading")
        });
    }

    fn set(&self, memories: &mut Memories) {
        memories.prony = self.series();
    }

    fn slow_law(&self, law: Material) -> Option<Material> {
        if self.moduli == Moduli::LongTerm { Some(law) } else { law.with_isochoric_scaled(self.slow()) }
    }
}
