//! Documents that are held in memory: all together take no more than a fixed part of it.

use super::problem::Problem;
use crate::service::jobs::held_text::HeldText;
use axum::body::{Body, HttpBody as _};
use futures::StreamExt as _;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, timeout_at};

/// Memory of all large documents [bytes]: the largest that the service accepts by default has a twelfth of it.
const ALL: usize = 48 << 20;
/// What is counted [bytes].
const UNIT: usize = 1 << 10;
/// Largest body that is not counted [bytes]: as many are received as there are connections for uploads.
const SMALL: usize = 64 << 10;
/// How long a body that holds memory may take to arrive, and how much longer for each byte [s]: 30 s for the largest by default. Slow
/// ones would keep the memory from all others.
const ARRIVAL: (f64, f64) = (10.0, 5e-6);
/// How long a document waits for memory. Most are answered in less.
const PATIENCE: Duration = Duration::from_secs(5);

/// The memory of documents, which requests take before they receive or load theirs.
#[derive(Debug)]
pub struct Bodies(Arc<Semaphore>);

impl Default for Bodies {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(ALL / UNIT)))
    }
}

impl Bodies {
    /// Receives a body of at most `limit` bytes. A large one waits for the memory of all of it, so that none holds a part and waits for the
    /// rest.
    ///
    /// # Errors
    /// If it is longer, is interrupted or too slow, or no memory becomes free for it.
    pub async fn receive(&self, body: Body, limit: u64) -> Result<HeldText, Problem> {
        let expected = body.size_hint().upper().map_or(limit, |declared| declared.min(limit)) as usize;
        let (mut text, mut memory) = (Vec::new(), None);
        let mut pieces = body.into_data_stream();
        let mut latest = None;
        loop {
            let next = match latest {
                Some(latest) => timeout_at(latest, pieces.next()).await.map_err(|_| Problem::too_slow())?,
                None => pieces.next().await,
            };
            let Some(piece) = next else { break };
            let piece = piece.map_err(|_| Problem::broken_body())?;
            let length = text.len() + piece.len();
            if length as u64 > limit {
                return Err(Problem::too_large(limit));
            }
            if length > SMALL && memory.is_none() {
                memory = Some(self.hold(expected).await?);
                let (first, for_each) = ARRIVAL;
                latest = Some(Instant::now() + Duration::from_secs_f64(first + for_each * expected as f64));
                text.reserve_exact(expected.max(length) - text.len());
            }
            text.extend_from_slice(&piece);
        }
        Ok(held(text, memory))
    }

    /// Loads a document that may have `most` bytes, and holds memory for those that it has.
    ///
    /// # Errors
    /// Those of `load`, or if no memory becomes free for it.
    pub async fn load(
        &self,
        most: usize,
        load: impl Future<Output = Result<Vec<u8>, Problem>>,
    ) -> Result<HeldText, Problem> {
        let memory = self.hold(most).await?;
        Ok(held(load.await?, Some(memory)))
    }

    /// Holds memory for so many bytes, or all that there is.
    async fn hold(&self, bytes: usize) -> Result<OwnedSemaphorePermit, Problem> {
        let units = bytes.min(ALL).div_ceil(UNIT) as u32;
        let free = Arc::clone(&self.0).acquire_many_owned(units);
        let held = tokio::time::timeout(PATIENCE, free).await.map_err(|_| Problem::no_memory())?;
        held.map_err(|closed| Problem::internal(&closed))
    }
}

/// A text with the part of some memory that it needs.
fn held(text: Vec<u8>, memory: Option<OwnedSemaphorePermit>) -> HeldText {
    let memory = memory.map(|mut memory| {
        let needed = text.len().div_ceil(UNIT).min(memory.num_permits());
        // What is left of it is free again.
        memory.split(needed).unwrap_or(memory)
    });
    HeldText::new(text, memory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::StatusCode;
    use axum::response::IntoResponse as _;
    use futures::future::join;

    #[tokio::test]
    async fn large_bodies_share_a_fixed_memory() {
        let bodies = Bodies::default();
        let receive = |length: usize| bodies.receive(Body::from(vec![b' '; length]), 64 << 20);
        let first = receive(30 << 20).await.unwrap();
        assert_eq!(first.len(), 30 << 20);
        let small = receive(SMALL).await.unwrap();
        // None becomes free for this one, and enough for that.
        let (refused, second) = join(receive(20 << 20), async {
            tokio::time::sleep(PATIENCE / 2).await;
            receive(10 << 20).await
        })
        .await;
        assert_eq!(refused.unwrap_err().into_response().status(), StatusCode::SERVICE_UNAVAILABLE);
        let later = async {
            tokio::time::sleep(Duration::from_millis(20)).await;
            drop(first);
        };
        join(async { receive(20 << 20).await.unwrap() }, later).await;
        drop((small, second));
        assert_eq!(receive(50 << 20).await.unwrap().len(), 50 << 20, "alone");
        assert_eq!(bodies.0.available_permits(), ALL / UNIT);
        let refused = receive((64 << 20) + 1).await.unwrap_err().into_response();
        assert_eq!(refused.status(), StatusCode::PAYLOAD_TOO_LARGE);
    }

    #[tokio::test]
    async fn a_body_that_holds_memory_arrives_in_time_or_not_at_all() {
        let bodies = Bodies::default();
        let begun = Instant::now();
        let first = futures::stream::iter([Ok::<_, std::io::Error>(vec![b' '; SMALL + 1])]);
        let stalled = Body::from_stream(first.chain(futures::stream::pending()));
        let refused = bodies.receive(stalled, 100_000).await.unwrap_err().into_response();
        assert_eq!(refused.status(), StatusCode::REQUEST_TIMEOUT);
        assert!(begun.elapsed() < Duration::from_secs(15), "{:?}", begun.elapsed());
        assert_eq!(bodies.0.available_permits(), ALL / UNIT);
    }

    #[tokio::test]
    async fn a_document_holds_what_it_has() {
        let bodies = Bodies::default();
        let loaded = bodies.load(4 << 20, async { Ok(vec![b' '; 3000]) }).await.unwrap();
        assert_eq!(bodies.0.available_permits(), ALL / UNIT - 3);
        let (text, memory) = loaded.into_parts();
        drop(memory);
        assert_eq!((text.len(), bodies.0.available_permits()), (3000, ALL / UNIT));
    }
}
