//! Global semismooth Newton on all contacts at once (Alart & Curnier 1991; Joli & Feng 2008), damped and regularised.
//!
//! Open contacts have `F = r`: their step is known, and only the others enter the linear system. The Jacobian of a rank
//! deficient W is singular: W is taken as `W + α I` in it, with α falling as the error does (Levenberg–Marquardt's way),
//! which takes the least change of the reactions that are not determined.

use super::scaled::Scaled;
use super::{Ending, Limits};
use crate::mechanics::contact::generalised_jacobian::{Linearised, linearise_alart_curnier};
use crate::mechanics::contact::problem::local;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Steps unless the caller says otherwise.
pub(super) const MAX_STEPS: usize = 100;
/// Halvings of a step.
const MAX_HALVINGS: usize = 8;

/// Newton steps until the error is within the tolerance, or no step lowers it.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    let mut best = (scaled.error(), scaled.r.clone());
    let mut error = best.0;
    let mut worse = 0;
    for step in 0..limits.iterations {
        if error <= limits.tolerance || limits.interrupted() || worse > 8 {
            scaled.r.copy_from_slice(&best.1);
            scaled.update_velocity();
            return Ending { iterations: step, error: best.0 };
        }
        let alpha = (1e-3 * error).clamp(1e-13, 1e-4);
        let Some(direction) = direction(scaled, alpha) else { break };
        let start = scaled.r.clone();
        let mut share = 1.0;
        let mut chosen = (f64::INFINITY, 1.0);
        for _ in 0..=MAX_HALVINGS {
            move_to(scaled, &start, &direction, share);
            let e = scaled.error();
            if e < chosen.0 { chosen = (e, share); }
            if e <= (1.0 - 0.1 * share) * error { break; }
            share *= 0.5;
        }
        if chosen.1 != share { move_to(scaled, &start, &direction, chosen.1); }
        error = scaled.error();
        if std::env::var("DBG").is_ok() { println!("newton {step} err {error:.3e} share {} alpha {alpha:.1e}", chosen.1); }
        if error < 0.999*best.0 { best = (error, scaled.r.clone()); worse = 0; } else { worse += 1; }
    }
    scaled.r.copy_from_slice(&best.1);
    scaled.update_velocity();
    Ending { iterations: limits.iterations, error: best.0 }
}

fn move_to(scaled: &mut Scaled, start: &[f64], direction: &[f64], share: f64) {
    for ((r, s), d) in scaled.r.iter_mut().zip(start).zip(direction) {
        *r = s + share * d;
    }
    scaled.update_velocity();
}

/// The Newton step of all reactions.
fn direction(scaled: &Scaled, alpha: f64) -> Option<Vec<f64>> {
    let at: Vec<Linearised> = (0..scaled.contacts)
        .map(|c| linearise_alart_curnier(local(&scaled.r, c), local(&scaled.u, c), scaled.mu[c]))
        .collect();
    let open = |a: &Linearised| a.by_u == [[0.0; 3]; 3];
    let mut place = vec![usize::MAX; scaled.contacts];
    let mut pressed = Vec::new();
    let mut direction = vec![0.0; 3 * scaled.contacts];
    let mut moved = vec![0.0; 3 * scaled.contacts];
    for (c, a) in at.iter().enumerate() {
        if open(a) {
            for i in 0..3 { direction[3*c+i] = -a.f[i]; }
            if a.f != [0.0; 3] { scaled.add_column(c, a.f.map(|x| -x), &mut moved); }
        } else {
            place[c] = pressed.len();
            pressed.push(c);
        }
    }
    let n = 3 * pressed.len();
    let mut rhs = Mat::<f64>::zeros(n, 1);
    for (k, &c) in pressed.iter().enumerate() {
        let m = local(&moved, c);
        for i in 0..3 {
            let b = at[c].by_u[i];
            rhs[(3*k+i, 0)] = -at[c].f[i] - (b[0]*m[0]+b[1]*m[1]+b[2]*m[2]);
        }
    }
    let mut J = Mat::<f64>::zeros(n, n);
    for (k, &d) in pressed.iter().enumerate() {
        scaled.for_column(d, &place, |l, block| {
            let a = &at[pressed[l]];
            let mut block = *block;
            if l == k { for i in 0..3 { block[i][i] += alpha; } }
            for i in 0..3 {
                for j in 0..3 {
                    let mut x = a.by_u[i][0]*block[0][j] + a.by_u[i][1]*block[1][j] + a.by_u[i][2]*block[2][j];
                    if l == k { x += a.by_r[i][j]; }
                    J[(3*l+i, 3*k+j)] = x;
                }
            }
        });
    }
    J.partial_piv_lu().solve_in_place(&mut rhs);
    for (k, &c) in pressed.iter().enumerate() {
        for i in 0..3 { direction[3*c+i] = rhs[(3*k+i, 0)]; }
    }
    direction.iter().all(|x| x.is_finite()).then_some(direction)
}
