//! `/v1/materials`: the named sets of the library, as `contuse materials --json` has them.

use super::problem::{Problem, ProblemBody};
use crate::scene::materials::library::{MaterialSet, find, nearest_to, sets};
use axum::Json;
use axum::extract::Path;

/// All sets of material parameters that a scene can name, with their sources.
#[utoipa::path(get, path = "/v1/materials", tag = "materials", operation_id = "list_materials",
    responses((status = 200, description = "The sets, family by family", body = [MaterialSet])))]
pub async fn list() -> Json<&'static [MaterialSet]> {
    Json(sets())
}

/// Get one set with its sources.
#[utoipa::path(get, path = "/v1/materials/{family}/{set}", tag = "materials", operation_id = "get_material",
    params(
        ("family" = String, Path, description = "The part of the name before the `/`: `muscle`, `fat`, `skin`, …"),
        ("set" = String, Path, description = "The part of the name after the `/`")),
    responses(
        (status = 200, description = "The set with its constants, range and sources", body = MaterialSet),
        (status = 404, description = "The library has no set of this name", body = ProblemBody, content_type = "application/problem+json")))]
pub async fn get(Path((family, set)): Path<(String, String)>) -> Result<Json<&'static MaterialSet>, Problem> {
    let name = format!("{family}/{set}");
    find(&name).map(Json).ok_or_else(|| Problem::no_such_material(&nearest_to(&name)))
}
