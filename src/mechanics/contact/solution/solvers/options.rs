//! Stopping criteria of the solvers, and what they report.

use super::method::Method;

/// Largest violation of the law by a converged solution, as a fraction of the free velocities.
pub const LARGEST_OF_FREE: f64 = 1e-2;

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
    /// Called between iterations: true stops the solver with its best iterate. It never changes the path to a
    /// solution.
    pub interrupt: Option<&'a dyn Fn() -> bool>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: None, method: Method::Hybrid, interrupt: None }
    }
}

/// Stopping criteria of one solver.
pub(super) struct Limits<'a> {
    pub tolerance: f64,
    pub iterations: usize,
    pub interrupt: Option<&'a dyn Fn() -> bool>,
}

impl Limits<'_> {
    pub fn interrupted(&self) -> bool {
        self.interrupt.is_some_and(|requested| requested())
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
    /// [`Errors::of_free`](super::super::problem::Errors::of_free) of the solution.
    pub error_of_free: f64,
    /// The scaled error is within the tolerance, and the law violated by at most a hundredth of the free velocities:
    /// where no solution exists, reactions may grow until the scaled error is small. Otherwise `r` is the best
    /// iterate.
    pub converged: bool,
    /// Contacts without a local solution in the last sweep of Gauss–Seidel: nothing moves them along n, or friction
    /// jams.
    pub failed_contacts: usize,
}
