//! Nonsmooth Gauss–Seidel: one contact after the other is solved exactly, the others held (Jean & Moreau; Jourdan,
//! Alart & Jean 1998).

use super::Options;
use super::scaled::Scaled;
use crate::mechanics::contact::delassus::times;
use crate::mechanics::contact::local::solve_contact;
use crate::mechanics::contact::problem::local;

/// Sweeps unless the caller says otherwise.
const MAX_SWEEPS: usize = 10_000;

/// Sweeps until the error is within the tolerance; returns how many.
pub(super) fn solve(scaled: &mut Scaled, options: &Options) -> usize {
    let most = options.max_iterations.unwrap_or(MAX_SWEEPS);
    for sweep in 0..most {
        if scaled.error() <= options.tolerance || options.interrupted() {
            return sweep;
        }
        for c in 0..scaled.contacts {
            let W = scaled.diagonal[c];
            let (old, u) = (local(&scaled.r, c), local(&scaled.u, c));
            let own = times(&W, old);
            let new = solve_contact(&W, [u[0] - own[0], u[1] - own[1], u[2] - own[2]], scaled.mu[c]);
            scaled.change(c, new);
        }
    }
    most
}
