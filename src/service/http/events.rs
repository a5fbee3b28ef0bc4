//! `/v1/jobs/{id}/events`: events of a job as server-sent events.
//!
//! Events are read from the store, not from memory: an interrupted stream resumes after `Last-Event-ID`, even in
//! another process. The channel only signals when to query the store again.

use super::app::App;
use super::extract::{JobPath, Owner, Sender};
use super::problem::{Problem, ProblemBody};
use crate::service::jobs::store::EventRow;
use crate::service::permits::RequestPermit;
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
/// Events `queued`, `running`, `progress`, `requeued`, and last `succeeded`, `failed` or `cancelled`; each has an id
/// and JSON data. A what-if question also has a `case` for every case (its `index`, the total number `of`, its
/// numbers), in the order of the cases; `error_bars` once, if those of the base apply to all cases; and a `limit` for
/// every requested limit. After `requeued` the work restarts, and so do the cases: the later `case` of an index
/// replaces the earlier one, with the same numbers. The stream ends after the last event. A client that reconnects with
/// `Last-Event-ID` receives what it missed; if nothing is left the answer is 204, which makes a browser stop
/// reconnecting.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", tag = "jobs", operation_id = "follow_job",
    params(("id" = uuid::Uuid, Path), ("Last-Event-ID" = Option<i64>, Header, description = "The last event received")),
    responses(
        (status = 200, description = "Events of the job as a stream of server-sent events", body = String, content_type = "text/event-stream"),
        (status = 204, description = "The job has ended and no event is left"),
        (status = 400, description = "Last-Event-ID is not a number", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "No job of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Too many event streams of this client", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Too many event streams", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn follow(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
    Sender(sender): Sender,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    // Subscribed before the first query, so that nothing is missed in between.
    let notifications = app.queue.listen();
    let row = app.queue.store.job(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    let last = last_event_id(&headers)?;
    let (events, ended) = app.queue.store.events_after(row.seq, last, BATCH).await?;
    if events.is_empty() && ended {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let permit = app.permits.streams.take(sender)?;
    let closing = app.queue.closing();
    let heartbeat = KeepAlive::new().interval(app.config.heartbeat).text("still here");
    let has_more = events.len() == BATCH as usize;
    let listener = Listener {
        app,
        seq: row.seq,
        last,
        unsent: events.into(),
        has_more,
        ended,
        notifications,
        closing,
        _permit: permit,
    };
    let stream = Sse::new(listener.into_stream()).keep_alive(heartbeat);
    // Proxies would buffer the stream until it ends.
    Ok(([(header::CACHE_CONTROL, "no-store"), (X_ACCEL_BUFFERING, "no")], stream).into_response())
}

const X_ACCEL_BUFFERING: header::HeaderName = header::HeaderName::from_static("x-accel-buffering");

/// A client that follows a job.
struct Listener {
    app: Arc<App>,
    seq: i64,
    last: i64,
    unsent: VecDeque<EventRow>,
    /// Whether the store may have unread events.
    has_more: bool,
    ended: bool,
    notifications: Receiver<Option<i64>>,
    closing: watch::Receiver<bool>,
    _permit: RequestPermit,
}

impl Listener {
    fn into_stream(self) -> impl Stream<Item = Result<Event, Infallible>> {
        futures::stream::unfold(self, |mut listener| async move {
            let event = listener.next().await?;
            Some((Ok(event), listener))
        })
    }

    /// The next event; `None` if the job has ended or was deleted, and if the service shuts down (the client reconnects
    /// to the next process with the last id that it received).
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

    /// Waits for an event of the job; false if the service shuts down.
    async fn wait(&mut self) -> bool {
        if std::mem::take(&mut self.has_more) {
            return true;
        }
        loop {
            tokio::select! {
                received = self.notifications.recv() => match received {
                    Ok(seq) if seq.is_none_or(|seq| seq == self.seq) => return true,
                    Ok(_) => {}
                    // Some announcements were missed: one may have been for this job.
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

/// The last event received by the client; 0 for none.
fn last_event_id(headers: &HeaderMap) -> Result<i64, Problem> {
    let Some(value) = headers.get("last-event-id") else { return Ok(0) };
    let number = value.to_str().ok().and_then(|text| text.trim().parse().ok()).filter(|n| *n >= 0);
    number.ok_or_else(|| Problem::bad_header("Last-Event-ID", "the id of an event of this stream"))
}
