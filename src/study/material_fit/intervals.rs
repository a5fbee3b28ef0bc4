//! Confidence intervals of fitted parameters: of the linearised model, with independent normal errors of the same variance.
//!
//! The covariance of the unknowns is s² (JᵀJ)⁻¹ with s² = |r|²/(n − p); the interval is ± t √variance with Student's t of n − p degrees of
//! freedom (Bates & Watts 1988). Of a parameter of a fixed sign it is that of its logarithm.

use super::answer::FittedParameter;
use super::least_squares::{Minimum, SINGULAR};
use super::model::Model;
use super::student::two_sided_quantile;
use crate::scene::problem::{Pointer, Problem};
use nalgebra::{DMatrix, DVector};

/// Fraction of such intervals that contain the parameter.
const CONFIDENCE: f64 = 0.95;
/// Condition number of J with columns of length 1 from which parameters are nearly dependent (Belsley, Kuh & Welsch 1980) [-].
const NEARLY_SINGULAR: f64 = 30.0;
/// Component of a singular direction from which a parameter takes part in it [-].
const TAKES_PART: f64 = 0.3;
/// Standard error relative to the value from which a parameter counts as undetermined [-].
const UNDETERMINED: f64 = 0.5;

/// Variances of the unknowns at a minimum.
pub(super) struct Intervals {
    /// Singular values of J with columns of length 1.
    singular_values: DVector<f64>,
    /// Right singular vectors, as columns.
    directions: DMatrix<f64>,
    /// Pseudo-inverse (JᵀJ)⁺ of the normal matrix.
    inverse: DMatrix<f64>,
    /// Whether the variance of each unknown is bounded.
    is_bounded: Vec<bool>,
    /// Number of residuals less that of parameters.
    degrees_of_freedom: usize,
    /// s, `None` without degrees of freedom.
    deviation: Option<f64>,
}

impl Intervals {
    /// Intervals about a minimum, by linearisation.
    pub fn new(minimum: &Minimum) -> Self {
        let (J, r) = (&minimum.jacobian, &minimum.residual);
        let lengths = DVector::from_iterator(J.ncols(), J.column_iter().map(|column| column.norm()));
        let inverse_length = lengths.map(|length| if length > 0.0 { 1.0 / length } else { 0.0 });
        let svd = (J * DMatrix::from_diagonal(&inverse_length)).svd(false, true);
        let directions = svd.v_t.map_or_else(|| DMatrix::zeros(J.ncols(), J.ncols()), |v_t| v_t.transpose());
        let least = SINGULAR * svd.singular_values.max();
        let gains = svd.singular_values.map(|s| if s > least { 1.0 / (s * s) } else { 0.0 });
        let scaled = &directions * DMatrix::from_diagonal(&gains) * directions.transpose();
        let inverse = DMatrix::from_fn(J.ncols(), J.ncols(), |i, k| {
            scaled[(i, k)] * inverse_length[i] * inverse_length[k]
        });
        let in_null_space =
            |i: usize| (0..gains.len()).any(|k| gains[k] == 0.0 && directions[(i, k)].abs() > 0.1);
        let degrees_of_freedom = r.len() - J.ncols();
        Self {
            is_bounded: (0..J.ncols()).map(|i| lengths[i] > 0.0 && !in_null_space(i)).collect(),
            deviation: (degrees_of_freedom > 0).then(|| r.norm() / (degrees_of_freedom as f64).sqrt()),
            singular_values: svd.singular_values,
            directions,
            inverse,
            degrees_of_freedom,
        }
    }

    /// Number of residuals less that of parameters.
    pub fn degrees_of_freedom(&self) -> usize {
        self.degrees_of_freedom
    }

    /// Standard deviation s of the residuals.
    pub fn deviation(&self) -> Option<f64> {
        self.deviation
    }

    /// Condition number of J with columns of length 1; `None` where J is singular.
    pub fn condition(&self) -> Option<f64> {
        let (most, least) = (self.singular_values.max(), self.singular_values.min());
        (least > SINGULAR * most).then(|| most / least)
    }

    /// Correlations of the unknowns; empty where one has no variance.
    pub fn correlations(&self) -> Vec<Vec<f64>> {
        if self.is_bounded.contains(&false) {
            return Vec::new();
        }
        let C = &self.inverse;
        let row = |i: usize| (0..C.ncols()).map(|k| C[(i, k)] / (C[(i, i)] * C[(k, k)]).sqrt()).collect();
        (0..C.nrows()).map(row).collect()
    }

    /// The parameters with their intervals.
    pub fn parameters(&self, model: &Model, values: &[f64]) -> Vec<FittedParameter> {
        let t = if self.degrees_of_freedom > 0 {
            two_sided_quantile(CONFIDENCE, self.degrees_of_freedom)
        } else {
            f64::NAN
        };
        let of = |(i, (parameter, &value)): (usize, (&crate::scene::material_fit::Parameter, &f64))| {
            let error =
                self.deviation.filter(|_| self.is_bounded[i]).map(|s| s * self.inverse[(i, i)].sqrt());
            let (standard_error, interval) = match error {
                None => (None, None),
                // The interval of the logarithm.
                Some(e) if parameter.has_fixed_sign => {
                    let ends = [value * (-t * e).exp(), value * (t * e).exp()];
                    (Some(value.abs() * e), Some([ends[0].min(ends[1]), ends[0].max(ends[1])]))
                }
                Some(e) => {
                    let e = parameter.scale * e;
                    (Some(e), Some([value - t * e, value + t * e]))
                }
            };
            FittedParameter {
                pointer: parameter.pointer.clone(),
                start: parameter.start,
                value,
                standard_error: standard_error.filter(|e| e.is_finite()),
                interval: interval.filter(|ends| ends.iter().all(|end| end.is_finite())),
                is_logarithm: parameter.has_fixed_sign,
            }
        };
        model.parameters.iter().zip(values).enumerate().map(of).collect()
    }

    /// Reports what the curves do not determine.
    pub fn report(&self, parameters: &[FittedParameter], problems: &mut Vec<Problem>) {
        let root = Pointer::root();
        if self.degrees_of_freedom == 0 {
            problems.push(
                Problem::warning(
                    "no_degrees_of_freedom",
                    &root,
                    "as many parameters as points: no intervals",
                )
                .value(parameters.len())
                .limit("fewer parameters than points")
                .remedy("add points, or fit fewer parameters"),
            );
        }
        problems.extend(self.dependent(parameters));
        for (i, parameter) in parameters.iter().enumerate() {
            let is_undetermined = match parameter.standard_error {
                Some(error) => error > UNDETERMINED * parameter.value.abs(),
                None => self.degrees_of_freedom > 0,
            };
            if is_undetermined {
                let message = format!("the curves hardly determine {}", parameter.pointer);
                problems.push(
                    Problem::warning("undetermined", &root.key("free").index(i), message)
                        .value(parameter.standard_error.map_or_else(
                            || "no finite standard error".to_owned(),
                            |error| format!("{:.3e} ± {error:.1e}", parameter.value),
                        ))
                        .limit(format!("a standard error of at most {UNDETERMINED} of the value"))
                        .remedy("fix it, or add a test that depends on it"),
                );
            }
        }
    }

    /// Parameters that can be changed together with hardly a change of the curves.
    fn dependent(&self, parameters: &[FittedParameter]) -> Option<Problem> {
        let condition = self.singular_values.max() / self.singular_values.min();
        if !(condition > NEARLY_SINGULAR) {
            return None;
        }
        let weakest = self.singular_values.imin();
        let takes_part =
            |(i, _): &(usize, &FittedParameter)| self.directions[(*i, weakest)].abs() > TAKES_PART;
        let names: Vec<&str> =
            parameters.iter().enumerate().filter(takes_part).map(|(_, p)| p.pointer.as_str()).collect();
        let message =
            format!("the curves hardly change when these are changed together: {}", names.join(", "));
        Some(
            Problem::warning("nearly_dependent", &Pointer::root().key("free"), message)
                .value(format!("condition number {condition:.1e}"))
                .limit(format!("at most {NEARLY_SINGULAR}, with columns of the Jacobian of length 1"))
                .remedy("fix one of them, or add a test of another kind or range"),
        )
    }
}
