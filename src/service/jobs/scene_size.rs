//! Size of a scene before it is loaded, read from its document, whether or not that is valid.

use super::JobKind;
use crate::scene::document::Generator;
use crate::service::meshes::MeshShelf;
use serde::Deserialize as _;
use serde_json::Value;

/// Number of elements that the validation of a document makes or reads, approximately: those of its scene, times the number of
/// scenes that a question tries. `u64::MAX` where local refinement decides.
pub(super) fn elements(kind: JobKind, document: &Value, meshes: &MeshShelf) -> u64 {
    match kind {
        JobKind::Simulation => of_scene(document, meshes),
        JobKind::Study => of_scene(&document["scene"], meshes),
        JobKind::WhatIf => {
            // Each parameter is tried at both ends of its range.
            let scenes = 1 + 2 * document["parameters"].as_array().map_or(0, Vec::len) as u64;
            of_scene(&document["scene"], meshes).saturating_mul(scenes)
        }
    }
}

fn of_scene(scene: &Value, meshes: &MeshShelf) -> u64 {
    let bodies = scene["bodies"].as_array().into_iter().flatten();
    bodies.fold(0, |sum, body| sum.saturating_add(of_body(body, meshes)))
}

fn of_body(body: &Value, meshes: &MeshShelf) -> u64 {
    if body["refinement"].as_array().is_some_and(|places| !places.is_empty()) {
        return u64::MAX;
    }
    let mesh = &body["mesh"];
    if let Some(name) = mesh["file"]["name"].as_str() {
        let splits = mesh["file"]["refine"].as_u64().unwrap_or(0).min(20) as u32;
        let elements = meshes.find(name).map_or(0, |mesh| mesh.report.elements);
        return elements.saturating_mul(8_u64.saturating_pow(splits));
    }
    // What is no generator is refused without making anything.
    Generator::deserialize(&mesh["generator"]).map_or(0, |generator| generator.element_count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Budget, NoFiles, load};

    #[test]
    fn a_generated_scene_has_the_elements_that_its_document_says() {
        let text = include_str!("../../../scenarios/flashball_thigh/scene_elastic.json");
        let document: Value = serde_json::from_str(text).unwrap();
        let loaded = load(text.as_bytes(), &NoFiles, &Budget::SERVICE).unwrap();
        let generators = document["bodies"].as_array().unwrap().iter().map(|body| &body["mesh"]["generator"]);
        let elements: u64 = generators.map(|g| Generator::deserialize(g).unwrap().element_count()).sum();
        assert_eq!(elements, loaded.scene.element_count() as u64);
    }
}
