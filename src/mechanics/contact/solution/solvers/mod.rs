//! Solvers of a [`ContactProblem`], one file each, under its name in the literature.
//!
//! All use the same dimensionless numbers, see `scaled.rs`.

mod accelerated_gradient;
mod block_lu;
mod block_system;
mod de_saxce;
mod extragradient;
mod fixed_point;
mod frictionless;
mod hybrid;
mod interior_point;
mod linear_system;
mod local_newton;
mod matrix_free;
mod measure;
mod method;
mod newton;
mod newton_krylov;
mod nsgs;
mod options;
mod parts;
mod proximal;
mod scaled;
mod second_order_cone;
mod uzawa;

pub use frictionless::solve_frictionless;
pub use matrix_free::{MatrixFree, solve_matrix_free};
pub use method::Method;
pub use options::{LARGEST_OF_MOTION, Options, SolveReport, largest_of_motion};

use super::problem::ContactProblem;
use options::{Limits, Work};
use scaled::Scaled;

/// Solves for the reactions: `r` (3 nc) is the initial guess, then the solution. Initial values that are no numbers, or
/// whose squares overflow, count as zero. Groups of contacts that W does not connect are solved one by one.
///
/// The errors are those of the result in the problem as given. Deterministic.
///
/// # Panics
/// If `r` does not have three numbers per contact.
pub fn solve(problem: &ContactProblem, r: &mut [f64], options: &Options) -> SolveReport {
    assert_eq!(r.len(), problem.q().len(), "three reactions per contact");
    let groups = parts::groups(problem.W());
    if groups.len() > 1
        && let Ok(work) = parts::solve(problem, &groups, r, options, solve_connected)
    {
        let of_all = SolveReport::new(&problem.errors(r), &work.total, options.tolerance);
        return SolveReport { converged: of_all.converged && work.all_solved, ..of_all };
    }
    solve_connected(problem, r, options)
}

/// Solves all contacts at once.
fn solve_connected(problem: &ContactProblem, r: &mut [f64], options: &Options) -> SolveReport {
    if problem.q().iter().all(|q| *q == 0.0) {
        r.fill(0.0);
    }
    let mut scaled = Scaled::new(problem, r, options.tolerance);
    let (solver, iterations) = run(&mut scaled, options.method, |most| Limits::new(options, most));
    scaled.store(r);
    let Scaled { failed_contacts, is_jammed, .. } = scaled;
    let work = Work { solver, iterations, failed_contacts, is_jammed };
    SolveReport::new(&problem.errors(r), &work, options.tolerance)
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
