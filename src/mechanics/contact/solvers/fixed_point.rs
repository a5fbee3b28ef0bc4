//! What the first-order methods share: steps that need finite μ, until the error is small.

use super::scaled::Scaled;
use super::{Ending, Limits};

/// Iterations unless the caller says otherwise.
pub(super) const MAX_STEPS: usize = 100_000;

/// Takes steps until the error is within the tolerance; with infinite μ, where the De Saxcé form is none, nothing is done. `prepare`
/// makes what the steps need, of which the first is usually their length.
pub(super) fn iterate<S>(
    scaled: &mut Scaled,
    limits: &Limits,
    prepare: impl FnOnce(&Scaled) -> S,
    mut step: impl FnMut(&mut Scaled, &mut S),
) -> Ending {
    let mut error = scaled.error();
    if error <= limits.tolerance || scaled.mu.iter().any(|mu| mu.is_infinite()) {
        return Ending { iterations: 0, error };
    }
    let mut own = prepare(scaled);
    let mut steps = 0;
    while error > limits.tolerance && steps < limits.iterations && !limits.interrupted() {
        step(scaled, &mut own);
        error = scaled.error();
        steps += 1;
    }
    Ending { iterations: steps, error }
}
