//! Measures of an iterate in dimensionless numbers: its error, and whether its reactions grow without bound.

use crate::contact::solution::local::{Local, proj_coulomb_cone, squared_residual};
use crate::contact::solution::problem::{local, squared, squared_motion, work};

/// Ratio of reactions to the motion from which they may be without bound [-]. They are a thousand times as large where a body of a
/// millionth of the mass of another is between it and a wall.
pub(super) const UNBOUNDED: f64 = 1e6;
/// Distance of unbounded reactions from their cones, as a fraction of their size.
const OUTSIDE: f64 = 1e-2;
/// Part of the work of the free velocities on unbounded reactions that these do not stop.
const LEFT: f64 = 0.2;

/// A dimensionless problem (see `scaled.rs`) at its iterate.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub mu: &'a [f64],
    pub q: &'a [f64],
    pub r: &'a [f64],
    /// Velocities `W r + q`.
    pub u: &'a [f64],
    /// Norm `‖q‖` of the free velocities.
    pub q_size: f64,
    /// Largest error relative to the motion of a solution, in multiples of the tolerance.
    pub hidden: f64,
}

impl At<'_> {
    /// The scaled error `‖F‖ / max(‖r‖, ‖q‖)`, or, where it is larger, what `of_motion` of
    /// [`Errors`](crate::contact::solution::problem::Errors) measures, over `hidden`.
    pub fn error(&self) -> f64 {
        let (mut error, mut unstopped, mut reactions, mut change) = (0.0, 0.0, 0.0, 0.0);
        for (c, &mu) in self.mu.iter().enumerate() {
            let (r, u, q) = (local(self.r, c), local(self.u, c), local(self.q, c));
            let residual = squared_residual(r, u, mu, 1.0);
            error += residual;
            unstopped += residual.max(u[0].min(0.0).powi(2));
            reactions += squared(r);
            change += work(r, [u[0] - q[0], u[1] - q[1], u[2] - q[2]]);
        }
        if unstopped == 0.0 {
            return 0.0;
        }
        let motion = squared_motion(self.q_size * self.q_size, change, reactions).sqrt();
        (error.sqrt() / reactions.sqrt().max(self.q_size)).max(unstopped.sqrt() / (self.hidden * motion))
    }

    /// [`Growth::is_unbounded`] of all contacts.
    pub fn is_jammed(&self) -> bool {
        let mut growth = Growth::default();
        for (c, &mu) in self.mu.iter().enumerate() {
            growth.add(local(self.r, c), [local(self.u, c), local(self.q, c)], mu);
        }
        growth.is_unbounded(self.q_size * self.q_size)
    }
}

/// Sums over contacts that show whether reactions grow without bound.
///
/// Without friction no solution exists where reactions `y ≥ 0` change no velocity, `W y = 0`, and the free velocities do work against them,
/// `y · q < 0`: whatever the other reactions, `y · u = y · q`. Iterates of a solver grow along such a y.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Growth {
    /// `‖r‖²`, and the squared distance of r from the cones.
    reactions: f64,
    outside: f64,
    /// Work on r of the free velocities and of the present ones, these with the slip of the bi-potential.
    free: f64,
    left: f64,
    /// `rᵀ W r`.
    change: f64,
}

impl Growth {
    /// Adds a contact with its reaction, its velocities with and without reactions, and its coefficient of friction.
    pub fn add(&mut self, r: Local, [u, q]: [Local; 2], mu: f64) {
        let sticks = mu.is_infinite();
        let nearest = if sticks { [r[0].max(0.0), r[1], r[2]] } else { proj_coulomb_cone(r, mu) };
        let slip = if sticks { 0.0 } else { mu * u[1].hypot(u[2]) };
        self.reactions += squared(r);
        self.outside += squared([0, 1, 2].map(|i| r[i] - nearest[i]));
        self.free += work(r, q);
        self.left += work(r, u) + slip * r[0];
        self.change += work(r, u) - work(r, q);
    }

    /// Whether the reactions are far larger than the motion, and the free velocities `‖q‖² = free` go on doing work against them.
    pub fn is_unbounded(&self, free: f64) -> bool {
        self.free < 0.0
            && self.left < LEFT * self.free
            && self.outside <= OUTSIDE * OUTSIDE * self.reactions
            && self.reactions > UNBOUNDED * UNBOUNDED * squared_motion(free, self.change, self.reactions)
    }
}
