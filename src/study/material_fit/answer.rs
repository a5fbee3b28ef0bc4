//! The answer of a fit, and how well the law follows the curves.

use super::model::Prediction;
use crate::scene::material_fit::{Constants, FitQuestion, TestDocument, TestKind};
use crate::scene::problem::{Pointer, Problem};
use nalgebra::DVector;
use serde::Serialize;
use serde_json::json;

/// Durbin–Watson statistic below which residuals are correlated: it is 2 of independent ones [-].
const CORRELATED: f64 = 1.0;
/// Points from which that is looked at.
const ENOUGH_POINTS: usize = 8;

/// Fitted constants, and what is known of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitAnswer {
    /// Law and Prony series as a part of a scene takes them; `valid_to.stretch` is the range of the tests.
    #[serde(flatten)]
    pub constants: Constants,
    /// The fitted parameters with their confidence intervals.
    pub parameters: Vec<FittedParameter>,
    /// Correlations of the estimates, of logarithms where those are fitted; empty where there are none.
    pub correlations: Vec<Vec<f64>>,
    /// Condition number of the Jacobian with columns of length 1; null where it is singular.
    pub condition: Option<f64>,
    /// Points of all tests.
    pub points: usize,
    /// Number of points less that of parameters.
    pub degrees_of_freedom: usize,
    /// Standard deviation of the residuals, with these degrees of freedom [Pa; of the logarithm for relative errors].
    pub residual_deviation: Option<f64>,
    /// How well each test is followed.
    pub tests: Vec<FittedTest>,
    /// Principal stretches of the tests, from … to, rest included [-]; null of relaxation alone.
    pub stretch_range: Option<[f64; 2]>,
    /// Iterations of Levenberg and Marquardt.
    pub iterations: u32,
    /// Whether they ended at a minimum; if not, the numbers are no fit.
    pub has_converged: bool,
    /// What is wrong with the fit, or with the fitted law in a scene.
    pub problems: Vec<Problem>,
}

/// A fitted parameter with its confidence interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedParameter {
    /// JSON pointer to it.
    pub pointer: String,
    /// Value at which the iteration started.
    pub start: f64,
    /// Fitted value, in the unit of the parameter.
    pub value: f64,
    /// Standard error of the parameter, in its unit; null if undetermined.
    pub standard_error: Option<f64>,
    /// 95 % confidence interval of the parameter, in its unit; null if undetermined.
    pub interval: Option<[f64; 2]>,
    /// Whether the logarithm was fitted; the interval is then symmetric in it.
    pub is_logarithm: bool,
}

/// How well the law follows one test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedTest {
    /// Kind of test: how the specimen was deformed.
    pub kind: TestKind,
    /// Number of points of the curve.
    pub points: usize,
    /// Smallest and largest stretch, amount of shear [-] or time [s].
    pub range: [f64; 2],
    /// Root mean square of the errors [Pa].
    pub rms_pa: f64,
    /// Largest error relative to the measured value, among values that are not 0 [-].
    pub largest_relative_error: f64,
    /// 1 − Σ (model − measured)²/Σ (measured − mean)² [-]; null where all measured values are the same.
    pub r_squared: Option<f64>,
}

/// How well the law follows each test.
pub(super) fn tests(question: &FitQuestion, predictions: &[Prediction]) -> Vec<FittedTest> {
    question
        .tests
        .iter()
        .zip(predictions)
        .map(|(test, prediction)| test_of(test, &prediction.values))
        .collect()
}

fn test_of(test: &TestDocument, model: &[f64]) -> FittedTest {
    let count = test.points.len() as f64;
    let mean = test.points.iter().map(|point| point[1]).sum::<f64>() / count;
    let spread: f64 = test.points.iter().map(|point| (point[1] - mean).powi(2)).sum();
    let pairs = || test.points.iter().zip(model).map(|(point, model)| (point[1], model - point[1]));
    let squares: f64 = pairs().map(|(_, error)| error * error).sum();
    let relative = pairs().filter(|(y, _)| *y != 0.0).map(|(y, error)| (error / y).abs());
    let least = |[a, b]: [f64; 2], point: &[f64; 2]| [a.min(point[0]), b.max(point[0])];
    FittedTest {
        kind: test.kind,
        points: test.points.len(),
        range: test.points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], least).map(rounded),
        rms_pa: (squares / count).sqrt(),
        largest_relative_error: relative.fold(0.0, f64::max),
        r_squared: (spread > 0.0).then(|| 1.0 - squares / spread),
    }
}

/// Reports a law that follows none of the curves: it is no nearer to any than the mean of its values.
pub(super) fn no_fit(tests: &[FittedTest]) -> Option<Problem> {
    let best = tests.iter().filter_map(|test| test.r_squared).reduce(f64::max)?;
    (best <= 0.0).then(|| {
        Problem::error("no_fit", &Pointer::root(), "the law follows none of the curves")
            .value(best)
            .limit("an R² above 0")
            .remedy("check signs and units of the stresses; free more parameters, or choose another law")
    })
}

/// Principal stretches of all tests, `None` without a path.
pub(super) fn stretch_range(predictions: &[Prediction]) -> Option<[f64; 2]> {
    let ranges = predictions.iter().filter_map(|prediction| prediction.stretches);
    ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).map(|range| range.map(rounded))
}

/// The end of a range to nine significant digits, without the rounding errors of the square roots and units that it comes from.
fn rounded(end: f64) -> f64 {
    format!("{end:.8e}").parse().unwrap_or(end)
}

/// The constants with the range of the tests as that to which the law was fitted. Other ranges and limits are those of the constants before.
pub(super) fn with_range(constants: Constants, range: Option<[f64; 2]>) -> Constants {
    let with = |range: [f64; 2]| {
        let mut document = serde_json::to_value(&constants).ok()?;
        let material = document.get_mut("material")?.as_object_mut()?;
        material.insert("valid_to".into(), json!({"stretch": range}));
        serde_json::from_value(document).ok()
    };
    range.and_then(with).unwrap_or(constants)
}

/// Reports residuals of one sign over long stretches: the law does not follow the curves, and intervals of independent errors are
/// too narrow (Durbin & Watson 1950).
pub(super) fn correlated_residuals(question: &FitQuestion, residual: &DVector<f64>) -> Option<Problem> {
    let mut first = 0;
    let mut changes = 0.0;
    for test in &question.tests {
        let of_test = residual.rows(first, test.points.len());
        changes += (1..of_test.len()).map(|i| (of_test[i] - of_test[i - 1]).powi(2)).sum::<f64>();
        first += test.points.len();
    }
    let statistic = changes / residual.norm_squared();
    let is_correlated = residual.len() >= ENOUGH_POINTS && statistic < CORRELATED;
    is_correlated.then(|| {
        let message = "the errors of neighbouring points are alike: the law does not follow the curves in all, and the intervals are too narrow";
        Problem::warning("correlated_errors", &Pointer::root().key("tests"), message)
            .value(format!("Durbin–Watson statistic {statistic:.2}"))
            .limit("about 2, of independent errors")
            .remedy("choose a law with more terms, or a smaller range")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_ranges_are_without_rounding_errors() {
        let range = |stretches| {
            let prediction = Prediction { values: Vec::new(), stretches: Some(stretches) };
            json!(stretch_range(&[prediction])).to_string()
        };
        assert_eq!(range([0.769_230_769_230_769_3, 1.700_000_000_000_000_2]), "[0.769230769,1.7]");
        assert_eq!(range([0.1 + 0.2, 1.0]), "[0.3,1.0]");
    }
}
