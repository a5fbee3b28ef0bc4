//! Moves the impact point over the boundary surface of any mesh, together with the projectile.

use super::base_facts::BaseFacts;
use super::misfit::Misfit;
use super::named::{body_of, striker};
use super::rigid_motion::carry_body;
use crate::mechanics::tensor::Vec3;
use crate::mesh::triangulated_surface::{SurfacePoint, TriangulatedSurface};
use crate::mesh::walk::{Obstacle, WalkEnd};
use crate::scene::document::{BodyDocument, SceneDocument};
use nalgebra::Rotation3;
use serde_json::json;
use std::sync::Arc;

/// Tangential fraction below which a direction counts as normal to the surface.
const LEAST_ALONG: f64 = 1e-6;

/// Projectile, target and impact point.
pub(super) struct Aim {
    projectile: usize,
    target: usize,
    surface: Arc<TriangulatedSurface>,
    point: SurfacePoint,
}

/// Impact point of a projectile: where the path of its centre, relative to a target, first meets the target's boundary. The
/// target is given by name, or the first body with a mesh in the path.
pub(super) fn aim(
    scene: &SceneDocument,
    facts: &BaseFacts,
    [projectile, target]: [Option<&String>; 2],
) -> Result<Aim, Misfit> {
    let projectile = striker(scene, projectile)?;
    let targets = match target {
        Some(name) => vec![named_target(scene, projectile, name)?],
        None => (0..scene.bodies.len()).filter(|&body| may_be_hit(scene, projectile, body)).collect(),
    };
    let center = facts.center(scene, projectile)?;
    let mut first: Option<(f64, Aim)> = None;
    for target in targets {
        let surface = facts.boundary(scene, target)?;
        let Some((time, point)) = surface.entry(&center, &approach(scene, projectile, target)) else {
            continue;
        };
        if first.as_ref().is_none_or(|(earliest, _)| time < *earliest) {
            first = Some((time, Aim { projectile, target, surface, point }));
        }
    }
    first.map(|(_, aim)| aim).ok_or_else(|| passes_by(scene, projectile, &center, target))
}

fn may_be_hit(scene: &SceneDocument, projectile: usize, body: usize) -> bool {
    body != projectile && scene.bodies[body].rigid.is_none()
}

fn named_target(scene: &SceneDocument, projectile: usize, name: &String) -> Result<usize, Misfit> {
    let target = body_of(scene, "target", Some(name), "target", |_| false)?;
    may_be_hit(scene, projectile, target).then_some(target).ok_or_else(|| Misfit {
        field: "target",
        value: json!(name),
        message: if target == projectile {
            "this is the projectile itself".into()
        } else {
            "this body is rigid: it has no meshed surface to move over".into()
        },
        limit: "another body with a mesh".into(),
        remedy: "name the body that is hit, or use offset_m".into(),
    })
}

/// Velocity of the projectile relative to the target [m/s].
fn approach(scene: &SceneDocument, projectile: usize, target: usize) -> Vec3 {
    let [of, from] = [projectile, target].map(|body| Vec3::from(scene.bodies[body].velocity_m_per_s));
    of - from
}

fn passes_by(scene: &SceneDocument, projectile: usize, center: &Vec3, target: Option<&String>) -> Misfit {
    let BodyDocument { name, velocity_m_per_s, .. } = &scene.bodies[projectile];
    let at =
        target.map_or("every body with a mesh".to_owned(), |target| format!("the surface of {target:?}"));
    let [place, velocity] = [*center, Vec3::from(*velocity_m_per_s)].map(|v| in_words(&v));
    Misfit {
        field: if target.is_some() { "target" } else { "body" },
        value: json!(target.unwrap_or(name)),
        message: format!(
            "{name} has no impact point: the line through its centre {place} m along its velocity {velocity} m/s misses {at}"
        ),
        limit: "a flight at the surface of the target".into(),
        remedy: "aim the centre of the projectile at the target in the scene (placement, velocity), or use offset_m"
            .into(),
    }
}

impl Aim {
    /// Unit tangent of the surface at the impact point in the given direction.
    pub(super) fn heading(&self, along: [f64; 3]) -> Result<Vec3, Misfit> {
        let direction = Vec3::from(along).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let normal = self.point.normal;
        (direction - normal * normal.dot(&direction)).try_normalize(LEAST_ALONG).ok_or_else(|| Misfit {
            field: "along",
            value: json!(along),
            message: format!(
                "this direction is normal to the surface, whose normal is {} there",
                in_words(&normal)
            ),
            limit: "a direction at an angle to the normal".into(),
            remedy: "give a tangential direction".into(),
        })
    }
}

/// Moves the projectile so that it hits a point `value` [m] away over the surface, straight ahead along a direction
/// (backwards if negative), as it would have hit the old one: by the rigid motion that carries along the point, the
/// normal and the plane of the path.
pub(super) fn move_over_surface(
    scene: &mut SceneDocument,
    aim: &Aim,
    along: [f64; 3],
    value: f64,
) -> Result<(), Misfit> {
    let heading = aim.heading(along)?;
    if value == 0.0 {
        return Ok(());
    }
    let from = &aim.point;
    let walked = aim.surface.walk(from, &(heading * value.signum()), value.abs());
    let to = walked.map_err(|end| cut_short(&scene.bodies[aim.target].name, value, &end))?;
    // The binormal of the path is carried along.
    let across = from.normal.cross(&heading);
    let turn = if to.normal == from.normal {
        Rotation3::identity()
    } else {
        let [old, new] = [from, &to].map(|point| Rotation3::face_towards(&point.normal, &across));
        new * old.inverse()
    };
    let frame = Vec3::from(scene.bodies[aim.target].velocity_m_per_s);
    carry_body(&mut scene.bodies[aim.projectile], &turn, &(to.place - turn * from.place), &frame);
    Ok(())
}

/// The surface ends within the distance.
fn cut_short(target: &str, value: f64, end: &WalkEnd) -> Misfit {
    let place = in_words(&end.place);
    let what = match end.what {
        Obstacle::Border => format!("the surface of {target} ends at {place}"),
        Obstacle::SharpEdge { turn_deg } => {
            format!("the surface of {target} has a sharp edge at {place}, where it turns by {turn_deg:.0}°")
        }
        Obstacle::Beginning => format!("the path around {target} returns to its start at {place}"),
    };
    let limit = if value < 0.0 { ("more than", -end.walked) } else { ("less than", end.walked) };
    Misfit {
        field: "along",
        value: json!(value),
        message: format!("{what}, {:.4e} m from the impact point of the base", end.walked),
        limit: format!("{} {:.4e} m in this direction", limit.0, limit.1),
        remedy: "stay below that, or go in another direction".into(),
    }
}

/// Formats as "(0.0100, 0.0000, -0.0200)".
fn in_words(v: &Vec3) -> String {
    format!("({:.4}, {:.4}, {:.4})", v.x, v.y, v.z)
}
