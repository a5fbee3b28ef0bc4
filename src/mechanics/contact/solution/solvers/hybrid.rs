//! The default: one solver after the other, each from the best iterate so far, fast ones first.
//!
//! A few sweeps of Gauss–Seidel find which contacts press, from where Newton's method solves most problems. Those
//! that remain are degenerate: more careful steps, sweeps and steps in turn, interior points, then proximal points. The budgets are numbers of
//! iterations, so that the sequence does not depend on the machine; only under a time limit, stages share what is left of it.

use super::method::Method;
use super::options::{Ending, Limits};
use super::scaled::Scaled;
use super::{interior_point, newton, nsgs, proximal};

/// The solvers in their order, with the largest number of iterations of each; the rounds come before the careful steps where a Newton step
/// is dear.
const STAGES: [(Stage, usize); 7] = [
    (Stage::Sweeps, 20),
    (Stage::Bold, 40),
    (Stage::Careful, 80),
    (Stage::Alternate, usize::MAX),
    (Stage::InteriorPoint, 100),
    (Stage::Proximal, 600),
    (Stage::Sweeps, 100_000),
];

/// Share of the time that is left to a stage, but to the last, under a time limit.
const SHARE: f64 = 0.5;
/// Cost of a Newton step in sweeps from which rounds of both come before many Newton steps alone.
const DEAR: f64 = 30.0;
/// Sweeps of a round, in units of the cost of a Newton step, and their least number.
const ROUND: (f64, usize) = (5.0, 60);
/// Sweeps in the same unit up to which rounds go on in any case: what the stages that follow would cost.
const LEAST: f64 = 400.0;
/// Factor on the error of a round that is worth another.
const WORTH: f64 = 0.7;
/// Most contacts of which interior points cost little.
const FEW: usize = 100;
/// Most Newton steps of a round.
const STEPS: usize = 80;

#[derive(Clone, Copy, Debug)]
enum Stage {
    Sweeps,
    Bold,
    Alternate,
    Careful,
    InteriorPoint,
    Proximal,
}

/// Solves; returns which solver found the best iterate.
pub(super) fn solve(scaled: &mut Scaled, given: &Limits) -> (Method, Ending) {
    let mut total = 0;
    let mut best = (scaled.error(), Method::Nsgs, scaled.r.clone());
    let mut stages = STAGES;
    if scaled.newton_cost_in_sweeps() > DEAR {
        stages.swap(2, 3);
    }
    let has_friction = scaled.mu.iter().any(|mu| *mu > 0.0);
    for (place, (stage, most)) in stages.into_iter().enumerate() {
        // Reactions without bound are no proof where there is friction: interior points, which follow no active set, have the last word
        // where they cost little.
        let is_last_word = matches!(stage, Stage::InteriorPoint) && has_friction && scaled.mu.len() <= FEW;
        if scaled.is_jammed && !is_last_word {
            continue;
        }
        let share = if place + 1 < stages.len() { SHARE } else { 1.0 };
        let limits = Limits { iterations: given.iterations.saturating_sub(total), ..*given }
            .at_most(most)
            .share(share);
        let (method, ending) = match stage {
            Stage::Sweeps => (Method::Nsgs, nsgs::solve(scaled, &limits)),
            Stage::Bold => (Method::Newton, newton::solve(scaled, &limits, newton::BOLD)),
            Stage::Alternate => alternate(scaled, &limits),
            Stage::Careful => (Method::Newton, newton::solve(scaled, &limits, newton::CAREFUL)),
            Stage::InteriorPoint => (Method::InteriorPoint, interior_point::solve(scaled, &limits)),
            Stage::Proximal => (Method::Proximal, proximal::solve(scaled, &limits)),
        };
        total += ending.iterations;
        if ending.error <= given.tolerance {
            return (method, Ending { iterations: total, ..ending });
        }
        if ending.error < best.0 {
            best = (ending.error, method, scaled.r.clone());
        }
        if given.interrupted() {
            break;
        }
    }
    scaled.set_reactions(&best.2);
    (best.1, Ending { iterations: total, error: best.0 })
}

/// Rounds of sweeps and Newton steps, as long as each reduces the error: sweeps find which contacts press and slip where Newton steps
/// lead astray, and cost far less where W is sparse.
fn alternate(scaled: &mut Scaled, given: &Limits) -> (Method, Ending) {
    let limits = |most: usize, done: usize| {
        Limits { iterations: given.iterations.saturating_sub(done), ..*given }.at_most(most)
    };
    let sweeps = scaled.newton_cost_in_sweeps();
    let round = ((ROUND.0 * sweeps) as usize).max(ROUND.1);
    let (mut iterations, mut error) = (0, scaled.error());
    loop {
        let before = error;
        for method in [Method::Nsgs, Method::Newton] {
            let ending = match method {
                Method::Nsgs => nsgs::solve(scaled, &limits(round, iterations)),
                _ => newton::solve(scaled, &limits(STEPS, iterations), newton::NEAR),
            };
            iterations += ending.iterations;
            error = ending.error;
            if error <= given.tolerance {
                return (method, Ending { iterations, error });
            }
        }
        let is_over = error > WORTH * before && iterations as f64 > LEAST * sweeps;
        if is_over || scaled.is_jammed || iterations >= given.iterations || given.interrupted() {
            return (Method::Nsgs, Ending { iterations, error });
        }
    }
}
