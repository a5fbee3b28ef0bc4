//! The problems found so far, and checks of a single number.

use crate::scene::problem::{Pointer, Problem, ProblemList};

/// List of problems, in the order in which they were found.
#[derive(Debug, Default)]
pub struct Findings(pub ProblemList);

impl Findings {
    /// Appends a problem to those found so far.
    pub fn push(&mut self, problem: Problem) {
        self.0.push(problem);
    }
    /// Adds a problem unless `holds`.
    pub fn require(&mut self, holds: bool, problem: impl FnOnce() -> Problem) {
        if !holds {
            self.0.push(problem());
        }
    }
    /// `value` must be greater than zero.
    pub fn positive(&mut self, pointer: &Pointer, what: &str, value: f64, remedy: &str) {
        self.require(value > 0.0 && value.is_finite(), || {
            Problem::error("not_positive", pointer, format!("{what} must be positive"))
                .value(value)
                .limit("> 0")
                .remedy(remedy)
        });
    }
    /// `value` must not be negative.
    pub fn not_negative(&mut self, pointer: &Pointer, what: &str, value: f64, remedy: &str) {
        self.require(value >= 0.0 && value.is_finite(), || {
            Problem::error("negative", pointer, format!("{what} must not be negative"))
                .value(value)
                .limit(">= 0")
                .remedy(remedy)
        });
    }
    /// `value` must not exceed a physical upper bound: beyond it, numbers overflow before the run can report it.
    pub fn at_most(&mut self, pointer: &Pointer, what: &str, value: f64, most: f64, remedy: &str) {
        self.require(!(value.abs() > most), || {
            Problem::error("out_of_range", pointer, format!("{what} is beyond any physical value"))
                .value(value)
                .limit(format!("at most {most:e}"))
                .remedy(remedy)
        });
    }
    /// `value` must lie between two limits, both included.
    pub fn between(
        &mut self,
        pointer: &Pointer,
        what: &str,
        value: f64,
        [low, high]: [f64; 2],
        remedy: &str,
    ) {
        self.require(value >= low && value <= high, || {
            Problem::error("out_of_range", pointer, format!("{what} is out of its range"))
                .value(value)
                .limit(format!("between {low} and {high}"))
                .remedy(remedy)
        });
    }
    /// The direction `value` must have a finite length > 0.
    pub fn direction(&mut self, pointer: &Pointer, what: &str, value: [f64; 3]) {
        let length = value.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.require(length > 0.0 && length.is_finite(), || {
            Problem::error("no_direction", pointer, format!("{what} has no direction"))
                .value(value.to_vec())
                .limit("a vector of finite length > 0")
                .remedy("give a direction such as [0, 0, 1]")
        });
    }
    /// Warns when `value` is unusual; its unit is then probably wrong.
    pub fn usual(&mut self, pointer: &Pointer, what: &str, value: f64, [low, high]: [f64; 2], remedy: &str) {
        self.require(!value.is_finite() || (value.abs() >= low && value.abs() <= high), || {
            Problem::warning("unusual_unit", pointer, format!("{what} is unusual: is its unit right?"))
                .value(value)
                .limit(format!("usually {low} to {high}"))
                .remedy(remedy)
        });
    }
}
