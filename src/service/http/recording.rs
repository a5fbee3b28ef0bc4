//! `/v1/jobs/{id}/recording`: the MCAP file, whole or in part.

use super::App;
use super::extract::{JobPath, Owner, Parameters};
use super::problem::{Problem, ProblemBody};
use super::range::{Wanted, wanted};
use crate::service::jobs::JobsError;
use crate::service::jobs::recordings::FileDigest;
use crate::service::jobs::snapshots::Which;
use crate::service::jobs::store::JobRow;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use futures::Stream;
use serde::Deserialize;
use std::io::SeekFrom;
use std::path::PathBuf;
use std::sync::Arc;
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncSeekExt};
use utoipa::IntoParams;

/// Digest of the whole file, whatever part is sent (RFC 9530).
pub const REPR_DIGEST: HeaderName = HeaderName::from_static("repr-digest");
/// Bytes read from the file at a time.
const PIECE: usize = 256 << 10;

/// Which recording is wanted.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct RecordingParameters {
    /// Number of a snapshot of a job that runs, as its `Content-Location` says.
    snapshot: Option<u32>,
}

/// Download the recording.
///
/// The file never changes: `ETag` is its SHA-256. One range at a time; several are answered with the whole file. While the
/// job runs this is a snapshot, a whole file of its own; a download in parts names it by `If-Range` or by the address in
/// `Content-Location`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/recording", tag = "jobs", operation_id = "get_recording",
    params(("id" = uuid::Uuid, Path), RecordingParameters,
        ("Range" = Option<String>, Header, description = "`bytes=…`"),
        ("If-Range" = Option<String>, Header, description = "The range only if the file has this ETag, else the whole"),
        ("If-None-Match" = Option<String>, Header, description = "Only if the file has none of these ETags")),
    responses(
        (status = 200, description = "The whole file", body = Vec<u8>, content_type = "application/octet-stream", headers(
            ("ETag" = String), ("Accept-Ranges" = String), ("Content-Length" = u64), ("Content-Disposition" = String),
            ("Repr-Digest" = String, description = "Of a final recording"),
            ("Content-Location" = String, description = "Of a snapshot"))),
        (status = 206, description = "A part of it", body = Vec<u8>, content_type = "application/octet-stream", headers(
            ("Content-Range" = String))),
        (status = 304, description = "The client has it"),
        (status = 404, description = "No such job, or it left no recording", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Nothing is recorded yet", body = ProblemBody, content_type = "application/problem+json"),
        (status = 410, description = "The snapshot is not kept any more, or the recording was removed from the disk", body = ProblemBody, content_type = "application/problem+json"),
        (status = 412, description = "It is another file than the client has", body = ProblemBody, content_type = "application/problem+json"),
        (status = 416, description = "No byte of the range exists", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn download(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
    Parameters(parameters): Parameters<RecordingParameters>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let row = app.queue.store.job(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    let file = match (parameters.snapshot, row.state.is_final()) {
        (None, true) => final_file(&app, &row)?,
        (Some(_), true) => return Err(Problem::snapshot_gone()),
        (Some(number), false) => {
            snapshot_file(&app, &row, Which::Number(number)).await?.ok_or_else(Problem::snapshot_gone)?
        }
        (None, false) => match snapshot_file(&app, &row, which(&headers)).await? {
            Some(file) => file,
            None => ended_meanwhile(&app, &owner, &row).await?,
        },
    };
    send(&file, &method, &headers).await
}

/// A file that can be sent: it never changes under this digest.
struct Sendable {
    path: PathBuf,
    digest: FileDigest,
    /// What a client may call it.
    name: String,
    /// Address of a snapshot; `None` for a final recording.
    snapshot: Option<String>,
}

/// The recording of a job that has ended.
fn final_file(app: &App, row: &JobRow) -> Result<Sendable, Problem> {
    let recording = row.recording.clone().ok_or_else(|| Problem::never("recording", row.state))?;
    Ok(Sendable {
        path: app.queue.folder.recording(row.id),
        digest: FileDigest { bytes: recording.bytes, sha256: recording.sha256 },
        name: format!("{}-{}.mcap", file_name(&row.name), row.id),
        snapshot: None,
    })
}

/// What can be seen of the recording of a job that runs. Copied on a thread that may wait for the disk.
async fn snapshot_file(app: &Arc<App>, row: &JobRow, which: Which) -> Result<Option<Sendable>, Problem> {
    let (queue, id) = (Arc::clone(&app.queue), row.id);
    let looking = tokio::task::spawn_blocking(move || queue.snapshot(id, &which));
    let snapshot = looking.await.map_err(|e| Problem::internal(&e))??;
    Ok(snapshot.map(|s| Sendable {
        path: s.path,
        digest: s.digest,
        name: format!("{}-{}-snapshot-{}.mcap", file_name(&row.name), row.id, s.number),
        snapshot: Some(format!("/v1/jobs/{}/recording?snapshot={}", row.id, s.number)),
    }))
}

/// The snapshot that a client has parts of, if it says so.
fn which(headers: &HeaderMap) -> Which {
    let tag = [header::IF_RANGE, header::IF_MATCH].iter().find_map(|name| headers.get(name)?.to_str().ok());
    tag.map_or(Which::Latest, |tag| Which::OfDigest(tag.trim().trim_matches('"').to_owned()))
}

/// The final recording of a job that ended between the look into the store and the look for a snapshot.
async fn ended_meanwhile(app: &App, owner: &str, row: &JobRow) -> Result<Sendable, Problem> {
    let row_now = app.queue.store.job(owner, row.id).await?.ok_or_else(Problem::no_such_job)?;
    if row_now.state.is_final() {
        final_file(app, &row_now)
    } else {
        Err(Problem::not_yet("recording", row_now.state))
    }
}

/// The whole file, a part of it, or only what is said of it.
async fn send(file: &Sendable, method: &Method, headers: &HeaderMap) -> Result<Response, Problem> {
    let bytes = file.digest.bytes;
    let etag = format!("\"{}\"", file.digest.sha256);
    let mut response = match wanted(method, headers, &etag, bytes) {
        Wanted::NotModified => StatusCode::NOT_MODIFIED.into_response(),
        Wanted::PreconditionFailed => return Err(Problem::precondition_failed()),
        Wanted::Unsatisfiable => return Err(Problem::range_not_satisfiable(bytes)),
        Wanted::Whole => {
            let body = body(file, 0, bytes, method).await?;
            (StatusCode::OK, [(header::CONTENT_LENGTH, bytes)], body).into_response()
        }
        Wanted::Part { first, last } => {
            let length = last - first + 1;
            let body = body(file, first, length, method).await?;
            let content_range = format!("bytes {first}-{last}/{bytes}");
            let part = [(header::CONTENT_LENGTH, length.to_string()), (header::CONTENT_RANGE, content_range)];
            (StatusCode::PARTIAL_CONTENT, part, body).into_response()
        }
    };
    describe(response.headers_mut(), file, &etag)?;
    Ok(response)
}

/// What is said of a file with every answer.
fn describe(headers: &mut HeaderMap, file: &Sendable, etag: &str) -> Result<(), Problem> {
    let value = |text: &str| HeaderValue::try_from(text).map_err(|e| Problem::internal(&e));
    headers.insert(header::ETAG, value(etag)?);
    headers.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
    headers.insert(header::CONTENT_DISPOSITION, value(&format!("attachment; filename=\"{}\"", file.name))?);
    // Private: it belongs to a token. A file never changes, but it may be deleted, or followed by a newer one.
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-cache"));
    if let Some(address) = &file.snapshot {
        headers.insert(header::CONTENT_LOCATION, value(address)?);
    } else {
        let digest = BASE64_STANDARD.encode(raw_digest(&file.digest.sha256));
        headers.insert(REPR_DIGEST, value(&format!("sha-256=:{digest}:"))?);
    }
    Ok(())
}

/// The bytes of hexadecimal digits.
fn raw_digest(hexadecimal: &str) -> Vec<u8> {
    let digit = |c: u8| char::from(c).to_digit(16).unwrap_or(0) as u8;
    hexadecimal
        .as_bytes()
        .chunks(2)
        .map(|pair| pair.iter().fold(0, |byte, c| (byte << 4) | digit(*c)))
        .collect()
}

/// A name that every system takes as that of a file.
fn file_name(scene: &str) -> String {
    let kept: String = scene
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' })
        .take(60)
        .collect();
    let trimmed = kept.trim_matches('-');
    if trimmed.is_empty() { "contuse".to_owned() } else { trimmed.to_owned() }
}

/// `length` bytes of a file from `first` on; nothing when only the head is asked for.
async fn body(file: &Sendable, first: u64, length: u64, method: &Method) -> Result<Body, Problem> {
    let opened = async {
        let mut opened = File::open(&file.path).await?;
        let bytes = opened.metadata().await?.len();
        opened.seek(SeekFrom::Start(first)).await?;
        Ok((opened, bytes))
    };
    match opened.await {
        Ok((_, bytes)) if bytes != file.digest.bytes => Err(lost(file)),
        Ok(_) if *method == Method::HEAD => Ok(Body::empty()),
        Ok((opened, _)) => Ok(Body::from_stream(pieces(opened, length))),
        Err(error) if std::io::Error::kind(&error) == std::io::ErrorKind::NotFound => Err(lost(file)),
        Err(error) => Err(JobsError::file(&file.path, error).into()),
    }
}

/// What is not there, or not as it was kept: a snapshot went with its run, a recording somebody removed.
fn lost(file: &Sendable) -> Problem {
    if file.snapshot.is_some() { Problem::snapshot_gone() } else { Problem::recording_lost() }
}

/// The next `left` bytes of a file, in pieces. A file that is deleted meanwhile can still be read to its end.
fn pieces(file: File, left: u64) -> impl Stream<Item = std::io::Result<Bytes>> {
    futures::stream::try_unfold((file, left), |(mut file, left)| async move {
        if left == 0 {
            return Ok(None);
        }
        let mut piece = vec![0; PIECE.min(usize::try_from(left).unwrap_or(PIECE))];
        let n = file.read(&mut piece).await?;
        if n == 0 {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        piece.truncate(n);
        Ok(Some((Bytes::from(piece), (file, left - n as u64))))
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
