//! The question of `contuse material fit`: measured curves, a law with starting values, and which of its parameters are free.

mod check;
mod curve_file;
mod parameter;

pub use parameter::Parameter;

use super::materials::MaterialDocument;
use super::named_materials::{self, WrittenMaterial};
use super::problem::{Pointer, Problem, Problems};
use super::prony_document::PronyDocument;
use super::{json, schema, structure};
use crate::mechanics::material::Path;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io;
use std::sync::LazyLock;

/// Curves, and the law to fit to them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitQuestion {
    /// The law with the starting values of its parameters, or a set of the library, whose law is taken.
    #[schemars(with = "WrittenMaterial")]
    pub material: MaterialDocument,
    /// Prony series with its starting values; only relaxation tests depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prony_series: Option<PronyDocument>,
    /// JSON pointers to the numbers that are fitted, such as `/material/c10_pa` or `/prony_series/branches/0/relaxation_time_s`.
    pub free: Vec<String>,
    /// Measured curves.
    pub tests: Vec<TestDocument>,
    /// How the errors of the measured values are distributed.
    #[serde(default)]
    pub errors: Errors,
}

/// One measured curve: `points` or `csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestDocument {
    /// Kind of test.
    pub kind: TestKind,
    /// Points of the curve: stretch or amount of shear [-] and nominal stress [Pa], or time [s] and relaxation modulus [Pa].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 2]>,
    /// CSV file with the points, relative to the folder of the question; its header has the names of the two columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub csv: Option<String>,
}

/// Kind of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TestKind {
    /// Tension or compression along x, the sides free of load.
    Uniaxial,
    /// Equal stretch along x and y, the third side free.
    Equibiaxial,
    /// Simple shear x += γ y, the third side free; the nominal stress is the shear force over the area at rest.
    Shear,
    /// Relaxation modulus G(t) in shear of small strain.
    Relaxation,
}

/// How the errors of the measured values are distributed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Errors {
    /// Of the same size at all points [Pa]: Σ (model − measured)² is minimised.
    #[default]
    Absolute,
    /// Proportional to the value: Σ ln²(model/measured) is minimised.
    Relative,
}

/// The part of the question that a fit changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constants {
    /// The law.
    pub material: MaterialDocument,
    /// Its relaxation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prony_series: Option<PronyDocument>,
}

static QUESTION: LazyLock<Value> = LazyLock::new(|| schema::schema_of::<FitQuestion>("Contuse material fit"));

impl FitQuestion {
    /// Reads and checks a question; `file` gives the bytes of a CSV file by its name. Also returns the warnings.
    ///
    /// # Errors
    /// All problems at once.
    pub fn read(
        bytes: &[u8],
        file: &dyn Fn(&str) -> io::Result<Vec<u8>>,
    ) -> Result<(Self, Vec<Problem>), Problems> {
        let parsed = json::parse(bytes)?;
        let mut checked = structure::check(&parsed.value, &QUESTION);
        checked.problems.splice(0..0, parsed.problems);
        if checked.is_cut_short {
            return Err(Problems(checked.problems));
        }
        named_materials::resolve_questions(&mut checked);
        let mut question: Self = match serde_path_to_error::deserialize(&checked.mended) {
            Ok(question) => question,
            Err(error) => {
                checked.problems.push(Problem::refused_by_serde(&error, &checked.mended));
                return Err(Problems(checked.problems));
            }
        };
        let mut found = curve_file::read_curves(&mut question.tests, file);
        check::check(&question, &mut found);
        let problems = checked.merged_with(found);
        if problems.iter().any(Problem::is_error) {
            Err(Problems(problems))
        } else {
            Ok((question, problems))
        }
    }

    /// The constants with their starting values.
    pub fn constants(&self) -> Constants {
        Constants { material: self.material.clone(), prony_series: self.prony_series.clone() }
    }

    /// The free parameters.
    pub fn parameters(&self) -> Vec<Parameter> {
        let constants = self.constants();
        self.free.iter().filter_map(|pointer| Parameter::of(&constants, pointer, self.largest_pa())).collect()
    }

    /// Largest measured value [Pa].
    fn largest_pa(&self) -> f64 {
        let values = self.tests.iter().flat_map(|test| &test.points).map(|point| point[1].abs());
        values.fold(f64::MIN_POSITIVE, f64::max)
    }
}

impl TestDocument {
    /// Where the `index`-th test of a question is.
    pub fn place(index: usize) -> Pointer {
        Pointer::root().key("tests").index(index)
    }
}

impl TestKind {
    /// Columns of a CSV file of such a test.
    pub fn columns(self) -> [&'static str; 2] {
        match self {
            Self::Uniaxial | Self::Equibiaxial => ["stretch", "nominal_stress_pa"],
            Self::Shear => ["shear", "nominal_stress_pa"],
            Self::Relaxation => ["time_s", "shear_modulus_pa"],
        }
    }
    /// The path of a specimen and the component (i, j) of its nominal stress; `None` of relaxation.
    pub fn path(self) -> Option<(Path, (usize, usize))> {
        match self {
            Self::Uniaxial => Some((Path::Uniaxial, (0, 0))),
            Self::Equibiaxial => Some((Path::Equibiaxial, (0, 0))),
            Self::Shear => Some((Path::SimpleShear, (0, 1))),
            Self::Relaxation => None,
        }
    }
}
