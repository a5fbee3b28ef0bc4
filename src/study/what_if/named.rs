//! Resolves the names in a change to bodies, limbs, parts and pairs of the scene.

use super::misfit::Misfit;
use crate::mesh::generate::limb_segment::LimbSegment;
use crate::scene::document::{BodyDocument, ContactPairs, Generator, MeshDocument, Role, SceneDocument};
use crate::scene::problem::suggest;
use serde_json::json;

/// Index of the named body, or of the only projectile.
pub(super) fn striker(scene: &SceneDocument, name: Option<&String>) -> Result<usize, Misfit> {
    body_of(scene, "body", name, "projectile", |body| body.role == Role::Projectile)
}

/// The named limb segment, or the only one.
pub(super) fn limb_of<'a>(
    scene: &'a SceneDocument,
    name: Option<&String>,
) -> Result<(usize, &'a LimbSegment), Misfit> {
    let limb = |body: &'a BodyDocument| match &body.mesh {
        Some(MeshDocument::Generator(Generator::LimbSegment(limb))) => Some(limb),
        _ => None,
    };
    let index = body_of(scene, "limb", name, "limb segment", |body| {
        matches!(&body.mesh, Some(MeshDocument::Generator(Generator::LimbSegment(_))))
    })?;
    limb(&scene.bodies[index]).map(|limb| (index, limb)).ok_or_else(|| Misfit {
        field: "limb",
        value: json!(name),
        message: "this body is not a limb segment: its layers and its skin have no parameters".into(),
        limit: "a body whose mesh is made by the generator limb_segment".into(),
        remedy: "use impact_offset_m to hit another point of its surface".into(),
    })
}

/// Parameters of the limb segment that generates a body.
pub(super) fn limb_mut(body: &mut BodyDocument) -> Option<&mut LimbSegment> {
    match &mut body.mesh {
        Some(MeshDocument::Generator(Generator::LimbSegment(limb))) => Some(limb),
        _ => None,
    }
}

/// Index of the named body, or of the only one that is `meant`.
pub(super) fn body_of(
    scene: &SceneDocument,
    field: &'static str,
    name: Option<&String>,
    what: &str,
    meant: impl Fn(&BodyDocument) -> bool,
) -> Result<usize, Misfit> {
    let names = || scene.bodies.iter().map(|body| body.name.as_str());
    let misfit = |message: String, remedy: String| Misfit {
        field,
        value: json!(name),
        message,
        limit: "a body of the scene".into(),
        remedy,
    };
    if let Some(name) = name {
        let found = names().position(|known| known == name);
        return found
            .ok_or_else(|| misfit(format!("the scene has no body {name:?}"), suggest(name, names())));
    }
    let mut found = scene.bodies.iter().enumerate().filter(|(_, body)| meant(body)).map(|(index, _)| index);
    match (found.next(), found.next()) {
        (Some(index), None) => Ok(index),
        (None, _) => Err(misfit(format!("the scene has no {what}"), format!("name it in {field:?}"))),
        (Some(_), Some(_)) => {
            Err(misfit(format!("the scene has more than one {what}"), format!("name it in {field:?}")))
        }
    }
}

/// Index of the pair with these names, in any order.
pub(super) fn pair_of(scene: &SceneDocument, names: &[String; 2]) -> Result<usize, Misfit> {
    let ContactPairs::List(pairs) = &scene.contact.pairs else {
        return Err(Misfit {
            field: "between",
            value: json!(names),
            message: "the scene has no list of pairs: everything may touch everything".into(),
            limit: "a pair of the scene's list".into(),
            remedy: "omit `between`, or list the pairs in the scene".into(),
        });
    };
    let is_meant =
        |between: &[String; 2]| between == names || (between[0] == names[1] && between[1] == names[0]);
    pairs.iter().position(|pair| is_meant(&pair.between)).ok_or_else(|| Misfit {
        field: "between",
        value: json!(names),
        message: "the scene lists no such pair".into(),
        limit: "a pair of the scene's list".into(),
        remedy: suggest("", pairs.iter().map(|pair| pair.between[0].as_str())),
    })
}

/// Indices of the body and of the entry of a part.
pub(super) fn part_of(scene: &SceneDocument, body: &String, part: &str) -> Result<[usize; 2], Misfit> {
    let body = striker(scene, Some(body))?;
    let names = || scene.bodies[body].parts.iter().map(|entry| entry.part.as_str());
    let entry = names().position(|name| name == part).ok_or_else(|| Misfit {
        field: "part",
        value: json!(part),
        message: format!("{} has no entry for the part {part:?}", scene.bodies[body].name),
        limit: "an entry of the body's `parts`".into(),
        remedy: suggest(part, names()),
    })?;
    Ok([body, entry])
}
