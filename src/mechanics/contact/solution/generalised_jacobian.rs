//! An element of the generalised Jacobian of the residual of the contact law used by Newton's method.
//!
//! The residual is zero exactly at a solution, in a scaling for which ρ = 1 is appropriate (see [`super::solvers`]).

use super::delassus::Block;
use super::local::{Local, length};

/// A residual `F(r, u)` of one contact and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearised {
    /// Residual F(r, u) of the contact.
    pub f: Local,
    /// Derivative ∂F/∂r of the residual.
    pub by_r: Block,
    /// Derivative ∂F/∂u; exactly zero where the contact is open, and then `F = r`.
    pub by_u: Block,
}

const IDENTITY: Block = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const OPEN: Block = [[0.0; 3]; 3];

/// The augmented Lagrangian's residual: `F_n = r_n − ⟨r_n − u_n⟩`, `F_t = r_t − Proj(r_t − u_t)` on the disc of radius
/// `μ ⟨r_n − u_n⟩` (Alart & Curnier 1991). μ = ∞ stands for full stick.
#[inline]
pub fn linearise_alart_curnier(r: Local, u: Local, mu: f64) -> Linearised {
    let pressed = r[0] - u[0];
    if pressed <= 0.0 {
        return Linearised { f: r, by_r: IDENTITY, by_u: OPEN };
    }
    let (z, limit) = ([r[1] - u[1], r[2] - u[2]], mu * pressed);
    let size = length(z[0], z[1]);
    if size <= limit {
        return Linearised { f: u, by_r: OPEN, by_u: IDENTITY };
    }
    let e = [z[0] / size, z[1] / size];
    let factor = limit / size;
    let mut by_r = OPEN;
    let mut by_u = OPEN;
    by_u[0][0] = 1.0;
    for i in 0..2 {
        for j in 0..2 {
            let same = if i == j { 1.0 } else { 0.0 };
            let across = factor * (same - e[i] * e[j]);
            by_r[i + 1][j + 1] = same - across;
            by_u[i + 1][j + 1] = across;
        }
        by_r[i + 1][0] = -mu * e[i];
        by_u[i + 1][0] = mu * e[i];
    }
    Linearised { f: [u[0], r[1] - limit * e[0], r[2] - limit * e[1]], by_r, by_u }
}
