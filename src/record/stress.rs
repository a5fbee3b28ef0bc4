//! `/stress/{body}`: nodal and element fields, each once; positions follow from the displacements.

use super::packed;
use super::proto::contuse::{PackedArray, Stress};
use crate::measure::fields::Fields;
use crate::mechanics::tensor::Vec3;
use crate::scene::document::FieldName;
use crate::step::Frame;
use std::array;

/// Topic prefix, followed by the body's name.
pub const TOPIC: &str = "/stress/";
/// Schema of the fields.
pub const SCHEMA: &str = "contuse.v1.Stress";

/// Name of the array that marks eroded elements.
pub const ERODED: &str = "eroded";

/// Name of the array of displacements, from which positions follow.
pub const DISPLACEMENT: &str = "displacement_m";
/// Name of the array of von Mises stresses.
pub const VON_MISES: &str = "von_mises_pa";

/// The requested nodal scalars of one body: name, unit, values.
fn nodal_scalars<'a>(
    fields: Option<&'a Fields>,
    nodes: &std::ops::Range<usize>,
) -> impl Iterator<Item = (&'static str, &'static str, &'a [f64])> {
    let named = fields.into_iter().flat_map(|fields| {
        [
            (VON_MISES, "Pa", &fields.von_mises),
            ("pressure_pa", "Pa", &fields.pressure),
            ("principal_strain", "", &fields.principal_strain),
        ]
    });
    named.filter_map(|(name, unit, values)| Some((name, unit, values.get(nodes.clone())?)))
}

/// Positions x = X + V t + u [m] of the nodes of a body in a message, from its mesh at rest and its flight velocity;
/// `None` if the message has no displacement for each of them.
pub fn positions(message: &Stress, rest: &[[f64; 3]], flight: [f64; 3]) -> Option<Vec<[f64; 3]>> {
    let u = f32s(message, DISPLACEMENT).filter(|u| u.len() == 3 * rest.len())?;
    let time = message.time_s.max(0.0);
    let moved = rest.iter().zip(u.as_chunks::<3>().0);
    Some(moved.map(|(x, u)| array::from_fn(|k| x[k] + flight[k] * time + f64::from(u[k]))).collect())
}

/// The numbers of a nodal array of a message, if it is there.
pub fn f32s(message: &Stress, name: &str) -> Option<Vec<f32>> {
    let array = message.nodal.iter().find(|array| array.name == name)?;
    Some(array.data.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
}

/// 1 for each eroded element of a message; empty if the body cannot erode.
pub fn eroded(message: &Stress) -> &[u8] {
    message.element.iter().find(|array| array.name == ERODED).map_or(&[], |array| &array.data)
}

/// The velocities of the nodes of one body at t_n: the means of the adjacent half steps, including the rigid-body velocity V.
fn velocities(frame: &Frame, nodes: std::ops::Range<usize>, flight: Vec3) -> impl Iterator<Item = Vec3> {
    let halves = frame.v[nodes.clone()].iter().zip(&frame.v_after[nodes]);
    halves.map(move |(before, after)| (before + after) * 0.5 + flight)
}

/// The message of one body at a field time.
pub fn message(frame: &Frame, body: usize, fields: Option<&Fields>) -> Stress {
    let plan_body = &frame.plan.bodies[body];
    let nodes = plan_body.nodes.start as usize..plan_body.nodes.end as usize;
    let mut nodal: Vec<PackedArray> = nodal_scalars(fields, &nodes)
        .map(|(name, unit, values)| packed::scalars(name, unit, values.iter().copied().map(packed::rounded)))
        .collect();
    nodal.push(packed::vectors(DISPLACEMENT, "m", frame.u[nodes.clone()].iter().copied()));
    if frame.plan.fields.contains(&FieldName::Velocity) {
        let velocities = velocities(frame, nodes, plan_body.flight_velocity);
        nodal.push(packed::vectors("velocity_m_per_s", "m/s", velocities));
    }
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
