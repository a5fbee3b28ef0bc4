//! Nonsmooth Gauss–Seidel: one contact after the other is solved exactly, with the others fixed (Jean & Moreau;
//! Jourdan, Alart & Jean 1998).

use super::local_newton;
use super::options::{Ending, Limits};
use super::scaled::Scaled;
use crate::contact::solution::delassus::times;
use crate::contact::solution::problem::local;

/// Default limit of sweeps.
pub(super) const MAX_SWEEPS: usize = 100_000;

/// Sweeps until the error is within the tolerance.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    for sweep in 0..=limits.iterations {
        let error = scaled.error();
        if error <= limits.tolerance || sweep == limits.iterations || limits.interrupted() {
            return Ending { iterations: sweep, error };
        }
        self::sweep(scaled);
        if sweep % 64 == 63 {
            // Remove accumulated rounding.
            scaled.update_velocity();
        }
    }
    Ending { iterations: limits.iterations, error: scaled.error() }
}

/// One sweep over all contacts, in order; counts the contacts without a local solution.
pub(super) fn sweep(scaled: &mut Scaled) {
    scaled.failed_contacts = 0;
    for c in 0..scaled.contacts {
        let W = &scaled.diagonal[c];
        let (old, u) = (local(&scaled.r, c), local(&scaled.u, c));
        let own = times(W, old);
        let q = [u[0] - own[0], u[1] - own[1], u[2] - own[2]];
        let new = local_newton::solve(W, q, scaled.mu[c], old);
        scaled.failed_contacts += usize::from(!new.solved);
        scaled.change(c, new.r);
    }
}
