//! Errors as `application/problem+json` (RFC 9457). The only file that assigns statuses to errors.

use crate::blobs::BlobError;
use crate::mesh::read::MeshFormat;
use crate::scene::{self, Problems, problem::Pointer};
use crate::service::fair_queue::Refusal;
use crate::service::jobs::{JobId, JobState, JobsError};
use crate::service::permits::NoPermit;
use crate::service::tokens::Scope;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

/// Time after which to repeat a validation that could not begin [s].
pub(super) const VALIDATION_WAIT_S: u64 = 10;

/// Time after which to repeat a submission of an owner whose jobs wait [s].
const QUEUE_WAIT_S: u64 = 30;

/// Time after which to repeat an upload, a download or an event stream [s].
const PERMIT_WAIT_S: u64 = 10;

/// Error of a request.
#[derive(Clone, Debug)]
pub struct Problem {
    status: StatusCode,
    // Boxed: every handler returns a problem or an answer, and most return answers.
    body: Box<ProblemBody>,
    headers: Vec<(HeaderName, HeaderValue)>,
}

/// Problem document of an error.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ProblemBody {
    /// Kind of the problem, `urn:contuse:problem:…`, machine-readable.
    #[serde(rename = "type")]
    pub kind: String,
    /// Kind of the problem for display.
    pub title: String,
    /// Status code of the HTTP response.
    pub status: u16,
    /// What is wrong with this request.
    pub detail: String,
    /// Suggested change of the request.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// Problems of a scene. After 100 errors the last entry, `too_many_problems`, has the number of the others as its value.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<scene::Problem>,
    /// Line of a JSON text, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// Column of a JSON text, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// Identifier of this occurrence in the log of the service.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instance: Option<String>,
}

impl Problem {
    fn new(status: StatusCode, kind: &str, title: &str, detail: impl Into<String>) -> Self {
        let body = ProblemBody {
            kind: format!("urn:contuse:problem:{kind}"),
            title: title.to_owned(),
            status: status.as_u16(),
            detail: detail.into(),
            remedy: None,
            errors: Vec::new(),
            line: None,
            column: None,
            instance: None,
        };
        Self { status, body: Box::new(body), headers: Vec::new() }
    }

    fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.body.remedy = Some(remedy.into());
        self
    }

    fn header(mut self, name: HeaderName, value: HeaderValue) -> Self {
        self.headers.push((name, value));
        self
    }

    /// No resource at this address.
    pub fn no_such_address() -> Self {
        Self::new(StatusCode::NOT_FOUND, "not-found", "Not found", "There is nothing at this address.")
            .remedy("The addresses are listed at /docs.")
    }

    /// There is no such job, or it belongs to another owner: the answer is the same.
    pub fn no_such_job() -> Self {
        Self::new(StatusCode::NOT_FOUND, "job-not-found", "Job not found", "There is no job with this id.")
    }

    /// There is no such mesh, or it belongs to another owner.
    pub fn no_such_mesh() -> Self {
        Self::new(StatusCode::NOT_FOUND, "mesh-not-found", "Mesh not found", "There is no mesh with this id.")
            .remedy("Upload it to /v1/meshes; its id is in the answer.")
    }

    /// A waiting or running job names the mesh.
    pub fn mesh_in_use(job: JobId) -> Self {
        let detail = format!("The job {job}, which has not ended, names this mesh.");
        Self::new(StatusCode::CONFLICT, "mesh-in-use", "Mesh in use", detail)
            .remedy("Wait for the job to end, or cancel it, then delete the mesh.")
    }

    /// A mesh of the document was deleted while it was validated.
    pub fn mesh_gone(id: &str) -> Self {
        let gone = scene::Problem::error(
            "mesh_not_found",
            &Pointer::root(),
            format!("the mesh {id} was deleted while the document was validated"),
        );
        Self::invalid_scene("document", gone.remedy("upload it to /v1/meshes again").alone())
    }

    /// The library has no such set; `nearest` says which there are.
    pub fn no_such_material(nearest: &str) -> Self {
        let (title, detail) = ("Material not found", "The library has no set of this name.");
        Self::new(StatusCode::NOT_FOUND, "material-not-found", title, detail)
            .remedy(format!("All are at /v1/materials; {nearest}"))
    }

    /// The address exists, but not for this method.
    pub fn method_not_allowed() -> Self {
        let detail = "This address does not accept this method; the header Allow lists those that it does.";
        Self::new(StatusCode::METHOD_NOT_ALLOWED, "method-not-allowed", "Method not allowed", detail)
    }

    /// The body exceeds the limit of this service.
    pub fn too_large(limit: u64) -> Self {
        let detail = format!("The body is larger than {limit} bytes.");
        Self::new(StatusCode::PAYLOAD_TOO_LARGE, "body-too-large", "Body too large", detail)
            .remedy(
                "Upload meshes to /v1/meshes and name them by id; or ask the operator for a larger limit.",
            )
            // The rest of the body is not read, so the connection cannot be reused.
            .header(header::CONNECTION, HeaderValue::from_static("close"))
    }

    /// The body was not received in time.
    pub fn too_slow() -> Self {
        let detail = "The body did not arrive in time.";
        Self::new(StatusCode::REQUEST_TIMEOUT, "body-too-slow", "Body too slow", detail)
            .header(header::CONNECTION, HeaderValue::from_static("close"))
    }

    /// The body was interrupted.
    pub fn broken_body() -> Self {
        Self::new(
            StatusCode::BAD_REQUEST,
            "body-broken",
            "Body broken",
            "The body could not be read completely.",
        )
    }

    /// The body has another declared media type.
    pub fn unsupported_media_type(expected: &str) -> Self {
        let detail = format!("The body must be {expected}.");
        Self::new(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "unsupported-media-type",
            "Unsupported media type",
            detail,
        )
        .remedy(format!("Send the header `Content-Type: {expected}`."))
    }

    /// The body is invalid JSON.
    pub fn bad_json(error: &serde_json::Error) -> Self {
        let mut problem = Self::not_json(error.to_string());
        problem.body.line = Some(error.line());
        problem.body.column = Some(error.column());
        problem
    }

    /// The body is no JSON that can be used, as whoever parsed it says.
    pub fn not_json(detail: String) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "bad-json", "Not JSON", detail)
    }

    /// A query parameter is invalid.
    pub fn bad_parameter(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "bad-parameter", "Bad parameter", detail)
    }

    /// A header is invalid.
    pub fn bad_header(name: &str, expected: &str) -> Self {
        let detail = format!("The header {name} has to be {expected}.");
        Self::new(StatusCode::BAD_REQUEST, "bad-header", "Bad header", detail)
    }

    /// Missing or unknown bearer token.
    pub fn unauthorized() -> Self {
        let detail = "This service requires a valid bearer token.";
        Self::new(StatusCode::UNAUTHORIZED, "unauthorized", "Unauthorized", detail)
            .remedy("Send the header `Authorization: Bearer …`.")
            .header(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"))
    }

    /// A token whose last day is over.
    pub fn expired_token() -> Self {
        Self::new(StatusCode::UNAUTHORIZED, "expired-token", "Expired token", "This token has expired.")
            .remedy("Ask the operator for a new one (`contuse token`).")
            .header(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer error=\"invalid_token\""))
    }

    /// A token that does not allow a request.
    pub fn beyond_scope(scope: Scope, needed: Scope) -> Self {
        let (scope, needed) = (scope.as_str(), needed.as_str());
        let detail = format!("The scope of this token is `{scope}`, and the request needs `{needed}`.");
        Self::new(StatusCode::FORBIDDEN, "beyond-scope", "Beyond the scope of the token", detail)
            .remedy("Use another token, or ask the operator for one (`contuse token --scope`).")
            .header(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer error=\"insufficient_scope\""))
    }

    /// Wrong tokens again and again from one address.
    pub fn too_many_wrong_tokens(wait_s: u64) -> Self {
        Self::new(
            StatusCode::TOO_MANY_REQUESTS,
            "too-many-wrong-tokens",
            "Too many wrong tokens",
            "Too many requests with a wrong token came from this address.",
        )
        .remedy("Send the right token; wrong ones are refused until the time in Retry-After is over.")
        .header(header::RETRY_AFTER, wait_s.into())
    }

    /// The service is reached under a name that is not its own.
    pub fn foreign_host() -> Self {
        let detail = "A service without tokens answers under its own names only.";
        Self::new(StatusCode::MISDIRECTED_REQUEST, "foreign-host", "Foreign host", detail)
            .remedy("Use localhost or 127.0.0.1; the operator can add a name with --host, or require tokens.")
    }

    /// A request of a web page of another origin.
    pub fn cross_origin() -> Self {
        let detail = "A web page of another origin may neither read nor change anything here.";
        Self::new(StatusCode::FORBIDDEN, "cross-origin", "Cross-origin request", detail)
            .remedy("The operator can allow the origin with --cors-origin.")
    }

    /// The document cannot run: `what` is a scene, or contains one.
    pub fn invalid_scene(what: &str, errors: Problems) -> Self {
        let count = errors.error_count();
        let detail = match errors.omitted_errors() {
            0 => format!("The {what} has {count} error(s); every one is listed with its place."),
            more => format!(
                "The {what} has {count} error(s); the first {} are listed with their places, {more} more are not.",
                count - more
            ),
        };
        let mut problem =
            Self::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-scene", "Invalid scene", detail);
        problem.body.errors = errors.0;
        problem
    }

    /// The key belongs to an earlier request with another body or address.
    pub fn idempotency_key_reused() -> Self {
        let detail =
            "This Idempotency-Key belongs to an earlier request with another body or to another address.";
        Self::new(StatusCode::CONFLICT, "idempotency-key-reused", "Idempotency-Key reused", detail)
            .remedy("Use a new key for a new request.")
    }

    /// The job had ended before it could be cancelled.
    pub fn too_late_to_cancel(state: JobState) -> Self {
        let detail = format!("The job has ended already ({}).", state.as_str());
        Self::new(StatusCode::CONFLICT, "job-ended", "Job ended", detail)
    }

    /// The requested result is not yet available.
    pub fn not_yet(what: &str, state: JobState) -> Self {
        let detail = format!("The job is {}: it has no {what} yet.", state.as_str());
        Self::new(StatusCode::CONFLICT, "not-yet", "Not yet", detail)
            .remedy("Follow /v1/jobs/{id}/events to its end, then ask again.")
            .header(header::RETRY_AFTER, HeaderValue::from_static("1"))
    }

    /// The job ended without the requested result.
    pub fn never(what: &str, state: JobState) -> Self {
        let detail = format!("The job has ended ({}) and left no {what}.", state.as_str());
        Self::new(StatusCode::NOT_FOUND, "not-left", "Nothing left", detail)
            .remedy("The job says why at /v1/jobs/{id}.")
    }

    /// The recording of the job has no fields.
    pub fn no_fields() -> Self {
        let detail = "The recording of the job has no fields: its scene requested none.";
        Self::new(StatusCode::NOT_FOUND, "no-fields", "No fields", detail)
            .remedy("Name some in `record.fields` of the scene, and submit it again.")
    }

    /// The job is of a kind that has no plan.
    pub fn no_plan(purpose: &str) -> Self {
        let detail = format!("The job {purpose}: it has no scene of its own, and so no plan.");
        Self::new(StatusCode::NOT_FOUND, "no-plan", "No plan", detail)
            .remedy("Send the scene to /v1/jobs/validate, which answers with its plan.")
    }

    /// The recording of the job was removed from the disk or truncated.
    pub fn recording_lost() -> Self {
        let detail = "The recording of this job was removed or damaged in the data folder of the service.";
        Self::new(StatusCode::GONE, "recording-lost", "Recording lost", detail).remedy(
            "Its summary is still at /v1/jobs/{id}/summary; submit the scene again for a new recording.",
        )
    }

    /// The snapshot is no longer kept.
    pub fn snapshot_gone() -> Self {
        let detail = "This snapshot is not kept: only the last few are, and only while the job runs.";
        Self::new(StatusCode::GONE, "snapshot-gone", "Snapshot gone", detail)
            .remedy("Ask without `snapshot` for the latest one, or for the final recording.")
    }

    /// The range contains no byte of the file.
    pub fn range_not_satisfiable(length: u64) -> Self {
        let detail = format!("The recording has {length} bytes; the range has none of them.");
        let problem = Self::new(
            StatusCode::RANGE_NOT_SATISFIABLE,
            "range-not-satisfiable",
            "Range not satisfiable",
            detail,
        );
        match HeaderValue::try_from(format!("bytes */{length}")) {
            Ok(value) => problem.header(header::CONTENT_RANGE, value),
            Err(_) => problem,
        }
    }

    /// The recording differs from the one that the client has.
    pub fn precondition_failed() -> Self {
        let detail = "The recording is not the one that If-Match names.";
        Self::new(StatusCode::PRECONDITION_FAILED, "precondition-failed", "Precondition failed", detail)
    }

    /// The service is shutting down or overloaded.
    pub fn unavailable(detail: &str) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "unavailable", "Unavailable", detail)
            .remedy("Try again later.")
            .header(header::RETRY_AFTER, HeaderValue::from_static("5"))
    }

    /// Too much work of its kind waits already; `wait_s` is the time after which to try again.
    pub(super) fn busy(detail: impl Into<String>, wait_s: u64) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "busy", "Busy", detail)
            .remedy("Send it again after the time in Retry-After.")
            .header(header::RETRY_AFTER, wait_s.into())
    }

    /// An upload is no mesh: why.
    pub(super) fn invalid_mesh(why: String) -> Self {
        let formats = MeshFormat::extensions_in_words();
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-mesh", "Invalid mesh", why).remedy(format!(
            "Send a complete file of solid cells, of labels or of a closed surface: {formats}."
        ))
    }

    /// The client asks for more than one client may.
    fn too_many(detail: impl Into<String>, wait_s: u64) -> Self {
        Self::new(StatusCode::TOO_MANY_REQUESTS, "too-many-requests", "Too many requests", detail)
            .remedy("Wait for the answers to earlier requests, at least for the time in Retry-After.")
            .header(header::RETRY_AFTER, wait_s.into())
    }

    /// The owner keeps as much as one may.
    fn quota_used(most: u64, what: &str) -> Self {
        let detail =
            format!("With this, you would keep more than the {most} {what} that one owner may keep.");
        Self::new(StatusCode::FORBIDDEN, "quota-used", "Quota used", detail).remedy(
            "Delete jobs or meshes that are not needed any more, or ask the operator for a larger quota.",
        )
    }

    /// The bodies of other requests take all the memory for them.
    pub fn no_memory() -> Self {
        Self::busy("Documents and answers of others take all the memory for them.", PERMIT_WAIT_S)
            .header(header::CONNECTION, HeaderValue::from_static("close"))
    }

    /// The other bodies of the client take all the memory for those of one client.
    pub fn no_memory_of_client() -> Self {
        let detail = "Your other documents and answers take all the memory for those of one client.";
        Self::too_many(detail, PERMIT_WAIT_S).header(header::CONNECTION, HeaderValue::from_static("close"))
    }

    /// An owner asks more often than one may.
    pub fn too_many_requests(wait_s: u64) -> Self {
        Self::too_many("You send requests more often than one owner may.", wait_s)
    }

    /// The service has no space for this.
    fn storage_full(error: &JobsError, detail: impl Into<String>) -> Self {
        tracing::error!(%error, "too little space is left");
        Self::new(StatusCode::INSUFFICIENT_STORAGE, "storage-full", "Storage full", detail)
            .remedy("Delete jobs or meshes that are not needed any more; or ask the operator for more space, and try again later.")
            .header(header::RETRY_AFTER, HeaderValue::from_static("60"))
    }

    /// Internal error. Details are in the log, under the identifier in the answer.
    pub fn internal(error: &dyn std::fmt::Display) -> Self {
        let instance = uuid::Uuid::new_v4().urn().to_string();
        tracing::error!(instance, %error, "internal error");
        let detail = "An internal error of the service; its log has details under the id of this instance.";
        let mut problem = Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", "Internal error", detail);
        problem.body.instance = Some(instance);
        problem
    }
}

impl From<JobsError> for Problem {
    fn from(error: JobsError) -> Self {
        match error {
            JobsError::Blob(BlobError::TooLarge { most }) => Self::too_large(most),
            JobsError::QueueFull { waiting } => Self::unavailable(&format!("{waiting} jobs wait already.")),
            JobsError::OwnerWaits { waiting } => {
                Self::too_many(format!("{waiting} jobs of this owner wait already."), QUEUE_WAIT_S)
            }
            JobsError::OwnerKeeps { most, what } => Self::quota_used(most, what),
            JobsError::OwnerUploads { under_way, most } => Self::too_many(
                format!("With {under_way} bytes of uploads under way you would keep more than {most}."),
                PERMIT_WAIT_S,
            ),
            short @ (JobsError::NoRoom { .. } | JobsError::DiskShort { .. }) => {
                Self::storage_full(&short, format!("The service cannot store this: {short}."))
            }
            full if full.is_storage_full() => {
                Self::storage_full(&full, "The service has no space left to store this.")
            }
            scarce if scarce.is_out_of_descriptors() => {
                tracing::error!(error = %scarce, "no descriptor is left");
                Self::busy("The service has reached its limit of open files.", PERMIT_WAIT_S)
            }
            passing if passing.is_passing() => {
                tracing::error!(error = %passing, "the store does not answer");
                Self::unavailable("The storage of the service does not answer.")
            }
            other => Self::internal(&other),
        }
    }
}

impl From<Refusal> for Problem {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Full { waiting } => {
                Self::busy(format!("{waiting} validations wait already."), VALIDATION_WAIT_S)
            }
            Refusal::OwnerLimit { waiting } => {
                let detail = format!("{waiting} validations of this token are already waiting.");
                Self::too_many(detail, VALIDATION_WAIT_S)
            }
            Refusal::TooLong { waited } => {
                let waited_s = waited.as_secs_f64();
                Self::busy(format!("No validation could begin within {waited_s} s."), VALIDATION_WAIT_S)
            }
        }
    }
}

impl From<NoPermit> for Problem {
    fn from(no_permit: NoPermit) -> Self {
        let problem = match no_permit {
            NoPermit::Taken { most } => Self::busy(
                format!("{most} requests of this kind are in progress, which is the limit."),
                PERMIT_WAIT_S,
            ),
            NoPermit::OfClient { most } => Self::too_many(
                format!("{most} of your requests of this kind are in progress, the limit of one client."),
                PERMIT_WAIT_S,
            ),
        };
        // The body of the request is not read, so the connection cannot be reused.
        problem.header(header::CONNECTION, HeaderValue::from_static("close"))
    }
}

/// The answer to a connection beyond the limits.
pub fn no_connection(refused: NoPermit) -> Response {
    let problem = match refused {
        NoPermit::Taken { most } => {
            Problem::busy(format!("{most} connections are open, which is the limit."), PERMIT_WAIT_S)
        }
        NoPermit::OfClient { most } => Problem::busy(
            format!("{most} connections from your address are open, which is the limit per address."),
            PERMIT_WAIT_S,
        ),
    };
    problem.into_response()
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let body = serde_json::to_vec(&self.body).unwrap_or_default();
        let mut response = (self.status, body).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        headers.extend(self.headers);
        response
    }
}
