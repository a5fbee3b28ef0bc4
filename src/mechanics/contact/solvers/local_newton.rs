//! One contact exactly: Newton on the 3×3 bi-potential equation, with the enumerative solution behind it.
//!
//! Newton's method from where the contact was takes two or three steps. Where it does not end, the cases are gone through
//! one by one ([`solve_contact`]: open, stick, and slip by the roots of a quartic, found by Newton with bisection;
//! Bonnefon & Daviet 2011), and Newton polishes what an unsymmetric block leaves.

use crate::mechanics::contact::delassus::{Block, times};
use crate::mechanics::contact::generalised_jacobian::linearise_alart_curnier;
use crate::mechanics::contact::local::{Local, natural_map, solve_contact};
use crate::mechanics::contact::problem::squared;

/// Newton steps before the cases are gone through.
const MAX_STEPS: usize = 8;
/// A residual of this share of the reaction and the free velocity is rounding.
const EXACT: f64 = 1e-14;
/// A residual beyond this share is a failure.
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
    let error = squared(natural_map(case, u, mu, 1.0)).sqrt();
    LocalSolution { r: case, solved: error <= SOLVED * squared(q).max(squared(case)).sqrt() }
}

/// Newton from `r`; `None` if it does not end, or ends outside the law.
#[inline]
fn newton(W: &Block, q: Local, mu: f64, mut r: Local) -> Option<Local> {
    if r[0] <= 0.0 {
        // An open contact that closes: as if it pressed, so that the first step is to stick.
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

/// `A x = b` by cofactors; `None` if A is singular to rounding.
#[inline]
pub(super) fn solve_3x3(A: &Block, b: Local) -> Option<Local> {
    let cross = |a: Local, b: Local| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let (c0, c1, c2) = (cross(A[1], A[2]), cross(A[2], A[0]), cross(A[0], A[1]));
    let determinant = A[0][0] * c0[0] + A[0][1] * c0[1] + A[0][2] * c0[2];
    let x = [0, 1, 2].map(|i| (c0[i] * b[0] + c1[i] * b[1] + c2[i] * b[2]) / determinant);
    x.iter().all(|x| x.is_finite()).then_some(x)
}
