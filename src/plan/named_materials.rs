//! The parts of a scene whose material is a set of the library, with the numbers that they run with.

use crate::scene::Scene;
use crate::scene::document::PartDocument;
use crate::scene::materials::library;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A part by the name of its set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct NamedMaterialReport {
    /// Name of the body.
    pub body: String,
    /// Name of the part.
    pub part: String,
    /// Name of the set.
    pub library: String,
    /// Citations of its sources, with their addresses.
    pub sources: Vec<String>,
    /// The part as it runs, with the numbers of the set or the scene's own.
    #[cfg_attr(feature = "service", schema(value_type = Object))]
    pub resolved: Value,
}

impl NamedMaterialReport {
    /// All of a scene.
    pub(super) fn of(scene: &Scene) -> Vec<Self> {
        let bodies = &scene.document.bodies;
        let parts = bodies.iter().flat_map(|body| body.parts.iter().map(|part| (body.name.as_str(), part)));
        parts.filter_map(|(body, part)| Self::of_part(body, part)).collect()
    }

    fn of_part(body: &str, part: &PartDocument) -> Option<Self> {
        let library = part.library.clone()?;
        let sources = library::find(&library).map_or(&[][..], |set| &set.sources);
        Some(Self {
            body: body.to_owned(),
            part: part.part.clone(),
            sources: sources.iter().map(|source| format!("{} <{}>", source.citation, source.url)).collect(),
            // A part that was read can be written.
            resolved: serde_json::to_value(part).unwrap_or_default(),
            library,
        })
    }
}
