//! `/v1/jobs/{id}/export.vtu.tar`: the fields of a job's recording for ParaView, made while they are sent.

use super::app::App;
use super::exports::{NoRecording, recorded_row};
use super::extract::{self, JobPath, Owner};
use super::problem::Problem;
use super::recording::file_name;
use crate::blobs::Blob;
use crate::record::RecordError;
use crate::record::vtk::Archive;
use crate::report::ReadError;
use crate::report::fields::write_series;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use futures::stream::{self, StreamExt as _};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// Bytes of the archive in a piece.
const PIECE: usize = 64 << 10;
/// Pieces that wait for the client; beyond them the work waits.
const PIECES_AHEAD: usize = 2;

/// A piece of the archive, or why it ends here.
type Piece = Result<Bytes, ReadError>;

/// Get the fields of a job for ParaView and PyVista: an archive (tar) of a `.pvd` file and its folder of `.vtu` files.
///
/// The archive is made while it is sent, so it has no length in advance; one that lacks its end is not whole.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/export.vtu.tar", tag = "jobs", operation_id = "get_fields", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "The archive", body = Vec<u8>, content_type = "application/x-tar", headers(("Content-Disposition" = String))),
        NoRecording,
    )
)]
pub async fn archive(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
    extract::Sender(client): extract::Sender,
) -> Result<Response, Problem> {
    let permit = app.permits.downloads.take(client)?;
    let row = recorded_row(&app, &owner, id, "fields").await?;
    let (blob, name) = (row.recording_name(), file_name(&row.name));
    let opened = app.queue.with_files({
        let blob = blob.clone();
        move |queue| Ok(queue.blobs.open(&blob)?)
    });
    let opened = app.queue.unless_silent(opened).await??.ok_or_else(Problem::recording_lost)?;
    let (sender, mut receiver) = channel(PIECES_AHEAD);
    let disposition = format!("attachment; filename=\"{name}-{id}.tar\"");
    let work = move || write(opened, Path::new(&blob), &name, &sender);
    let exports = app.exports.clone();
    // It ends with the archive, or with the client.
    tokio::spawn(async move { exports.call(work).await });
    // The first piece decides between an archive and a problem.
    let first = receiver.recv().await.ok_or_else(|| Problem::internal(&"the export has stopped"))?;
    let first = first.map_err(|error| problem(&error))?;
    let headers =
        [(header::CONTENT_TYPE, "application/x-tar".to_owned()), (header::CONTENT_DISPOSITION, disposition)];
    let pieces = pieces(first, receiver).map(move |piece| {
        let _permit = &permit;
        piece
    });
    Ok((headers, Body::from_stream(pieces)).into_response())
}

/// Writes the archive to a client.
fn write(recording: Box<dyn Blob>, blob: &Path, name: &str, sender: &Sender<Piece>) {
    let out = BufWriter::with_capacity(PIECE, Pipe(sender.clone()));
    let Err(error) = write_series(recording, blob, Archive::new(out, name)) else { return };
    if !sender.is_closed() {
        tracing::error!(blob = %blob.display(), %error, "the fields of a recording cannot be exported");
        // A client that left meanwhile needs no reason.
        let _ = sender.blocking_send(Err(error));
    }
}

fn problem(error: &ReadError) -> Problem {
    match error {
        ReadError::Fields(RecordError::NoFields) => Problem::no_fields(),
        _ => Problem::recording_lost(),
    }
}

/// The pieces of a stream, of which the first has been received.
fn pieces(first: Bytes, rest: Receiver<Piece>) -> impl stream::Stream<Item = io::Result<Bytes>> {
    let rest = stream::unfold(rest, |mut rest| async move { Some((rest.recv().await?, rest)) });
    stream::iter([Ok(first)]).chain(rest.map(|piece| piece.map_err(io::Error::other)))
}

/// The end of a channel at which pieces are written; writing waits for the other end.
struct Pipe(Sender<Piece>);

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let bytes = &bytes[..bytes.len().min(PIECE)];
        let piece = Bytes::copy_from_slice(bytes);
        self.0.blocking_send(Ok(piece)).map_err(|_| io::ErrorKind::BrokenPipe)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
