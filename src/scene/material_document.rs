//! Materials in a scene document.

use super::validity_document::ValidityDocument;
use crate::mechanics::material::{
    CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, MooneyRivlin,
    NeoHookean, Volumetric,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A constitutive law with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub enum MaterialDocument {
    /// ψ = C10 (Ī1 − 3) + C01 (Ī2 − 3) + U(J)
    MooneyRivlin {
        /// C10 [Pa].
        c10_pa: f64,
        /// C01 [Pa].
        c01_pa: f64,
        /// Bulk modulus K [Pa].
        bulk_modulus_pa: f64,
        /// Form of U(J).
        #[serde(default)]
        volumetric: VolumetricDocument,
        /// How far the law may be believed; by default its own range.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        valid_to: Option<ValidityDocument>,
    },
    /// ψ = C10 (Ī1 − 3) + U(J)
    NeoHookean {
        /// C10 [Pa], half the shear modulus.
        c10_pa: f64,
        /// Bulk modulus K [Pa].
        bulk_modulus_pa: f64,
        /// Form of U(J).
        #[serde(default)]
        volumetric: VolumetricDocument,
        /// How far the law may be believed; by default its own range.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        valid_to: Option<ValidityDocument>,
    },
    /// ψ = μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)²
    CoupledNeoHookean {
        /// Shear modulus μ [Pa].
        mu_pa: f64,
        /// First Lamé parameter λ [Pa].
        lambda_pa: f64,
        /// How far the law may be believed; by default its own range.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        valid_to: Option<ValidityDocument>,
    },
    /// ψ = c/2 (Ī1 − 3) + Σ k1/(2 k2) (exp[k2 ⟨E⟩²] − 1) + U(J), E = κ (I1 − 3) + (1 − 3κ)(I4 − 1)
    HolzapfelGasserOgden {
        /// Matrix shear modulus c [Pa].
        c_pa: f64,
        /// Fibre stiffness k1 [Pa].
        k1_pa: f64,
        /// Fibre exponent k2 [-].
        k2: f64,
        /// Dispersion κ, 0 (aligned) to 1/3 (isotropic) [-].
        #[serde(default)]
        kappa: f64,
        /// Fibre families in the material axes.
        fibres: Families,
        /// Invariants in the fibre term.
        #[serde(default)]
        i4: I4Invariants,
        /// The matrix term.
        #[serde(default)]
        matrix: MatrixDocument,
        /// Bulk modulus K [Pa].
        bulk_modulus_pa: f64,
        /// Form of U(J).
        #[serde(default)]
        volumetric: VolumetricDocument,
        /// How far the law may be believed; by default its own range.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        valid_to: Option<ValidityDocument>,
    },
}

/// Fibre families, in the material axes e1, e2, e3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Families {
    /// Angles from e1 towards e2, one a family [degree]; two families at ±β are `[β, −β]`.
    AnglesDeg(Vec<f64>),
    /// Directions, of any length.
    Directions(Vec<[f64; 3]>),
}

/// Invariants in the fibre term.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum I4Invariants {
    /// I1 and I4 of C: no swelling under fibre tension.
    #[default]
    Full,
    /// I1 and I4 of J^(−2/3) C, for comparison with codes that use them.
    Isochoric,
}

/// The matrix term of the Holzapfel–Gasser–Ogden law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MatrixDocument {
    /// c/2 (Ī1 − 3)
    #[default]
    Isochoric,
    /// c/2 (I1 − 3) − c ln J
    Coupled,
}

/// Form of U(J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VolumetricDocument {
    /// K/2 (ln J)²
    #[default]
    LnSquared,
    /// K/2 (J − 1)²
    Quadratic,
    /// K/4 (J² − 1 − 2 ln J)
    QuadraticLn,
}

impl MaterialDocument {
    /// Multiplies every stiffness but that against a change of volume (the bulk modulus, or λ).
    pub fn scale_stiffness(&mut self, factor: f64) {
        match self {
            Self::MooneyRivlin { c10_pa: a, c01_pa: b, .. }
            | Self::HolzapfelGasserOgden { c_pa: a, k1_pa: b, .. } => {
                *a *= factor;
                *b *= factor;
            }
            Self::NeoHookean { c10_pa: a, .. } | Self::CoupledNeoHookean { mu_pa: a, .. } => *a *= factor,
        }
    }

    /// The law that is meant; `None` when its fibre directions are too many, or one has no direction.
    pub fn to_material(&self) -> Option<Material> {
        Some(match *self {
            Self::MooneyRivlin { c10_pa: c10, c01_pa: c01, bulk_modulus_pa, volumetric, .. } => {
                Material::MooneyRivlin(MooneyRivlin {
                    c10,
                    c01,
                    volumetric: volumetric.with(bulk_modulus_pa),
                })
            }
            Self::NeoHookean { c10_pa: c10, bulk_modulus_pa, volumetric, .. } => {
                Material::NeoHookean(NeoHookean { c10, volumetric: volumetric.with(bulk_modulus_pa) })
            }
            Self::CoupledNeoHookean { mu_pa: mu, lambda_pa: lambda, .. } => {
                Material::CoupledNeoHookean(CoupledNeoHookean { mu, lambda })
            }
            Self::HolzapfelGasserOgden {
                c_pa: c,
                k1_pa: k1,
                k2,
                kappa,
                ref fibres,
                i4,
                matrix,
                bulk_modulus_pa,
                volumetric,
                ..
            } => Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
                c,
                k1,
                k2,
                kappa,
                families: FibreFamilies::new(&fibres.directions())?,
                i4: match i4 {
                    I4Invariants::Full => I4Form::Full,
                    I4Invariants::Isochoric => I4Form::Isochoric,
                },
                matrix: match matrix {
                    MatrixDocument::Isochoric => MatrixForm::Isochoric,
                    MatrixDocument::Coupled => MatrixForm::Coupled,
                },
                volumetric: volumetric.with(bulk_modulus_pa),
            }),
        })
    }

    /// What the scene says of how far the law may be believed.
    pub fn valid_to(&self) -> ValidityDocument {
        match self {
            Self::MooneyRivlin { valid_to, .. }
            | Self::NeoHookean { valid_to, .. }
            | Self::CoupledNeoHookean { valid_to, .. }
            | Self::HolzapfelGasserOgden { valid_to, .. } => valid_to.unwrap_or_default(),
        }
    }

    /// The law's name in documents.
    pub fn law_name(&self) -> &'static str {
        match self {
            Self::MooneyRivlin { .. } => "mooney_rivlin",
            Self::NeoHookean { .. } => "neo_hookean",
            Self::CoupledNeoHookean { .. } => "coupled_neo_hookean",
            Self::HolzapfelGasserOgden { .. } => "holzapfel_gasser_ogden",
        }
    }

    /// Whether all that depends on J alone is in U(J), so that an element may average it.
    pub fn is_split(&self) -> bool {
        match self {
            Self::MooneyRivlin { .. } | Self::NeoHookean { .. } => true,
            Self::CoupledNeoHookean { .. } => false,
            Self::HolzapfelGasserOgden { matrix, .. } => *matrix == MatrixDocument::Isochoric,
        }
    }

    /// Number of fibre families.
    pub fn family_count(&self) -> usize {
        match self {
            Self::HolzapfelGasserOgden { fibres, .. } => fibres.count(),
            Self::MooneyRivlin { .. } | Self::NeoHookean { .. } | Self::CoupledNeoHookean { .. } => 0,
        }
    }
}

impl Families {
    /// How many there are.
    pub fn count(&self) -> usize {
        match self {
            Self::AnglesDeg(angles) => angles.len(),
            Self::Directions(directions) => directions.len(),
        }
    }

    /// Their directions in the material axes, of any length.
    pub fn directions(&self) -> Vec<[f64; 3]> {
        match self {
            Self::AnglesDeg(angles) => {
                let direction = |angle: &f64| [angle.to_radians().cos(), angle.to_radians().sin(), 0.0];
                angles.iter().map(direction).collect()
            }
            Self::Directions(directions) => directions.clone(),
        }
    }
}

impl VolumetricDocument {
    /// The energy with its bulk modulus K [Pa].
    pub fn with(self, K: f64) -> Volumetric {
        match self {
            Self::LnSquared => Volumetric::LnSquared(K),
            Self::Quadratic => Volumetric::Quadratic(K),
            Self::QuadraticLn => Volumetric::QuadraticLn(K),
        }
    }
}
