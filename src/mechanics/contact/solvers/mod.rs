//! Solvers of a [`ContactProblem`], one file each under its name in the literature.
//!
//! All work in the same dimensionless numbers, see [`scaled`].

mod hybrid;
mod interior_point;
mod linear_system;
mod local_newton;
mod newton;
mod nsgs;
mod proximal;
mod scaled;
mod second_order_cone;

use super::problem::ContactProblem;
use scaled::Scaled;

/// Which solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Picks and switches by itself.
    #[default]
    Hybrid,
    /// Block Gauss–Seidel with the exact solution of each contact.
    Nsgs,
    /// Semismooth Newton.
    Newton,
    /// IP.
    InteriorPoint,
    /// prox.
    Proximal,
}

impl Method {
    /// All of them, the default first.
    pub const ALL: [Self; 5] = [Self::Hybrid, Self::Nsgs, Self::Newton, Self::InteriorPoint, Self::Proximal];

    /// Its name, as in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hybrid => "hybrid",
            Self::Nsgs => "nsgs",
            Self::Newton => "newton",
            Self::InteriorPoint => "interior-point",
            Self::Proximal => "proximal",
        }
    }

    /// The solver of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }
}

/// When to stop, and how to get there.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Largest scaled error [-] of a converged solution.
    pub tolerance: f64,
    /// Most iterations of the solver (its own: sweeps or Newton steps); `None` for what suits it.
    pub max_iterations: Option<usize>,
    /// Which solver.
    pub method: Method,
    /// Asked between iterations: true ends the solver with its best iterate. It never changes the way to a solution.
    pub interrupt: Option<&'a dyn Fn() -> bool>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: None, method: Method::Hybrid, interrupt: None }
    }
}

/// When one solver stops.
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

/// How one solver stopped: with its best iterate.
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

/// How a solution ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// Which solver found it; never [`Method::Hybrid`].
    pub solver: Method,
    /// Iterations of all solvers that had a part in it.
    pub iterations: usize,
    /// [`ContactProblem::error_scaled`] of the solution.
    pub error_scaled: f64,
    /// [`ContactProblem::error_plain`] of the solution.
    pub error_plain: f64,
    /// The scaled error is within the tolerance. Else the solution is the best iterate.
    pub converged: bool,
}

/// Solves for the reactions: `r` (3 nc) start in, solution out. Numbers of the start that are not finite count as zero.
///
/// The errors are measured on what is handed out, with the problem as given. Deterministic.
///
/// # Panics
/// If `r` has not three numbers a contact.
pub fn solve(problem: &ContactProblem, r: &mut [f64], options: &Options) -> SolveReport {
    assert_eq!(r.len(), problem.q().len(), "three reactions a contact");
    let mut scaled = Scaled::new(problem, r);
    let limits = |most| Limits {
        tolerance: options.tolerance,
        iterations: options.max_iterations.unwrap_or(most),
        interrupt: options.interrupt,
    };
    let (solver, ending) = match options.method {
        Method::Hybrid => hybrid::solve(&mut scaled, options.tolerance, &limits(usize::MAX)),
        Method::Nsgs => (Method::Nsgs, nsgs::solve(&mut scaled, &limits(nsgs::MAX_SWEEPS))),
        Method::InteriorPoint => {
            (Method::InteriorPoint, interior_point::solve(&mut scaled, &limits(interior_point::MAX_STEPS)))
        }
        Method::Proximal => (Method::Proximal, proximal::solve(&mut scaled, &limits(proximal::MAX_STEPS))),
        Method::Newton => {
            (Method::Newton, newton::solve(&mut scaled, &limits(newton::MAX_STEPS), newton::CAREFUL))
        }
    };
    scaled.store(r);
    let (error_scaled, error_plain) = (problem.error_scaled(r), problem.error_plain(r));
    SolveReport {
        solver,
        iterations: ending.iterations,
        error_scaled,
        error_plain,
        converged: error_scaled <= options.tolerance,
    }
}
