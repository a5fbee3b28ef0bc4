//! A primal-dual interior-point method on the bi-potential law itself: the second-order cone program of the frozen slip
//! (Acary, Cadoux, Lemaréchal & Malick 2011), with the slip `‖u_t‖` linearised along instead of frozen.
//!
//! With `x = (μ r_n, r_t)` and `y = (ũ_n/μ, u_t)` both cones are `Q = { x_0 ≥ ‖x_t‖ }`, and the law is
//!
//! ```text
//! y = M x + b + ‖y_t‖ e_0,    x, y ∈ Q,    x ∘ y = 0,    M = P⁻¹ W P⁻¹,  b = P⁻¹ q,  P = diag(μ, 1, 1)
//! ```
//!
//! Newton's method with Nesterov–Todd scaling follows `x ∘ y = m e_0` as m falls. The system `M + G H`, with H
//! positive definite in every block, is regular however deficient the rank of W. m falls only where both the
//! complementarity and the velocities have come close to their targets: otherwise the iterates reach the border
//! before they are solutions, and stick there. ‖y_t‖ is smoothed at the scale of m, where a sticking contact has its
//! kink.
//!
//! A frictionless contact (μ = 0) has the half line alone.

use super::block_system::{BlockFactors, BlockSystem};
use super::options::{Ending, Limits};
use super::scaled::Scaled;
use super::second_order_cone::{Scaling, longest_step, product, quotient};
use crate::contact::solution::delassus::{Block, times};
use crate::contact::solution::local::Local;
use crate::contact::solution::problem::local;

/// Default limit of steps.
pub(super) const MAX_STEPS: usize = 100;
/// First m, as a fraction of the square of the largest free velocity, and the factor by which it falls.
const TARGET: (f64, f64) = (0.1, 0.1);
/// Deviation of `x ∘ y` from its target, as a fraction of it, below which m may fall.
const CENTRED: f64 = 0.9;
/// Residual of the velocities in multiples of m (over the scale) below which m may fall.
const FEASIBLE: f64 = 10.0;
/// Smoothing of ‖y_t‖ as a fraction of m over the scale.
const ROUNDING: f64 = 0.01;
/// Fraction of the distance to the border of the cones that a step may take.
const BORDER: f64 = 0.99;
/// Steps shorter than this, this many in a row, make no progress.
const STUCK: (f64, usize) = (1e-2, 4);

/// The iterate, with the data of each contact that a step needs.
struct Iterate<'a> {
    scaled: &'a Scaled,
    system: BlockSystem,
    /// The diagonal of P⁻¹; 0 for frictionless directions.
    inverse: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    /// Largest component of the scaled free velocities `P⁻¹ q`.
    scale: f64,
}

/// The linearised equations of one step.
struct Step {
    scalings: Vec<Scaling>,
    /// The gradient of the smoothed ‖y_t‖.
    gradients: Vec<[f64; 2]>,
    /// Residual `M x + b + ‖y_t‖ e_0 − y`.
    residual: Vec<f64>,
    factors: BlockFactors,
}

/// Steps until the error is within the tolerance, or they make no progress; ends with the best iterate. Requires
/// finite μ; else does nothing.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    let mut best = (scaled.error(), scaled.r.clone());
    let mut steps = 0;
    let mut short = 0;
    if scaled.mu.iter().any(|mu| mu.is_infinite()) {
        return Ending { iterations: 0, error: best.0 };
    }
    let mut trial = scaled.clone();
    let mut iterate = Iterate::new(scaled);
    let mut target = TARGET.0 * iterate.scale * iterate.scale;
    while steps < limits.iterations && short < STUCK.1 && !limits.interrupted() {
        // Keep the best iterate.
        trial.set_reactions(&iterate.reactions());
        let error = trial.error();
        if error < best.0 {
            best = (error, trial.r.clone());
        }
        if error <= limits.tolerance {
            break;
        }
        // One Newton step; m falls where the iterate is close to its target.
        let velocity: Vec<f64> = trial.u.iter().zip(&iterate.inverse).map(|(u, p)| u * p).collect();
        let Some(step) = iterate.linearise(&velocity, ROUNDING * target / iterate.scale) else { break };
        if step.off_centre(target) < CENTRED && step.infeasibility() * iterate.scale < FEASIBLE * target {
            target *= TARGET.1;
        }
        let Some(step_length) = iterate.advance(&step, target) else { break };
        short = if step_length < STUCK.0 { short + 1 } else { 0 };
        steps += 1;
    }
    scaled.set_reactions(&best.1);
    Ending { iterations: steps, error: best.0 }
}

impl<'a> Iterate<'a> {
    /// An iterate well inside the cones.
    fn new(scaled: &'a Scaled) -> Self {
        let row = |&mu: &f64| if mu > 0.0 { [1.0 / mu, 1.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let inverse: Vec<f64> = scaled.mu.iter().flat_map(row).collect();
        let scale = scaled.q.iter().zip(&inverse).fold(0.0, |m: f64, (q, p)| m.max((q * p).abs()));
        let x: Vec<f64> = (0..inverse.len()).map(|i| if i % 3 == 0 { scale } else { 0.0 }).collect();
        Self { scaled, system: BlockSystem::default(), inverse, y: x.clone(), x, scale }
    }

    /// Reactions `r = P⁻¹ x`.
    fn reactions(&self) -> Vec<f64> {
        self.x.iter().zip(&self.inverse).map(|(x, p)| x * p).collect()
    }

    /// The equations around the iterate, with `velocity = M x + b`; `None` where they are singular.
    fn linearise(&mut self, velocity: &[f64], rounding: f64) -> Option<Step> {
        let contacts = self.scaled.contacts;
        let scalings: Vec<Scaling> =
            (0..contacts).map(|c| Scaling::new(local(&self.x, c), local(&self.y, c))).collect();
        let mut gradients = Vec::with_capacity(contacts);
        let mut residual: Vec<f64> = velocity.iter().zip(&self.y).map(|(v, y)| v - y).collect();
        for c in 0..contacts {
            let [_, t1, t2] = local(&self.y, c);
            let slip = t1.hypot(t2).hypot(rounding);
            let rubs = self.scaled.mu[c] > 0.0;
            gradients.push(if rubs { [t1 / slip, t2 / slip] } else { [0.0; 2] });
            residual[3 * c] += if rubs { slip } else { 0.0 };
        }
        self.system.begin(contacts);
        let every: Vec<usize> = (0..contacts).collect();
        for d in 0..contacts {
            let right = local(&self.inverse, d);
            self.scaled.for_column(d, &every, |c, block| {
                let left = local(&self.inverse, c);
                let block = [0, 1, 2].map(|i| [0, 1, 2].map(|j| left[i] * block[i][j] * right[j]));
                self.system.add(c, d, &block);
            });
            self.system.add(d, d, &through_slip(&scalings[d].square, gradients[d]));
        }
        Some(Step { scalings, gradients, residual, factors: self.system.factorise()? })
    }

    /// One Newton step towards `x ∘ y = target e_0`; returns its length, or `None` if the system is singular.
    fn advance(&mut self, step: &Step, target: f64) -> Option<f64> {
        let contacts = self.scaled.contacts;
        // dx from the reduced system, with dy + H dx = z.
        let z: Vec<Local> = step.scalings.iter().map(|s| s.towards(target)).collect();
        let mut dx = Vec::with_capacity(3 * contacts);
        for (c, z) in z.iter().enumerate() {
            let [g1, g2] = step.gradients[c];
            let [r0, r1, r2] = local(&step.residual, c);
            dx.extend([z[0] - g1 * z[1] - g2 * z[2] - r0, z[1] - r1, z[2] - r2]);
        }
        if !step.factors.solve(&mut dx) {
            return None;
        }
        // dy, and the longest step inside the cones.
        let mut dy = Vec::with_capacity(3 * contacts);
        let mut longest = f64::INFINITY;
        for (c, z) in z.iter().enumerate() {
            let h = times(&step.scalings[c].square, local(&dx, c));
            let d = [z[0] - h[0], z[1] - h[1], z[2] - h[2]];
            longest = longest.min(longest_step(local(&self.x, c), local(&dx, c)));
            longest = longest.min(longest_step(local(&self.y, c), d));
            dy.extend(d);
        }
        let step_length = (BORDER * longest).min(1.0);
        for (x, d) in self.x.iter_mut().zip(&dx) {
            *x += step_length * d;
        }
        for (y, d) in self.y.iter_mut().zip(&dy) {
            *y += step_length * d;
        }
        Some(step_length)
    }
}

impl Step {
    /// Largest `‖x ∘ y − m e_0‖ / m` of all contacts.
    fn off_centre(&self, target: f64) -> f64 {
        let off = |s: &Scaling| {
            let [n, t1, t2] = product(s.lambda, s.lambda);
            (n - target).abs().max(t1.hypot(t2)) / target
        };
        self.scalings.iter().map(off).fold(0.0, f64::max)
    }

    fn infeasibility(&self) -> f64 {
        self.residual.iter().fold(0.0, |m, x| m.max(x.abs()))
    }
}

impl Scaling {
    /// Right-hand side `V (λ \ (m e_0 − λ ∘ λ))`.
    fn towards(&self, target: f64) -> Local {
        let square = product(self.lambda, self.lambda);
        times(&self.root, quotient(self.lambda, [target - square[0], -square[1], -square[2]]))
    }
}

/// Product `G H` with `G = I − e_0 (0, ∇‖y_t‖)`.
fn through_slip(H: &Block, [g1, g2]: [f64; 2]) -> Block {
    [[0, 1, 2].map(|j| H[0][j] - g1 * H[1][j] - g2 * H[2][j]), H[1], H[2]]
}
