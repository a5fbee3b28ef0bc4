//! Documents exchanged over HTTP.

use crate::plan::PlanReport;
use crate::scene::Problem;
use crate::scene::geometry::BodyGeometry;
use crate::scene::summary::BodySummary;
use crate::service::jobs::engine::ScenePreview;
use crate::service::jobs::store::{Job, NOTICE};
use serde::Serialize;
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

/// A scene document; its schema is a separate file, which the service also serves at `/scene.schema.json`.
#[derive(Debug)]
pub struct SceneBody;

impl PartialSchema for SceneBody {
    fn schema() -> RefOr<Schema> {
        RefOr::Ref(Ref::new("scene.schema.json"))
    }
}
impl ToSchema for SceneBody {
    fn name() -> std::borrow::Cow<'static, str> {
        "Scene".into()
    }
}

/// A page of jobs.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct JobList {
    /// The jobs, newest first.
    pub jobs: Vec<Job>,
    /// `cursor` of the next page; null on the last one.
    pub next_cursor: Option<String>,
}

/// Preview of a valid scene.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Validation {
    /// Always true: an invalid scene is answered with a problem.
    pub valid: bool,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Warnings that do not prevent a run.
    pub warnings: Vec<Problem>,
    /// The bodies and their meshes, placed [m].
    pub bodies: Vec<BodySummary>,
    /// Plan of the run and its expected cost.
    pub plan: PlanReport,
    /// The bodies as they begin, if they are asked for and have no more than 60 000 elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry: Option<Vec<BodyGeometry>>,
    /// The disclaimer of every result.
    pub notice: &'static str,
}

impl Validation {
    /// The answer for a scene that can run.
    pub fn of(preview: ScenePreview) -> Self {
        Self {
            valid: true,
            name: preview.checked.name,
            content_hash: preview.checked.content_hash,
            warnings: preview.checked.warnings,
            bodies: preview.bodies,
            plan: preview.plan,
            geometry: preview.geometry,
            notice: NOTICE,
        }
    }
}
