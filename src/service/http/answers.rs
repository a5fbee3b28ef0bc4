//! Large answers count for their client until they are sent, in the memory that documents share.

use super::app::App;
use super::bodies::Bodies;
use super::extract::sender_of;
use super::problem::Problem;
use crate::service::jobs::held_text::HeldMemory;
use axum::Extension;
use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;
use hyper::body::{Frame, SizeHint};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

/// Largest answer that does not count [bytes]: connections are limited.
const SMALL: u64 = 64 << 10;

/// Refuses a large answer where the memory of its client, or of all, is taken. Streams are sent in pieces, and do not count.
pub async fn counted(State(app): State<Arc<App>>, request: Request, next: Next) -> Result<Response, Problem> {
    let extensions = request.extensions().clone();
    let mut answer = next.run(request).await;
    let made_in = answer.extensions_mut().remove::<MadeIn>();
    let Some(bytes) = answer.body().size_hint().exact().filter(|bytes| *bytes > SMALL) else {
        return Ok(answer);
    };
    let memory = match made_in.and_then(|MadeIn(memory)| Arc::into_inner(memory)) {
        Some(memory) => Bodies::keep(memory, bytes as usize),
        None => app.bodies.take(&sender_of(&extensions).0, bytes as usize)?,
    };
    let memory = Arc::new(memory);
    Ok(answer.map(|body| Body::new(Counted { body, memory })))
}

/// Memory in which an answer was made, which then holds what it needs of it until it is sent.
#[derive(Clone)]
pub struct MadeIn(Arc<HeldMemory>);

impl MadeIn {
    /// For the answer that is made while this is held.
    pub fn new(memory: HeldMemory) -> Extension<Self> {
        Extension(Self(Arc::new(memory)))
    }
}

/// A body whose pieces hold memory, also when they wait in the buffer of a connection.
struct Counted {
    body: Body,
    memory: Arc<HeldMemory>,
}

/// A piece of a body.
struct Piece(Bytes, #[allow(dead_code)] Arc<HeldMemory>);

impl AsRef<[u8]> for Piece {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl HttpBody for Counted {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let memory = Arc::clone(&self.memory);
        let held = |bytes| Bytes::from_owner(Piece(bytes, memory));
        Pin::new(&mut self.body).poll_frame(context).map_ok(|frame| frame.map_data(held))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures::StreamExt as _;

    #[tokio::test]
    async fn pieces_count_until_the_last_one_is_sent() {
        let bodies = Bodies::default();
        let memory = Arc::new(bodies.take("a", 20 << 20).unwrap());
        let body = Counted { body: Body::from(vec![b'x'; 100]), memory };
        assert_eq!(body.size_hint().exact(), Some(100));
        let mut pieces = Body::new(body).into_data_stream();
        let waiting = pieces.next().await.unwrap().unwrap();
        assert_eq!(waiting.len(), 100);
        drop(pieces);
        assert!(bodies.take("a", 5 << 20).is_err(), "what waits to be sent still counts");
        let of_other = bodies.take("b", 20 << 20).unwrap();
        assert!(bodies.take("c", 20 << 20).is_err(), "all is taken");
        drop((waiting, of_other));
        assert!(bodies.take("a", 24 << 20).is_ok());
    }
}
