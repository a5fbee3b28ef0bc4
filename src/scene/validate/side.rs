//! Projectiles that come from a cut side of generated layers, whose depths are counted from their top.

use super::Findings;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::scene::document::{BodyDocument, Role, SceneDocument};
use crate::scene::exposed_faces::{CUT_SIDES, TOP, counts_from_top};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::scene_body::SceneBody;

/// Warns of projectiles that begin beyond a cut side of layers and not above their top.
pub fn check(document: &SceneDocument, bodies: &[SceneBody], out: &mut Findings) {
    let is_projectile = |body: &&(&BodyDocument, &SceneBody)| body.0.role == Role::Projectile;
    let all: Vec<(&BodyDocument, &SceneBody)> = document.bodies.iter().zip(bodies).collect();
    for (layers, SceneBody { mesh, .. }) in &all {
        if !counts_from_top(document, layers, mesh) {
            continue;
        }
        for (body, made) in all.iter().filter(is_projectile) {
            let velocity = Vec3::from(body.velocity_m_per_s) - Vec3::from(layers.velocity_m_per_s);
            if let Some(side) = side_hit(mesh, made, &velocity) {
                out.push(problem(&body.name, &layers.name, side));
            }
        }
    }
}

/// The side that a projectile of a relative velocity [m/s] comes from, if it begins beyond one, and not above the top.
fn side_hit(layers: &Mesh, projectile: &SceneBody, velocity: &Vec3) -> Option<&'static str> {
    let centre = middle_of(&layers.nodes)?;
    // Outward normal of a side, and the distance of the projectile from it: layers are a cuboid, turned or not.
    let beyond = |name: &str| {
        let nodes = layers.node_sets.get(name)?;
        let middle = middle_of(nodes.iter().map(|node| &layers.nodes[*node as usize]))?;
        let normal = (middle - centre).try_normalize(0.0)?;
        Some((normal, lowest(projectile, &normal) - normal.dot(&middle)))
    };
    let (_, above) = beyond(TOP)?;
    let approach = |name: &'static str| {
        let (normal, distance) = beyond(name)?;
        let speed = -normal.dot(velocity);
        (distance >= 0.0 && speed > 0.0).then_some((name, speed))
    };
    let (side, _) = CUT_SIDES.into_iter().filter_map(approach).max_by(|a, b| a.1.total_cmp(&b.1))?;
    (above < 0.0).then_some(side)
}

/// Centre of the bounding box of some points, which of a cuboid and its sides is their own; `None` without any.
fn middle_of<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Option<Vec3> {
    let mut points = points.into_iter();
    let first = *points.next()?;
    let [low, high] = points.fold([first; 2], |[low, high], x| [low.inf(x), high.sup(x)]);
    Some(0.5 * (low + high))
}

/// Least coordinate of a body along a direction [m]; of a rigid one that of the ball around it.
fn lowest(body: &SceneBody, direction: &Vec3) -> f64 {
    match &body.rigid {
        Some(rigid) => direction.dot(&rigid.pose.centre) - rigid.shape.outer_radius(),
        None => body.mesh.nodes.iter().map(|x| direction.dot(x)).fold(f64::INFINITY, f64::min),
    }
}

fn problem(projectile: &str, layers: &str, side: &str) -> Problem {
    let message = format!(
        "{projectile} comes from {side} of {layers}, whose depths are counted from its top ({TOP}): depth of stress, deflection and \
         contact patch are not those below the face that is hit"
    );
    Problem::warning("hit_from_the_side", &Pointer::root().key("measures").key("skin_set"), message)
        .limit("a skin where the projectile comes from")
        .remedy(format!("name the face that is hit: \"measures\": {{\"skin_set\": \"{side}\"}}, or place {projectile} above the top"))
}
