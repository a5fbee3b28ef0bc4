//! A body that holds something until it is sent.

use axum::body::{Body, Bytes, HttpBody};
use hyper::body::{Frame, SizeHint};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

/// A body that holds something, as its pieces do, also when they wait in the buffer of a connection.
pub(super) fn holding<T: Send + Sync + 'static>(body: Body, held: T) -> Body {
    Body::new(HeldBody { body, held: Arc::new(held) })
}

struct HeldBody<T> {
    body: Body,
    held: Arc<T>,
}

/// A piece of a body.
struct Piece<T>(Bytes, #[allow(dead_code)] Arc<T>);

impl<T> AsRef<[u8]> for Piece<T> {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl<T: Send + Sync + 'static> HttpBody for HeldBody<T> {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let held = Arc::clone(&self.held);
        let piece = |bytes| Bytes::from_owner(Piece(bytes, held));
        Pin::new(&mut self.body).poll_frame(context).map_ok(|frame| frame.map_data(piece))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
