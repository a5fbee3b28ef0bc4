//! Timeouts for clients that do not read, so that stalled downloads do not exhaust the connections.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep};

/// A stream whose writes fail if the other side accepts too little: while writes have to wait, at least `least_rate` bytes per second
/// in every interval of `timeout`.
pub struct StallTimeout<S> {
    stream: S,
    timeout: Duration,
    least_bytes: u64,
    /// End of the interval in which writes have to wait.
    limit: Pin<Box<Sleep>>,
    /// Bytes accepted in this interval; `None` if no write waits.
    accepted: Option<u64>,
    /// Whether a write waits.
    is_waiting: bool,
    /// When the last one that had to wait was accepted.
    waited: Instant,
}

impl<S> StallTimeout<S> {
    /// Limits the waiting time of writes to `stream` to `timeout`, and their rate in that time to `least_rate` [bytes/s].
    pub fn new(stream: S, timeout: Duration, least_rate: u64) -> Self {
        let least_bytes = (least_rate as f64 * timeout.as_secs_f64()) as u64;
        let limit = Box::pin(sleep(timeout));
        Self {
            stream,
            timeout,
            least_bytes: least_bytes.max(1),
            limit,
            accepted: None,
            is_waiting: false,
            waited: Instant::now(),
        }
    }

    /// The outcome of a write of some bytes, or an error if too few were accepted for too long.
    fn limited<T>(
        &mut self,
        cx: &mut Context<'_>,
        outcome: Poll<io::Result<T>>,
        bytes: impl Fn(&T) -> u64,
    ) -> Poll<io::Result<T>> {
        if let Poll::Ready(ended) = outcome {
            if let (Ok(value), Some(accepted)) = (&ended, &mut self.accepted) {
                *accepted += bytes(value);
            }
            if std::mem::take(&mut self.is_waiting) {
                self.waited = Instant::now();
            }
            return Poll::Ready(ended);
        }
        let now = Instant::now();
        let was_waiting = std::mem::replace(&mut self.is_waiting, true);
        // What waited long ago says nothing of the client now.
        let is_long_ago = !was_waiting && now.duration_since(self.waited) >= self.timeout;
        if self.accepted.is_none() || is_long_ago {
            self.begin(now);
        }
        ready!(self.limit.as_mut().poll(cx));
        if self.accepted.is_none_or(|accepted| accepted < self.least_bytes) {
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        self.begin(now);
        // Registers for the end of the next interval, which is in the future.
        ready!(self.limit.as_mut().poll(cx));
        Poll::Ready(Err(io::ErrorKind::TimedOut.into()))
    }

    /// Begins an interval in which bytes have to be accepted.
    fn begin(&mut self, now: Instant) {
        self.accepted = Some(0);
        self.limit.as_mut().reset(now + self.timeout);
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for StallTimeout<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buf: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(cx, buf)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for StallTimeout<S> {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.stream).poll_write(cx, buf);
        self.limited(cx, outcome, |n| *n as u64)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bufs: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.stream).poll_write_vectored(cx, bufs);
        self.limited(cx, outcome, |n| *n as u64)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let outcome = Pin::new(&mut self.stream).poll_flush(cx);
        self.limited(cx, outcome, |()| 0)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let outcome = Pin::new(&mut self.stream).poll_shutdown(cx);
        self.limited(cx, outcome, |()| 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

    #[tokio::test]
    async fn writes_to_a_client_that_does_not_read_fail() {
        let (stream, _client) = duplex(16);
        let mut stream = StallTimeout::new(stream, Duration::from_millis(50), 0);
        stream.write_all(&[0; 16]).await.unwrap();
        assert_eq!(stream.write_all(&[0; 1]).await.unwrap_err().kind(), io::ErrorKind::TimedOut);
    }

    #[tokio::test]
    async fn slow_clients_that_read_are_served() {
        let (stream, mut client) = duplex(16);
        let mut stream = StallTimeout::new(stream, Duration::from_millis(200), 100);
        let reader = tokio::spawn(async move {
            let mut bytes = [0; 160];
            for piece in bytes.chunks_mut(16) {
                sleep(Duration::from_millis(40)).await;
                client.read_exact(piece).await.unwrap();
            }
        });
        stream.write_all(&[7; 160]).await.unwrap();
        reader.await.unwrap();
    }

    #[tokio::test]
    async fn clients_that_read_a_byte_now_and_then_are_not_served_for_ever() {
        let (stream, mut client) = duplex(16);
        let mut stream = StallTimeout::new(stream, Duration::from_millis(200), 1000);
        let reader = tokio::spawn(async move {
            let mut byte = [0];
            while client.read_exact(&mut byte).await.is_ok() {
                sleep(Duration::from_millis(20)).await;
            }
        });
        let error = stream.write_all(&[7; 1600]).await.unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        drop(stream);
        reader.await.unwrap();
    }

    #[tokio::test]
    async fn pauses_of_the_service_are_not_those_of_the_client() {
        let (stream, mut client) = duplex(16);
        let mut stream = StallTimeout::new(stream, Duration::from_millis(60), 1000);
        let reader = tokio::spawn(async move {
            let mut bytes = [0; 96];
            client.read_exact(&mut bytes).await.unwrap();
        });
        for _ in 0..3 {
            stream.write_all(&[7; 32]).await.unwrap();
            sleep(Duration::from_millis(100)).await;
        }
        reader.await.unwrap();
    }
}
