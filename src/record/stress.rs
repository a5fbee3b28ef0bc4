//! `/stress/{body}`: nodal and element fields.

use super::packed;
use super::proto::contuse::{PackedArray, Stress};
use crate::measure::fields::Fields;
use crate::mechanics::tensor::Vec3;
use crate::scene::document::FieldName;
use crate::step::Frame;

/// Topic prefix, followed by the body's name.
pub const TOPIC: &str = "/stress/";
/// Schema of the fields.
pub const SCHEMA: &str = "contuse.v1.Stress";

/// Name of the array that marks eroded elements.
pub const ERODED: &str = "eroded";

/// A scalar field of the nodes of one body: name, unit, values.
pub type NodalScalar<'a> = (&'static str, &'static str, &'a [f64]);

/// The requested nodal scalars of one body.
pub fn nodal_scalars<'a>(fields: Option<&'a Fields>, nodes: &std::ops::Range<u32>) -> Vec<NodalScalar<'a>> {
    let Some(fields) = fields else { return Vec::new() };
    let range = nodes.start as usize..nodes.end as usize;
    [
        ("von_mises_pa", "Pa", &fields.von_mises),
        ("pressure_pa", "Pa", &fields.pressure),
        ("principal_strain", "", &fields.principal_strain),
    ]
    .into_iter()
    .filter_map(|(name, unit, values)| Some((name, unit, values.get(range.clone())?)))
    .collect()
}

/// The requested nodal vectors of one body: name, unit, values.
pub fn nodal_vectors(frame: &Frame, body: usize) -> Vec<(&'static str, &'static str, Vec<Vec3>)> {
    let body = &frame.plan.bodies[body];
    let range = body.nodes.start as usize..body.nodes.end as usize;
    let mut vectors = Vec::new();
    if frame.plan.fields.contains(&FieldName::Displacement) {
        vectors.push(("displacement_m", "m", frame.u[range.clone()].to_vec()));
    }
    if frame.plan.fields.contains(&FieldName::Velocity) {
        // At t_n: the mean of the adjacent half steps, including the flight velocity.
        let halves = frame.v[range.clone()].iter().zip(&frame.v_after[range]);
        let velocity = halves.map(|(before, after)| (before + after) * 0.5 + body.flight_velocity);
        vectors.push(("velocity_m_per_s", "m/s", velocity.collect()));
    }
    vectors
}

/// The message of one body at a field time.
pub fn message(frame: &Frame, body: usize, fields: Option<&Fields>) -> Stress {
    let plan_body = &frame.plan.bodies[body];
    let scalars = nodal_scalars(fields, &plan_body.nodes);
    let mut nodal: Vec<PackedArray> = scalars
        .into_iter()
        .map(|(name, unit, values)| packed::scalars(name, unit, values.iter().copied()))
        .collect();
    nodal
        .extend(nodal_vectors(frame, body).into_iter().map(|(name, unit, v)| packed::vectors(name, unit, v)));
    let range = plan_body.elements.start as usize..plan_body.elements.end as usize;
    let cauchy = fields.and_then(|f| f.element_cauchy.get(range));
    let cauchy = cauchy.map(|c| packed::f32s("cauchy_pa", "Pa", c.iter().copied()));
    let is_eroded = |element| u8::from(frame.erosion.contains(element));
    let eroded = plan_body.erodes.then(|| packed::u8s(ERODED, plan_body.elements.clone().map(is_eroded)));
    Stress {
        time_s: frame.time,
        step: frame.step,
        body: plan_body.name.clone(),
        nodal,
        element: cauchy.into_iter().chain(eroded).collect(),
    }
}
