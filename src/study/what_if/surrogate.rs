//! Fast polynomial surrogates fitted to the cases, which predict the response in others; answers come from the model
//! only.
//!
//! Least squares of second degree if there are enough cases, otherwise of first. Accuracy is measured by leave-one-out
//! cross-validation: each case is predicted from all others, with error `e_i / (1 − h_i)`, h the diagonal of the hat
//! matrix (Allen 1974, PRESS).

use super::case_answer::CaseAnswer;
use crate::measure::QuantityOfInterest;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::collections::BTreeMap;

/// Minimum number of cases per coefficient.
const CASES_PER_TERM: f64 = 1.5;
/// Relative singular value below which the cases do not determine all coefficients.
const SINGULAR: f64 = 1e-9;
/// Relative differences below this are rounding.
const ROUNDING: f64 = 1e-12;
/// Leverage above which a case cannot be predicted from the others.
const MOST_LEVERAGE: f64 = 1.0 - 1e-6;

/// A polynomial surrogate of one number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Surrogate {
    /// Number predicted by the polynomial.
    pub quantity: QuantityOfInterest,
    /// Number of finished cases in the fit.
    pub cases: usize,
    /// Degree of the polynomial.
    pub degree: usize,
    /// Range of each parameter over those cases, by name, mapped to −1…1 in the polynomial. It is not valid outside.
    pub ranges: BTreeMap<String, [f64; 2]>,
    /// Terms of the polynomial, to be summed.
    pub terms: Vec<Term>,
    /// Root-mean-square error of cross-validation, in the unit of the number.
    pub hold_out_error: f64,
    /// Fraction of the variance predicted in cross-validation [-]; 1 is perfect, below 0 is worse than the mean. Absent
    /// if the number is the same in all cases up to rounding, without variance to predict.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_out_explained_variance: Option<f64>,
}

/// A coefficient with the parameters it multiplies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Term {
    /// Names of the factors, twice for a square; none for the constant.
    pub parameters: Vec<String>,
    /// Coefficient, in the unit of the number.
    pub coefficient: f64,
}

#[cfg(test)]
impl Surrogate {
    /// Predicted value at values of all parameters; `None` if one is missing or out of range.
    pub fn propose(&self, values: &BTreeMap<String, f64>) -> Option<f64> {
        let mut z = BTreeMap::new();
        for (name, [low, high]) in &self.ranges {
            let value = values.get(name).filter(|value| (*low..=*high).contains(*value))?;
            z.insert(name, place(*value, [*low, *high]));
        }
        let term = |term: &Term| -> Option<f64> {
            term.parameters.iter().try_fold(term.coefficient, |product, name| Some(product * z.get(name)?))
        };
        self.terms.iter().map(term).sum()
    }
}

/// Surrogates of all numbers in the cases, each of the highest degree that the cases determine.
pub fn surrogates(cases: &[CaseAnswer]) -> Vec<Surrogate> {
    QuantityOfInterest::ALL.into_iter().filter_map(|quantity| fit(quantity, cases)).collect()
}

fn fit(quantity: QuantityOfInterest, cases: &[CaseAnswer]) -> Option<Surrogate> {
    let with_number = |case: &CaseAnswer| Some((case.parameters.clone(), case.numbers.get(&quantity)?.value));
    let mut given: Vec<(BTreeMap<String, f64>, f64)> = cases.iter().filter_map(with_number).collect();
    // Duplicate cases would predict themselves.
    given.sort_by(|a, b| a.0.values().partial_cmp(b.0.values()).unwrap_or(std::cmp::Ordering::Equal));
    given.dedup_by(|a, b| a.0 == b.0);
    let ranges = ranges(&given);
    let values = DVector::from_iterator(given.len(), given.iter().map(|(_, value)| *value));
    let names: Vec<&String> = ranges.keys().collect();
    if names.is_empty() {
        return None;
    }
    // The highest degree that the cases determine.
    [2, 1].into_iter().find_map(|degree| {
        let terms = terms(names.len(), degree);
        if (given.len() as f64) < CASES_PER_TERM * terms.len() as f64 {
            return None;
        }
        let entry = |row: usize, column: usize| -> f64 {
            let at = |i: &usize| place(given[row].0[names[*i]], ranges[names[*i]]);
            terms[column].iter().map(at).product()
        };
        let (coefficients, press) =
            least_squares(DMatrix::from_fn(given.len(), terms.len(), entry), &values)?;
        let variance = values.map(|value| value - values.mean()).norm_squared();
        let rounding = (ROUNDING * values.norm()).powi(2);
        let named = |(term, coefficient): (&Vec<usize>, &f64)| Term {
            parameters: term.iter().map(|i| names[*i].clone()).collect(),
            coefficient: *coefficient,
        };
        Some(Surrogate {
            quantity,
            cases: given.len(),
            degree,
            ranges: ranges.clone(),
            terms: terms.iter().zip(&coefficients).map(named).collect(),
            hold_out_error: (press / given.len() as f64).sqrt(),
            hold_out_explained_variance: (variance > rounding).then(|| 1.0 - press / variance),
        })
    })
}

/// Minimum and maximum of each parameter that varies.
fn ranges(given: &[(BTreeMap<String, f64>, f64)]) -> BTreeMap<String, [f64; 2]> {
    let mut ranges: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for (name, value) in given.iter().flat_map(|(parameters, _)| parameters) {
        let range = ranges.entry(name.clone()).or_insert([*value; 2]);
        *range = [range[0].min(*value), range[1].max(*value)];
    }
    ranges.retain(|_, [low, high]| low < high);
    ranges
}

/// Maps a value in a range to −1…1.
fn place(value: f64, [low, high]: [f64; 2]) -> f64 {
    (2.0 * value - low - high) / (high - low)
}

/// All products of the parameters up to a degree.
fn terms(parameters: usize, degree: usize) -> Vec<Vec<usize>> {
    let mut terms = vec![Vec::new()];
    terms.extend((0..parameters).map(|i| vec![i]));
    if degree > 1 {
        terms.extend((0..parameters).flat_map(|i| (i..parameters).map(move |j| vec![i, j])));
    }
    terms
}

/// Coefficients, and the sum of squared errors of each row predicted from the others; `None` if the rows do not
/// determine them.
fn least_squares(A: DMatrix<f64>, b: &DVector<f64>) -> Option<(Vec<f64>, f64)> {
    let svd = A.clone().svd(true, true);
    let (largest, least) = (svd.singular_values.max(), svd.singular_values.min());
    if !(least > SINGULAR * largest) {
        return None;
    }
    let x = svd.solve(b, 0.0).ok()?;
    let off = b - A * &x;
    let U = svd.u?;
    let mut press = 0.0;
    for (off, row) in off.iter().zip(U.row_iter()) {
        let leverage = row.norm_squared();
        if leverage > MOST_LEVERAGE {
            return None;
        }
        press += (off / (1.0 - leverage)).powi(2);
    }
    Some((x.iter().copied().collect(), press))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::case_answer::Number;
    use super::super::cases::Origin;
    use super::*;
    use std::collections::BTreeSet;

    /// Cases at points of two parameters, with one number each.
    fn cases(points: &[[f64; 2]], number: impl Fn([f64; 2]) -> f64) -> Vec<CaseAnswer> {
        let case = |(index, point): (usize, &[f64; 2])| CaseAnswer {
            index,
            name: String::new(),
            origin: Origin::Base,
            parameters: BTreeMap::from([
                ("speed".into(), point[0]),
                ("fat".into(), point[1]),
                ("still".into(), 7.0),
            ]),
            edits: BTreeMap::new(),
            ending: "finished".into(),
            reason: None,
            reaches: Vec::new(),
            lower_bounds: BTreeSet::new(),
            steps: 1,
            numbers: BTreeMap::from([(
                QuantityOfInterest::PeakForceN,
                Number::new(number(*point), None, true),
            )]),
        };
        points.iter().enumerate().map(case).collect()
    }

    fn spread(count: u32) -> Vec<[f64; 2]> {
        // Halton sequence.
        let digit = |mut i: u32, base: u32| {
            let (mut value, mut fraction) = (0.0, 1.0 / f64::from(base));
            while i > 0 {
                value += fraction * f64::from(i % base);
                i /= base;
                fraction /= f64::from(base);
            }
            value
        };
        (1..=count).map(|i| [80.0 + 40.0 * digit(i, 2), 0.005 + 0.01 * digit(i, 3)]).collect()
    }

    #[test]
    fn a_quadratic_is_found_again_and_predicts_itself() {
        let law = |[v, t]: [f64; 2]| 3.0 + 0.2 * v * v - 4e3 * t * v + 1e6 * t * t;
        let all = surrogates(&cases(&spread(20), law));
        let [surrogate] = &all[..] else { panic!("{all:?}") };
        assert_eq!((surrogate.degree, surrogate.cases, surrogate.terms.len()), (2, 20, 6));
        assert!(
            surrogate.hold_out_error < 1e-8 && surrogate.hold_out_explained_variance.unwrap() > 1.0 - 1e-9
        );
        let at = BTreeMap::from([("speed".into(), 97.0), ("fat".into(), 0.0091)]);
        assert!((surrogate.propose(&at).unwrap() - law([97.0, 0.0091])).abs() < 1e-8);
        let outside = BTreeMap::from([("speed".into(), 130.0), ("fat".into(), 0.0091)]);
        assert_eq!(surrogate.propose(&outside), None);
    }

    #[test]
    fn what_it_is_off_is_that_of_fits_without_the_case() {
        let points = spread(12);
        let law = |[v, t]: [f64; 2]| (0.1 * v).sin() + 300.0 * t;
        let surrogate = &surrogates(&cases(&points, law))[0];
        // Cross-validation by explicit refitting; the ranges of the others may be narrower, but the polynomials are the
        // same.
        let off = |i: &usize| {
            let mut others = points.clone();
            let omitted = others.remove(*i);
            let others = cases(&others, law);
            let given: Vec<_> = others
                .iter()
                .map(|case| (case.parameters.clone(), case.numbers[&QuantityOfInterest::PeakForceN].value))
                .collect();
            let ranges = ranges(&given);
            let row = |at: &BTreeMap<String, f64>| -> Vec<f64> {
                let z: Vec<f64> = ranges.iter().map(|(name, range)| place(at[name], *range)).collect();
                terms(2, surrogate.degree).iter().map(|term| term.iter().map(|i| z[*i]).product()).collect()
            };
            let rows: Vec<f64> = given.iter().flat_map(|(at, _)| row(at)).collect();
            let A = DMatrix::from_row_slice(given.len(), rows.len() / given.len(), &rows);
            let values: Vec<f64> = given.iter().map(|(_, value)| *value).collect();
            let (x, _) = least_squares(A, &DVector::from_vec(values)).unwrap();
            let left = &cases(&[omitted], law)[0];
            let said: f64 = row(&left.parameters).iter().zip(&x).map(|(a, x)| a * x).sum();
            (said - law(omitted)).powi(2)
        };
        let error = ((0..12).map(|i| off(&i)).sum::<f64>() / 12.0).sqrt();
        assert!(
            (surrogate.hold_out_error / error - 1.0).abs() < 1e-9,
            "{} {error}",
            surrogate.hold_out_error
        );
    }

    #[test]
    fn of_a_constant_there_is_no_fraction() {
        for constant in [0.0, 27.316] {
            let all = surrogates(&cases(&spread(20), |_| constant));
            let [surrogate] = &all[..] else { panic!("{all:?}") };
            assert_eq!(surrogate.hold_out_explained_variance, None);
            assert!(surrogate.hold_out_error < 1e-12, "{}", surrogate.hold_out_error);
        }
    }

    #[test]
    fn too_few_cases_make_no_surrogate() {
        let law = |[v, t]: [f64; 2]| v * t;
        assert_eq!(surrogates(&cases(&spread(4), law)), []);
        assert_eq!(surrogates(&cases(&spread(6), law))[0].degree, 1);
        // Repeating a case adds no information.
        let again: Vec<[f64; 2]> = spread(4).into_iter().chain(spread(4)).collect();
        assert_eq!(surrogates(&cases(&again, law)), []);
        // No variation, no surrogate.
        assert_eq!(surrogates(&cases(&[[90.0, 0.01]; 9], law)), []);
    }
}
