//! Pairs that cannot meet before the end, by a rigorous bound on their motion.
//!
//! A body that starts undeformed and without spin, without gravity, *flies straight*: its u is exactly zero, and x = X +
//! V_b t, until a contact reaction acts on it. Its boundary surface is then known for the whole run, and so is the smallest
//! distance of two such bodies. A body with all nodes held never moves. A body that may touch another one may be deflected,
//! and from then on its motion is unknown: all its pairs stay, and the partners in these may be deflected too. A pair is
//! omitted if, at the fixed point of this rule, both sides fly straight (or are held) and the distance of their bounding
//! boxes exceeds the reach of detection from the start to the end of a step beyond the end time, in which the last
//! reactions are computed. A body that flies straight keeps its shape and does not touch itself; nor is it deflected by
//! what it might find close to itself at the start. Such a pair never has a candidate contact: the run has the same bits
//! with it and without.
//!
//! Deformed bodies are deliberately not bounded. A speed such as √(2E/m) from a node's mass is no theorem of the discrete
//! motion (the ledger's ½ v₋ᵀMv₊ does not bound the velocities of a step), so it would have to be monitored in every step;
//! the broad phase already does that with distant surfaces, at the same cost.

use super::body::PlanBody;
use crate::mechanics::contact::detection::closest_point::Patch;
use crate::mechanics::contact::detection::node_to_face::reach;
use crate::mechanics::contact::detection::rigid_detection;
use crate::mechanics::rigid::RigidBody;
use crate::mechanics::tensor::Vec3;

/// Relative allowance for rounding of the lengths involved [-].
const ROUNDING: f64 = 1e-9;
/// Number of reductions of the interval that contains the closest approach.
const ITERATIONS: usize = 200;

/// A requested pair that is omitted.
#[derive(Clone, Debug, PartialEq)]
pub struct DistantPair {
    /// Names of the two sides, joined by a dash.
    pub name: String,
    /// Whether exactly one of them is the tissue.
    pub on_tissue: bool,
    /// Whether it is a self-contact pair.
    pub of_itself: bool,
    /// Why the sides cannot meet.
    pub why: String,
}

/// Bounds on the motion of a body that are known before the run.
#[derive(Clone, Debug)]
pub(super) struct BodyMotion {
    /// Bounding box of its surface at the start [m].
    low: Vec3,
    high: Vec3,
    flight: Vec3,
    /// Reach of its largest face in detection [m].
    reach: f64,
    /// All nodes are held along all axes.
    held: bool,
    /// It flies straight until something touches it.
    straight: bool,
}

impl BodyMotion {
    /// Motion of a deformable body, from the initial `u` [m] and `v` [m/s] and `inverse_mass` [1/kg] of all nodes;
    /// `is_loaded` under gravity.
    pub fn new(body: &PlanBody, X: &[Vec3], [u, v, inverse_mass]: [&[Vec3]; 3], is_loaded: bool) -> Self {
        let nodes = body.nodes.start as usize..body.nodes.end as usize;
        let zero = |values: &[Vec3]| values[nodes.clone()].iter().all(|x| *x == Vec3::zeros());
        let places = || body.boundary.nodes.iter().map(|&node| X[node as usize] + u[node as usize]);
        let infinite = Vec3::repeat(f64::INFINITY);
        let sizes = body.boundary.faces.iter().map(|face| Patch::new(face, X).area().sqrt());
        Self {
            low: places().fold(infinite, |low, x| low.inf(&x)),
            high: places().fold(-infinite, |high, x| high.sup(&x)),
            flight: body.flight_velocity,
            reach: reach(sizes.fold(0.0, f64::max)),
            held: zero(inverse_mass) && body.flight_velocity == Vec3::zeros(),
            straight: !is_loaded && zero(u) && zero(v),
        }
    }

    /// Motion of a rigid body in any orientation: the bounding box of its circumscribed ball.
    pub fn rigid(body: &PlanBody, rigid: &RigidBody, X: &[Vec3], is_loaded: bool) -> Self {
        let (centre, radius) = (X[rigid.centre as usize], rigid.shape.outer_radius());
        Self {
            low: centre.add_scalar(-radius),
            high: centre.add_scalar(radius),
            flight: body.flight_velocity,
            reach: rigid_detection::reach(rigid.shape.size()),
            held: false,
            straight: !is_loaded,
        }
    }

    /// The motion if loads deform or move the body.
    #[must_use]
    pub fn driven(self) -> Self {
        Self { held: false, straight: false, ..self }
    }

    /// Largest absolute coordinate of its surface until a time [s], as a length [m].
    fn extent(&self, until: f64) -> f64 {
        self.low.amax().max(self.high.amax()) + self.flight.norm() * until
    }
}

/// The other side of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) enum Other {
    /// A body; the same one for self-contact.
    Body(usize),
    /// A fixed plane: point [m] and unit normal.
    Plane(Vec3, Vec3),
}

/// For each pair, why it cannot meet until a time [s]; `None` if it may meet.
pub(super) fn cannot_meet(
    motions: &[BodyMotion],
    pairs: &[(usize, Other)],
    until: f64,
) -> Vec<Option<String>> {
    let mut motions = motions.to_vec();
    loop {
        let verdicts: Vec<Option<String>> =
            pairs.iter().map(|(body, other)| apart(&motions, *body, *other, until)).collect();
        // Both sides of a pair that may meet may be deflected.
        let mut deflected = false;
        for ((body, other), _) in pairs.iter().zip(&verdicts).filter(|(_, verdict)| verdict.is_none()) {
            let second = match other {
                Other::Body(second) if second == body => continue,
                Other::Body(second) => *second,
                Other::Plane(..) => *body,
            };
            for touched in [*body, second] {
                deflected |= std::mem::replace(&mut motions[touched].straight, false);
            }
        }
        if !deflected {
            return verdicts;
        }
    }
}

/// Why the two sides stay apart, if both motions are known and they do.
fn apart(motions: &[BodyMotion], body: usize, other: Other, until: f64) -> Option<String> {
    let a = &motions[body];
    let known = |motion: &BodyMotion| motion.held || motion.straight;
    let (distance, needed, both_held) = match other {
        Other::Body(b) => {
            if b == body {
                return known(a).then(|| "nothing can deform it before the end".into());
            }
            let b = &motions[b];
            if !(known(a) && known(b)) {
                return None;
            }
            let rounding = ROUNDING * (a.extent(until) + b.extent(until));
            (closest_approach(a, b, until), a.reach.max(b.reach) + rounding, a.held && b.held)
        }
        Other::Plane(point, normal) => {
            if !known(a) {
                return None;
            }
            let rounding = ROUNDING * (a.extent(until) + point.amax());
            (least_height(a, &point, &normal, until), a.reach + rounding, a.held)
        }
    };
    if both_held {
        return Some("both are held fixed".into());
    }
    (distance > needed).then(|| {
        format!("they stay at least {distance:.3e} m apart to the end, and nothing can deflect either before")
    })
}

/// A lower bound on the distance of two moving boxes until a time [m].
///
/// The distance is the norm of the gaps along each axis, each convex in time, so it is convex: trisection encloses its
/// minimum, and the variation inside the last interval is at most |relative velocity| × interval.
fn closest_approach(a: &BodyMotion, b: &BodyMotion, until: f64) -> f64 {
    let drift = a.flight - b.flight;
    let distance = |t: f64| {
        let moved = drift * t;
        let gap = (a.low + moved - b.high).sup(&(b.low - a.high - moved));
        gap.sup(&Vec3::zeros()).norm()
    };
    let (mut early, mut late) = (0.0, until);
    for _ in 0..ITERATIONS {
        let third = (late - early) / 3.0;
        if distance(early + third) <= distance(late - third) {
            late -= third;
        } else {
            early += third;
        }
    }
    let seen = distance(0.0).min(distance(until)).min(distance(early)).min(distance(late));
    (seen - drift.norm() * (late - early)).max(0.0)
}

/// Smallest height of a moving box above a plane until a time [m]; linear in time, so attained at one end.
fn least_height(a: &BodyMotion, point: &Vec3, normal: &Vec3, until: f64) -> f64 {
    let lowest = Vec3::from_fn(|i, _| if normal[i] > 0.0 { a.low[i] } else { a.high[i] });
    let at = |t: f64| normal.dot(&(lowest + a.flight * t - point));
    at(0.0).min(at(until))
}

#[cfg(test)]
mod tests;
