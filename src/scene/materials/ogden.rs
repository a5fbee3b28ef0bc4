//! The Ogden law in a scene document.

use super::checks::{self, MOST_MODULUS};
use super::{LawDocument, VolumetricDocument};
use crate::mechanics::material::{MAX_OGDEN_TERMS, Material, Ogden, OgdenTerm};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Upper bound of the fitted powers of the stretch [-].
const MOST_POWER: f64 = 50.0;

/// ψ = Σ μ/α (λ̄1^α + λ̄2^α + λ̄3^α − 3) + U(J), λ̄ = J^(−1/3) λ
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OgdenDocument {
    /// Terms of the law; the shear modulus at rest is ½ Σ μ α.
    pub terms: OgdenTerms,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

/// Terms of an Ogden law, in either of two notations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum OgdenTerms {
    /// μ/α (λ̄1^α + λ̄2^α + λ̄3^α − 3).
    MuAlpha(Vec<MuAlpha>),
    /// c/m² (λ̄1^m + λ̄2^m + λ̄3^m − 3), the notation of FEBio: μ = c/m, α = m.
    Febio(Vec<FebioTerm>),
}

/// One term in Ogden's notation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MuAlpha {
    /// Coefficient μ [Pa], of the same sign as α.
    pub mu_pa: f64,
    /// Power α of the stretches [-].
    pub alpha: f64,
}

/// One term in the notation of FEBio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FebioTerm {
    /// Coefficient c of the term [Pa].
    pub c_pa: f64,
    /// Power m of the stretches [-].
    pub m: f64,
}

impl OgdenTerms {
    fn terms(&self) -> Vec<OgdenTerm> {
        match self {
            Self::MuAlpha(terms) => terms.iter().map(|t| OgdenTerm { mu: t.mu_pa, alpha: t.alpha }).collect(),
            Self::Febio(terms) => terms.iter().map(|t| OgdenTerm { mu: t.c_pa / t.m, alpha: t.m }).collect(),
        }
    }

    /// Field names of the list, the modulus and the power.
    fn names(&self) -> [&'static str; 3] {
        match self {
            Self::MuAlpha(_) => ["mu_alpha", "mu_pa", "alpha"],
            Self::Febio(_) => ["febio", "c_pa", "m"],
        }
    }
}

impl LawDocument for OgdenDocument {
    fn to_material(&self) -> Option<Material> {
        let law = Ogden::new(&self.terms.terms(), self.volumetric.with(self.bulk_modulus_pa))?;
        Some(law.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        let (terms, [list, modulus, power]) = (self.terms.terms(), self.terms.names());
        let place = here.key("terms").key(list);
        out.require((1..=MAX_OGDEN_TERMS).contains(&terms.len()), || {
            Problem::error("too_many_items", &place, "the number of terms is out of its range")
                .value(terms.len())
                .limit(format!("1 to {MAX_OGDEN_TERMS}"))
                .remedy("three terms fit rubber over its whole range")
        });
        for (i, term) in terms.iter().enumerate() {
            let here = place.index(i);
            out.at_most(
                &here.key(modulus),
                "the modulus",
                term.mu * term.alpha,
                MOST_MODULUS,
                "give it in Pa",
            );
            out.require(term.alpha != 0.0 && term.alpha.abs() <= MOST_POWER, || {
                Problem::error("out_of_range", &here.key(power), "the power of a stretch is out of its range")
                    .value(term.alpha)
                    .limit(format!("not 0, and from -{MOST_POWER} to {MOST_POWER}"))
                    .remedy("tissue has powers up to about 30; a power near 0 is the logarithm, which 0.01 approximates")
            });
        }
        let G = terms.iter().map(|term| 0.5 * term.mu * term.alpha).sum();
        checks::modulus(&place, "the shear modulus ½ Σ μ α", G, out);
        checks::stability(self.to_material(), &place, out);
        checks::bulk(self.bulk_modulus_pa, G, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        match &mut self.terms {
            OgdenTerms::MuAlpha(terms) => terms.iter_mut().for_each(|term| term.mu_pa *= factor),
            OgdenTerms::Febio(terms) => terms.iter_mut().for_each(|term| term.c_pa *= factor),
        }
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }
}
