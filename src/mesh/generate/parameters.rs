//! Checks of the parameters of a generator; collects all problems.

use super::MAX_ELEMENTS;
use crate::mesh::{MeshError, ParameterProblem};

/// Problems found so far.
#[derive(Default)]
pub(super) struct Checks(Vec<ParameterProblem>);

impl Checks {
    /// Adds a problem unless `holds`.
    pub(super) fn require(
        &mut self,
        holds: bool,
        field: impl Into<String>,
        value: f64,
        limit: impl Into<String>,
        remedy: &str,
    ) {
        if !holds {
            self.0.push(ParameterProblem {
                field: field.into(),
                value,
                limit: limit.into(),
                remedy: remedy.into(),
            });
        }
    }

    /// A length [m] must be finite and greater than zero.
    pub(super) fn positive_length(&mut self, field: &str, value: f64) {
        let holds = value > 0.0 && value.is_finite();
        self.require(holds, field, value, "finite and > 0", "give a length in metres");
    }

    /// A distance [m] must be finite and not negative.
    pub(super) fn distance(&mut self, field: &str, value: f64) {
        let holds = value >= 0.0 && value.is_finite();
        self.require(holds, field, value, "finite and >= 0", "give a distance in metres");
    }

    /// A number of elements must be at least `least`.
    pub(super) fn count(&mut self, field: &str, value: u32, least: u32) {
        let remedy = "give more elements";
        self.require(value >= least, field, f64::from(value), format!("at least {least}"), remedy);
    }

    /// The ratio of the largest to the smallest element must be at least one.
    pub(super) fn grading(&mut self, field: &str, ratio: f64) {
        let holds = (1.0..=1000.0).contains(&ratio);
        let remedy = "give largest over smallest element; 1 is uniform";
        self.require(holds, field, ratio, "between 1 and 1000", remedy);
    }

    /// A point [m] must have finite coordinates.
    pub(super) fn finite(&mut self, field: &str, point: &[f64; 3]) {
        for (axis, &value) in point.iter().enumerate() {
            let remedy = "give a coordinate in metres";
            self.require(value.is_finite(), format!("{field}[{axis}]"), value, "finite", remedy);
        }
    }

    /// The mesh must not exceed the largest number of elements of a generator.
    pub(super) fn budget(&mut self, elements: u64) {
        let limit = format!("a mesh of at most {MAX_ELEMENTS} elements");
        self.require(
            elements <= MAX_ELEMENTS,
            "element_count",
            elements as f64,
            limit,
            "reduce the element counts",
        );
    }

    /// Whether no problem has been found.
    pub(super) fn none(&self) -> bool {
        self.0.is_empty()
    }

    /// Problems of all parameters, in the order in which they were found.
    pub(super) fn into_problems(self) -> Vec<ParameterProblem> {
        self.0
    }
}

/// The problems as the error of `generate`, if there are any.
///
/// # Errors
/// `Parameters` unless the list is empty.
pub(super) fn refuse(generator: &'static str, problems: Vec<ParameterProblem>) -> Result<(), MeshError> {
    if problems.is_empty() { Ok(()) } else { Err(MeshError::Parameters { generator, problems }) }
}
