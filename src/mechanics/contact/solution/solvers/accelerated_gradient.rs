//! Projected gradient accelerated by Nesterov's momentum, restarted where it points back (O'Donoghue & Candès 2015; for
//! contact Mazhar et al. 2015), on the De Saxcé form.

use super::fixed_point::{Iterate, iterate};
use super::options::{Ending, Limits};

/// State carried from step to step.
struct Momentum {
    rho: f64,
    size: f64,
    /// The last iterate, and its extrapolation by the momentum.
    last: Vec<f64>,
    ahead: Vec<f64>,
}

/// Iterations until the error is within the tolerance; requires finite μ, else does nothing.
pub(super) fn solve<P: Iterate>(scaled: &mut P, limits: &Limits) -> Ending {
    let start = |scaled: &mut P| {
        let (last, ahead) = (scaled.at().r.to_vec(), scaled.at().r.to_vec());
        Momentum { rho: scaled.safe_step(), size: 1.0, last, ahead }
    };
    iterate(scaled, limits, start, |scaled, momentum| {
        let Momentum { rho, size, last, ahead } = momentum;
        scaled.set_reactions(ahead);
        let next = scaled.projected_step(ahead, *rho);
        // (y − r₊) · (r₊ − r) > 0: the momentum points uphill.
        let uphill: f64 = (0..next.len()).map(|i| (ahead[i] - next[i]) * (next[i] - last[i])).sum();
        let grown = if uphill > 0.0 { 1.0 } else { 0.5 * (1.0 + (1.0 + 4.0 * *size * *size).sqrt()) };
        let momentum = if uphill > 0.0 { 0.0 } else { (*size - 1.0) / grown };
        *ahead = next.iter().zip(&*last).map(|(n, l)| n + momentum * (n - l)).collect();
        *size = grown;
        scaled.set_reactions(&next);
        *last = next;
    })
}
