//! Stopping criteria of the solvers, and what they report.

use super::super::problem::Errors;
use super::method::Method;

/// Largest tolerance, and largest violation of the law by a converged solution relative to the motion
/// ([`Errors::of_motion`](Errors::of_motion)).
pub const LARGEST_OF_MOTION: f64 = 1e-2;
/// The same in multiples of the tolerance: on light bodies reactions, which the tolerance is relative to, are so much larger than the motion.
const HIDDEN: f64 = 10.0;
/// What is small relative to the motion whatever the tolerance.
const SMALL: f64 = 1e-8;

/// Largest error relative to the motion of a solution that has converged to a `tolerance`.
pub fn largest_of_motion(tolerance: f64) -> f64 {
    (HIDDEN * tolerance).clamp(SMALL, LARGEST_OF_MOTION)
}

/// Method and stopping criteria.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Largest scaled error [-] of a converged solution.
    pub tolerance: f64,
    /// Largest number of iterations of the solver (sweeps or Newton steps), of each group of contacts that W connects; `None` for its
    /// default.
    pub max_iterations: Option<usize>,
    /// Method by which to solve.
    pub method: Method,
    /// Called between iterations: the part of the time limit that is spent; from 1 on the solver stops with its best iterate. The hybrid
    /// shares what is left among its stages. Without a limit 0 until the solver shall stop: the path to a solution does not change.
    pub spent: Option<&'a dyn Fn() -> f64>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: None, method: Method::Hybrid, spent: None }
    }
}

/// Stopping criteria of one solver.
#[derive(Clone, Copy)]
pub(super) struct Limits<'a> {
    pub tolerance: f64,
    pub iterations: usize,
    /// As in [`Options`], and the part of the time limit at which to stop.
    pub spent: Option<&'a dyn Fn() -> f64>,
    pub until: f64,
}

impl<'a> Limits<'a> {
    /// Those of the options, with a default number of iterations.
    pub fn new(options: &Options<'a>, most: usize) -> Self {
        let iterations = options.max_iterations.unwrap_or(most);
        Self { tolerance: options.tolerance, iterations, spent: options.spent, until: 1.0 }
    }

    /// The same for at most so many iterations.
    pub fn at_most(&self, iterations: usize) -> Self {
        Self { iterations: iterations.min(self.iterations), ..*self }
    }

    /// The same for a share of the time that is left.
    pub fn share(&self, share: f64) -> Self {
        let spent = self.spent.map_or(0.0, |spent| spent()).min(self.until);
        Self { until: spent + share * (self.until - spent), ..*self }
    }

    pub fn interrupted(&self) -> bool {
        self.spent.is_some_and(|spent| spent() >= self.until)
    }
}

/// Result of one solver at its best iterate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ending {
    pub iterations: usize,
    pub error: f64,
}

impl std::fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("tolerance", &self.tolerance)
            .field("max_iterations", &self.max_iterations)
            .field("method", &self.method)
            .finish_non_exhaustive()
    }
}

/// How a solution was found; fields as of [`SolveReport`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Work {
    pub solver: Method,
    pub iterations: usize,
    pub failed_contacts: usize,
    pub is_jammed: bool,
}

impl SolveReport {
    pub(super) fn new(errors: &Errors, work: &Work, tolerance: f64) -> Self {
        let converged = errors.scaled <= tolerance && errors.of_motion <= largest_of_motion(tolerance);
        Self {
            solver: work.solver,
            iterations: work.iterations,
            error_scaled: errors.scaled,
            error_plain: errors.plain,
            error_of_free: errors.of_free,
            error_of_motion: errors.of_motion,
            converged,
            is_jammed: work.is_jammed && !converged,
            failed_contacts: work.failed_contacts,
        }
    }
}

/// Outcome of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// The solver that found it; never [`Method::Hybrid`].
    pub solver: Method,
    /// Iterations of all solvers involved.
    pub iterations: usize,
    /// [`ContactProblem::error_scaled`] of the solution.
    pub error_scaled: f64,
    /// [`ContactProblem::error_plain`] of the solution.
    pub error_plain: f64,
    /// [`Errors::of_free`](Errors::of_free) of the solution.
    pub error_of_free: f64,
    /// [`Errors::of_motion`](Errors::of_motion) of the solution.
    pub error_of_motion: f64,
    /// The scaled error is within the tolerance, and that relative to the motion within [`largest_of_motion`]: where no solution exists,
    /// reactions may grow until the scaled error is small. Otherwise `r` is the best iterate.
    pub converged: bool,
    /// Reactions that change no velocity were found to grow without bound, since the free velocities do work against them: nothing can
    /// stop these contacts. Sure without friction; with it probable, and most of the stages that remain are omitted.
    pub is_jammed: bool,
    /// Contacts without a local solution in the last sweep of Gauss–Seidel: nothing moves them along n, or friction
    /// jams.
    pub failed_contacts: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_stops_after_its_share_of_the_time_and_without_a_limit_never() {
        let now = std::cell::Cell::new(0.5);
        let spent = || now.get();
        let limits = Limits::new(&Options { spent: Some(&spent), ..Options::default() }, 10);
        let (half, whole) = (limits.share(0.5), limits.share(1.0));
        now.set(0.74);
        assert!(!half.interrupted() && half.at_most(3).iterations == 3);
        now.set(0.76);
        assert!(half.interrupted() && !whole.interrupted());
        // A share of nothing is over at once.
        now.set(1.0);
        assert!(whole.interrupted() && limits.share(0.5).interrupted());
        assert!(!Limits::new(&Options::default(), 10).share(0.5).interrupted());
    }
}
