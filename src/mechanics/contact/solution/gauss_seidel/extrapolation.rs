//! Anderson acceleration of long sequences of sweeps: the combination of the last iterates with the least change
//! (Walker & Ni 2011, "Anderson acceleration for fixed-point iterations").
//!
//! ```text
//! f_k = G(p_k) − p_k        γ = argmin ‖f_k − Σ γ_j Δf_j‖        p_{k+1} = G(p_k) − Σ γ_j ΔG_j
//! ```
//!
//! with Δ the differences from sweep to sweep. The result may leave the cones; the next sweep brings it back.

use super::super::local::Local;
use crate::contact::Reaction;

/// Number of sweeps combined with the last one.
const DEPTH: usize = 5;
/// Number of sweeps before it begins: most solutions are found by then.
const BEGIN: usize = 6;
/// Growth of the squared change of a sweep at which the history is discarded.
const GROWN: f64 = 4.0;
/// Least pivot of the normal equations, relative to the diagonal.
const DEPENDENT: f64 = 1e-10;
/// The same, relative to the squared change of a sweep: where there is no solution each sweep adds the same, and
/// differences are rounding.
const RESOLVED: f64 = 1e-8;
/// Largest step, relative to the impulses that it is added to.
const LARGEST: f64 = 10.0;

/// History of the last sweeps: impulses and their changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Extrapolation {
    /// Impulses before a sweep; after it, the step to be added.
    step: Vec<Local>,
    /// Changes f by the previous sweep, and its result G.
    last: [Vec<Local>; 2],
    /// Differences Δf and ΔG from sweep to sweep, in a ring buffer.
    differences: [[Vec<Local>; 2]; DEPTH],
    sweeps: usize,
    /// Number of valid differences.
    known: usize,
    /// Squared change by the previous sweep.
    last_change: f64,
}

impl Extrapolation {
    pub fn with_capacity(contacts: usize) -> Self {
        let room = || [Vec::with_capacity(contacts), Vec::with_capacity(contacts)];
        Self {
            step: Vec::with_capacity(contacts),
            last: room(),
            differences: std::array::from_fn(|_| room()),
            ..Self::default()
        }
    }

    pub fn restart(&mut self) {
        (self.sweeps, self.known) = (0, 0);
    }

    /// Stores the impulses before a sweep.
    pub fn remember(&mut self, reactions: &[Reaction]) {
        self.step.clear();
        self.step.extend(reactions.iter().map(|reaction| reaction.impulse));
    }

    /// The step to add to the impulses after a sweep of squared change `change`, if any.
    pub fn step(&mut self, reactions: &[Reaction], change: f64) -> Option<&[Local]> {
        self.sweeps += 1;
        if self.sweeps < BEGIN {
            return None;
        }
        let has_grown = change > GROWN * self.last_change;
        self.last_change = change;
        let slot = self.sweeps % DEPTH;
        self.differ(reactions, slot);
        if has_grown || self.sweeps == BEGIN {
            self.known = 0;
            return None;
        }
        self.known = (self.known + 1).min(DEPTH);
        let coefficients = self.coefficients(slot);
        self.step.fill([0.0; 3]);
        for (k, coefficient) in coefficients.iter().enumerate().take(self.known) {
            for (step, result) in self.step.iter_mut().zip(&self.differences[Self::back(slot, k)][1]) {
                *step = [0, 1, 2].map(|i| step[i] - coefficient * result[i]);
            }
        }
        let size = |list: &[Local]| list.iter().flatten().map(|x| x * x).sum::<f64>();
        (size(&self.step) <= LARGEST * LARGEST * size(&self.last[1])).then_some(&self.step[..])
    }

    /// Slot of the difference `k` sweeps before that in `slot`.
    fn back(slot: usize, k: usize) -> usize {
        (slot + DEPTH - k) % DEPTH
    }

    /// Stores the change by this sweep and its difference from that of the previous sweep; at the first sweep there
    /// is none.
    fn differ(&mut self, reactions: &[Reaction], slot: usize) {
        let Self { step: before, last: [change, result], differences, .. } = self;
        let [changes, results] = &mut differences[slot];
        changes.clear();
        results.clear();
        let is_first = self.sweeps == BEGIN;
        if is_first {
            change.clear();
            result.clear();
            change.resize(reactions.len(), [0.0; 3]);
            result.resize(reactions.len(), [0.0; 3]);
        }
        let less = |a: &Local, b: &Local| [0, 1, 2].map(|i| a[i] - b[i]);
        let sides = before.iter().zip(change).zip(result);
        for (reaction, ((before, change), result)) in reactions.iter().zip(sides) {
            let now = less(&reaction.impulse, before);
            changes.push(less(&now, change));
            results.push(less(&reaction.impulse, result));
            (*change, *result) = (now, reaction.impulse);
        }
    }

    /// Least squares by Cholesky: the coefficients γ of the differences, the latest first, that minimise `‖f − ΔF
    /// γ‖`.
    fn coefficients(&self, slot: usize) -> [f64; DEPTH] {
        let of = |k: usize| &self.differences[Self::back(slot, k)][0];
        let dot = |a: &[Local], b: &[Local]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
        };
        let (n, least) = (self.known, RESOLVED * dot(&self.last[0], &self.last[0]));
        // Normal equations.
        let (mut L, mut y) = ([[0.0; DEPTH]; DEPTH], [0.0; DEPTH]);
        for i in 0..n {
            for j in 0..=i {
                L[i][j] = dot(of(i), of(j));
            }
            y[i] = dot(of(i), &self.last[0]);
        }
        // Cholesky factor; a difference in the span of the later ones gets no coefficient.
        for i in 0..n {
            let diagonal = L[i][i];
            for j in 0..i {
                let sum: f64 = (0..j).map(|k| L[i][k] * L[j][k]).sum();
                L[i][j] = if L[j][j] > 0.0 { (L[i][j] - sum) / L[j][j] } else { 0.0 };
            }
            let pivot = diagonal - L[i][..i].iter().map(|x| x * x).sum::<f64>();
            L[i][i] = if pivot > (DEPENDENT * diagonal).max(least) { pivot.sqrt() } else { 0.0 };
        }
        // Forward and backward substitution.
        for i in 0..n {
            let sum: f64 = (0..i).map(|k| L[i][k] * y[k]).sum();
            y[i] = if L[i][i] > 0.0 { (y[i] - sum) / L[i][i] } else { 0.0 };
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|k| L[k][i] * y[k]).sum();
            y[i] = if L[i][i] > 0.0 { (y[i] - sum) / L[i][i] } else { 0.0 };
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_linear_iteration_ends_in_a_few_sweeps() {
        // p ← p + (1 − λ)(p* − p) in five modes, the slowest of which takes seventy sweeps to halve without
        // acceleration.
        let rates = [0.99, 0.97, 0.9, 0.5, 0.1];
        let (mut reactions, mut extrapolation) = (vec![Reaction::default(); 40], Extrapolation::default());
        let goal = |c: usize, i: usize| 1.0 + c as f64 - 0.3 * i as f64;
        let mut left = Vec::new();
        for _ in 0..16 {
            extrapolation.remember(&reactions);
            let mut change = 0.0;
            for (c, reaction) in reactions.iter_mut().enumerate() {
                for (i, p) in reaction.impulse.iter_mut().enumerate() {
                    let step = (1.0 - rates[(c + i) % 5]) * (goal(c, i) - *p);
                    *p += step;
                    change += step * step;
                }
            }
            left.push(change.sqrt());
            if let Some(step) = extrapolation.step(&reactions, change) {
                for (reaction, step) in reactions.iter_mut().zip(step) {
                    reaction.impulse.iter_mut().zip(step).for_each(|(p, step)| *p += step);
                }
            }
        }
        assert!(left[5] > 1e-2 * left[0] && left[15] < 1e-8 * left[0], "{left:?}");
    }
}
