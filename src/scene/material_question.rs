//! A law evaluated at a deformation: the input and output of `contuse material`.

use super::document::MaterialDocument;
use super::named_materials::WrittenMaterial;
use super::problem::{Pointer, Problem, Problems};
use super::read::{accept, read};
use super::validate::Findings;
use super::{json, named_materials, schema};
use crate::mechanics::material::{Deformations, PointStress, Validity};
use crate::mechanics::tensor::Mat3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::sync::LazyLock;

/// A law, and a deformation at which to evaluate it. Fibre directions refer to material axes x, y, z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialQuestion {
    /// The law, or a set of the library.
    #[schemars(with = "WrittenMaterial")]
    pub material: MaterialDocument,
    /// Deformation gradient F, rows spatial [-]; not needed along a path.
    #[serde(rename = "F", default, skip_serializing_if = "Option::is_none")]
    pub deformation_gradient: Option<[[f64; 3]; 3]>,
}

/// Strain energy and stresses at a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MaterialAnswer {
    /// Volume ratio J = det F [-].
    #[serde(rename = "J")]
    pub jacobian: f64,
    /// Strain energy per reference volume ψ [J/m³].
    pub psi_j_per_m3: f64,
    /// First Piola–Kirchhoff stress P = ∂ψ/∂F, rows spatial [Pa].
    #[serde(rename = "P_pa")]
    pub first_piola_pa: [[f64; 3]; 3],
    /// Cauchy stress σ = P Fᵀ / J [Pa].
    pub cauchy_pa: [[f64; 3]; 3],
    /// Whether the deformation is in the range of the law.
    pub range: InRange,
}

/// Where a deformation is in the range of validity of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InRange {
    /// In the range that the parameters are fitted to.
    Fitted,
    /// In the range that is usual for the law, where none is given for the parameters.
    Usual,
    /// Beyond that range, where the law is extrapolated.
    Extrapolated,
    /// Beyond the limit of the law: its stress is that of no intact tissue.
    BeyondLimit,
}

impl InRange {
    /// That of a deformation gradient `F`.
    fn of(F: &Mat3, validity: &Validity) -> Self {
        let (stretches, J) = (F.singular_values(), F.determinant());
        let exceeds =
            |range: &Deformations| range.excess([stretches.min(), stretches.max()], [J; 2]) > 1.0 + ROUNDING;
        match (exceeds(&validity.fitted), exceeds(&validity.limit)) {
            (_, true) => Self::BeyondLimit,
            (true, false) => Self::Extrapolated,
            (false, false) if validity.given.stretch => Self::Fitted,
            (false, false) => Self::Usual,
        }
    }

    /// As written in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fitted => "fitted",
            Self::Usual => "usual",
            Self::Extrapolated => "extrapolated",
            Self::BeyondLimit => "beyond_limit",
        }
    }
}

/// Amount by which a deformation at the end of a range exceeds it by rounding [-].
const ROUNDING: f64 = 1e-12;

impl MaterialAnswer {
    /// The answer for a deformation gradient `F`, given the range of the law.
    pub fn new(F: &Mat3, stress: &PointStress, validity: &Validity) -> Self {
        Self {
            jacobian: F.determinant(),
            psi_j_per_m3: stress.psi,
            first_piola_pa: rows(&stress.P),
            cauchy_pa: rows(&stress.cauchy),
            range: InRange::of(F, validity),
        }
    }
    /// Whether all numbers are finite; an extreme deformation can overflow.
    pub fn is_finite(&self) -> bool {
        let stresses = self.first_piola_pa.iter().chain(&self.cauchy_pa).flatten();
        [self.jacobian, self.psi_j_per_m3].iter().chain(stresses).all(|x| x.is_finite())
    }
}

/// A matrix as a list of rows.
pub fn rows(m: &Mat3) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}

/// One question or a list of them, as in the input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum MaterialQuestions {
    /// One question, written without a list.
    One(Box<MaterialQuestion>),
    /// A list of questions.
    Many(Vec<MaterialQuestion>),
}

static QUESTIONS: LazyLock<Value> =
    LazyLock::new(|| schema::schema_of::<MaterialQuestions>("Contuse material questions"));

impl MaterialQuestions {
    /// Reads and checks questions; also returns the warnings.
    ///
    /// # Errors
    /// All problems at once.
    pub fn read(bytes: &[u8]) -> Result<(Self, Vec<Problem>), Problems> {
        let parsed = json::parse(bytes)?;
        let (questions, checked) = read::<Self>(&parsed, &QUESTIONS, named_materials::resolve_questions)?;
        let mut found = Findings::default();
        for (pointer, question) in questions.each() {
            question.material.check(&pointer.key("material"), &mut found);
        }
        // No time steps are taken here, so a stiff volume costs nothing.
        found.0.retain(|problem| problem.code != "stiff_volume");
        accept(questions, checked.merged_with(found))
    }

    /// Each question, with its pointer in the input.
    pub fn each(&self) -> Box<dyn Iterator<Item = (Pointer, &MaterialQuestion)> + '_> {
        match self {
            Self::One(question) => Box::new(std::iter::once((Pointer::root(), &**question))),
            Self::Many(list) => {
                Box::new(list.iter().enumerate().map(|(i, question)| (Pointer::root().index(i), question)))
            }
        }
    }
}
