//! Frictionless problems: one unknown per contact, `0 ≤ r_n ⊥ W_nn r_n + q_n ≥ 0`.
//!
//! A few sweeps of projected Gauss–Seidel provide an estimate of the active set, which is solved and updated in turn
//! (the primal-dual active set method, which is Newton's on this problem: Hintermüller, Ito & Kunisch 2002); sweeps
//! finish the rest.

use super::linear_system::LinearSystem;
use super::measure::Growth;
use super::method::Method;
use super::options::{Ending, Limits, Options, SolveReport, Work, largest_of_motion};
use super::scaled::Scaled;
use crate::contact::solution::local;
use crate::contact::solution::problem::{Errors, ProblemError, squared_motion};

/// Default limit of sweeps.
pub(super) const MAX_SWEEPS: usize = 100_000;
/// Sweeps before the active set is estimated.
const FIRST_SWEEPS: usize = 20;
/// Largest number of estimates of the active set.
const GUESSES: usize = 50;
/// Compliance added to each contact, relative to its own, that bounds reactions that nothing else does.
const ALPHA: f64 = 1e-13;

/// The normal part of a problem.
struct Normal {
    /// Columns of `W_nn`: (row, value).
    columns: Vec<Vec<(u32, f64)>>,
    diagonal: Vec<f64>,
    r: Vec<f64>,
    u: Vec<f64>,
    q: Vec<f64>,
    /// `‖q‖` of all three directions, as in the scaled error.
    q_size: f64,
    /// As in `measure.rs`.
    hidden: f64,
    is_jammed: bool,
}

/// Iterations until the error is within the tolerance.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    let mut normal = Normal::new(scaled, limits.tolerance);
    let iterations = normal.solve(limits);
    let r: Vec<f64> = normal.r.iter().flat_map(|r| [*r, 0.0, 0.0]).collect();
    scaled.set_reactions(&r);
    scaled.is_jammed = normal.is_jammed;
    Ending { iterations, error: scaled.error() }
}

/// Solves `0 ≤ r ⊥ W r + q ≥ 0` with W (nc × nc, row by row) of the normal directions; `r` is the initial guess, then
/// the solution.
///
/// # Errors
/// [`ProblemError`] where W or q have values that are not finite or do not match the length of `r`.
pub fn solve_frictionless(
    W: &[f64],
    q: &[f64],
    r: &mut [f64],
    options: &Options,
) -> Result<SolveReport, ProblemError> {
    let n = r.len();
    for (array, expected, given) in [("q", n, q.len()), ("W", n * n, W.len())] {
        if given != expected {
            return Err(ProblemError::Length { array, expected, given });
        }
    }
    for (array, numbers) in [("q", q), ("W", W)] {
        if let Some(index) = numbers.iter().position(|x| !x.is_finite()) {
            return Err(ProblemError::NotFinite {
                array,
                index: if array == "W" { index / n } else { index },
            });
        }
    }
    // Dimensionless, as in `scaled.rs`: the diagonal is one.
    let root: Vec<f64> =
        (0..n).map(|c| W[c * (n + 1)].sqrt()).map(|d| if d > 0.0 { d } else { 1.0 }).collect();
    let entry = |c: usize, d: usize| W[c * n + d] / (root[c] * root[d]);
    let column = |d: usize| (0..n).map(|c| (c as u32, entry(c, d))).filter(|(_, w)| *w != 0.0).collect();
    let scaled_q: Vec<f64> = q.iter().zip(&root).map(|(q, root)| q / root).collect();
    let mut normal = Normal {
        columns: (0..n).map(column).collect(),
        diagonal: (0..n).map(|c| entry(c, c)).collect(),
        r: r.iter().zip(&root).map(|(r, root)| r * root).collect(),
        u: scaled_q.clone(),
        q_size: scaled_q.iter().map(|x| x * x).sum::<f64>().sqrt(),
        q: scaled_q,
        hidden: largest_of_motion(options.tolerance) / options.tolerance,
        is_jammed: false,
    };
    normal.update_velocity();
    let iterations = normal.solve(&Limits::new(options, MAX_SWEEPS));
    // Solution and its errors in the original units.
    for ((r, scaled), root) in r.iter_mut().zip(&normal.r).zip(&root) {
        *r = scaled / root;
    }
    let f = |c: usize| -> f64 {
        let u: f64 = q[c] + (0..n).map(|d| W[c * n + d] * r[d]).sum::<f64>();
        r[c] - (r[c] - u).max(0.0)
    };
    let plain = (0..n).map(|c| f(c).powi(2)).sum::<f64>().sqrt();
    let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let ratio = |error: f64, size: f64| if error == 0.0 { 0.0 } else { error / size };
    let [residual, reactions, motion] = normal.sizes();
    let errors = Errors {
        scaled: ratio(residual, reactions.max(normal.q_size)),
        plain: ratio(plain, size(q).max(size(r))),
        of_free: ratio(residual, normal.q_size),
        of_motion: ratio(residual, motion),
    };
    let is_jammed = normal.is_jammed;
    let work = Work { solver: Method::Frictionless, iterations, failed_contacts: 0, is_jammed };
    Ok(SolveReport::new(&errors, &work, options.tolerance))
}

impl Normal {
    /// Sweeps, active sets, sweeps; returns the number of iterations.
    fn solve(&mut self, limits: &Limits) -> usize {
        let mut iterations = self.sweep_until(limits, FIRST_SWEEPS.min(limits.iterations));
        if self.error() > limits.tolerance {
            iterations += self.guess_until(limits, GUESSES.min(limits.iterations - iterations));
        }
        iterations + self.sweep_until(limits, limits.iterations - iterations)
    }

    fn new(scaled: &Scaled, tolerance: f64) -> Self {
        let every: Vec<usize> = (0..scaled.contacts).collect();
        let mut columns = vec![Vec::new(); scaled.contacts];
        for (d, column) in columns.iter_mut().enumerate() {
            scaled.for_column(d, &every, |c, block| {
                if block[0][0] != 0.0 {
                    column.push((c as u32, block[0][0]));
                }
            });
        }
        let normal = |x: &[f64]| -> Vec<f64> { x.iter().step_by(3).copied().collect() };
        let q_size = scaled.q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let q = normal(&scaled.q);
        let diagonal = scaled.diagonal.iter().map(|block| block[0][0]).collect();
        let hidden = largest_of_motion(tolerance) / tolerance;
        let (r, u) = (normal(&scaled.r), q.clone());
        let mut normal = Self { columns, diagonal, r, u, q, q_size, hidden, is_jammed: false };
        normal.update_velocity();
        normal
    }

    fn update_velocity(&mut self) {
        self.u.copy_from_slice(&self.q);
        for (column, &r) in self.columns.iter().zip(&self.r) {
            for &(row, w) in column {
                self.u[row as usize] += w * r;
            }
        }
    }

    /// Norms of the natural map, or of the approach where it is larger, of the reactions, and of the motion.
    fn sizes(&self) -> [f64; 3] {
        let (mut residual, mut reactions, mut change) = (0.0, 0.0, 0.0);
        for ((r, u), q) in self.r.iter().zip(&self.u).zip(&self.q) {
            let f = r - (r - u).max(0.0);
            residual += (f * f).max(u.min(0.0).powi(2));
            reactions += r * r;
            change += r * (u - q);
        }
        [residual, reactions, squared_motion(self.q_size * self.q_size, change, reactions)].map(f64::sqrt)
    }

    /// As that of `measure.rs`.
    fn error(&self) -> f64 {
        let [residual, reactions, motion] = self.sizes();
        if residual == 0.0 { 0.0 } else { residual / reactions.max(self.q_size).min(self.hidden * motion) }
    }

    /// Examines whether reactions become as large as [`ALPHA`] allows, and nothing is stopped.
    fn look_for_jam(&mut self) {
        let Some(r) = self.solve_active(ALPHA) else { return };
        let start = std::mem::take(&mut self.r);
        self.set_reactions(r);
        let mut growth = Growth::default();
        for ((r, u), q) in self.r.iter().zip(&self.u).zip(&self.q) {
            growth.add([*r, 0.0, 0.0], [u, q].map(|x| [*x, 0.0, 0.0]), 0.0);
        }
        self.is_jammed = growth.is_unbounded(self.q_size * self.q_size);
        self.set_reactions(start);
    }

    fn set_reactions(&mut self, r: Vec<f64>) {
        self.r = r;
        self.update_velocity();
    }

    fn sweep_until(&mut self, limits: &Limits, most: usize) -> usize {
        for sweep in 0..most {
            if self.is_jammed || self.error() <= limits.tolerance || limits.interrupted() {
                return sweep;
            }
            for c in 0..self.r.len() {
                let w = self.diagonal[c];
                let new = if w > 0.0 { local::solve_frictionless(w, self.u[c] - w * self.r[c]) } else { 0.0 };
                let change = new - self.r[c];
                if change != 0.0 {
                    self.r[c] = new;
                    for &(row, w) in &self.columns[c] {
                        self.u[row as usize] += w * change;
                    }
                }
            }
        }
        most
    }

    /// Solves for estimated active sets; keeps the best reactions.
    fn guess_until(&mut self, limits: &Limits, most: usize) -> usize {
        let mut best = (self.error(), self.r.clone());
        let mut guesses = 0;
        while guesses < most && best.0 > limits.tolerance && !limits.interrupted() {
            let Some(r) = self.solve_active(0.0) else { break };
            self.set_reactions(r);
            guesses += 1;
            let error = self.error();
            if error < best.0 {
                best = (error, self.r.clone());
            }
        }
        self.set_reactions(best.1);
        if best.0 > limits.tolerance && !limits.interrupted() {
            self.look_for_jam();
        }
        guesses
    }

    /// Reactions with `u + alpha r = 0` where contacts press by the current estimate, and zero elsewhere.
    fn solve_active(&self, alpha: f64) -> Option<Vec<f64>> {
        let mut place = vec![usize::MAX; self.r.len()];
        let active: Vec<usize> = (0..self.r.len()).filter(|&c| self.r[c] > self.u[c]).collect();
        for (k, &c) in active.iter().enumerate() {
            place[c] = k;
        }
        let mut system = LinearSystem::new(active.len());
        for (k, &d) in active.iter().enumerate() {
            if alpha > 0.0 {
                system.add(k, k, alpha);
            }
            for &(row, w) in self.columns[d].iter().filter(|(row, _)| place[*row as usize] != usize::MAX) {
                system.add(place[row as usize], k, w);
            }
        }
        let mut x: Vec<f64> = active.iter().map(|&c| -self.q[c]).collect();
        let mut r = vec![0.0; self.r.len()];
        if system.factorise()?.solve(&mut x) {
            for (x, &c) in x.iter().zip(&active) {
                r[c] = *x;
            }
            return Some(r);
        }
        None
    }
}
