//! `/reference/{body}`: the mesh at rest, so that a recording can be read, cut and converted without anything beside it.

use super::packed;
use super::proto::contuse::ReferenceMesh;
use crate::plan::Plan;
use crate::scene::document::Role;

/// Topic, before the body's name.
pub const TOPIC: &str = "/reference/";
/// Schema.
pub const SCHEMA: &str = "contuse.v1.ReferenceMesh";

/// The name of a role.
pub(super) fn role_name(role: Role) -> &'static str {
    match role {
        Role::Projectile => "projectile",
        Role::Tissue => "tissue",
        Role::Other => "other",
    }
}

/// The message of one body.
pub fn message(plan: &Plan, body: usize) -> ReferenceMesh {
    let body = &plan.bodies[body];
    let (first, last) = (body.nodes.start, body.nodes.end as usize);
    ReferenceMesh {
        time_s: 0.0,
        body: body.name.clone(),
        role: role_name(body.role).into(),
        parts: body.parts.clone(),
        positions: Some(packed::f64s(
            "position_m",
            "m",
            plan.X[first as usize..last].iter().map(|x| [x.x, x.y, x.z]),
        )),
        hexes: Some(packed::u32s("hexes", body.hexes.iter().map(|hex| hex.map(|node| node - first)))),
        part_of: Some(packed::u32s("part_of", body.part_of.iter().map(|&part| [part]))),
        flight_velocity_m_per_s: Some(body.flight_velocity.into()),
    }
}
