//! The Mooney–Rivlin law in a scene document.

use super::checks::{self, MOST_MODULUS, REACHED_STRETCH, USUAL_MODULUS};
use super::{LawDocument, VolumetricDocument};
use crate::mechanics::material::{Material, MooneyRivlin};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = C10 (Ī1 − 3) + C01 (Ī2 − 3) + U(J)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MooneyRivlinDocument {
    /// Coefficient C10 of Ī1 [Pa].
    pub c10_pa: f64,
    /// Coefficient C01 of Ī2 [Pa].
    pub c01_pa: f64,
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl LawDocument for MooneyRivlinDocument {
    fn to_material(&self) -> Option<Material> {
        let volumetric = self.volumetric.with(self.bulk_modulus_pa);
        Some(MooneyRivlin { c10: self.c10_pa, c01: self.c01_pa, volumetric }.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        check_constants(self.c10_pa, self.c01_pa, here, out);
        checks::bulk(self.bulk_modulus_pa, 2.0 * (self.c10_pa + self.c01_pa), self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.c10_pa *= factor;
        self.c01_pa *= factor;
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }
}

/// Uniaxial stress of the incompressible solid is P = 2 (1 − λ⁻³)(C10 λ + C01), which changes sign at λ = −C01/C10: a
/// negative constant makes it unstable beyond that stretch, in tension (C10 < 0) or in compression (C01 < 0).
fn check_constants(c10: f64, c01: f64, here: &Pointer, out: &mut Findings) {
    // Shear modulus at rest.
    let sum = c10 + c01;
    if sum.is_nan() || sum <= 0.0 {
        let message = format!(
            "the shear modulus 2 (C10 + C01) = {} Pa is not positive: the law is unstable",
            2.0 * sum
        );
        out.push(
            Problem::error("unstable_law", &here.key("c10_pa"), message)
                .value(c10)
                .limit(format!("> -C01 = {}", -c01))
                .remedy("make C10 + C01 positive"),
        );
        return;
    }
    for (name, value, other, sense) in [("c10_pa", c10, c01, "stretched"), ("c01_pa", c01, c10, "compressed")]
    {
        out.at_most(&here.key(name), "the modulus", value, MOST_MODULUS, "give it in Pa");
        out.usual(
            &here.key(name),
            "the modulus",
            if value == 0.0 { 1.0 } else { value },
            USUAL_MODULUS,
            "give it in Pa",
        );
        // A negative constant: an error where the stretch is one that runs reach.
        if value >= 0.0 {
            continue;
        }
        let critical = -c01 / c10;
        let reached = critical > REACHED_STRETCH[0] && critical < REACHED_STRETCH[1];
        let message = format!(
            "a negative constant makes the law unstable when it is {sense} beyond λ = {critical:.3} in uniaxial stress"
        );
        let place = here.key(name);
        let problem = if reached {
            Problem::error("unstable_law", &place, message)
        } else {
            Problem::warning("law_unstable_far_from_rest", &place, message)
        };
        out.push(
            problem
                .value(value)
                .limit(format!(">= 0 (with the other {other})"))
                .remedy("fit both constants under the constraint that neither is negative"),
        );
    }
}
