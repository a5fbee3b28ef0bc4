//! Weiss's transversely isotropic law in a scene document.

use super::checks::{self, MOST_EXPONENT, MOST_MODULUS};
use super::{Families, I4Invariants, LawDocument, VolumetricDocument};
use crate::mechanics::material::{
    FibreFamilies, MOST_TOE_EXPONENT, MOST_TOE_STRETCH, Material, StraighteningFibres, Weiss,
};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = C10 (Ī1 − 3) + C01 (Ī2 − 3) + Σ W(λ) + U(J), with λ W′ = 0 up to λ = 1, C3 (exp[C4 (λ − 1)] − 1) up to λ_m, C5 λ + C6 beyond
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeissDocument {
    /// Matrix coefficient C10 [Pa].
    pub c10_pa: f64,
    /// Matrix coefficient C01 [Pa].
    #[serde(default)]
    pub c01_pa: f64,
    /// Stiffness C3 of the toe region [Pa].
    pub c3_pa: f64,
    /// Exponent C4 of the toe region [-].
    pub c4: f64,
    /// Modulus C5 of straight fibres [Pa].
    pub c5_pa: f64,
    /// Stretch λ_m at which the fibres are straight [-].
    pub straight_stretch: f64,
    /// Fibre families, in the material axes.
    pub fibres: Families,
    /// The fibre stretch λ: that of F, or of J^(−1/3) F.
    #[serde(default)]
    pub i4: I4Invariants,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for WeissDocument {
    fn to_material(&self) -> Option<Material> {
        let law = Weiss {
            c10: self.c10_pa,
            c01: self.c01_pa,
            fibres: StraighteningFibres::new(self.c3_pa, self.c4, self.c5_pa, self.straight_stretch),
            families: FibreFamilies::new(&self.fibres.directions())?,
            i4: self.i4.form(),
            volumetric: self.volumetric.with(self.bulk_modulus_pa),
        };
        Some(law.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c10_pa"), "C10", self.c10_pa, out);
        let remedy = "give it in Pa; 0 omits the term, a negative value is unstable";
        for (name, value) in [("c01_pa", self.c01_pa), ("c3_pa", self.c3_pa), ("c5_pa", self.c5_pa)] {
            out.not_negative(&here.key(name), "the modulus", value, remedy);
            out.at_most(&here.key(name), "the modulus", value, MOST_MODULUS, "give it in Pa");
        }
        self.check_toe(here, out);
        let idle_remedy = "use mooney_rivlin with the same C10 and C01: it is the same solid and costs less";
        checks::families(&self.fibres, self.c3_pa.max(self.c5_pa), idle_remedy, here, out);
        checks::bulk(self.bulk_modulus_pa, 2.0 * (self.c10_pa + self.c01_pa), self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        for modulus in [&mut self.c10_pa, &mut self.c01_pa, &mut self.c3_pa, &mut self.c5_pa] {
            *modulus *= factor;
        }
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }

    fn family_count(&self) -> usize {
        self.fibres.count()
    }
}

impl WeissDocument {
    /// The toe region must exist, and its energy must be within the range of its series.
    fn check_toe(&self, here: &Pointer, out: &mut Findings) {
        let (c4, toe) = (&here.key("c4"), self.straight_stretch - 1.0);
        out.positive(c4, "the exponent C4", self.c4, "a small C4 such as 0.01 is nearly linear");
        out.at_most(c4, "the exponent C4", self.c4, MOST_EXPONENT, "ligaments have 10 to 100");
        out.require(toe > 0.0 && self.straight_stretch <= MOST_TOE_STRETCH, || {
            let message = "the stretch at which fibres are straight is out of its range";
            Problem::error("out_of_range", &here.key("straight_stretch"), message)
                .value(self.straight_stretch)
                .limit(format!("above 1, at most {MOST_TOE_STRETCH}"))
                .remedy("ligaments and tendons have 1.01 to 1.1; fibres without a toe have 1.0001")
        });
        out.require(self.c4 * toe <= MOST_TOE_EXPONENT, || {
            let message = "the toe region stiffens more than that of any fibre";
            Problem::error("out_of_range", c4, message)
                .value(self.c4)
                .limit(format!(
                    "C4 (λ_m − 1) at most {MOST_TOE_EXPONENT}: C4 at most {:.4e}",
                    MOST_TOE_EXPONENT / toe
                ))
                .remedy("lower straight_stretch, or C4")
        });
    }
}
