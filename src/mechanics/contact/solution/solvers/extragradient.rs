//! The extragradient method (Korpelevich 1976) with the step length of Khobotov (1987): the De Saxcé step is taken
//! from the current reactions, with the velocities of a predictor step.

use super::fixed_point::{Iterate, iterate};
use super::options::{Ending, Limits};
use super::scaled::Scaled;

/// Largest difference of the velocities of the prediction, as a fraction of what ρ allows.
const AGREEMENT: f64 = 0.9;
/// Fraction below which the next ρ may be longer.
const EASY: f64 = 0.3;
/// Factor on ρ that shortens a step.
const SHORTER: f64 = 2.0 / 3.0;
const LONGER: f64 = 1.5;
/// Largest number of shortenings of one step.
const MAX_SHORTENINGS: usize = 30;

/// Iterations until the error is within the tolerance; requires finite μ, else does nothing.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    iterate(scaled, limits, Iterate::safe_step, |scaled, rho| {
        let (r, u) = (scaled.r.clone(), scaled.u.clone());
        let mut ratio = 0.0;
        for _ in 0..MAX_SHORTENINGS {
            scaled.u.copy_from_slice(&u);
            let predicted = scaled.projected_step(&r, *rho);
            scaled.set_reactions(&predicted);
            ratio = *rho * lifted_distance(scaled, &u) / distance(&scaled.r, &r).max(f64::MIN_POSITIVE);
            if ratio <= AGREEMENT {
                break;
            }
            *rho *= SHORTER * (1.0 / ratio).min(1.0);
        }
        let corrected = scaled.projected_step(&r, *rho);
        scaled.set_reactions(&corrected);
        if ratio < EASY {
            *rho *= LONGER;
        }
    })
}

/// Distance of the current `u + μ ‖u_t‖ n` from that of other velocities.
fn lifted_distance(scaled: &Scaled, other: &[f64]) -> f64 {
    let lift = |u: &[f64], mu: f64| u[0] + mu * u[1].hypot(u[2]);
    let pairs = scaled.u.chunks_exact(3).zip(other.chunks_exact(3)).zip(&scaled.mu);
    let squares = pairs.map(|((a, b), &mu)| {
        (lift(a, mu) - lift(b, mu)).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)
    });
    squares.sum::<f64>().sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
