//! Nonlinear least squares by Levenberg and Marquardt: min ½ |r(x)|².
//!
//! A step minimises |r + J δ|² + λ |D δ|², with D the largest norms so far of the columns of J (Moré 1978). It is solved by the
//! singular values of J D⁻¹, so directions that the residuals do not depend on stay where they are.

use nalgebra::{DMatrix, DVector};

/// Largest number of iterations of one minimisation.
const ITERATIONS: u32 = 200;
/// Largest cosine of the angle between the residual and a column of J at a minimum [-].
const ORTHOGONAL: f64 = 1e-10;
/// The same where no step improves, with derivatives by differences.
const NEARLY_ORTHOGONAL: f64 = 1e-4;
/// Relative size of a step below which nothing more can be gained [-].
const SMALLEST_STEP: f64 = 1e-12;
/// Smallest singular value, relative to the largest, that derivatives by differences distinguish from 0 [-].
pub(super) const SINGULAR: f64 = 1e-5;
/// Step of central differences [-]: unknowns are scaled to the order of 1.
const DIFFERENCE: f64 = 1e-5;

/// Where the iterations ended.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Values of the unknowns.
    pub x: DVector<f64>,
    /// Residuals at these values.
    pub residual: DVector<f64>,
    /// Derivatives of the residuals by the unknowns.
    pub jacobian: DMatrix<f64>,
    /// Number of iterations that were needed.
    pub iterations: u32,
    /// Whether it is a minimum.
    pub has_converged: bool,
}

/// Minimises from `start`; residuals of a norm up to `negligible` are of rounding. `None` where the residuals at the start, or the
/// derivatives somewhere on the way, do not exist; a step to where there are none is shortened.
pub fn minimise(
    start: DVector<f64>,
    negligible: f64,
    residuals: &dyn Fn(&DVector<f64>) -> Option<DVector<f64>>,
) -> Option<Minimum> {
    let mut residual = residuals(&start)?;
    let mut jacobian = derivatives(&start, residuals)?;
    let mut x = start;
    let (mut lambda, mut scale) = (1e-3, DVector::from_element(x.len(), 0.0));
    for iterations in 0..ITERATIONS {
        let angle = largest_cosine(&jacobian, &residual);
        let done = |has_converged, x, residual, jacobian| {
            Some(Minimum { x, residual, jacobian, iterations, has_converged })
        };
        if residual.norm() <= negligible || angle <= ORTHOGONAL {
            return done(true, x, residual, jacobian);
        }
        for (scale, column) in scale.iter_mut().zip(jacobian.column_iter()) {
            *scale = column.norm().max(*scale);
        }
        match step(&x, &residual, &jacobian, &scale, &mut lambda, residuals) {
            Step::Taken(next) => (x, residual) = *next,
            Step::Converged => return done(true, x, residual, jacobian),
            Step::Stuck => return done(angle <= NEARLY_ORTHOGONAL, x, residual, jacobian),
        }
        jacobian = derivatives(&x, residuals)?;
    }
    Some(Minimum { x, residual, jacobian, iterations: ITERATIONS, has_converged: false })
}

/// Outcome of the search for a step.
enum Step {
    /// The unknowns and residuals after it.
    Taken(Box<(DVector<f64>, DVector<f64>)>),
    /// The step of Gauss and Newton, without damping, is negligible: this is the solution.
    Converged,
    /// No step improves, however small.
    Stuck,
}

/// The first step with a smaller residual, with λ ten times as large after each that has not.
fn step(
    x: &DVector<f64>,
    residual: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    scale: &DVector<f64>,
    lambda: &mut f64,
    residuals: &dyn Fn(&DVector<f64>) -> Option<DVector<f64>>,
) -> Step {
    let inverse_scale = scale.map(|d| if d > 0.0 { 1.0 / d } else { 0.0 });
    let svd = (jacobian * DMatrix::from_diagonal(&inverse_scale)).svd(true, true);
    let (Some(U), Some(Vt)) = (svd.u, svd.v_t) else { return Step::Stuck };
    let along = U.tr_mul(residual);
    let change = |gains: DVector<f64>| -Vt.tr_mul(&along.component_mul(&gains)).component_mul(&inverse_scale);
    let is_negligible = |change: &DVector<f64>| !(change.norm() > SMALLEST_STEP * (1.0 + x.norm()));
    let least = SINGULAR * svd.singular_values.max();
    if is_negligible(&change(svd.singular_values.map(|s| if s > least { 1.0 / s } else { 0.0 }))) {
        return Step::Converged;
    }
    loop {
        let change = change(svd.singular_values.map(|s| s / (s * s + *lambda)));
        if is_negligible(&change) {
            return Step::Stuck;
        }
        let trial = x + change;
        if let Some(next) = residuals(&trial).filter(|next| next.norm() < residual.norm()) {
            *lambda = (0.1 * *lambda).max(1e-15);
            return Step::Taken(Box::new((trial, next)));
        }
        *lambda *= 10.0;
    }
}

/// J by central differences.
fn derivatives(
    x: &DVector<f64>,
    residuals: &dyn Fn(&DVector<f64>) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let column = |i: usize| {
        let h = DIFFERENCE * x[i].abs().max(1.0);
        let at = |shift: f64| {
            let mut shifted = x.clone();
            shifted[i] += shift;
            residuals(&shifted)
        };
        Some((at(h)? - at(-h)?) / (2.0 * h))
    };
    let columns: Option<Vec<DVector<f64>>> = (0..x.len()).map(column).collect();
    Some(DMatrix::from_columns(&columns?))
}

/// Largest |cos| of the angle between the residual and a column of J: 0 at a minimum.
fn largest_cosine(jacobian: &DMatrix<f64>, residual: &DVector<f64>) -> f64 {
    let cosine = |column: nalgebra::DVectorView<f64>| {
        let product = column.norm() * residual.norm();
        if product > 0.0 { column.dot(residual).abs() / product } else { 0.0 }
    };
    jacobian.column_iter().map(cosine).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance, "{found} and not {expected}");
    }

    #[test]
    fn a_linear_problem_has_the_solution_of_the_normal_equations() {
        // y = a + b t, t = 0 … 4.
        let y = [1.0, 2.9, 5.2, 7.1, 8.8];
        let residuals =
            |x: &DVector<f64>| Some(DVector::from_fn(y.len(), |i, _| x[0] + x[1] * i as f64 - y[i]));
        let found = minimise(DVector::from_element(2, 0.0), 0.0, &residuals).unwrap();
        assert!(found.has_converged);
        close(found.x[1], 1.98, 1e-9);
        close(found.x[0], 5.0 - 2.0 * 1.98, 1e-9);
    }

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        let residuals =
            |x: &DVector<f64>| Some(DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]));
        let found = minimise(DVector::from_vec(vec![-1.2, 1.0]), 1e-12, &residuals).unwrap();
        assert!(found.has_converged);
        close(found.x[0], 1.0, 1e-9);
        close(found.x[1], 1.0, 1e-9);
    }

    #[test]
    fn a_parameter_without_effect_stays_and_a_region_without_values_is_avoided() {
        // ln(x0) = 0.5; x1 plays no part. The full first step leads to x0 < 0.
        let residuals =
            |x: &DVector<f64>| (x[0] > 0.0).then(|| DVector::from_vec(vec![x[0].ln() - 0.5, 0.0]));
        let found = minimise(DVector::from_vec(vec![20.0, 3.0]), 1e-14, &residuals).unwrap();
        assert!(found.has_converged);
        close(found.x[0], 0.5_f64.exp(), 1e-9);
        close(found.x[1], 3.0, 0.0);
    }
}
