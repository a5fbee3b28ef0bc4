//! The Holzapfel–Gasser–Ogden law in a scene document.

use super::checks::{self, MOST_EXPONENT, MOST_MODULUS, USUAL_MODULUS};
use super::{Families, LawDocument, VolumetricDocument};
use crate::mechanics::material::{FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = c/2 (Ī1 − 3) + Σ k1/(2 k2) (exp[k2 ⟨E⟩²] − 1) + U(J), E = κ (I1 − 3) + (1 − 3κ)(I4 − 1)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HolzapfelGasserOgdenDocument {
    /// Matrix shear modulus c [Pa].
    pub c_pa: f64,
    /// Fibre stiffness k1 [Pa].
    pub k1_pa: f64,
    /// Fibre exponent k2 [-].
    pub k2: f64,
    /// Dispersion κ, 0 (aligned) to 1/3 (isotropic) [-].
    #[serde(default)]
    pub kappa: f64,
    /// Fibre families, in the material axes.
    pub fibres: Families,
    /// Invariants used in the fibre term.
    #[serde(default)]
    pub i4: I4Invariants,
    /// Isochoric or coupled matrix term.
    #[serde(default)]
    pub matrix: MatrixDocument,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

/// Invariants used in the fibre term.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum I4Invariants {
    /// I1 and I4 of C: fibre tension causes no swelling.
    #[default]
    Full,
    /// I1 and I4 of J^(−2/3) C, for comparison with codes that use these.
    Isochoric,
}

/// Matrix term of the Holzapfel–Gasser–Ogden law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MatrixDocument {
    /// Split: c/2 (Ī1 − 3)
    #[default]
    Isochoric,
    /// Coupled: c/2 (I1 − 3) − c ln J
    Coupled,
}

impl LawDocument for HolzapfelGasserOgdenDocument {
    fn to_material(&self) -> Option<Material> {
        let law = HolzapfelGasserOgden {
            c: self.c_pa,
            k1: self.k1_pa,
            k2: self.k2,
            kappa: self.kappa,
            families: FibreFamilies::new(&self.fibres.directions())?,
            i4: self.i4.form(),
            matrix: match self.matrix {
                MatrixDocument::Isochoric => MatrixForm::Isochoric,
                MatrixDocument::Coupled => MatrixForm::Coupled,
            },
            volumetric: self.volumetric.with(self.bulk_modulus_pa),
        };
        Some(law.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c_pa"), "the matrix modulus c", self.c_pa, out);
        check_fibre_stiffness(self.k1_pa, self.k2, self.kappa, here, out);
        let idle_remedy = "use neo_hookean with C10 = c/2: it is the same solid and costs less";
        checks::families(&self.fibres, self.k1_pa, idle_remedy, here, out);
        checks::bulk(self.bulk_modulus_pa, self.c_pa, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.c_pa *= factor;
        self.k1_pa *= factor;
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }

    fn is_split(&self) -> bool {
        self.matrix == MatrixDocument::Isochoric
    }

    fn family_count(&self) -> usize {
        self.fibres.count()
    }
}

impl I4Invariants {
    /// The corresponding form of the law.
    pub fn form(self) -> I4Form {
        match self {
            Self::Full => I4Form::Full,
            Self::Isochoric => I4Form::Isochoric,
        }
    }
}

fn check_fibre_stiffness(k1: f64, k2: f64, kappa: f64, here: &Pointer, out: &mut Findings) {
    let k1_place = here.key("k1_pa");
    out.at_most(&k1_place, "the fibre stiffness k1", k1, MOST_MODULUS, "give it in Pa");
    out.at_most(&here.key("k2"), "the fibre exponent k2", k2, MOST_EXPONENT, "arteries have 1 to 1000");
    out.not_negative(
        &k1_place,
        "the fibre stiffness k1",
        k1,
        "0 for no fibres; a negative value is unstable",
    );
    if k1 > 0.0 {
        out.usual(&k1_place, "the fibre stiffness k1", k1, USUAL_MODULUS, "give it in Pa");
        out.positive(
            &here.key("k2"),
            "the fibre exponent k2",
            k2,
            "a small k2 such as 0.01 is nearly linear",
        );
    } else {
        out.not_negative(&here.key("k2"), "the fibre exponent k2", k2, "0 without fibre stiffness");
    }
    let remedy = "0 is aligned, 1/3 is isotropic";
    out.require((0.0..=1.0 / 3.0 + 1e-12).contains(&kappa), || {
        Problem::error("out_of_range", &here.key("kappa"), "the dispersion κ is out of its range")
            .value(kappa)
            .limit("between 0 and 1/3")
            .remedy(remedy)
    });
}
