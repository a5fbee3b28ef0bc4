//! `/v1/meshes`: upload, list, get or delete a mesh, begin a scene of it.

use super::answers::MadeIn;
use super::app::App;
use super::extract::{Owner, Parameters, Sender, declared_length, media_type};
use super::problem::{Problem, ProblemBody, VALIDATION_WAIT_S};
use crate::mesh::read::MeshFormat;
use crate::scene::first_impact::{Approach, FirstScene};
use crate::service::fair_queue::Lane;
use crate::service::jobs::JobsError;
use crate::service::jobs::engine::{Engine, MeshFile, NamedUpload};
use crate::service::jobs::queue::Queue;
use crate::service::jobs::store::MeshDeletion;
use crate::service::jobs::to_end::to_end;
use crate::service::jobs::upload::Upload;
use crate::service::meshes::{MeshRefusal, StoredMesh, is_id};
use crate::service::shelves::mesh_name;
use axum::body::Body;
use axum::extract::{Path, Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use futures::StreamExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::Read;
use std::sync::Arc;
use std::time::{Duration, Instant};
use utoipa::{IntoParams, ToSchema};

/// Largest mesh that is read in well below a second [bytes].
const SMALL_MESH: u64 = 2 << 20;

/// A page of meshes ends beyond so many bytes; a mesh may have ten thousand names.
const PAGE_BYTES: usize = 1 << 20;
/// Meshes that a page takes from the store at once.
const MESHES_AT_ONCE: usize = 2;
/// Memory for a page that is made [bytes].
const MEMORY_OF_LIST: usize = 8 << 20;

/// Largest coordinate and radius of a ball that comes to a target [m].
const FARTHEST: f64 = 1000.0;

/// Largest number of surfaces of which a scene is begun.
const MOST_SURFACES: usize = 100;

/// Options of an upload.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct UploadParameters {
    /// The format, unless the beginning of the file identifies it: `msh`, `inp`, `vtk`, `vtu`, `k`, `feb` or `bdf`;
    /// of a scan with labels `nii` (compressed, too), `nrrd` or `mha`, of a surface `stl`.
    format: Option<MeshFormat>,
}

/// Upload a mesh, or a scan with labels.
///
/// The body is the file itself (`curl --data-binary @ball.inp`). Its id is the SHA-256 of its bytes: the same file has
/// the same id, and a scene names it by `{"file": {"name": "<id>"}}`; a scan by `{"segmentation": {"name": "<id>", "size_m": …}}`,
/// closed surfaces by `{"segmentation": {"surfaces": [{"name": "<id>", "part": …}], "size_m": …}}`.
/// The report on a scan counts its voxels as elements, those of label n as part `label_<n>`.
#[utoipa::path(
    post, path = "/v1/meshes", tag = "meshes", operation_id = "upload_mesh", params(UploadParameters),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses(
        (status = 200, description = "The mesh was uploaded before", body = StoredMesh),
        (status = 201, description = "The mesh is stored", body = StoredMesh, headers(("Location" = String, description = "Address of the mesh"))),
        (status = 403, description = "As many bytes are kept as an owner may keep", body = ProblemBody, content_type = "application/problem+json"),
        (status = 413, description = "The body exceeds the limit of its size", body = ProblemBody, content_type = "application/problem+json"),
        (status = 415, description = "Not the file itself", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The file is not a mesh that can be used", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Too many uploads or validations of this client are in progress", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Too many uploads or validations are in progress, or the storage accepts no writes", body = ProblemBody, content_type = "application/problem+json"),
        (status = 507, description = "The service has no space left", body = ProblemBody, content_type = "application/problem+json", headers(("Retry-After" = u64, description = "Seconds"))),
    )
)]
pub async fn upload(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    Parameters(parameters): Parameters<UploadParameters>,
    Sender(sender): Sender,
    request: Request,
) -> Result<Response, Problem> {
    // Receive the file within the limits on size and time.
    if media_type(request.headers()).is_some_and(|m| m.starts_with("multipart/") || m == "application/json") {
        return Err(Problem::unsupported_media_type("application/octet-stream"));
    }
    let limit = app.config.runs.budget.mesh_bytes;
    let declared = declared_length(request.headers());
    if declared.is_some_and(|n| n > limit) {
        return Err(Problem::too_large(limit));
    }
    let permit = app.permits.uploads.take(sender)?;
    let upload = Upload::begin(&app.queue, &owner, declared, limit).await?;
    let receiving = receive(&app, request.into_body(), upload);
    let upload = tokio::time::timeout(app.config.upload_timeout, receiving)
        .await
        .map_err(|_| Problem::too_slow())??;
    drop(permit);

    // Limited in number: each holds a mesh in memory.
    let lane = if upload.digest().bytes <= SMALL_MESH { Lane::Small } else { Lane::Large };
    let engine = Arc::clone(&app.queue.engine);
    let inspect = move |is_wanted: &dyn Fn() -> bool| {
        let (bytes, format) = (upload.digest().bytes, parameters.format);
        let inspected = upload.open().map(|mut content| {
            engine.inspect_mesh(MeshFile { content: &mut content, bytes, format, is_wanted })
        });
        (inspected, upload)
    };
    let (inspected, upload) = app.validation_slots.call_while_wanted(&owner, lane, inspect).await?;
    let (format, report) = inspected.map_err(JobsError::from)??;

    // Store it under its digest.
    let queue = Arc::clone(&app.queue);
    let (id, is_new) = to_end(async move { upload.keep_mesh(&queue, format, &report).await }).await?;
    let mesh = app.queue.store.mesh(&owner, &id).await?.ok_or_else(Problem::no_such_mesh)?;
    let status = if is_new { StatusCode::CREATED } else { StatusCode::OK };
    let location = format!("/v1/meshes/{}", mesh.id);
    Ok((status, [(header::LOCATION, location)], Json(mesh)).into_response())
}

/// Get an uploaded mesh.
#[utoipa::path(
    get, path = "/v1/meshes/{id}", tag = "meshes", operation_id = "get_mesh", params(("id" = String, Path, description = "SHA-256 of the file")),
    responses(
        (status = 200, description = "Contents and quality of the mesh", body = StoredMesh),
        (status = 404, description = "No mesh of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn get(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    path: Result<Path<String>, axum::extract::rejection::PathRejection>,
) -> Result<Json<StoredMesh>, Problem> {
    let id = path.ok().map(|Path(id)| id).filter(|id| is_id(id)).ok_or_else(Problem::no_such_mesh)?;
    let mesh = app.queue.store.mesh(&owner, &id).await?.ok_or_else(Problem::no_such_mesh)?;
    Ok(Json(mesh))
}

/// What a first scene is made from, and how a ball approaches it.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct FirstSceneParameters {
    /// Name of the file of a closed surface, after which its part is called; `part_1` by default, and so on.
    name: Option<String>,
    /// Further closed surfaces of the body, inside or around this one: `<id>:<name of the file>`, separated by slashes.
    with: Option<String>,
    /// Radius of the ball [m]; 0.02 by default.
    radius_m: Option<f64>,
    /// A point that its path leads through [m], as `x,y,z`; by default the centre of the bounding box of the target.
    through_m: Option<String>,
}

impl FirstSceneParameters {
    /// Ids and names of the files, from this one on.
    fn files(&self, id: &str) -> Result<Vec<(String, String)>, Problem> {
        let others = self.with.as_deref().unwrap_or_default().split('/').filter(|word| !word.is_empty());
        let unnamed = |n: usize| format!("part_{n}");
        let other = |(n, word): (usize, &str)| {
            let (id, name) =
                word.split_once(':').map_or_else(|| (word, unnamed(n)), |(id, name)| (id, name.to_owned()));
            is_id(id).then(|| (id.to_owned(), name))
        };
        let own = (id.to_owned(), self.name.clone().unwrap_or_else(|| unnamed(1)));
        let files: Option<Vec<_>> = std::iter::once(Some(own)).chain((2..).zip(others).map(other)).collect();
        let files = files.filter(|files| files.len() <= MOST_SURFACES).ok_or_else(|| {
            Problem::bad_parameter(format!(
                "`with` must be ids of uploaded surfaces with their names, `<id>:<name>/<id>:<name>`, fewer than {MOST_SURFACES}."
            ))
        })?;
        let ids: BTreeSet<&str> = files.iter().map(|(id, _)| id.as_str()).collect();
        if ids.len() < files.len() {
            let message = "`with` has the same surface twice: each is one part or hole.";
            return Err(Problem::bad_parameter(message.to_owned()));
        }
        Ok(files)
    }

    fn approach(&self) -> Result<Approach, Problem> {
        let default = Approach::default();
        let through_m = self.through_m.as_ref().map(|text| {
            let numbers: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
            let point = numbers.and_then(|list| <[f64; 3]>::try_from(list).ok());
            point.filter(|point| point.iter().all(|x| x.abs() <= FARTHEST)).ok_or_else(|| {
                Problem::bad_parameter(
                    "`through_m` must be three numbers in metres, from -1000 to 1000: `x,y,z`.",
                )
            })
        });
        let radius_m = self.radius_m.unwrap_or(default.radius_m);
        if !(radius_m > 0.0 && radius_m <= FARTHEST) {
            return Err(Problem::bad_parameter("`radius_m` must be above 0 and at most 1000 metres."));
        }
        Ok(Approach { radius_m, through_m: through_m.transpose()? })
    }
}

/// Begin a scene of an uploaded mesh or scan, or of closed surfaces in each other, as `contuse scene from` does.
///
/// Bodies, parts and sets have guessed roles; what only you know is `null` or `to be chosen`, and `POST /v1/jobs/validate` names
/// it. Beside it, where a ball that comes along x, y or z touches the target.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/first-scene", tag = "meshes", operation_id = "first_scene",
    params(("id" = String, Path, description = "SHA-256 of the file"), FirstSceneParameters),
    responses(
        (status = 200, description = "The scene, the parts and sets of the mesh, and where a ball touches it", body = FirstScene),
        (status = 400, description = "A parameter of the query is not valid", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "No mesh of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "No scene can be made from it: several files that are not surfaces, or are too large together", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Too many validations of this token are waiting", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Too many validations are waiting", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn first_scene(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    path: Result<Path<String>, axum::extract::rejection::PathRejection>,
    Parameters(parameters): Parameters<FirstSceneParameters>,
) -> Result<Json<FirstScene>, Problem> {
    let approach = parameters.approach()?;
    let Json(mesh) = get(State(Arc::clone(&app)), Owner(owner.clone()), path).await?;
    let (mut meshes, mut uploads) = (Vec::new(), Vec::new());
    for (id, name) in parameters.files(&mesh.id)? {
        let mesh = app.queue.store.mesh(&owner, &id).await?.ok_or_else(Problem::no_such_mesh)?;
        uploads.push(NamedUpload { id, name, bytes: mesh.bytes });
        meshes.push(mesh);
    }
    if meshes.len() > 1 {
        check_surfaces(&meshes, app.config.runs.budget.mesh_bytes)?;
    }
    reading(&app, &owner, meshes, move |engine, file| engine.first_scene(file, &uploads, &approach)).await
}

impl From<MeshRefusal> for Problem {
    fn from(refusal: MeshRefusal) -> Self {
        match refusal {
            MeshRefusal::Lost(how) => {
                Self::busy(format!("The file was not checked: {how}."), VALIDATION_WAIT_S)
            }
            MeshRefusal::Invalid(why) => Self::invalid_mesh(why),
        }
    }
}

/// Only surfaces are begun together, within the limit on the size of one mesh.
fn check_surfaces(meshes: &[StoredMesh], limit: u64) -> Result<(), Problem> {
    let refusal = |message: String| Problem::from(MeshRefusal::Invalid(message));
    if let Some(other) = meshes.iter().find(|mesh| mesh.format != MeshFormat::Stl) {
        let id = &other.id;
        return Err(refusal(format!(
            "{id} is no surface: a scene is made from one file, or from several surfaces"
        )));
    }
    let bytes: u64 = meshes.iter().map(|mesh| mesh.bytes).sum();
    if bytes > limit {
        return Err(refusal(format!(
            "the surfaces have {bytes} bytes together, of which at most {limit} are read"
        )));
    }
    Ok(())
}

/// Has the engine read uploaded meshes, one after the other, for an answer, as soon as a slot is free.
pub(super) async fn reading<T: Send + 'static>(
    app: &App,
    owner: &str,
    meshes: Vec<StoredMesh>,
    answer: impl FnOnce(&dyn Engine, MeshFile<'_>) -> Result<T, MeshRefusal> + Send + 'static,
) -> Result<Json<T>, Problem> {
    let blobs: Vec<String> = meshes.iter().map(|mesh| mesh_name(&mesh.id, mesh.format)).collect();
    let open = move |queue: &Queue| {
        let mut content: Box<dyn Read + Send> = Box::new(std::io::empty());
        for blob in &blobs {
            let Some(next) = queue.blobs.open(blob)? else { return Ok(None) };
            content = Box::new(content.chain(next));
        }
        Ok(Some(content))
    };
    let opened = app.queue.unless_silent(app.queue.with_files(open)).await??;
    let mut content = opened.ok_or_else(Problem::no_such_mesh)?;
    let engine = Arc::clone(&app.queue.engine);
    let bytes: u64 = meshes.iter().map(|mesh| mesh.bytes).sum();
    let format = meshes.first().map(|mesh| mesh.format);
    let lane = if bytes <= SMALL_MESH { Lane::Small } else { Lane::Large };
    let read = move |is_wanted: &dyn Fn() -> bool| {
        answer(&*engine, MeshFile { content: &mut content, bytes, format, is_wanted })
    };
    let read = app.validation_slots.call_while_wanted(owner, lane, read);
    Ok(Json(app.queue.unless_silent(read).await???))
}

/// Page of a list of meshes.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct MeshListParameters {
    /// Maximum number of meshes, 1 to 200; 50 by default.
    limit: Option<u32>,
    /// `next_cursor` of the previous page.
    cursor: Option<String>,
}

/// A page of meshes.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct MeshList {
    /// The meshes, by their ids.
    pub meshes: Vec<StoredMesh>,
    /// `cursor` of the next page; null on the last one.
    pub next_cursor: Option<String>,
}

/// List the uploaded meshes.
#[utoipa::path(
    get, path = "/v1/meshes", tag = "meshes", operation_id = "list_meshes", params(MeshListParameters),
    responses(
        (status = 200, description = "A page of meshes, fewer than `limit` where their names take more than a megabyte", body = MeshList),
        (status = 400, description = "A parameter of the query is not valid", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Documents and answers of this client take all the memory for those of one client", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Documents and answers take all the memory for them", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn list(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    Sender(sender): Sender,
    Parameters(MeshListParameters { limit, cursor }): Parameters<MeshListParameters>,
) -> Result<(Extension<MadeIn>, Json<MeshList>), Problem> {
    let limit = limit.unwrap_or(50);
    if !(1..=200).contains(&limit) {
        return Err(Problem::bad_parameter("`limit` must be between 1 and 200."));
    }
    let mut after = cursor.unwrap_or_default();
    if !after.is_empty() && !is_id(&after) {
        return Err(Problem::bad_parameter("`cursor` must be the `next_cursor` of a page."));
    }
    let memory = app.bodies.hold(&sender, MEMORY_OF_LIST).await?;
    let (limit, mut meshes, mut bytes) = (limit as usize, Vec::new(), 0);
    // One more than requested shows whether there is another page.
    let has_more = loop {
        let wanted = (limit + 1 - meshes.len()).min(MESHES_AT_ONCE);
        let found = app.queue.store.meshes(&owner, &after, wanted as u32).await?;
        let is_last = found.len() < wanted;
        let room = if bytes < PAGE_BYTES { limit - meshes.len() } else { 0 };
        let is_full = found.len() > room;
        for mesh in found.into_iter().take(room) {
            bytes += serde_json::to_vec(&mesh).map_or(0, |text| text.len());
            after.clone_from(&mesh.id);
            meshes.push(mesh);
        }
        if is_full || is_last {
            break is_full;
        }
    };
    Ok((MadeIn::new(memory), Json(MeshList { meshes, next_cursor: has_more.then_some(after) })))
}

/// Delete an uploaded mesh.
///
/// Jobs that have ended keep their results; scenes that name the mesh cannot run any more.
#[utoipa::path(
    delete, path = "/v1/meshes/{id}", tag = "meshes", operation_id = "delete_mesh", params(("id" = String, Path, description = "SHA-256 of the file")),
    responses(
        (status = 204, description = "The mesh is deleted"),
        (status = 404, description = "No mesh of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "A waiting or running job names it", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn delete(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    path: Result<Path<String>, axum::extract::rejection::PathRejection>,
) -> Result<StatusCode, Problem> {
    let id = path.ok().map(|Path(id)| id).filter(|id| is_id(id)).ok_or_else(Problem::no_such_mesh)?;
    let queue = Arc::clone(&app.queue);
    match to_end(async move { queue.delete_mesh(&owner, &id).await }).await? {
        MeshDeletion::Deleted { .. } => Ok(StatusCode::NO_CONTENT),
        MeshDeletion::InUse { job } => Err(Problem::mesh_in_use(job)),
        MeshDeletion::Unknown => Err(Problem::no_such_mesh()),
    }
}

/// Bytes that are written to a file at a time: a client may send them one by one.
const GATHERED: usize = 32 << 10;

/// Receives a body into an upload.
async fn receive(app: &App, body: Body, mut upload: Upload) -> Result<Upload, Problem> {
    let mut stream = body.into_data_stream();
    let (began, timeout) = (Instant::now(), app.config.request_timeout);
    let (mut bytes, mut gathered) = (0_u64, Vec::new());
    loop {
        let next = tokio::time::timeout(timeout, stream.next()).await;
        let Some(piece) = next.map_err(|_| Problem::too_slow())? else { break };
        let piece = piece.map_err(|_| Problem::broken_body())?;
        bytes += piece.len() as u64;
        let in_time = Duration::from_secs_f64(bytes as f64 / app.config.least_rate.max(1) as f64);
        if began.elapsed() > timeout + in_time {
            return Err(Problem::too_slow());
        }
        gathered.extend_from_slice(&piece);
        if gathered.len() >= GATHERED {
            upload = upload.append(&app.queue, std::mem::take(&mut gathered)).await?;
        }
    }
    upload.append(&app.queue, gathered).await.map_err(Problem::from)
}
