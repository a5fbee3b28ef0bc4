//! Global semismooth Newton method on all contacts at once (Alart & Curnier 1991; Joli & Feng 2008), in whole or half
//! steps.
//!
//! Open contacts have `F = r`: their step is known, and only the others enter the linear system. The Jacobian is
//! singular where W is rank deficient: there W is replaced by `W + α I`, with α proportional to the error, which
//! gives the least change of reactions that are not determined.

use super::block_system::BlockSystem;
use super::options::{Ending, Limits};
use super::scaled::Scaled;
use crate::contact::solution::delassus::Block;
use crate::contact::solution::generalised_jacobian::{Linearised, linearise_alart_curnier};
use crate::contact::solution::local::Local;
use crate::contact::solution::problem::{is_zero, local};

/// Default limit of steps.
pub(super) const MAX_STEPS: usize = 100;
/// Ratio of errors at or below which a whole step is accepted at once.
const ENOUGH: f64 = 0.9;
/// Ratio to the best error below which an iterate is better.
const BETTER: f64 = 0.999;
/// Least regularisation α [-].
const LEAST_ALPHA: f64 = 1e-13;

/// Regularisation of the steps, and patience.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caution {
    /// α for an error of 1.
    pub slope: f64,
    /// Largest regularisation α [-].
    pub most: f64,
    /// Steps in a row without a better iterate after which the method stops.
    pub patience: usize,
}

/// Large steps, soon stopped: sufficient where the initial guess is good.
pub(super) const BOLD: Caution = Caution { slope: 1e-3, most: 1e-4, patience: 8 };
/// Shorter steps in the null space of W, and more of them.
pub(super) const CAREFUL: Caution = Caution { slope: 1.0, most: 0.1, patience: 60 };
/// Steps of a tenth of the reactions in the null space of W, soon stopped: between sweeps, from near one of many solutions.
pub(super) const NEAR: Caution = Caution { slope: 10.0, most: 0.1, patience: 6 };

/// Newton steps until the error is within the tolerance, or they make no progress; ends with the best iterate. Where there is none
/// within the tolerance, examines whether a contact cannot be stopped.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits, caution: Caution) -> Ending {
    let mut error = scaled.error();
    let mut best = (error, scaled.r.clone());
    let (mut steps, mut idle) = (0, 0);
    let mut system = BlockSystem::default();
    while error > limits.tolerance
        && steps < limits.iterations
        && idle <= caution.patience
        && !limits.interrupted()
    {
        let alpha = (caution.slope * error).clamp(LEAST_ALPHA, caution.most);
        let Some(direction) = direction(scaled, alpha, &mut system) else { break };
        error = search(scaled, &direction, error);
        steps += 1;
        idle += 1;
        if error < BETTER * best.0 {
            best = (error, scaled.r.clone());
            idle = 0;
        }
    }
    if best.0 > limits.tolerance && steps > 0 && scaled.proximal() == 0.0 && !limits.interrupted() {
        scaled.is_jammed |= is_jammed(scaled, &mut system);
    }
    if !(error <= best.0) {
        scaled.set_reactions(&best.1);
    }
    Ending { iterations: steps, error: best.0 }
}

/// Whether reactions become as large as the least regularisation allows, and nothing is stopped.
fn is_jammed(scaled: &mut Scaled, system: &mut BlockSystem) -> bool {
    let Some(direction) = direction(scaled, LEAST_ALPHA, system) else { return false };
    let start = scaled.r.clone();
    scaled.move_from(&start, &direction, 1.0);
    let is_jammed = scaled.at().is_jammed();
    scaled.set_reactions(&start);
    is_jammed
}

/// Moves along `direction`: by the whole step if that reduces the error enough, otherwise by the whole or half step,
/// whichever has the lower error.
///
/// Not by less: where a contact is about to open or to slip the error rises before it falls, and steps short enough
/// to avoid that stay at the kink.
fn search(scaled: &mut Scaled, direction: &[f64], error: f64) -> f64 {
    let start = scaled.r.clone();
    let mut at = |length| {
        scaled.move_from(&start, direction, length);
        scaled.error()
    };
    let whole = at(1.0);
    if whole <= ENOUGH * error {
        return whole;
    }
    let half = at(0.5);
    if whole < half { at(1.0) } else { half }
}

/// The Newton step of all reactions; `None` if the system is singular.
fn direction(scaled: &Scaled, alpha: f64, system: &mut BlockSystem) -> Option<Vec<f64>> {
    let at: Vec<Linearised> = (0..scaled.contacts)
        .map(|c| linearise_alart_curnier(local(&scaled.r, c), local(&scaled.u, c), scaled.mu[c]))
        .collect();
    // The known steps of open contacts, and their effect on the others.
    let mut direction = vec![0.0; 3 * scaled.contacts];
    let mut moved = vec![0.0; 3 * scaled.contacts];
    let mut place = vec![usize::MAX; scaled.contacts];
    let mut pressed = Vec::new();
    for (c, at) in at.iter().enumerate() {
        if at.by_u != [[0.0; 3]; 3] {
            place[c] = pressed.len();
            pressed.push(c);
        } else if !is_zero(at.f) {
            let step = at.f.map(|f| -f);
            direction[3 * c..3 * c + 3].copy_from_slice(&step);
            scaled.add_column(c, step, &mut moved);
        }
    }
    // The linear system of the pressing contacts, column by column.
    system.begin(pressed.len());
    let mut step = Vec::with_capacity(3 * pressed.len());
    let own = alpha + scaled.proximal();
    for (k, &d) in pressed.iter().enumerate() {
        step.extend(right_side(&at[d], local(&moved, d)));
        scaled.for_column(d, &place, |l, block| {
            let at = &at[pressed[l]];
            let block = if l == k { diagonal(at, block, own) } else { product(&at.by_u, block) };
            system.add(l, k, &block);
        });
    }
    if !system.factorise()?.solve(&mut step) {
        return None;
    }
    for (step, &c) in step.chunks_exact(3).zip(&pressed) {
        direction[3 * c..3 * c + 3].copy_from_slice(step);
    }
    Some(direction)
}

fn right_side(at: &Linearised, moved: Local) -> Local {
    [0, 1, 2].map(|i| {
        let b = at.by_u[i];
        -at.f[i] - (b[0] * moved[0] + b[1] * moved[1] + b[2] * moved[2])
    })
}

/// Diagonal block `∂F/∂r + ∂F/∂u (W_cc + α I)`.
fn diagonal(at: &Linearised, W: &Block, alpha: f64) -> Block {
    let mut own = *W;
    for (i, row) in own.iter_mut().enumerate() {
        row[i] += alpha;
    }
    let mut sum = product(&at.by_u, &own);
    for (s, b) in sum.iter_mut().flatten().zip(at.by_r.iter().flatten()) {
        *s += b;
    }
    sum
}

fn product(a: &Block, b: &Block) -> Block {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}
