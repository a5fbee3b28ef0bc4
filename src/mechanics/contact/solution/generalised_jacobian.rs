//! Elements of the generalised Jacobian of the two residuals of the contact law used by Newton's method.
//!
//! Both are zero exactly at a solution, in a scaling for which ρ = 1 is appropriate (see [`super::solvers`]).

use super::delassus::Block;
use super::local::{Local, length, proj_coulomb_cone};

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

/// The natural map of the bi-potential, `F = r − Proj_Kμ(r − u − μ ‖u_t‖ n)`, μ finite (De Saxcé & Feng 1998; Joli &
/// Feng 2008).
pub fn linearise_bipotential(r: Local, u: Local, mu: f64) -> Linearised {
    let slip = length(u[1], u[2]);
    let z = [r[0] - u[0] - mu * slip, r[1] - u[1], r[2] - u[2]];
    let p = proj_coulomb_cone(z, mu);
    let by_z = projection_derivative(z, mu);
    let mut linearised =
        Linearised { f: [r[0] - p[0], r[1] - p[1], r[2] - p[2]], by_r: IDENTITY, by_u: by_z };
    for (i, row) in by_z.iter().enumerate() {
        for j in 0..3 {
            linearised.by_r[i][j] -= row[j];
        }
        // d(u + μ ‖u_t‖ n) = du + μ n (u_t/‖u_t‖ · du_t).
        if slip > 0.0 {
            linearised.by_u[i][1] += row[0] * mu * u[1] / slip;
            linearised.by_u[i][2] += row[0] * mu * u[2] / slip;
        }
    }
    linearised
}

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

/// The derivative of [`proj_coulomb_cone`] at `z`.
fn projection_derivative(z: Local, mu: f64) -> Block {
    let [n, t1, t2] = z;
    let t = length(t1, t2);
    if n >= 0.0 && t <= mu * n {
        return IDENTITY;
    }
    if mu * t <= -n {
        return OPEN;
    }
    // Along the ray (1, μ e) the projection is linear; across it, it rotates with the circle of radius μ p_n.
    let (e, unit) = ([t1 / t, t2 / t], 1.0 / (1.0 + mu * mu));
    let turn = mu * (n + mu * t) * unit / t;
    let along = [1.0, mu * e[0], mu * e[1]];
    let mut d = along.map(|a| along.map(|b| a * b * unit));
    for i in 0..2 {
        for j in 0..2 {
            let same = if i == j { 1.0 } else { 0.0 };
            d[i + 1][j + 1] += turn * (same - e[i] * e[j]);
        }
    }
    d
}
