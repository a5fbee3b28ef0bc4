//! The law of one contact: projection on the Coulomb cone, natural map, and the exact solution of a single contact.
//!
//! All quantities are in the local frame (n, t1, t2), in either of two dual pairs: an impulse `r` [N s] and a
//! relative velocity `u` [m/s] with `u = W r + q`, or a force and a gap; the law is the same.
//!
//! Signorini with Coulomb, in the bi-potential form of De Saxcé & Feng (1998): with `ũ = u + μ ‖u_t‖ n`,
//! `K_μ ∋ r ⊥ ũ ∈ K_μ*`, which is `r = Proj_Kμ(r − ρ ũ)` for any ρ > 0.

/// A vector in the local frame: normal, first tangent, second tangent.
pub type Local = [f64; 3];
/// A symmetric 3×3 operator in the local frame, row by row.
pub type LocalOperator = [[f64; 3]; 3];

/// Orthogonal projection of `r` on `K_μ = { ‖r_t‖ ≤ μ r_n }`, 0 ≤ μ < ∞.
///
/// Stick: `r` itself in the cone. Open: 0 in the polar cone `μ ‖r_t‖ ≤ −r_n`. Slip otherwise: `r − (‖r_t‖ − μ r_n)/(1
/// + μ²) (r_t/‖r_t‖ − μ n)`.
#[inline]
pub fn proj_coulomb_cone(r: Local, mu: f64) -> Local {
    let [n, t1, t2] = r;
    let t = length(t1, t2);
    if n >= 0.0 && t <= mu * n {
        return r;
    }
    if mu * t <= -n {
        return [0.0; 3];
    }
    let excess = (t - mu * n) / (1.0 + mu * mu);
    let shrink = 1.0 - excess / t;
    [n + mu * excess, t1 * shrink, t2 * shrink]
}

/// Length of a tangential vector. Not `hypot`: the numbers of a contact problem have finite squares, and a square
/// root is fast and has the same bits everywhere.
#[inline]
pub(super) fn length(t1: f64, t2: f64) -> f64 {
    (t1 * t1 + t2 * t2).sqrt()
}

/// Residual of the law, `F = r − Proj_Kμ(r − ρ (u + μ ‖u_t‖ n))`, zero exactly at a solution. Where the projection changes nothing it is the
/// velocity, with all digits however large the reaction.
///
/// `mu = ∞` stands for full stick: then `F_n = r_n − ⟨r_n − ρ u_n⟩`, and `F_t` is `ρ u_t` where the contact presses
/// and `r_t` where it does not.
#[inline]
#[allow(clippy::float_cmp)] // exactly what the projection does not change
pub fn natural_map(r: Local, u: Local, mu: f64, rho: f64) -> Local {
    if mu.is_infinite() {
        return if r[0] > rho * u[0] { u.map(|u| rho * u) } else { r };
    }
    let step = [rho * (u[0] + mu * length(u[1], u[2])), rho * u[1], rho * u[2]];
    let from = [r[0] - step[0], r[1] - step[1], r[2] - step[2]];
    let p = proj_coulomb_cone(from, mu);
    if p == from { step } else { [r[0] - p[0], r[1] - p[1], r[2] - p[2]] }
}

/// Coefficient of friction from which the natural map hides the velocity of approach: it divides it by `√(1 + μ²)` [-].
const HIDES_APPROACH: f64 = 10.0;

/// Square of the residual of the law: that of the natural map, or, with strong friction, of the velocity of approach `ρ ⟨−u_n⟩` where
/// this is larger.
#[inline]
pub fn squared_residual(r: Local, u: Local, mu: f64, rho: f64) -> f64 {
    let [n, t1, t2] = natural_map(r, u, mu, rho);
    let squared = n * n + t1 * t1 + t2 * t2;
    if mu <= HIDES_APPROACH {
        return squared;
    }
    let approach = (rho * u[0]).min(0.0);
    squared.max(approach * approach)
}

/// Natural map of a frictionless contact: `r_n − ⟨r_n − ρ u_n⟩`.
#[inline]
pub fn natural_map_frictionless(r_n: f64, u_n: f64, rho: f64) -> f64 {
    r_n - (r_n - rho * u_n).max(0.0)
}

/// Solution of one frictionless contact: `r_n = ⟨−q_n⟩ / W_nn`; one unknown.
#[inline]
pub fn solve_frictionless(w_nn: f64, q_n: f64) -> f64 {
    if q_n < 0.0 { -q_n / w_nn } else { 0.0 }
}

/// Closed-form solution of one contact with `W = w I`, `w > 0`, the usual case (lumped mass, no fixed axis).
#[inline]
pub fn solve_isotropic(w: f64, q: Local, mu: f64) -> Local {
    if q[0] >= 0.0 {
        return [0.0; 3];
    }
    let r = [-q[0] / w, -q[1] / w, -q[2] / w];
    let limit = mu * r[0];
    let t2 = r[1] * r[1] + r[2] * r[2];
    // For μ = ∞ the limit is ∞, and everything sticks.
    if t2 <= limit * limit {
        return r;
    }
    let scale = limit / t2.sqrt();
    [r[0], r[1] * scale, r[2] * scale]
}

#[cfg(test)]
mod tests;
