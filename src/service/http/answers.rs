//! Large answers count for their client until they are sent, in the memory that documents share.

use super::app::App;
use super::bodies::Bodies;
use super::extract::sender_of;
use super::problem::Problem;
use crate::service::held_body::holding;
use crate::service::jobs::held_text::HeldMemory;
use axum::Extension;
use axum::body::HttpBody as _;
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;
use std::sync::Arc;

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
    Ok(answer.map(|body| holding(body, memory)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::Body;
    use futures::StreamExt as _;

    #[tokio::test]
    async fn pieces_count_until_the_last_one_is_sent() {
        let bodies = Bodies::default();
        let memory = bodies.take("a", 20 << 20).unwrap();
        let body = holding(Body::from(vec![b'x'; 100]), memory);
        assert_eq!(body.size_hint().exact(), Some(100));
        let mut pieces = body.into_data_stream();
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
