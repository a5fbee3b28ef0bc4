//! The proximal-point method for a rank-deficient W (Rockafellar 1976): a sequence of problems with `W + α I` and `q
//! − α r_k`, each well posed, each started at the last solution, by Gauss–Seidel and Newton.
//!
//! α falls while the inner problems are solved and rises where they are not. The error of `r_{k+1}` in the original
//! problem is α times its change.

use super::options::{Ending, Limits};
use super::scaled::Scaled;
use super::{newton, nsgs};

/// Default limit of outer iterations.
pub(super) const MAX_STEPS: usize = 600;
/// α of the first inner problem, the least and the greatest; every diagonal block has trace 3.
const ALPHA: (f64, f64, f64) = (1e-2, 1e-8, 1.0);
/// Factors on α after an inner problem that was solved, and after one that was not.
const CHANGE: (f64, f64) = (0.3, 5.0);
/// Largest number of Newton steps of an inner problem.
const NEWTON_STEPS: usize = 50;
/// Gauss–Seidel sweeps before these Newton steps.
const SWEEPS: usize = 10;
/// Tolerance of an inner problem, as a fraction of the current error and at least of the requested tolerance.
const INNER: f64 = 0.1;

/// Outer iterations until the error is within the tolerance; ends with the best iterate. Counts inner sweeps and
/// steps.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    let mut error = scaled.error();
    let mut best = (error, scaled.r.clone());
    let mut alpha = ALPHA.0;
    let mut iterations = 0;
    for _ in 0..limits.iterations {
        if error <= limits.tolerance || limits.interrupted() {
            break;
        }
        // The regularised problem around the current reactions.
        scaled.set_proximal(alpha);
        let tolerance = INNER * error.max(limits.tolerance);
        let inner = |iterations| Limits { tolerance, iterations, ..*limits };
        let swept = nsgs::solve(scaled, &inner(SWEEPS));
        let ending = newton::solve(scaled, &inner(NEWTON_STEPS), newton::CAREFUL);
        iterations += swept.iterations + ending.iterations;
        scaled.set_proximal(0.0);
        // Error of the original problem.
        error = scaled.error();
        if error < best.0 {
            best = (error, scaled.r.clone());
        }
        let change = if ending.error <= tolerance { CHANGE.0 } else { CHANGE.1 };
        alpha = (change * alpha).clamp(ALPHA.1, ALPHA.2);
    }
    if error > best.0 {
        scaled.set_reactions(&best.1);
    }
    Ending { iterations, error: best.0 }
}
