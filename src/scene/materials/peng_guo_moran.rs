//! The law of Peng, Guo and Moran in a scene document.

use super::checks::{self, MOST_MODULUS};
use super::{Families, LawDocument, VolumetricDocument};
use crate::mechanics::material::{FibreFamilies, FibreShear, Material, PengGuoMoran};
use crate::scene::problem::Pointer;
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Admissible stretches λ* [-].
const STRETCHES: [f64; 2] = [0.1, 10.0];
/// Largest admissible β [-]: beyond, f is a step within a thousandth of stretch.
const MOST_BETA: f64 = 1e4;

/// ψ = C10 (Ī1 − 3) + Σ [C2 ⟨I4 − 1⟩² + C3 ⟨I4 − 1⟩⁴ + f(λ) (I4/I3 (I5 − I1 I4 + I2) − 1)²] + U(J), f(λ) = γ/(1 +
/// e^(−β (λ − λ*)))
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PengGuoMoranDocument {
    /// Matrix coefficient C10 [Pa], half the shear modulus.
    pub c10_pa: f64,
    /// Fibre stiffness C2 [Pa].
    pub c2_pa: f64,
    /// Fibre stiffening C3 [Pa].
    #[serde(default)]
    pub c3_pa: f64,
    /// Stiffness γ of fibres that are sheared against the matrix [Pa].
    pub gamma_pa: f64,
    /// β [-]: how suddenly that stiffness comes with the stretch of the fibres.
    pub beta: f64,
    /// Stretch λ* of the fibres at which half of it is there [-].
    pub shear_stretch: f64,
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

impl LawDocument for PengGuoMoranDocument {
    fn to_material(&self) -> Option<Material> {
        let law = PengGuoMoran {
            c10: self.c10_pa,
            fibre: [self.c2_pa, self.c3_pa],
            shear: FibreShear { gamma: self.gamma_pa, beta: self.beta, stretch: self.shear_stretch },
            families: FibreFamilies::new(&self.fibres.directions())?,
            volumetric: self.volumetric.with(self.bulk_modulus_pa),
        };
        Some(law.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c10_pa"), "C10", self.c10_pa, out);
        let stiffnesses = [("c2_pa", self.c2_pa), ("c3_pa", self.c3_pa), ("gamma_pa", self.gamma_pa)];
        for (name, stiffness) in stiffnesses {
            let here = here.key(name);
            out.not_negative(
                &here,
                "a fibre stiffness",
                stiffness,
                "0 for none; a negative value is unstable",
            );
            out.at_most(&here, "the fibre stiffness", stiffness, MOST_MODULUS, "give it in Pa");
        }
        let remedy = "some 10 to 100, for a stiffness that comes within a few percent of stretch";
        out.not_negative(&here.key("beta"), "β", self.beta, remedy);
        out.at_most(&here.key("beta"), "β", self.beta, MOST_BETA, remedy);
        let remedy = "a stretch just above 1, at which the fibres are taut";
        out.between(&here.key("shear_stretch"), "the stretch λ*", self.shear_stretch, STRETCHES, remedy);
        let stiffest = self.c2_pa.max(self.c3_pa).max(self.gamma_pa);
        let idle_remedy = "use neo_hookean with the same C10: it is the same solid and costs less";
        checks::families(&self.fibres, stiffest, idle_remedy, here, out);
        checks::bulk(self.bulk_modulus_pa, 2.0 * self.c10_pa, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        for stiffness in [&mut self.c10_pa, &mut self.c2_pa, &mut self.c3_pa, &mut self.gamma_pa] {
            *stiffness *= factor;
        }
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }

    fn family_count(&self) -> usize {
        self.fibres.count()
    }
}
