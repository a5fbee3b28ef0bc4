//! The question of a fit as a JSON document.

use crate::mechanics::material::Path;
use crate::scene::materials::MaterialDocument;
use crate::scene::memories::PronyDocument;
use crate::scene::named_materials::WrittenMaterial;
use crate::scene::problem::Pointer;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    /// Measured curves, one for each test.
    pub tests: Vec<TestDocument>,
    /// How the errors of the measured values are distributed.
    #[serde(default)]
    pub errors: Errors,
}

/// One measured curve: `points` or `csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestDocument {
    /// Kind of test: how the specimen is deformed.
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
    /// Constant at all points [Pa]: Σ (model − measured)² is minimised.
    #[default]
    Absolute,
    /// Proportional to the value: Σ ln²(model/measured) is minimised.
    Relative,
}

/// The part of the question that a fit changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constants {
    /// Constitutive law with its parameters.
    pub material: MaterialDocument,
    /// Prony series of its relaxation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prony_series: Option<PronyDocument>,
}

impl FitQuestion {
    /// The constants with their starting values.
    pub fn constants(&self) -> Constants {
        Constants { material: self.material.clone(), prony_series: self.prony_series.clone() }
    }

    /// Largest measured value [Pa].
    pub(super) fn largest_pa(&self) -> f64 {
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
