//! The default: one solver after the other, each from the best iterate so far, fast ones first.
//!
//! A few sweeps of Gauss–Seidel find which contacts press, from where Newton's method solves most problems. Those
//! that remain are degenerate: more careful steps, interior points, then proximal points. The budgets are numbers of
//! iterations, so that the sequence does not depend on the machine.

use super::method::Method;
use super::options::{Ending, Limits};
use super::scaled::Scaled;
use super::{interior_point, newton, nsgs, proximal};

/// The solvers in their order, with the largest number of iterations of each.
const STAGES: [(Stage, usize); 6] = [
    (Stage::Sweeps, 20),
    (Stage::Bold, 40),
    (Stage::Careful, 80),
    (Stage::InteriorPoint, 100),
    (Stage::Proximal, 600),
    (Stage::Sweeps, 100_000),
];

#[derive(Clone, Copy, Debug)]
enum Stage {
    Sweeps,
    Bold,
    Careful,
    InteriorPoint,
    Proximal,
}

/// Solves; returns which solver found the best iterate.
pub(super) fn solve(scaled: &mut Scaled, given: &Limits) -> (Method, Ending) {
    let mut total = 0;
    let mut best = (scaled.error(), Method::Nsgs, scaled.r.clone());
    for (stage, most) in STAGES {
        let limits = Limits {
            tolerance: given.tolerance,
            iterations: most.min(given.iterations - total),
            interrupt: given.interrupt,
        };
        let (method, ending) = match stage {
            Stage::Sweeps => (Method::Nsgs, nsgs::solve(scaled, &limits)),
            Stage::Bold => (Method::Newton, newton::solve(scaled, &limits, newton::BOLD)),
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
        if limits.interrupted() {
            break;
        }
    }
    scaled.set_reactions(&best.2);
    (best.1, Ending { iterations: total, error: best.0 })
}
