//! Oblique impact of a soft solid ball without spin on a plane with friction.
//!
//! While all of the patch slides, friction is μ times the normal force: `Δv_t = μ (1 + e) v_n` with the ball's own e. Friction
//! acts in the plane, so about a point of it only the normal force has a moment; with its resultant below the centre,
//! `m v_t' R + I ω = m v_t R` for any μ, up to the arm that the ball's flattening δ takes from R.
//!
//! R = 15 mm, E = 100 MPa, ρ = 1000 kg/m³, v_n = 1 m/s: δ/R is about 0.017.

use crate::rig::{assert_at_most, assert_close, assert_within, mean_velocity, plan, run};
use contuse::mechanics::tensor::Vec3;
use contuse::step::Frame;
use serde_json::{Value, json};

const RADIUS: f64 = 0.015;
/// Height of the centre at the start [m].
const HEIGHT: f64 = 1.001 * RADIUS;

fn scene(n: u32, mu: f64, v_t: f64) -> Value {
    let (E, nu) = (1e8, 0.3);
    json!({
        "name": "oblique soft ball",
        "end_time_s": 1.1e-3,
        "bodies": [{
            "name": "ball",
            "mesh": {"generator": {
                "kind": "solid_ball", "center_m": [0, 0, HEIGHT], "radius_m": RADIUS, "elements_around": n,
                "elements_through": n / 2
            }},
            "velocity_m_per_s": [v_t, 0, -1],
            "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {
                "law": "neo_hookean", "c10_pa": E / (4.0 * (1.0 + nu)), "bulk_modulus_pa": E / (3.0 * (1.0 - 2.0 * nu))
            }}]
        }],
        "planes": [{"name": "plane", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": mu},
        "record": {"fields": [], "field_times_s": []}
    })
}

struct Seen {
    /// After the rebound [m/s].
    v: Vec3,
    /// m v_t' R + I ω over m v_t R [-].
    kept: f64,
    /// Angular momentum about the origin after, less before and less the moment of all reactions, over m v_t R [-].
    unexplained: f64,
    /// Largest flattening δ [m], from the lowest place of the centre.
    flattening: f64,
    still_touching: bool,
}

fn center(frame: &Frame) -> Vec3 {
    let plan = frame.plan;
    let weighted = (0..plan.node_count()).map(|a| frame.position(a as u32) * plan.mass[a]);
    weighted.sum::<Vec3>() / plan.bodies[0].mass
}

fn look(n: u32, mu: f64, v_t: f64) -> Seen {
    let plan = plan(&scene(n, mu, v_t));
    let m = plan.bodies[0].mass;
    let (mut moment, mut lowest, mut seen) = (0.0, f64::MAX, None);
    run(&plan, |frame| {
        let x = center(frame);
        lowest = lowest.min(x.z);
        for (contact, reaction) in frame.contacts.iter().zip(frame.reactions) {
            let [p_n, p_1, p_2] = reaction.impulse;
            let p = contact.frame[0] * p_n + contact.frame[1] * p_1 + contact.frame[2] * p_2;
            moment += frame.position(contact.slave).cross(&p).y;
        }
        let v = mean_velocity(frame, 0);
        let angular = Vec3::from(frame.energy.angular_momentum_kg_m2_per_s);
        let spin = (angular - x.cross(&Vec3::from(frame.energy.momentum_kg_m_per_s))).y;
        seen = Some(Seen {
            v,
            kept: (m * v.x * RADIUS + spin) / (m * v_t * RADIUS),
            unexplained: (angular.y - m * v_t * HEIGHT - moment) / (m * v_t * RADIUS),
            flattening: HEIGHT - 0.001 * RADIUS - lowest,
            still_touching: frame.reactions.iter().any(|r| r.impulse[0] > 0.0),
        });
    });
    seen.unwrap()
}

#[test]
fn friction_is_mu_times_the_normal_impulse_while_the_ball_slides() {
    for (n, spread) in [(4, 1e-9), (8, 1e-5)] {
        let mu = 0.1;
        let seen = look(n, mu, 5.0);
        assert!(!seen.still_touching);
        let e = seen.v.z;
        assert!((0.9..1.0).contains(&e), "restitution {e}");
        // One node that slides (n = 4) does so along x; a patch spreads, by some thousandths of the 5 m/s to the sides.
        assert_close(5.0 - seen.v.x, mu * (1.0 + e), spread, "change of the tangential velocity");
        assert_at_most(seen.v.y, 1e-12, "velocity across [m/s]");
        assert_moments(&seen, 5.0);
    }
}

/// Reactions explain all of the angular momentum; what is not kept about the contact point is the arm that flattening takes.
fn assert_moments(seen: &Seen, v_t: f64) {
    assert_at_most(
        seen.unexplained,
        1e-12,
        "angular momentum that no reaction explains, of that at the start",
    );
    // Friction of Δv_t acts at R − δ, and the resultant of the pressure moves ahead or behind by as much.
    let missing = 2.0 * seen.flattening / RADIUS * (v_t - seen.v.x) / v_t;
    assert!((0.01..0.025).contains(&(seen.flattening / RADIUS)));
    assert_within(
        seen.kept,
        1.0,
        missing.max(0.002),
        "fraction of the angular momentum about the contact point",
    );
}

#[test]
fn angular_momentum_about_the_contact_point_is_kept_for_any_friction() {
    for (mu, v_t) in [(0.05, 2.0), (0.1, 1.0), (0.3, 1.0), (0.6, 1.0)] {
        let [coarse, fine] = [4, 8].map(|n| look(n, mu, v_t));
        assert_moments(&fine, v_t);
        // On the coarse ball one node turns with the ball, away from below its centre.
        assert!((fine.kept - 1.0).abs() < (coarse.kept - 1.0).abs(), "{mu}: {} → {}", coarse.kept, fine.kept);
    }
}
