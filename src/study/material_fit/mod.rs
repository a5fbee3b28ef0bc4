//! Parameters of a law from measured curves, with confidence intervals.

mod answer;
mod intervals;
mod least_squares;
mod model;
mod student;

pub use answer::{FitAnswer, FittedParameter, FittedTest};

use crate::scene::material_fit::{Constants, FitQuestion, TestDocument};
use crate::scene::problem::{Pointer, Problem, Problems};
use intervals::Intervals;
use least_squares::{Minimum, minimise};
use model::{Model, Prediction};

/// Fits the free parameters of a question that was checked.
///
/// # Errors
/// A test on which the law has no stress with the starting values, or next to a point on the way.
pub fn fit(question: &FitQuestion) -> Result<FitAnswer, Problems> {
    let model = Model::new(question);
    let start = model.start();
    // The starting values must have a stress at every point.
    model.predictions(&question.constants()).map_err(|(test, error)| {
        Problem::error("no_stress", &TestDocument::place(test), format!("with the starting values: {error}"))
            .limit("a stress at every point of the curves")
            .remedy("start from a stiffer law, or omit the points that are far from rest")
            .alone()
    })?;
    let residuals = |x: &_| model.residuals(x);
    let no_derivative = || {
        Problem::error("no_derivative", &Pointer::root(), "the curves have no derivative by the parameters")
            .limit("finite stresses of the sign of the measured ones at the starting values and on the way from them")
            .remedy("choose other starting values; relative errors need points away from rest")
            .alone()
    };
    let minimum = minimise(start, model.negligible(), &residuals).ok_or_else(no_derivative)?;
    let constants = model.constants(&minimum.x).ok_or_else(no_derivative)?;
    let predictions = model.predictions(&constants).map_err(|_| no_derivative())?;
    Ok(answer_of(question, &model, &minimum, constants, &predictions))
}

fn answer_of(
    question: &FitQuestion,
    model: &Model,
    minimum: &Minimum,
    constants: Constants,
    predictions: &[Prediction],
) -> FitAnswer {
    let is_exact = minimum.residual.norm() <= 10.0 * model.negligible();
    let intervals = Intervals::new(minimum);
    let mut problems = Vec::new();
    if !minimum.has_converged {
        problems.push(
            Problem::error("not_converged", &Pointer::root(), "the iterations ended before a minimum")
                .value(minimum.iterations)
                .limit("a minimum of the sum of squares")
                .remedy("choose other starting values, or fit fewer parameters"),
        );
    }
    let values = model.values(&minimum.x);
    let parameters = intervals.parameters(model, &values);
    intervals.report(&parameters, &mut problems);
    if !is_exact {
        problems.extend(answer::correlated_residuals(question, &minimum.residual));
    }
    let tests = answer::tests(question, predictions);
    problems.extend(answer::no_fit(&tests));
    let is_fit = !problems.iter().any(Problem::is_error);
    let stretch_range = answer::stretch_range(predictions);
    let constants = answer::with_range(constants, stretch_range.filter(|_| is_fit));
    problems.extend(constants.check());
    FitAnswer {
        constants,
        parameters,
        correlations: intervals.correlations(),
        condition: intervals.condition(),
        points: minimum.residual.len(),
        degrees_of_freedom: intervals.degrees_of_freedom(),
        residual_deviation: intervals.deviation(),
        tests,
        stretch_range,
        iterations: minimum.iterations,
        has_converged: minimum.has_converged,
        problems,
    }
}
