//! Matrix-free solution of problems with too many contacts for W to fit into memory, by products with W only: Newton steps,
//! and projected gradients with momentum where these fail.

use super::fixed_point::{Iterate, MAX_STEPS};
use super::measure::At;
use super::method::Method;
use super::options::{Ending, Limits, Options, SolveReport, Work, largest_of_motion};
use super::{accelerated_gradient, newton_krylov};
use crate::contact::solution::delassus::Block;
use crate::contact::solution::problem::{Errors, ProblemError, mean_diagonals};

/// As [`super::super::problem::ContactProblem`], with W given only by its diagonal blocks and its products; μ finite.
pub struct MatrixFree<'a> {
    /// `W r`: r (3 nc) in, the product (3 nc) out.
    pub product: &'a mut dyn FnMut(&[f64], &mut [f64]),
    /// Diagonal blocks `W_cc`, nc.
    pub diagonal: &'a [Block],
    /// The free relative velocities q, 3 nc.
    pub q: &'a [f64],
    /// Coefficients of friction μ [-], nc.
    pub mu: &'a [f64],
}

/// As [`super::solve`], by [`Method::AcceleratedGradient`] if the options name it, else by Newton steps first.
///
/// # Errors
/// [`ProblemError`] where lengths do not match, numbers are not valid, or a μ is not finite.
pub fn solve_matrix_free(
    problem: &mut MatrixFree,
    r: &mut [f64],
    options: &Options,
) -> Result<SolveReport, ProblemError> {
    problem.check(r)?;
    // Solve in dimensionless numbers.
    let d = mean_diagonals(problem.diagonal.iter().copied());
    let root: Vec<f64> = d.iter().map(|d| d.sqrt()).collect();
    let own: Vec<Block> =
        problem.diagonal.iter().zip(&d).map(|(own, d)| own.map(|row| row.map(|w| w / d))).collect();
    let mut scaled = Scaled::new(problem, &root, r, options.tolerance);
    let (mut solver, mut ending) = (Method::Newton, Ending { iterations: 0, error: f64::INFINITY });
    if options.method != Method::AcceleratedGradient {
        ending = newton_krylov::solve(&mut scaled, &own, &Limits::new(options, newton_krylov::MAX_STEPS));
    }
    if !(ending.error <= options.tolerance) {
        let last = accelerated_gradient::solve(&mut scaled, &Limits::new(options, MAX_STEPS));
        ending.iterations += last.iterations;
        solver = Method::AcceleratedGradient;
    }
    let is_jammed = scaled.at().is_jammed();
    // Errors of the solution in the units of the problem.
    for (i, (r, scaled)) in r.iter_mut().zip(&scaled.r).enumerate() {
        *r = scaled / root[i / 3];
    }
    let u: Vec<f64> = scaled.u.iter().enumerate().map(|(i, u)| u * root[i / 3]).collect();
    let errors = Errors::new(&d, (problem.q, problem.mu), r, &u);
    let work = Work { solver, iterations: ending.iterations, failed_contacts: 0, is_jammed };
    Ok(SolveReport::new(&errors, &work, options.tolerance))
}

impl MatrixFree<'_> {
    fn check(&self, r: &[f64]) -> Result<(), ProblemError> {
        let contacts = self.diagonal.len();
        let lengths = [
            ("q", 3 * contacts, self.q.len()),
            ("mu", contacts, self.mu.len()),
            ("r", 3 * contacts, r.len()),
        ];
        for (array, expected, given) in lengths {
            if given != expected {
                return Err(ProblemError::Length { array, expected, given });
            }
        }
        let own: Vec<f64> = self.diagonal.iter().flatten().flatten().copied().collect();
        for (array, numbers, rows) in [("q", self.q, 1), ("W", &own, 3), ("r", r, 1)] {
            if let Some(index) = numbers.iter().position(|x| !x.is_finite()) {
                return Err(ProblemError::NotFinite { array, index: index / rows });
            }
        }
        match self.mu.iter().position(|mu| !(*mu >= 0.0 && mu.is_finite())) {
            Some(contact) => Err(ProblemError::Friction { contact, mu: self.mu[contact] }),
            None => Ok(()),
        }
    }
}

/// The problem in dimensionless numbers, as in `scaled.rs`.
struct Scaled<'p, 'a> {
    problem: &'p mut MatrixFree<'a>,
    root: &'p [f64],
    q: Vec<f64>,
    q_size: f64,
    hidden: f64,
    r: Vec<f64>,
    u: Vec<f64>,
}

impl<'p, 'a> Scaled<'p, 'a> {
    fn new(problem: &'p mut MatrixFree<'a>, root: &'p [f64], r: &[f64], tolerance: f64) -> Self {
        let q: Vec<f64> = problem.q.iter().enumerate().map(|(i, q)| q / root[i / 3]).collect();
        let q_size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let start: Vec<f64> = r.iter().enumerate().map(|(i, r)| r * root[i / 3]).collect();
        let hidden = largest_of_motion(tolerance) / tolerance;
        let mut scaled = Self { problem, root, q_size, hidden, u: q.clone(), r: start, q };
        if r.iter().any(|r| *r != 0.0) {
            let effect = scaled.effect(r);
            scaled.u.iter_mut().zip(&effect).for_each(|(u, effect)| *u += effect);
        }
        scaled
    }

    /// The scaled velocities `W r` of reactions in the units of the problem.
    fn effect(&mut self, r: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; r.len()];
        (self.problem.product)(r, &mut y);
        for (i, y) in y.iter_mut().enumerate() {
            *y /= self.root[i / 3];
        }
        y
    }
}

impl Iterate for Scaled<'_, '_> {
    fn at(&self) -> At<'_> {
        let Self { q, q_size, hidden, r, u, .. } = self;
        At { mu: self.problem.mu, q, r, u, q_size: *q_size, hidden: *hidden }
    }

    fn set_reactions(&mut self, r: &[f64]) {
        self.r = r.to_vec();
        self.u = self.product(r);
        for (u, q) in self.u.iter_mut().zip(&self.q) {
            *u += q;
        }
    }

    fn set_known(&mut self, r: &[f64], u: &[f64]) {
        self.r.copy_from_slice(r);
        self.u.copy_from_slice(u);
    }

    fn product(&mut self, x: &[f64]) -> Vec<f64> {
        let given: Vec<f64> = x.iter().enumerate().map(|(i, x)| x / self.root[i / 3]).collect();
        self.effect(&given)
    }
}
