//! Exact solution of one contact: Newton's method on the 3×3 bi-potential equation, with the enumerative solution as
//! a fallback.
//!
//! From the last reaction Newton's method takes two or three steps. Where it does not converge, the cases are
//! enumerated ([`solve_contact`]: open, stick, and slip by the roots of a quartic, found by Newton with bisection;
//! Bonnefon & Daviet 2011), and Newton's method corrects for an unsymmetric block.

use crate::contact::solution::delassus::{Block, times};
use crate::contact::solution::generalised_jacobian::linearise_alart_curnier;
use crate::contact::solution::local::{Local, squared_residual};
use crate::contact::solution::problem::squared;
use crate::contact::solution::slip::solve_contact;

/// Newton steps before the cases are enumerated.
const MAX_STEPS: usize = 8;
/// Residual, as a fraction of the reaction and the free velocity, that is rounding.
const EXACT: f64 = 1e-14;
/// The same, beyond which the solution has failed.
const SOLVED: f64 = 1e-10;

/// The reaction of one contact, and whether it obeys the law.
pub(super) struct LocalSolution {
    pub r: Local,
    pub solved: bool,
}

/// Solves `u = W r + q` with the law, starting at `r`; `W` of order one.
#[inline]
pub(super) fn solve(W: &Block, q: Local, mu: f64, r: Local) -> LocalSolution {
    if q[0] >= 0.0 {
        return LocalSolution { r: [0.0; 3], solved: true };
    }
    if let Some(r) = newton(W, q, mu, r) {
        return LocalSolution { r, solved: true };
    }
    let case = solve_contact(&symmetric(W), q, mu);
    if let Some(r) = newton(W, q, mu, case) {
        return LocalSolution { r, solved: true };
    }
    let u = velocity(W, case, q);
    let error = squared_residual(case, u, mu, 1.0).sqrt();
    LocalSolution { r: case, solved: error <= SOLVED * squared(q).max(squared(case)).sqrt() }
}

/// Newton's method from `r`; `None` if it does not converge, or converges to a point that violates the law.
#[inline]
fn newton(W: &Block, q: Local, mu: f64, mut r: Local) -> Option<Local> {
    if r[0] <= 0.0 {
        // An open contact that closes: start as if it pressed, so that the first step is to stick.
        r = [-q[0] / W[0][0], 0.0, 0.0];
    }
    let size = squared(q);
    for _ in 0..MAX_STEPS {
        let u = velocity(W, r, q);
        let at = linearise_alart_curnier(r, u, mu);
        if squared(at.f) <= EXACT * EXACT * size.max(squared(r)) {
            return Some(r);
        }
        let mut jacobian = at.by_r;
        for (row, by_u) in jacobian.iter_mut().zip(&at.by_u) {
            for (j, x) in row.iter_mut().enumerate() {
                *x += by_u[0] * W[0][j] + by_u[1] * W[1][j] + by_u[2] * W[2][j];
            }
        }
        let step = solve_3x3(&jacobian, at.f)?;
        r = [r[0] - step[0], r[1] - step[1], r[2] - step[2]];
    }
    None
}

#[inline]
fn velocity(W: &Block, r: Local, q: Local) -> Local {
    let w = times(W, r);
    [w[0] + q[0], w[1] + q[1], w[2] + q[2]]
}

fn symmetric(W: &Block) -> Block {
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (W[i][j] + W[j][i])))
}

/// Solves `A x = b` by cofactors; `None` if A is singular to rounding.
#[inline]
pub(super) fn solve_3x3(A: &Block, b: Local) -> Option<Local> {
    let cross = |a: Local, b: Local| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let (c0, c1, c2) = (cross(A[1], A[2]), cross(A[2], A[0]), cross(A[0], A[1]));
    let determinant = A[0][0] * c0[0] + A[0][1] * c0[1] + A[0][2] * c0[2];
    let entry = |i: usize| (c0[i] * b[0] + c1[i] * b[1] + c2[i] * b[2]) / determinant;
    let x = [entry(0), entry(1), entry(2)];
    x.iter().all(|x| x.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::solution::local::proj_coulomb_cone;
    use crate::random::Random;

    /// `A Aᵀ + I/2`, with an unsymmetric part of the given size.
    fn operator(random: &mut Random, unsymmetric: f64) -> Block {
        let a: Block = std::array::from_fn(|_| random.numbers());
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let own = if i == j { 0.5 } else { 0.0 };
                let product: f64 = (0..3).map(|k| a[i][k] * a[j][k]).sum();
                own + product + unsymmetric * random.next()
            })
        })
    }

    #[test]
    fn newton_finds_what_the_fixed_point_finds() {
        let mut random = Random(7);
        for case in 0..2000 {
            let unsymmetric = [0.0, 1e-3][case % 2];
            let W = operator(&mut random, unsymmetric);
            let q: Local = random.numbers();
            let mu = [0.1, 0.4, 0.0][case % 3];
            // Brute force: De Saxcé's fixed point, with a short step.
            let rho = 0.5 / (W[0][0] + W[1][1] + W[2][2]);
            let mut expected = [0.0; 3];
            for _ in 0..4000 {
                let u = velocity(&W, expected, q);
                let lifted = u[0] + mu * u[1].hypot(u[2]);
                let step = [lifted, u[1], u[2]];
                expected = proj_coulomb_cone([0, 1, 2].map(|i| expected[i] - rho * step[i]), mu);
            }
            let start: Local = random.numbers();
            for from in [[0.0; 3], start] {
                let LocalSolution { r, solved } = solve(&W, q, mu, from);
                let off = squared([0, 1, 2].map(|i| r[i] - expected[i])).sqrt();
                assert!(solved && off <= 1e-8, "case {case}: {r:?} against {expected:?}");
            }
        }
    }

    #[test]
    fn strong_friction_and_thin_operators_are_solved_or_reported() {
        let mut random = Random(11);
        for case in 0..5000 {
            let mut W = operator(&mut random, 0.0);
            let mu = [0.7, 3.0, 100.0, f64::INFINITY][case % 4];
            if case % 5 == 0 {
                // A row and a column along which nothing moves.
                for i in 0..3 {
                    (W[2][i], W[i][2]) = (0.0, 0.0);
                }
            }
            let q: Local = random.numbers();
            let LocalSolution { r, solved } = solve(&W, q, mu, [0.0; 3]);
            let u = velocity(&W, r, q);
            let error = squared_residual(r, u, mu, 1.0).sqrt();
            let size = squared(q).max(squared(r)).sqrt();
            assert!(solved == (error <= 1e-10 * size) || q[0] >= 0.0, "case {case}: {error:e}, {solved}");
            // For μ = ∞ a contact about to open may have no solution.
            assert!(solved || case % 5 == 0 || mu.is_infinite(), "case {case}: {error:e}, μ = {mu}");
        }
    }
}
