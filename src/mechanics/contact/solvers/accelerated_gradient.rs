//! Projected gradient accelerated by Nesterov's momentum, restarted where it points back (O'Donoghue & Candès 2015; for
//! contact Mazhar et al. 2015), on the De Saxcé form.

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
    let (mut momentum, mut steps) = (1.0_f64, 0);
    let mut last = scaled.r.clone();
    let mut ahead = last.clone();
    while error > limits.tolerance && steps < limits.iterations && !limits.interrupted() {
        scaled.set_reactions(&ahead);
        let next = scaled.projected_step(&ahead, rho);
        // (y − r₊) · (r₊ − r) > 0: the momentum leads uphill.
        let uphill: f64 = (0..next.len()).map(|i| (ahead[i] - next[i]) * (next[i] - last[i])).sum();
        let grown = if uphill > 0.0 { 1.0 } else { 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt()) };
        let share = if uphill > 0.0 { 0.0 } else { (momentum - 1.0) / grown };
        ahead = next.iter().zip(&last).map(|(n, l)| n + share * (n - l)).collect();
        momentum = grown;
        scaled.set_reactions(&next);
        last = next;
        error = scaled.error();
        steps += 1;
    }
    Ending { iterations: steps, error }
}
