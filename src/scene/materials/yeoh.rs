//! The Yeoh law in a scene document.

use super::checks::{self, MOST_MODULUS};
use super::{LawDocument, VolumetricDocument};
use crate::mechanics::material::{Material, Yeoh};
use crate::scene::problem::Pointer;
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = C10 (Ī1 − 3) + C20 (Ī1 − 3)² + C30 (Ī1 − 3)³ + U(J)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct YeohDocument {
    /// Coefficient C10 [Pa], half the shear modulus.
    pub c10_pa: f64,
    /// Coefficient C20 [Pa]; negative where rubber softens before it stiffens.
    #[serde(default)]
    pub c20_pa: f64,
    /// Coefficient C30 of (Ī1 − 3)³ [Pa].
    #[serde(default)]
    pub c30_pa: f64,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for YeohDocument {
    fn to_material(&self) -> Option<Material> {
        let volumetric = self.volumetric.with(self.bulk_modulus_pa);
        Some(Yeoh { c10: self.c10_pa, c20: self.c20_pa, c30: self.c30_pa, volumetric }.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c10_pa"), "C10", self.c10_pa, out);
        for (name, value) in [("c20_pa", self.c20_pa), ("c30_pa", self.c30_pa)] {
            out.at_most(&here.key(name), "the constant", value, MOST_MODULUS, "give it in Pa");
        }
        let place = here.key(if self.c20_pa < 0.0 { "c20_pa" } else { "c30_pa" });
        checks::stability(self.to_material(), &place, out);
        checks::bulk(self.bulk_modulus_pa, 2.0 * self.c10_pa, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.c10_pa *= factor;
        self.c20_pa *= factor;
        self.c30_pa *= factor;
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }
}
