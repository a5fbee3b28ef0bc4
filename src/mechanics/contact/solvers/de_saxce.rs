//! The fixed point of De Saxcé & Feng (1998) on all contacts at once: `r ← Proj_K(r − ρ (u + μ ‖u_t‖ n))`.
//!
//! Sure and slow: ρ is the inverse of the largest eigenvalue of W.

use super::scaled::Scaled;
use super::{Ending, Limits};

/// Iterations unless the caller says otherwise.
pub(super) const MAX_STEPS: usize = 100_000;

/// Iterations until the error is within the tolerance; needs finite μ, else nothing is done.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    let mut error = scaled.error();
    if scaled.mu.iter().any(|mu| mu.is_infinite()) {
        return Ending { iterations: 0, error };
    }
    let rho = 1.0 / scaled.largest_eigenvalue();
    let mut steps = 0;
    while error > limits.tolerance && steps < limits.iterations && !limits.interrupted() {
        let next = scaled.projected_step(&scaled.r, rho);
        scaled.set_reactions(&next);
        error = scaled.error();
        steps += 1;
    }
    Ending { iterations: steps, error }
}
