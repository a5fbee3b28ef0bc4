//! Which pairs cannot meet before the end, by a bound on their motion that is a proof.
//!
//! A body that starts without deformation and spin, without gravity, *flies straight*: its u is exactly zero, and
//! x = X + V_b t, until a contact reaction acts on it. Its skin is known for the whole run then, and so is how near two such
//! bodies come. A body whose nodes are all held never moves at all. Whoever may touch somebody may be deflected, and from
//! then on nothing is known of it: all its pairs stay, and with them its partners in those may be deflected too. So a pair
//! is left out when, at the fixed point of this rule, both sides fly straight (or are held) and their boxes stay farther
//! apart than detection reaches, from the start to the end of a step beyond the end time, in which the last reactions are
//! computed. A body that flies straight keeps its shape and does not meet itself; nor does what it might find near itself at the
//! start deflect it. Such a pair never has a candidate contact: the run has the same bits with it and without.
//!
//! Deformed bodies are not bounded, on purpose. A speed like √(2E/m) of a node's mass is no theorem of the discrete motion
//! (the ledger's ½ v₋ᵀMv₊ does not bound the velocities of a step), so it would have to be watched in every step; that is
//! what the broad phase does with distant surfaces already, at the same cost.

use super::PlanBody;
use crate::mechanics::contact::closest_point::Patch;
use crate::mechanics::contact::detection::reach;
use crate::mechanics::contact::rigid_detection;
use crate::mechanics::rigid::RigidBody;
use crate::mechanics::tensor::Vec3;

/// Share of the lengths involved that is given away to rounding.
const ROUNDING: f64 = 1e-9;
/// Halvings of the interval in which the closest approach lies.
const ITERATIONS: usize = 200;

/// A pair that was asked for and is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct DistantPair {
    /// Names of the two sides.
    pub name: String,
    /// Whether one of them is the tissue, and the other is not.
    pub on_tissue: bool,
    /// Whether it is a body with itself.
    pub of_itself: bool,
    /// Why they cannot meet.
    pub why: String,
}

/// What is known of a body's motion before the run.
#[derive(Clone, Debug)]
pub(super) struct BodyMotion {
    /// Box of its skin at the start [m].
    low: Vec3,
    high: Vec3,
    flight: Vec3,
    /// How far its largest face reaches in detection [m].
    reach: f64,
    /// All nodes are held along all axes.
    held: bool,
    /// It flies straight unless something touches it.
    straight: bool,
}

impl BodyMotion {
    /// Of a body; `u` [m], `v` [m/s] at the start and `inverse_mass` [1/kg] of all nodes; `is_loaded` when gravity pulls.
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

    /// Of a rigid body, turned anyhow: the box of the ball around it.
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

    /// The same of a body that loads deform or move.
    #[must_use]
    pub fn driven(self) -> Self {
        Self { held: false, straight: false, ..self }
    }

    /// Largest coordinate that its skin has until a time [s], as a length [m].
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

/// For each pair why it cannot meet until a time [s]; `None` for those that may.
pub(super) fn cannot_meet(
    motions: &[BodyMotion],
    pairs: &[(usize, Other)],
    until: f64,
) -> Vec<Option<String>> {
    let mut motions = motions.to_vec();
    loop {
        let verdicts: Vec<Option<String>> =
            pairs.iter().map(|(body, other)| apart(&motions, *body, *other, until)).collect();
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

/// Why the two sides stay apart, if both are known and do.
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

/// A lower bound of the distance of two moving boxes until a time [m].
///
/// The distance is the norm of ⟨how far apart along each axis⟩, each convex in time, so it is convex: thirds close in on its
/// least value, and what may lie between is within |relative velocity| × interval.
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

/// The least height of a moving box over a plane until a time [m]; linear in time, so at one of its ends.
fn least_height(a: &BodyMotion, point: &Vec3, normal: &Vec3, until: f64) -> f64 {
    let lowest = Vec3::from_fn(|i, _| if normal[i] > 0.0 { a.low[i] } else { a.high[i] });
    let at = |t: f64| normal.dot(&(lowest + a.flight * t - point));
    at(0.0).min(at(until))
}

#[cfg(test)]
mod tests;
