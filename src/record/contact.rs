//! `/contact/forces`: forces of the contact pairs, and at the field times their contacts.

use super::packed;
use super::proto::contuse::{ContactForces, PackedArray, PairForces};
use crate::measure::Measures;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::tensor::Vec3;
use crate::step::Frame;

/// Topic of the contact forces.
pub const TOPIC: &str = "/contact/forces";
/// Schema of the contact forces.
pub const SCHEMA: &str = "contuse.v1.ContactForces";

/// A contact sticks when its tangential reaction is this far inside the cone, relative to μ r_n.
const STICK_MARGIN: f64 = 1e-9;
const STICK: u8 = 1;
const SLIP: u8 = 2;

/// The message of a measured frame.
pub fn message(frame: &Frame, measures: &Measures) -> ContactForces {
    let pairs = measures.listed_pairs().map(|(index, pair)| {
        let now = pair.force.now();
        PairForces {
            pair: pair.name.clone(),
            slave_body: pair.between[0].clone(),
            master_body: pair.between[1].clone(),
            force_n: Some(now.force.into()),
            force_norm_n: now.force.norm(),
            impulse_n_s: Some(now.impulse.into()),
            impulse_norm_n_s: now.impulse.norm(),
            patch_area_m2: now.patch.area,
            patch_long_axis_m: now.patch.axes[0],
            patch_short_axis_m: now.patch.axes[1],
            peak_pressure_pa: now.patch.peak_pressure,
            patch_nodes: now.patch.nodes,
            nodes_across_patch: now.patch.nodes_across,
            contacts: if frame.is_field_time { active_contacts(frame, index as u32) } else { Vec::new() },
        }
    });
    ContactForces { time_s: frame.time, step: frame.step, pairs: pairs.collect() }
}

/// Arrays of the pair's contacts with r_n > 0; all empty if nothing touches.
fn active_contacts(frame: &Frame, pair: u32) -> Vec<PackedArray> {
    let Some(contact) = &frame.plan.contact else { return Vec::new() };
    let sides = contact.pairs.get(pair as usize);
    let first_node = frame.plan.bodies[contact.surface_body[sides.slave]].nodes.start;
    let active = || frame.contacts_of(pair).filter(|(_, r)| r.impulse[0] > 0.0);
    let force = |impulse: f64| impulse / frame.mean_step;
    let tangential = |(c, r): (&Contact, &Reaction)| -> Vec3 {
        c.frame[1] * force(r.impulse[1]) + c.frame[2] * force(r.impulse[2])
    };
    vec![
        packed::u32s("node", active().map(|(c, _)| [c.slave - first_node])),
        packed::vectors("position_m", "m", active().map(|(c, _)| c.point)),
        packed::vectors("normal", "", active().map(|(c, _)| c.frame[0])),
        packed::scalars("normal_force_n", "N", active().map(|(_, r)| force(r.impulse[0]))),
        packed::vectors("tangential_force_n", "N", active().map(tangential)),
        packed::scalars("gap_m", "m", active().map(|(c, _)| c.gap)),
        packed::u8s("status", active().map(|(c, r)| status(r, c.law.mu()))),
    ]
}

/// Stick inside the cone of the contact's own law, slip on it; frictionless contacts always slip.
fn status(reaction: &Reaction, mu: f64) -> u8 {
    let [r_n, r_1, r_2] = reaction.impulse;
    if r_1.hypot(r_2) < mu * r_n * (1.0 - STICK_MARGIN) { STICK } else { SLIP }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn status_is_by_the_cone() {
        let reaction = |t: f64| Reaction { impulse: [2.0, 0.6 * t, 0.8 * t] };
        assert_eq!(status(&reaction(0.5), 0.3), STICK);
        assert_eq!(status(&reaction(0.6), 0.3), SLIP);
        assert_eq!(status(&reaction(0.0), 0.0), SLIP);
        assert_eq!(status(&reaction(9.0), f64::INFINITY), STICK);
    }
}
