//! The neo-Hookean laws in a scene document: the isochoric split and the coupled compressible form.

use super::checks::{self, MOST_MODULUS};
use super::{LawDocument, VolumetricDocument};
use crate::mechanics::material::{CoupledNeoHookean, Material, NeoHookean};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = C10 (Ī1 − 3) + U(J)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NeoHookeanDocument {
    /// Coefficient C10 [Pa], half the shear modulus.
    pub c10_pa: f64,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for NeoHookeanDocument {
    fn to_material(&self) -> Option<Material> {
        Some(NeoHookean { c10: self.c10_pa, volumetric: self.volumetric.with(self.bulk_modulus_pa) }.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c10_pa"), "C10", self.c10_pa, out);
        checks::bulk(self.bulk_modulus_pa, 2.0 * self.c10_pa, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.c10_pa *= factor;
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }
}

/// ψ = μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)²
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledNeoHookeanDocument {
    /// Shear modulus μ [Pa].
    pub mu_pa: f64,
    /// First Lamé parameter λ [Pa].
    pub lambda_pa: f64,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for CoupledNeoHookeanDocument {
    fn to_material(&self) -> Option<Material> {
        Some(CoupledNeoHookean { mu: self.mu_pa, lambda: self.lambda_pa }.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        let (mu, lambda) = (self.mu_pa, self.lambda_pa);
        let place = here.key("lambda_pa");
        checks::modulus(&here.key("mu_pa"), "the shear modulus", mu, out);
        out.at_most(&place, "λ", lambda, MOST_MODULUS, "give it in Pa");
        let K = lambda + 2.0 / 3.0 * mu;
        out.require(K > 0.0, || {
            let message = format!("the bulk modulus λ + 2μ/3 = {K} Pa is not positive: the law is unstable");
            Problem::error("unstable_law", &place, message)
                .value(lambda)
                .limit(format!("> -2μ/3 = {}", -2.0 / 3.0 * mu))
                .remedy("λ = K − 2μ/3; λ = 0 has Poisson's ratio about 0")
        });
        checks::ratio(K, mu, &place, out);
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
