//! The middle of a step, without the contraction by rotation.
//!
//! A body that turns by an angle ϑ about n in a step is narrower in the middle of the chord, `x_m = ½ (x + x⁺)`, by the factor cos ½ϑ across
//! n: at a bulk modulus of 300 μ and a fifth of a radian that is a pressure of 3 μ. Forces are therefore evaluated where D widens it again,
//! about the centre of mass,
//!
//! ```text
//! x̃ = D x_m          D = s 1 − c cᵀ/(1 + s)          s = √(1 + c²) = 1/cos ½ϑ          c = n tan ½ϑ
//! f̄ = D⁻¹ f(x̃)      D⁻¹ = (1 + c cᵀ/(1 + s))/s
//! ```
//!
//! which is the body itself, turned by ½ϑ, where it does not deform. With c of the nearest rotation, the least squares of `Δx − 2 c × x_m` by
//! mass, D differs from 1 by what is of second order in the step. Neither force resultant nor moment about x_m comes of it: the Kirchhoff stress
//! `P̃ F̃ᵀ` is symmetric, and with it `D⁻¹ P̃ F_mᵀ = D⁻¹ P̃ F̃ᵀ D⁻¹`.

use crate::mechanics::sparse::Unknowns;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::plan::Plan;
use crate::step::state::State;

/// Replaces the mean displacements of a step by those of the widened middle, `u` [m], and gives D⁻¹ of each body, from the displacements at
/// both ends [m], nodes × 3.
pub(super) fn widen(plan: &Plan, [before, after]: [&[Vec3]; 2], u: &mut Vec<Vec3>) -> Vec<Mat3> {
    u.clear();
    u.extend(before.iter().zip(after).map(|(before, after)| (before + after) * 0.5));
    let of_body = |body: usize| {
        let Turn { centre, rate, .. } = Turn::of(plan, body, u, &|node| after[node] - before[node]);
        let c = rate * 0.5;
        let s = (1.0 + c.norm_squared()).sqrt();
        let across = c * c.transpose() / (1.0 + s);
        let D = Mat3::identity() * s - across;
        for node in nodes_of(plan, body) {
            let r = plan.X[node] + u[node] - centre;
            u[node] += D * r - r;
        }
        (Mat3::identity() + across) / s
    };
    (0..plan.bodies.len()).map(of_body).collect()
}

/// The velocities at the end of a step of size h [s] with which every body turns on as it does, `v` [m/s]: with the Cayley transform of ½ h ω
/// a rigid body moves as such, `u⁺ = u + ½ h (v + v⁺)`.
pub(super) fn turn_on(plan: &Plan, unknowns: &Unknowns, state: &State, h: f64, v: &mut [Vec3]) {
    let mut turned = v.to_vec();
    for body in 0..plan.bodies.len() {
        let Turn { mean, rate, .. } = Turn::of(plan, body, &state.u, &|node| state.v[node]);
        let c = rate * (0.5 * h);
        for node in nodes_of(plan, body) {
            let w = state.v[node] - mean;
            // (1 − ĉ)⁻¹ (1 + ĉ) w
            let across = c.cross(&(w + c.cross(&w)));
            turned[node] += across * (2.0 / (1.0 + c.norm_squared()));
        }
    }
    unknowns.for_each(|_, node, axis| v[node][axis] = turned[node][axis]);
}

fn nodes_of(plan: &Plan, body: usize) -> std::ops::Range<usize> {
    plan.bodies[body].nodes.start as usize..plan.bodies[body].nodes.end as usize
}

/// The rigid part of a field of a body, by mass.
struct Turn {
    /// Centre of mass [m].
    centre: Vec3,
    /// Mean of the field.
    mean: Vec3,
    /// ω of `mean + ω × (x − centre)` [1/m of the field].
    rate: Vec3,
}

impl Turn {
    /// Of a field at displacements `u` [m].
    fn of(plan: &Plan, body: usize, u: &[Vec3], field: &dyn Fn(usize) -> Vec3) -> Self {
        let mean = |at: &dyn Fn(usize) -> Vec3| {
            let sum = nodes_of(plan, body).fold(Vec3::zeros(), |sum, node| sum + at(node) * plan.mass[node]);
            sum / plan.bodies[body].mass
        };
        let (centre, mean) = (mean(&|node| plan.X[node] + u[node]), mean(field));
        // Moments of inertia and of the field about the centre.
        let (mut inertia, mut moment) = (Mat3::zeros(), Vec3::zeros());
        for node in nodes_of(plan, body) {
            let (r, m) = (plan.X[node] + u[node] - centre, plan.mass[node]);
            inertia += (Mat3::identity() * r.norm_squared() - r * r.transpose()) * m;
            moment += r.cross(&(field(node) - mean)) * m;
        }
        // The node of a rigid body is its centre, without inertia about itself; its orientation is not a displacement.
        let inverse = if plan.bodies[body].rigid.is_some() { None } else { inertia.try_inverse() };
        let rate = inverse.map_or_else(Vec3::zeros, |inverse| inverse * moment);
        Self { centre, mean, rate }
    }
}
