//! `/v1/jobs/{id}/recording`: the MCAP file, in full or in part.

use super::app::App;
use super::extract::{JobPath, Owner, Parameters, Sender};
use super::problem::{Problem, ProblemBody};
use super::range::{Wanted, wanted};
use crate::blobs::{Blob, BlobDigest};
use crate::service::jobs::JobsError;
use crate::service::jobs::queue::Queue;
use crate::service::jobs::snapshots::Which;
use crate::service::jobs::store::Job;
use crate::service::permits::RequestPermit;
use crate::service::shelves::snapshot_name;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use futures::{Stream, StreamExt as _};
use serde::Deserialize;
use std::io::{self, SeekFrom};
use std::sync::Arc;
use utoipa::IntoParams;

/// Digest of the whole file, regardless of the part that is sent (RFC 9530).
pub const REPR_DIGEST: HeaderName = HeaderName::from_static("repr-digest");
/// Bytes read from the file at a time.
const PIECE: usize = 64 << 10;

/// Query parameters that select a recording.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct RecordingParameters {
    /// Number of a snapshot of a running job, from its `Content-Location`.
    snapshot: Option<u32>,
    /// Whether the answer is 204 in place of 409 while nothing is recorded yet; false by default.
    if_any: Option<bool>,
}

/// Download the recording.
///
/// The file is immutable: its `ETag` is its SHA-256. One range per request; requests for several receive the whole
/// file. While the job is running this is a snapshot, a complete file of its own; partial downloads identify it by
/// `If-Range` or by the address in `Content-Location`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/recording", tag = "jobs", operation_id = "get_recording",
    params(("id" = uuid::Uuid, Path), RecordingParameters,
        ("Range" = Option<String>, Header, description = "Range of bytes: `bytes=first-last`"),
        ("If-Range" = Option<String>, Header, description = "The range only if the file has this ETag, otherwise the whole file"),
        ("If-None-Match" = Option<String>, Header, description = "Only if the file has none of these ETags")),
    responses(
        (status = 200, description = "The whole file; of a running job, the snapshot so far", body = Vec<u8>, content_type = "application/octet-stream", headers(
            ("ETag" = String), ("Accept-Ranges" = String), ("Content-Length" = u64), ("Content-Disposition" = String),
            ("Repr-Digest" = String, description = "SHA-256 of a final recording"),
            ("Content-Location" = String, description = "Address of this snapshot, while the job runs"))),
        (status = 204, description = "Nothing is recorded yet, and `if_any` asks for this answer"),
        (status = 206, description = "A part of it", body = Vec<u8>, content_type = "application/octet-stream", headers(
            ("Content-Range" = String))),
        (status = 304, description = "The client has it"),
        (status = 404, description = "No such job, or it left no recording", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Nothing is recorded yet", body = ProblemBody, content_type = "application/problem+json"),
        (status = 410, description = "The snapshot is not kept any more, or the recording was removed from the disk", body = ProblemBody, content_type = "application/problem+json"),
        (status = 412, description = "The file differs from the client's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 416, description = "No byte of the range exists", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "The storage does not answer", body = ProblemBody, content_type = "application/problem+json", headers(
            ("Retry-After" = u64, description = "Seconds"))),
    )
)]
pub async fn download(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
    Parameters(parameters): Parameters<RecordingParameters>,
    Sender(sender): Sender,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let permit = app.permits.downloads.take(sender)?;
    let row = app.queue.store.job(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    let file = match (parameters.snapshot, row.state.is_final()) {
        (None, true) => final_file(&row)?,
        (Some(_), true) => return Err(Problem::snapshot_gone()),
        (Some(number), false) => {
            snapshot_file(&app, &row, Which::Number(number)).await?.ok_or_else(Problem::snapshot_gone)?
        }
        (None, false) => match snapshot_file(&app, &row, which(&headers)).await? {
            Some(file) => file,
            None => match ended_meanwhile(&app, &owner, &row).await? {
                Some(file) => file,
                None if parameters.if_any == Some(true) => return Ok(StatusCode::NO_CONTENT.into_response()),
                None => return Err(Problem::not_yet("recording", row.state)),
            },
        },
    };
    send(&app, &file, permit, &method, &headers).await
}

/// A file to send: immutable under this digest.
struct Sendable {
    /// Name of the blob.
    blob: String,
    digest: BlobDigest,
    name: String,
    /// Address of a snapshot.
    snapshot: Option<String>,
}

/// The recording of a job that has ended.
fn final_file(row: &Job) -> Result<Sendable, Problem> {
    let recording = row.recording.clone().ok_or_else(|| Problem::never("recording", row.state))?;
    Ok(Sendable {
        blob: row.recording_name(),
        digest: BlobDigest { bytes: recording.bytes, sha256: recording.sha256 },
        name: format!("{}-{}.mcap", file_name(&row.name), row.id),
        snapshot: None,
    })
}

/// Snapshot of the recording of a running job, copied on a thread that may wait for the disk.
async fn snapshot_file(app: &Arc<App>, row: &Job, which: Which) -> Result<Option<Sendable>, Problem> {
    let id = row.id;
    let snapshot = app.queue.with_files(move |queue| queue.snapshot(id, &which)).await?;
    Ok(snapshot.map(|s| {
        let address = format!("/v1/jobs/{id}/recording?snapshot={}", s.number);
        let name = format!("{}-{id}-snapshot-{}.mcap", file_name(&row.name), s.number);
        Sendable { blob: snapshot_name(id, s.number), digest: s.digest, name, snapshot: Some(address) }
    }))
}

/// The snapshot of which the client already has parts, if it says so.
fn which(headers: &HeaderMap) -> Which {
    let tag = [header::IF_RANGE, header::IF_MATCH].iter().find_map(|name| headers.get(name)?.to_str().ok());
    tag.map_or(Which::Latest, |tag| Which::OfDigest(tag.trim().trim_matches('"').to_owned()))
}

/// The final recording of a job that ended between the queries of the store and of the snapshots; `None` if it goes on.
async fn ended_meanwhile(app: &App, owner: &str, row: &Job) -> Result<Option<Sendable>, Problem> {
    let row_now = app.queue.store.job(owner, row.id).await?.ok_or_else(Problem::no_such_job)?;
    row_now.state.is_final().then(|| final_file(&row_now)).transpose()
}

/// Sends the whole file, a part of it, or only its headers.
async fn send(
    app: &App,
    file: &Sendable,
    permit: RequestPermit,
    method: &Method,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let bytes = file.digest.bytes;
    let etag = format!("\"{}\"", file.digest.sha256);
    let mut response = match wanted(method, headers, &etag, bytes) {
        Wanted::NotModified => StatusCode::NOT_MODIFIED.into_response(),
        Wanted::PreconditionFailed => return Err(Problem::precondition_failed()),
        Wanted::Unsatisfiable => return Err(Problem::range_not_satisfiable(bytes)),
        Wanted::Whole => {
            let body = body(app, file, [0, bytes], method, permit).await?;
            (StatusCode::OK, [(header::CONTENT_LENGTH, bytes)], body).into_response()
        }
        Wanted::Part { first, last } => {
            let length = last - first + 1;
            let body = body(app, file, [first, length], method, permit).await?;
            let content_range = format!("bytes {first}-{last}/{bytes}");
            let part = [(header::CONTENT_LENGTH, length.to_string()), (header::CONTENT_RANGE, content_range)];
            (StatusCode::PARTIAL_CONTENT, part, body).into_response()
        }
    };
    describe(response.headers_mut(), file, &etag)?;
    Ok(response)
}

/// Headers of a file in every answer.
fn describe(headers: &mut HeaderMap, file: &Sendable, etag: &str) -> Result<(), Problem> {
    let value = |text: &str| HeaderValue::try_from(text).map_err(|e| Problem::internal(&e));
    headers.insert(header::ETAG, value(etag)?);
    headers.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
    headers.insert(header::CONTENT_DISPOSITION, value(&format!("attachment; filename=\"{}\"", file.name))?);
    // Private: it belongs to a token. A file is immutable, but it may be deleted, or superseded by a newer one.
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-cache"));
    if let Some(address) = &file.snapshot {
        headers.insert(header::CONTENT_LOCATION, value(address)?);
    } else {
        let digest = BASE64_STANDARD.encode(raw_digest(&file.digest.sha256));
        headers.insert(REPR_DIGEST, value(&format!("sha-256=:{digest}:"))?);
    }
    Ok(())
}

fn raw_digest(hexadecimal: &str) -> Vec<u8> {
    let digit = |c: u8| char::from(c).to_digit(16).unwrap_or(0) as u8;
    hexadecimal
        .as_bytes()
        .chunks(2)
        .map(|pair| pair.iter().fold(0, |byte, c| (byte << 4) | digit(*c)))
        .collect()
}

/// A file name that is valid on every system.
pub(super) fn file_name(scene: &str) -> String {
    let kept: String = scene
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' })
        .take(60)
        .collect();
    let trimmed = kept.trim_matches('-');
    if trimmed.is_empty() { "contuse".to_owned() } else { trimmed.to_owned() }
}

/// `length` bytes of a file starting at `first`, which hold the permit until they are sent; empty for a HEAD request.
async fn body(
    app: &App,
    file: &Sendable,
    [first, length]: [u64; 2],
    method: &Method,
    permit: RequestPermit,
) -> Result<Body, Problem> {
    let name = file.blob.clone();
    let open = move |queue: &Queue| at(queue.blobs.open(&name)?, first);
    match app.queue.unless_silent(app.queue.with_files(open)).await?? {
        Some(opened) if opened.bytes != file.digest.bytes => Err(lost(file)),
        Some(_) if *method == Method::HEAD => Ok(Body::empty()),
        Some(opened) => {
            let pieces = pieces(opened.blob, length).map(move |piece| {
                let _permit = &permit;
                piece
            });
            Ok(Body::from_stream(pieces))
        }
        None => Err(lost(file)),
    }
}

/// A blob opened for reading at an offset.
struct Opened {
    blob: Box<dyn Blob>,
    bytes: u64,
}

/// Opens an existing blob for reading at `first`.
fn at(blob: Option<Box<dyn Blob>>, first: u64) -> Result<Option<Opened>, JobsError> {
    let Some(mut blob) = blob else { return Ok(None) };
    let bytes = blob.seek(SeekFrom::End(0)).and_then(|end| blob.seek(SeekFrom::Start(first)).map(|_| end));
    let bytes = bytes.map_err(|error| JobsError::file("a recording", error))?;
    Ok(Some(Opened { blob, bytes }))
}

/// Error for a missing or damaged file: a snapshot removed with its run, or a recording removed from the disk.
fn lost(file: &Sendable) -> Problem {
    if file.snapshot.is_some() { Problem::snapshot_gone() } else { Problem::recording_lost() }
}

/// The next `left` bytes of a blob in pieces, each read on a thread that may wait for the disk.
fn pieces(blob: Box<dyn Blob>, left: u64) -> impl Stream<Item = io::Result<Bytes>> {
    futures::stream::try_unfold((blob, left), |(mut blob, left)| async move {
        if left == 0 {
            return Ok(None);
        }
        let reading = tokio::task::spawn_blocking(move || {
            let mut piece = vec![0; PIECE.min(usize::try_from(left).unwrap_or(PIECE))];
            let n = blob.read(&mut piece)?;
            piece.truncate(n);
            io::Result::Ok((piece, blob))
        });
        let (piece, blob) = reading.await.map_err(io::Error::other)??;
        if piece.is_empty() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let left = left - piece.len() as u64;
        Ok(Some((Bytes::from(piece), (blob, left))))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_harmless() {
        assert_eq!(file_name("flash ball / thigh"), "flash-ball---thigh");
        assert_eq!(file_name("../../\"\r\n"), "contuse");
        assert_eq!(file_name("Schädel"), "Sch-del");
        assert_eq!(file_name(&"x".repeat(500)).len(), 60);
    }

    #[test]
    fn digest_is_that_of_the_digits() {
        assert_eq!(raw_digest("00ff1a"), [0x00, 0xff, 0x1a]);
    }
}
