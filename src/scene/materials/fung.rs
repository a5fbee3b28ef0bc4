//! Fung's orthotropic law in a scene document.

use super::checks::{self, MOST_MODULUS};
use super::{LawDocument, VolumetricDocument};
use crate::mechanics::material::{FungOrthotropic, Material, OrthotropicModuli};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// ψ = c/2 (e^Q − 1) + U(J), c Q = Ẽ : ℂ : Ẽ, Ẽ = ½ (J^(−2/3) C − I), ℂ orthotropic in the material axes
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FungOrthotropicDocument {
    /// Stress scale c [Pa]: the tissue stiffens at strains where the energy of the moduli is c/2.
    pub c_pa: f64,
    /// Young's moduli E1, E2, E3 [Pa].
    pub young_pa: [f64; 3],
    /// Shear moduli G12, G23, G31 [Pa].
    pub shear_pa: [f64; 3],
    /// Poisson's ratios ν12, ν23, ν31 [-].
    pub poisson: [f64; 3],
    /// Bulk modulus K [Pa].
    pub bulk_modulus_pa: f64,
    /// Form of the volumetric energy U(J).
    #[serde(default)]
    pub volumetric: VolumetricDocument,
    /// Range of validity; by default that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

impl FungOrthotropicDocument {
    fn moduli(&self) -> OrthotropicModuli {
        OrthotropicModuli { young: self.young_pa, shear: self.shear_pa, poisson: self.poisson }
    }
}

impl LawDocument for FungOrthotropicDocument {
    fn to_material(&self) -> Option<Material> {
        let volumetric = self.volumetric.with(self.bulk_modulus_pa);
        Some(FungOrthotropic::new(self.c_pa, &self.moduli(), volumetric)?.into())
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::modulus(&here.key("c_pa"), "c", self.c_pa, out);
        for (name, what, moduli) in
            [("young_pa", "Young's modulus", self.young_pa), ("shear_pa", "the shear modulus", self.shear_pa)]
        {
            for (i, modulus) in moduli.into_iter().enumerate() {
                checks::modulus(&here.key(name).index(i), what, modulus, out);
            }
        }
        for (i, ratio) in self.poisson.into_iter().enumerate() {
            out.at_most(
                &here.key("poisson").index(i),
                "Poisson's ratio",
                ratio,
                MOST_MODULUS,
                "use 0 to 0.5",
            );
        }
        out.require(self.moduli().normal_stiffness().is_some(), || {
            let message = "some strain has a negative energy: the law is unstable";
            Problem::error("unstable_law", &here.key("poisson"), message)
                .value(self.poisson.to_vec())
                .limit("a positive definite compliance, so ν12² < E1/E2, ν23² < E2/E3, ν31² < E3/E1 and 1 − ν12² E2/E1 − … > 0")
                .remedy("reduce Poisson's ratios: the bulk modulus makes the tissue nearly incompressible")
        });
        let G = self.shear_pa.into_iter().fold(0.0, f64::max);
        checks::bulk(self.bulk_modulus_pa, G, self.volumetric, here, out);
    }

    fn valid_to(&self) -> Option<ValidityDocument> {
        self.valid_to
    }

    fn scale_stiffness(&mut self, factor: f64) {
        self.c_pa *= factor;
        for modulus in self.young_pa.iter_mut().chain(&mut self.shear_pa) {
            *modulus *= factor;
        }
    }

    fn scale_bulk_modulus(&mut self, factor: f64) {
        self.bulk_modulus_pa *= factor;
    }

    /// The three material axes.
    fn family_count(&self) -> usize {
        3
    }
}
