//! Projectiles that reach nothing: on straight paths no box around another body, and no plane, comes into their way.

use super::Findings;
use crate::mechanics::tensor::Vec3;
use crate::scene::document::{BodyDocument, Role, SceneDocument};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::scene_body::SceneBody;

/// Warns of projectiles that nothing can touch before the end: the run would have no numbers of an impact.
pub fn check(document: &SceneDocument, bodies: &[SceneBody], out: &mut Findings) {
    if !document.bodies.iter().all(flies_straight) || is_loaded(document) {
        return;
    }
    let boxes: Vec<[Vec3; 2]> = bodies.iter().map(bounds).collect();
    for (i, body) in document.bodies.iter().enumerate() {
        let velocity = Vec3::from(body.velocity_m_per_s);
        if body.role != Role::Projectile || velocity == Vec3::zeros() {
            continue;
        }
        let others = (0..boxes.len()).filter(|j| *j != i).filter_map(|j| {
            let other = Vec3::from(document.bodies[j].velocity_m_per_s);
            time_to_box(boxes[i], velocity - other, boxes[j])
        });
        let planes = document.planes.iter().filter_map(|plane| {
            let normal = Vec3::from(plane.normal).try_normalize(0.0)?;
            time_to_plane(boxes[i], velocity, (normal, Vec3::from(plane.point_m)))
        });
        let first = others.chain(planes).fold(f64::INFINITY, f64::min);
        if first > document.end_time_s {
            out.push(problem(i, body, first, document.end_time_s));
        }
    }
}

/// Whether a body starts undeformed, without spin, and moves by its velocity alone.
fn flies_straight(body: &BodyDocument) -> bool {
    Vec3::from(body.spin_rad_per_s) == Vec3::zeros()
        && body.initial_deformation.is_none()
        && body.prescribed.is_empty()
        && body.face_loads.is_empty()
}

/// Whether something else moves bodies, before the start or after.
fn is_loaded(document: &SceneDocument) -> bool {
    document.gravity_m_per_s2.is_some()
        || document.preload.is_some()
        || document.dynamic_relaxation.is_some()
        || document.integrator.is_quasi_static()
}

/// Bounding box at the start [m]; of a rigid body that of the ball around it.
fn bounds(body: &SceneBody) -> [Vec3; 2] {
    if let Some(rigid) = &body.rigid {
        let radius = rigid.shape.outer_radius();
        return [rigid.pose.centre.add_scalar(-radius), rigid.pose.centre.add_scalar(radius)];
    }
    body.mesh.bounding_box().unwrap_or_default()
}

/// Time after which a box that moves by v [m/s] first touches another one [s]; `None` if it never does.
fn time_to_box([low, high]: [Vec3; 2], v: Vec3, [other_low, other_high]: [Vec3; 2]) -> Option<f64> {
    let (mut first, mut last) = (0.0_f64, f64::INFINITY);
    for k in 0..3 {
        let (near, far) = (other_low[k] - high[k], other_high[k] - low[k]);
        if v[k] == 0.0 {
            if near > 0.0 || far < 0.0 {
                return None;
            }
            continue;
        }
        let (enter, leave) = (near / v[k], far / v[k]);
        first = first.max(enter.min(leave));
        last = last.min(enter.max(leave));
    }
    (first <= last).then_some(first)
}

/// The same for a half space, by its normal and a point on its surface.
fn time_to_plane([low, high]: [Vec3; 2], v: Vec3, (normal, point): (Vec3, Vec3)) -> Option<f64> {
    let lowest = Vec3::from_fn(|k, _| if normal[k] < 0.0 { high[k] } else { low[k] });
    let (distance, approach) = ((lowest - point).dot(&normal), -v.dot(&normal));
    if distance <= 0.0 {
        return Some(0.0);
    }
    (approach > 0.0).then(|| distance / approach)
}

fn problem(index: usize, body: &BodyDocument, first: f64, end: f64) -> Problem {
    let at = Pointer::root().key("bodies").index(index).key("velocity_m_per_s");
    let name = &body.name;
    if first.is_finite() {
        let message = format!("{name} reaches no other body before the end");
        return Problem::warning("nothing_in_reach", &at, message)
            .value(body.velocity_m_per_s.to_vec())
            .limit(format!(
                "the bounding box of another body enters its path after {first:.3e} s at the earliest"
            ))
            .remedy(format!("raise end_time_s ({end:.3e} s), or place {name} closer"));
    }
    Problem::warning(
        "nothing_in_reach",
        &at,
        format!("{name} flies past all other bodies, or away from them"),
    )
    .value(body.velocity_m_per_s.to_vec())
    .limit("towards another body")
    .remedy("check the sign of the velocity, and the placement of both bodies")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_meet_when_their_sides_do() {
        let unit = [Vec3::zeros(), Vec3::repeat(1.0)];
        let beside = |x: f64, y: f64| [Vec3::new(x, y, 0.0), Vec3::new(x + 1.0, y + 1.0, 1.0)];
        let v = Vec3::new(2.0, 0.0, 0.0);
        assert_eq!(time_to_box(unit, v, beside(3.0, 0.5)), Some(1.0));
        assert_eq!(time_to_box(unit, v, beside(3.0, 1.5)), None);
        assert_eq!(time_to_box(unit, -v, beside(3.0, 0.5)), None);
        assert_eq!(time_to_box(unit, v, beside(0.5, 0.5)), Some(0.0));
        assert_eq!(time_to_box(unit, Vec3::zeros(), beside(3.0, 0.5)), None);
        // Diagonally past the corner.
        assert_eq!(time_to_box(unit, Vec3::new(1.0, 1.0, 0.0), beside(5.0, 0.0)), None);
    }

    #[test]
    fn planes_are_reached_by_the_lowest_corner() {
        let unit = [Vec3::zeros(), Vec3::repeat(1.0)];
        let floor = (Vec3::z(), Vec3::new(0.0, 0.0, -3.0));
        assert_eq!(time_to_plane(unit, Vec3::new(5.0, 0.0, -1.5), floor), Some(2.0));
        assert_eq!(time_to_plane(unit, Vec3::new(5.0, 0.0, 1.5), floor), None);
        let ceiling = (-Vec3::z(), Vec3::new(0.0, 0.0, 4.0));
        assert_eq!(time_to_plane(unit, Vec3::z(), ceiling), Some(3.0));
    }
}
