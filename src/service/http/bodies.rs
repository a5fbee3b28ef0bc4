//! Documents that are held in memory: all together take no more than a fixed part of it.

use super::problem::Problem;
use crate::service::jobs::held_text::{HeldMemory, HeldText};
use axum::body::{Body, HttpBody as _};
use futures::StreamExt as _;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, timeout_at};

/// Memory of all large documents [bytes]: the largest that the service accepts by default has a twelfth of it.
const ALL: usize = 48 << 20;
/// What one client has of it [bytes], or one larger document: whoever sends slowly keeps it from no one else.
const OF_CLIENT: usize = ALL / 2;
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
pub struct Bodies {
    all: Arc<Semaphore>,
    /// That of each client who holds some.
    of_clients: Mutex<BTreeMap<String, Weak<Semaphore>>>,
}

impl Default for Bodies {
    fn default() -> Self {
        Self { all: Arc::new(Semaphore::new(ALL / UNIT)), of_clients: Mutex::default() }
    }
}

impl Bodies {
    /// Receives a body of at most `limit` bytes from a client. A large one waits for the memory of all of it, so that none holds a part and waits for the
    /// rest.
    ///
    /// # Errors
    /// If it is longer, is interrupted or too slow, or no memory becomes free for it.
    pub async fn receive(&self, client: &str, body: Body, limit: u64) -> Result<HeldText, Problem> {
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
                memory = Some(self.hold(client, expected).await?);
                let (first, for_each) = ARRIVAL;
                latest = Some(Instant::now() + Duration::from_secs_f64(first + for_each * expected as f64));
                text.reserve_exact(expected.max(length) - text.len());
            }
            text.extend_from_slice(&piece);
        }
        Ok(held(text, memory))
    }

    /// Loads a document that may have `most` bytes for a client, and holds memory for those that it has.
    ///
    /// # Errors
    /// Those of `load`, or if no memory becomes free for it.
    pub async fn load(
        &self,
        client: &str,
        most: usize,
        load: impl Future<Output = Result<Vec<u8>, Problem>>,
    ) -> Result<HeldText, Problem> {
        let memory = self.hold(client, most).await?;
        Ok(held(load.await?, Some(memory)))
    }

    /// Holds memory for so many bytes of a client, or all that there is. What waits for that of its client takes none from others.
    ///
    /// # Errors
    /// If it does not become free in time.
    pub async fn hold(&self, client: &str, bytes: usize) -> Result<HeldMemory, Problem> {
        let latest = Instant::now() + PATIENCE;
        let of_client = part(&self.of_client(client), bytes.min(OF_CLIENT), latest).await;
        let of_client = of_client.ok_or_else(Problem::no_memory_of_client)?;
        let of_all = part(&self.all, bytes.min(ALL), latest).await.ok_or_else(Problem::no_memory)?;
        Ok(HeldMemory { of_all, of_client })
    }

    /// Memory for so many bytes of a client, or all that there is, at once: what waits for it is there already.
    ///
    /// # Errors
    /// If that of the client or of all is taken.
    pub fn take(&self, client: &str, bytes: usize) -> Result<HeldMemory, Problem> {
        let part = |memory: Arc<Semaphore>, bytes: usize| {
            memory.try_acquire_many_owned(bytes.div_ceil(UNIT) as u32).ok()
        };
        let of_client =
            part(self.of_client(client), bytes.min(OF_CLIENT)).ok_or_else(Problem::no_memory_of_client)?;
        let of_all = part(Arc::clone(&self.all), bytes.min(ALL)).ok_or_else(Problem::no_memory)?;
        Ok(HeldMemory { of_all, of_client })
    }

    /// What so many bytes need of some memory; the rest is given back.
    pub fn keep(mut memory: HeldMemory, bytes: usize) -> HeldMemory {
        memory.shrink(bytes.div_ceil(UNIT));
        memory
    }

    /// The memory of a client.
    fn of_client(&self, client: &str) -> Arc<Semaphore> {
        let mut of_clients = self.of_clients.lock().unwrap_or_else(PoisonError::into_inner);
        // That of others who hold none any more is forgotten.
        of_clients.retain(|_, memory| memory.strong_count() > 0);
        if let Some(memory) = of_clients.get(client).and_then(Weak::upgrade) {
            return memory;
        }
        let memory = Arc::new(Semaphore::new(OF_CLIENT / UNIT));
        of_clients.insert(client.to_owned(), Arc::downgrade(&memory));
        memory
    }
}

/// A part of some memory; `None` if it does not become free in time.
async fn part(memory: &Arc<Semaphore>, bytes: usize, latest: Instant) -> Option<OwnedSemaphorePermit> {
    let free = Arc::clone(memory).acquire_many_owned(bytes.div_ceil(UNIT) as u32);
    timeout_at(latest, free).await.ok()?.ok()
}

/// A text with the part of some memory that it needs.
fn held(text: Vec<u8>, memory: Option<HeldMemory>) -> HeldText {
    let memory = memory.map(|memory| Bodies::keep(memory, text.len()));
    HeldText::new(text, memory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::StatusCode;
    use axum::response::IntoResponse as _;
    use futures::future::join;

    /// A body of so many bytes.
    fn body(length: usize) -> Body {
        Body::from(vec![b' '; length])
    }

    fn status(refused: Result<HeldText, Problem>) -> StatusCode {
        refused.unwrap_err().into_response().status()
    }

    /// Memory that is free [bytes].
    fn free(bodies: &Bodies) -> usize {
        bodies.all.available_permits() * UNIT
    }

    #[tokio::test]
    async fn large_bodies_share_a_fixed_memory() {
        let bodies = Bodies::default();
        let receive = |client, length: usize| bodies.receive(client, body(length), 64 << 20);
        let first = receive("a", 30 << 20).await.unwrap();
        assert_eq!(first.len(), 30 << 20);
        let small = receive("b", SMALL).await.unwrap();
        // None becomes free for this one, and enough for that.
        let (refused, second) = join(receive("b", 20 << 20), async {
            tokio::time::sleep(PATIENCE / 2).await;
            receive("c", 10 << 20).await
        })
        .await;
        assert_eq!(status(refused), StatusCode::SERVICE_UNAVAILABLE);
        let later = async {
            tokio::time::sleep(Duration::from_millis(20)).await;
            drop(first);
        };
        join(async { receive("b", 20 << 20).await.unwrap() }, later).await;
        drop((small, second));
        assert_eq!(receive("a", 50 << 20).await.unwrap().len(), 50 << 20, "alone");
        assert_eq!(free(&bodies), ALL);
        assert_eq!(status(receive("a", (64 << 20) + 1).await), StatusCode::PAYLOAD_TOO_LARGE);
    }

    #[tokio::test]
    async fn what_one_client_holds_leaves_memory_for_others() {
        let bodies = Bodies::default();
        let receive = |client, length: usize| bodies.receive(client, body(length), 64 << 20);
        let of_a = [receive("a", 20 << 20).await.unwrap(), receive("a", 4 << 20).await.unwrap()];
        let begun = Instant::now();
        let waiting = futures::future::join_all((0..20).map(|_| receive("a", 4 << 20)));
        let (refused, of_b) = join(waiting, async {
            let received = receive("b", 20 << 20).await;
            assert!(begun.elapsed() < PATIENCE / 2, "{:?}", begun.elapsed());
            received
        })
        .await;
        for refused in refused {
            let answer = refused.unwrap_err().into_response();
            assert_eq!(answer.status(), StatusCode::TOO_MANY_REQUESTS);
            assert!(answer.headers().contains_key("retry-after"));
        }
        drop((of_a, of_b));
        assert_eq!(free(&bodies), ALL);
        drop(receive("c", 1 << 20).await.unwrap());
        assert_eq!(bodies.of_clients.lock().unwrap().len(), 1, "those who hold none are forgotten");
    }

    #[tokio::test]
    async fn a_body_that_holds_memory_arrives_in_time_or_not_at_all() {
        let bodies = Bodies::default();
        let begun = Instant::now();
        let first = futures::stream::iter([Ok::<_, std::io::Error>(vec![b' '; SMALL + 1])]);
        let stalled = Body::from_stream(first.chain(futures::stream::pending()));
        assert_eq!(status(bodies.receive("a", stalled, 100_000).await), StatusCode::REQUEST_TIMEOUT);
        assert!(begun.elapsed() < Duration::from_secs(15), "{:?}", begun.elapsed());
        assert_eq!(free(&bodies), ALL);
    }

    #[tokio::test]
    async fn a_document_holds_what_it_has() {
        let bodies = Bodies::default();
        let loaded = bodies.load("a", 4 << 20, async { Ok(vec![b' '; 3000]) }).await.unwrap();
        assert_eq!(free(&bodies), ALL - 3 * UNIT);
        let (text, memory) = loaded.into_parts();
        drop(memory);
        assert_eq!((text.len(), free(&bodies)), (3000, ALL));
    }
}
