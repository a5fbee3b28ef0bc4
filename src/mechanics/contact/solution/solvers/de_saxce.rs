//! The fixed point of De Saxcé & Feng (1998) on all contacts at once: `r ← Proj_K(r − ρ (u + μ ‖u_t‖ n))`.
//!
//! Robust and slow: ρ is the inverse of the largest eigenvalue of W.

use super::fixed_point::{Iterate, iterate};
use super::options::{Ending, Limits};
use super::scaled::Scaled;

/// Iterations until the error is within the tolerance; requires finite μ, else does nothing.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    iterate(scaled, limits, Iterate::safe_step, |scaled, rho| {
        let next = scaled.projected_step(&scaled.r, *rho);
        scaled.set_reactions(&next);
    })
}
