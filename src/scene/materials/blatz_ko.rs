//! The Blatz–Ko law in a scene document.

use super::{LawDocument, checks};
use crate::mechanics::material::{BlatzKo, Material};
use crate::scene::problem::Pointer;
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = μ/2 (I2/I3 + 2 √I3 − 5)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlatzKoDocument {
    /// Shear modulus μ [Pa]; Poisson's ratio is ¼.
    pub mu_pa: f64,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for BlatzKoDocument {
    fn to_material(&self) -> Option<Material> {
        Some(BlatzKo { mu: self.mu_pa }.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("mu_pa"), "the shear modulus", self.mu_pa, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.mu_pa *= factor;
    }

    fn is_split(&self) -> bool {
        false
    }
}
