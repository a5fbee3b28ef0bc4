//! Solvers of a [`ContactProblem`], one file each, under its name in the literature.
//!
//! All use the same dimensionless numbers, see `scaled.rs`.

mod accelerated_gradient;
mod de_saxce;
mod extragradient;
mod fixed_point;
mod frictionless;
mod hybrid;
mod interior_point;
mod linear_system;
mod local_newton;
mod matrix_free;
mod newton;
mod nsgs;
mod proximal;
mod scaled;
mod second_order_cone;
mod uzawa;

pub use frictionless::solve_frictionless;
pub use matrix_free::{MatrixFree, solve_matrix_free};

use super::problem::ContactProblem;
use scaled::Scaled;

/// Largest violation of the law by a converged solution, as a fraction of the free velocities.
pub const LARGEST_OF_FREE: f64 = 1e-2;

/// Method by which a contact problem is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Chooses and switches between solvers automatically.
    #[default]
    Hybrid,
    /// Block Gauss–Seidel with the exact solution of each contact.
    Nsgs,
    /// Semismooth Newton on all contacts.
    Newton,
    /// Primal-dual interior points on the second-order cones.
    InteriorPoint,
    /// Proximal points, each by Gauss–Seidel and Newton.
    Proximal,
    /// The fixed point of De Saxcé & Feng.
    DeSaxce,
    /// Extragradient steps of adaptive length.
    Extragradient,
    /// One projection per contact and sweep, with a step length for each contact.
    Uzawa,
    /// Projected gradient with Nesterov's momentum and restarts.
    AcceleratedGradient,
    /// One unknown per contact in frictionless problems; [`Method::Hybrid`] in others.
    Frictionless,
}

impl Method {
    /// All methods, the default first.
    pub const ALL: [Self; 10] = [
        Self::Hybrid,
        Self::Nsgs,
        Self::Newton,
        Self::InteriorPoint,
        Self::Proximal,
        Self::DeSaxce,
        Self::Uzawa,
        Self::Extragradient,
        Self::AcceleratedGradient,
        Self::Frictionless,
    ];

    /// Name in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hybrid => "hybrid",
            Self::Nsgs => "nsgs",
            Self::Newton => "newton",
            Self::InteriorPoint => "interior-point",
            Self::Proximal => "proximal",
            Self::DeSaxce => "de-saxce",
            Self::Uzawa => "uzawa",
            Self::Extragradient => "extragradient",
            Self::AcceleratedGradient => "accelerated-gradient",
            Self::Frictionless => "frictionless",
        }
    }

    /// Whether it allows an infinite μ, which the De Saxcé form does not.
    fn takes_full_stick(self) -> bool {
        matches!(self, Self::Hybrid | Self::Nsgs | Self::Newton | Self::Proximal | Self::Frictionless)
    }

    /// The method with a name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }
}

/// Method and stopping criteria.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Largest scaled error [-] of a converged solution.
    pub tolerance: f64,
    /// Largest number of iterations of the solver (sweeps or Newton steps); `None` for its default.
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
struct Limits<'a> {
    tolerance: f64,
    iterations: usize,
    interrupt: Option<&'a dyn Fn() -> bool>,
}

impl Limits<'_> {
    fn interrupted(&self) -> bool {
        self.interrupt.is_some_and(|asked| asked())
    }
}

/// Result of one solver at its best iterate.
#[derive(Clone, Copy, Debug)]
struct Ending {
    iterations: usize,
    error: f64,
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
    /// [`Errors::of_free`](super::problem::Errors::of_free) of the solution.
    pub error_of_free: f64,
    /// The scaled error is within the tolerance, and the law violated by at most a hundredth of the free velocities:
    /// where no solution exists, reactions may grow until the scaled error is small. Otherwise `r` is the best
    /// iterate.
    pub converged: bool,
    /// Contacts without a local solution in the last sweep of Gauss–Seidel: nothing moves them along n, or friction
    /// jams.
    pub failed_contacts: usize,
}

/// Solves for the reactions: `r` (3 nc) is the initial guess, then the solution. Initial values that are not finite
/// count as zero.
///
/// The errors are those of the result in the problem as given. Deterministic.
///
/// # Panics
/// If `r` does not have three numbers per contact.
pub fn solve(problem: &ContactProblem, r: &mut [f64], options: &Options) -> SolveReport {
    assert_eq!(r.len(), problem.q().len(), "three reactions per contact");
    if problem.q().iter().all(|q| *q == 0.0) {
        r.fill(0.0);
    }
    let mut scaled = Scaled::new(problem, r);
    let limits = |most| Limits {
        tolerance: options.tolerance,
        iterations: options.max_iterations.unwrap_or(most),
        interrupt: options.interrupt,
    };
    let (solver, iterations) = run(&mut scaled, options.method, limits);
    scaled.store(r);
    let errors = problem.errors(r);
    SolveReport {
        solver,
        iterations,
        error_scaled: errors.scaled,
        error_plain: errors.plain,
        error_of_free: errors.of_free,
        converged: errors.scaled <= options.tolerance && errors.of_free <= LARGEST_OF_FREE,
        failed_contacts: scaled.failed_contacts,
    }
}

/// Runs one solver; returns which one found the solution, and its iterations. Where a μ is infinite, which not all
/// solvers allow, the default replaces them.
fn run<'a>(scaled: &mut Scaled, method: Method, limits: impl Fn(usize) -> Limits<'a>) -> (Method, usize) {
    let sticks = scaled.mu.iter().any(|mu| mu.is_infinite());
    let ending = match method {
        _ if sticks && !method.takes_full_stick() => return run(scaled, Method::Hybrid, limits),
        Method::Hybrid | Method::Frictionless if scaled.is_frictionless() => {
            let ending = frictionless::solve(scaled, &limits(frictionless::MAX_SWEEPS));
            return (Method::Frictionless, ending.iterations);
        }
        Method::Hybrid | Method::Frictionless => {
            let (found_by, ending) = hybrid::solve(scaled, &limits(usize::MAX));
            return (found_by, ending.iterations);
        }
        Method::Nsgs => nsgs::solve(scaled, &limits(nsgs::MAX_SWEEPS)),
        Method::Newton => newton::solve(scaled, &limits(newton::MAX_STEPS), newton::CAREFUL),
        Method::InteriorPoint => interior_point::solve(scaled, &limits(interior_point::MAX_STEPS)),
        Method::Proximal => proximal::solve(scaled, &limits(proximal::MAX_STEPS)),
        Method::DeSaxce => de_saxce::solve(scaled, &limits(fixed_point::MAX_STEPS)),
        Method::Uzawa => uzawa::solve(scaled, &limits(fixed_point::MAX_STEPS)),
        Method::Extragradient => extragradient::solve(scaled, &limits(fixed_point::MAX_STEPS)),
        Method::AcceleratedGradient => accelerated_gradient::solve(scaled, &limits(fixed_point::MAX_STEPS)),
    };
    (method, ending.iterations)
}
