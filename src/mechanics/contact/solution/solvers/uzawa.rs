//! Uzawa's method in the bi-potential framework, contact by contact (De Saxcé & Feng 1998; Joli & Feng 2008): one
//! prediction and projection `r ← Proj_K(r − ρ (u + μ ‖u_t‖ n))` each, where Gauss–Seidel solves the contact exactly.
//!
//! Each contact has its own ρ, the inverse of the largest eigenvalue of its diagonal block of W.

use super::fixed_point::iterate;
use super::options::{Ending, Limits};
use super::scaled::Scaled;
use crate::contact::solution::delassus::Block;
use crate::contact::solution::local::proj_coulomb_cone;
use crate::contact::solution::problem::local;
use crate::tensor::Mat3;

/// Sweeps after which velocities are recomputed, to remove accumulated rounding.
const SUMMED_AFTER: usize = 64;

/// Sweeps until the error is within the tolerance; requires finite μ, else does nothing.
pub(super) fn solve(scaled: &mut Scaled, limits: &Limits) -> Ending {
    let start = |scaled: &mut Scaled| (scaled.diagonal.iter().map(step_of).collect::<Vec<f64>>(), 0);
    iterate(scaled, limits, start, |scaled, (rho, sweeps)| {
        for (c, &rho) in rho.iter().enumerate() {
            let (r, u, mu) = (local(&scaled.r, c), local(&scaled.u, c), scaled.mu[c]);
            let lifted = [u[0] + mu * u[1].hypot(u[2]), u[1], u[2]];
            scaled.change(c, proj_coulomb_cone([0, 1, 2].map(|i| r[i] - rho * lifted[i]), mu));
        }
        *sweeps += 1;
        if *sweeps % SUMMED_AFTER == 0 {
            scaled.update_velocity();
        }
    })
}

/// Step length ρ of a contact; 1 where nothing moves it.
fn step_of(W: &Block) -> f64 {
    let symmetric = Mat3::from_fn(|i, j| 0.5 * (W[i][j] + W[j][i]));
    let largest = symmetric.symmetric_eigenvalues().max();
    if largest > 0.0 { 1.0 / largest } else { 1.0 }
}
