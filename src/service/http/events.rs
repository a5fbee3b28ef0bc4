//! `/v1/jobs/{id}/events`: what happens to a job, as server-sent events.
//!
//! Events are read from the store and not from memory: a stream that broke off goes on after `Last-Event-ID`, also with
//! another process. The bell only says when to look again.

use super::App;
use super::extract::{JobPath, Owner};
use super::problem::{Problem, ProblemBody};
use crate::service::jobs::store::EventRow;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::Stream;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::watch;

/// Events read from the store at a time.
const BATCH: u32 = 100;

/// Follow a job.
///
/// Events `queued`, `running`, `progress`, `requeued`, and last `succeeded`, `failed` or `cancelled`; each has an id and
/// JSON data. A what-if question also has a `case` for every case (its `index`, how many there are `of`, its numbers), in the
/// order of the cases; `error_bars` once, where those of the base are for all cases; and a `limit` for every limit asked for.
/// After `requeued` the work begins anew, and so do the cases: the later `case` of an index replaces the earlier one, and its
/// numbers are the same. The stream ends after the last one. A client that comes back with `Last-Event-ID` hears what it missed;
/// when nothing is left the answer is 204, which tells a browser to stop asking.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", tag = "jobs", operation_id = "follow_job",
    params(("id" = uuid::Uuid, Path), ("Last-Event-ID" = Option<i64>, Header, description = "The last event that was heard")),
    responses(
        (status = 200, description = "The stream", body = String, content_type = "text/event-stream"),
        (status = 204, description = "The job has ended and nothing is left to hear"),
        (status = 400, description = "Last-Event-ID is no number", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "No such job", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn follow(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    // Listening begins before the first look, so that nothing falls between.
    let bell = app.queue.listen();
    let row = app.queue.store.job(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    let last = last_event_id(&headers)?;
    let (events, ended) = app.queue.store.events_after(row.seq, last, BATCH).await?;
    if events.is_empty() && ended {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let closing = app.queue.closing();
    let heartbeat = KeepAlive::new().interval(app.config.heartbeat).text("still here");
    let has_more = events.len() == BATCH as usize;
    let listener =
        Listener { app, seq: row.seq, last, unsent: events.into(), has_more, ended, bell, closing };
    let stream = Sse::new(listener.into_stream()).keep_alive(heartbeat);
    // Proxies would hold the stream back until it ends.
    Ok(([(header::CACHE_CONTROL, "no-store"), (X_ACCEL_BUFFERING, "no")], stream).into_response())
}

const X_ACCEL_BUFFERING: header::HeaderName = header::HeaderName::from_static("x-accel-buffering");

/// One who follows a job.
struct Listener {
    app: Arc<App>,
    seq: i64,
    last: i64,
    unsent: VecDeque<EventRow>,
    /// Whether the store may hold more than was read.
    has_more: bool,
    ended: bool,
    bell: Receiver<i64>,
    closing: watch::Receiver<bool>,
}

impl Listener {
    fn into_stream(self) -> impl Stream<Item = Result<Event, Infallible>> {
        futures::stream::unfold(self, |mut listener| async move {
            let event = listener.next().await?;
            Some((Ok(event), listener))
        })
    }

    /// The next event; `None` when the job has ended or is gone, and when the service shuts down (the client comes back
    /// to the next process with the last id that it heard).
    async fn next(&mut self) -> Option<Event> {
        loop {
            if let Some(row) = self.unsent.pop_front() {
                self.last = row.n;
                return Some(Event::default().id(row.n.to_string()).event(row.kind).data(row.data));
            }
            if self.ended || !self.wait().await {
                return None;
            }
            match self.app.queue.store.events_after(self.seq, self.last, BATCH).await {
                Ok((events, ended)) => {
                    self.has_more = events.len() == BATCH as usize;
                    self.unsent.extend(events);
                    self.ended = ended;
                }
                Err(error) => {
                    tracing::error!(%error, "cannot read events");
                    return None;
                }
            }
        }
    }

    /// Waits until something happened to the job; false when the service shuts down.
    async fn wait(&mut self) -> bool {
        if std::mem::take(&mut self.has_more) {
            return true;
        }
        loop {
            tokio::select! {
                rung = self.bell.recv() => match rung {
                    Ok(seq) if seq == self.seq => return true,
                    Ok(_) => {}
                    // It rang so often that some were missed: one may have been for this job.
                    Err(RecvError::Lagged(_)) => return true,
                    Err(RecvError::Closed) => return false,
                },
                changed = self.closing.wait_for(|closing| *closing) => {
                    let _ = changed;
                    return false;
                }
            }
        }
    }
}

/// The event after which the client wants to hear; 0 for all.
fn last_event_id(headers: &HeaderMap) -> Result<i64, Problem> {
    let Some(value) = headers.get("last-event-id") else { return Ok(0) };
    let number = value.to_str().ok().and_then(|text| text.trim().parse().ok()).filter(|n| *n >= 0);
    number.ok_or_else(|| Problem::bad_header("Last-Event-ID", "the id of an event of this stream"))
}
