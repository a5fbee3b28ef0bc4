//! Bodies that are held in memory: all together take no more than a fixed part of it.

use super::problem::Problem;
use axum::body::Body;
use futures::StreamExt as _;
use std::sync::Arc;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Memory of all bodies [bytes]: the largest document that the service accepts by default has a twelfth of it.
const ALL: usize = 48 << 20;
/// What is counted [bytes].
const UNIT: usize = 1 << 10;

/// The memory of bodies, which requests take as they receive theirs.
#[derive(Debug)]
pub struct Bodies(Arc<Semaphore>);

/// Memory that is held, free again when it is dropped.
pub type HeldMemory = Option<OwnedSemaphorePermit>;

impl Default for Bodies {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(ALL / UNIT)))
    }
}

impl Bodies {
    /// Receives a body of at most `limit` bytes, with the memory that it takes.
    ///
    /// # Errors
    /// If it is longer, is interrupted, or no memory is left for it.
    pub async fn receive(&self, body: Body, limit: u64) -> Result<(Vec<u8>, HeldMemory), Problem> {
        let (mut text, mut held): (Vec<u8>, HeldMemory) = (Vec::new(), None);
        let mut pieces = body.into_data_stream();
        while let Some(piece) = pieces.next().await {
            let piece = piece.map_err(|_| Problem::broken_body())?;
            if (text.len() + piece.len()) as u64 > limit {
                return Err(Problem::too_large(limit));
            }
            self.hold(&mut held, text.len() + piece.len())?;
            text.extend_from_slice(&piece);
        }
        Ok((text, held))
    }

    /// Holds memory for so many bytes.
    fn hold(&self, held: &mut HeldMemory, bytes: usize) -> Result<(), Problem> {
        let missing = bytes.div_ceil(UNIT) - held.as_ref().map_or(0, OwnedSemaphorePermit::num_permits);
        let Ok(missing) = u32::try_from(missing) else { return Err(Problem::no_memory()) };
        let more = Arc::clone(&self.0).try_acquire_many_owned(missing).map_err(|_| Problem::no_memory())?;
        match held {
            Some(held) => held.merge(more),
            None => *held = Some(more),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::StatusCode;
    use axum::response::IntoResponse as _;

    #[tokio::test]
    async fn bodies_share_a_fixed_memory() {
        let bodies = Bodies::default();
        let receive = |length: usize| bodies.receive(Body::from(vec![b' '; length]), 32 << 20);
        let (text, first) = receive(30 << 20).await.unwrap();
        assert_eq!(text.len(), 30 << 20);
        let refused = receive(20 << 20).await.unwrap_err().into_response();
        assert_eq!(refused.status(), StatusCode::SERVICE_UNAVAILABLE);
        let second = receive(10 << 20).await.unwrap();
        drop(first);
        receive(20 << 20).await.unwrap();
        drop(second);
        assert_eq!(bodies.0.available_permits(), ALL / UNIT);
        let refused = receive((32 << 20) + 1).await.unwrap_err().into_response();
        assert_eq!(refused.status(), StatusCode::PAYLOAD_TOO_LARGE);
    }
}
