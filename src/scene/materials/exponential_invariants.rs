//! The Demiray and Veronda–Westmann laws in a scene document.

use super::checks::{self, MOST_EXPONENT};
use super::{LawDocument, VolumetricDocument};
use crate::mechanics::material::{Demiray, Material, VerondaWestmann};
use crate::scene::problem::Pointer;
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = μ/(2b) (exp[b (Ī1 − 3)] − 1) + U(J)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DemirayDocument {
    /// Shear modulus at rest μ [Pa].
    pub mu_pa: f64,
    /// Exponent b of the exponential [-].
    pub b: f64,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for DemirayDocument {
    fn to_material(&self) -> Option<Material> {
        let volumetric = self.volumetric.with(self.bulk_modulus_pa);
        Some(Demiray { mu: self.mu_pa, b: self.b, volumetric }.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("mu_pa"), "the shear modulus μ", self.mu_pa, out);
        check_exponent(&here.key("b"), "the exponent b", self.b, out);
        checks::bulk(self.bulk_modulus_pa, self.mu_pa, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.mu_pa *= factor;
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }
}

/// ψ = C1 (exp[C2 (Ī1 − 3)] − 1) − C1 C2/2 (Ī2 − 3) + U(J)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VerondaWestmannDocument {
    /// Coefficient C1 [Pa]; the shear modulus at rest is C1 C2.
    pub c1_pa: f64,
    /// Exponent C2 of the exponential [-].
    pub c2: f64,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for VerondaWestmannDocument {
    fn to_material(&self) -> Option<Material> {
        let volumetric = self.volumetric.with(self.bulk_modulus_pa);
        Some(VerondaWestmann { c1: self.c1_pa, c2: self.c2, volumetric }.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c1_pa"), "C1", self.c1_pa, out);
        check_exponent(&here.key("c2"), "the exponent C2", self.c2, out);
        checks::stability(self.to_material(), &here.key("c2"), out);
        checks::bulk(self.bulk_modulus_pa, self.c1_pa * self.c2, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.c1_pa *= factor;
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }
}

fn check_exponent(place: &Pointer, what: &str, value: f64, out: &mut Findings) {
    out.positive(place, what, value, "a small exponent such as 0.01 is nearly neo-Hookean");
    out.at_most(place, what, value, MOST_EXPONENT, "skin and fat have 0.1 to 100");
}
