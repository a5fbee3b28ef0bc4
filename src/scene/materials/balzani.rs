//! The polyconvex law of Schröder, Neff and Balzani in a scene document.

use super::checks::{self, MOST_MODULUS};
use super::{Families, LawDocument, VolumetricDocument};
use crate::mechanics::material::{Balzani, FibreFamilies, Material};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Admissible powers [-]: above 2 the tangent is continuous where the fibres switch on; the upper bound exceeds fitted
/// values.
const POWERS: [f64; 2] = [2.0, 50.0];

/// ψ = c1 (Ī1 − 3) + Σ α1 ⟨I1 I4 − I5 − 2⟩^α2 + U(J)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BalzaniDocument {
    /// Matrix coefficient c1 [Pa], half the shear modulus.
    pub c1_pa: f64,
    /// Fibre stiffness α1 [Pa].
    pub alpha1_pa: f64,
    /// Power α2 [-], above 2.
    pub alpha2: f64,
    /// Fibre families, in the material axes.
    pub fibres: Families,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for BalzaniDocument {
    fn to_material(&self) -> Option<Material> {
        let law = Balzani {
            c1: self.c1_pa,
            alpha1: self.alpha1_pa,
            alpha2: self.alpha2,
            families: FibreFamilies::new(&self.fibres.directions())?,
            volumetric: self.volumetric.with(self.bulk_modulus_pa),
        };
        Some(law.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c1_pa"), "c1", self.c1_pa, out);
        let stiffness = here.key("alpha1_pa");
        let remedy = "0 for no fibres; a negative value is unstable";
        out.not_negative(&stiffness, "the fibre stiffness α1", self.alpha1_pa, remedy);
        out.at_most(&stiffness, "the fibre stiffness α1", self.alpha1_pa, MOST_MODULUS, "give it in Pa");
        out.require(self.alpha2 > POWERS[0] && self.alpha2 <= POWERS[1], || {
            Problem::error("out_of_range", &here.key("alpha2"), "the power α2 is out of its range")
                .value(self.alpha2)
                .limit(format!("above {}, at most {}", POWERS[0], POWERS[1]))
                .remedy("a power of 2 or less has a discontinuous tangent where the fibres switch on: use 2.01 instead of 2")
        });
        let idle_remedy = "use neo_hookean with C10 = c1: it is the same solid and costs less";
        checks::families(&self.fibres, self.alpha1_pa, idle_remedy, here, out);
        checks::bulk(self.bulk_modulus_pa, 2.0 * self.c1_pa, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.c1_pa *= factor;
        self.alpha1_pa *= factor;
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }

    fn family_count(&self) -> usize {
        self.fibres.count()
    }
}
