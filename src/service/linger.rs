//! Closing a connection such that its client reads the answer.
//!
//! A client that is still sending a body which was refused would find its connection reset, and lose the answer with it: so what it sends is
//! read and dropped for a while, as nginx does (`lingering_close`).

use super::seats::Seat;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _, ReadBuf};
use tokio::net::TcpStream;
use tokio::runtime::Handle;
use tokio::time::timeout;

/// For how long a client is waited for that sends nothing.
const SILENCE: Duration = Duration::from_secs(5);
/// For how long a client is waited for that sends.
const LONGEST: Duration = Duration::from_secs(30);

/// A connection that holds its seat until its client has closed it, too, or was waited for; or until the seat is given up.
pub(super) struct Lingering {
    stream: Option<(TcpStream, Arc<Seat>)>,
}

impl Lingering {
    /// A connection on its seat.
    pub fn new(stream: TcpStream, seat: Arc<Seat>) -> Self {
        Self { stream: Some((stream, seat)) }
    }

    /// The stream, which is there until this is dropped.
    fn stream(self: Pin<&mut Self>) -> io::Result<Pin<&mut TcpStream>> {
        let stream = self.get_mut().stream.as_mut();
        stream.map(|(stream, _)| Pin::new(stream)).ok_or_else(|| io::ErrorKind::NotConnected.into())
    }
}

impl Drop for Lingering {
    fn drop(&mut self) {
        let (Some((stream, seat)), Ok(runtime)) = (self.stream.take(), Handle::try_current()) else {
            return;
        };
        // It asked for nothing, and another one has its seat.
        if !seat.is_used() {
            return;
        }
        let is_open = match stream.try_read(&mut [0]) {
            Ok(count) => count > 0,
            Err(error) => error.kind() == io::ErrorKind::WouldBlock,
        };
        if is_open {
            runtime.spawn(async move {
                linger(stream).await;
                drop(seat);
            });
        }
    }
}

/// Ends the answer, and reads what the client still sends until it has closed the connection.
async fn linger(mut stream: TcpStream) {
    // A client that is gone does not read it.
    let _ = stream.shutdown().await;
    let mut dropped = [0; 8 << 10];
    let reading = async { while let Ok(Ok(1..)) = timeout(SILENCE, stream.read(&mut dropped)).await {} };
    let _ = timeout(LONGEST, reading).await;
}

impl AsyncRead for Lingering {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        self.stream()?.poll_read(cx, buf)
    }
}

impl AsyncWrite for Lingering {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        self.stream()?.poll_write(cx, buf)
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bufs: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.stream()?.poll_write_vectored(cx, bufs)
    }

    fn is_write_vectored(&self) -> bool {
        true
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let flushed = self.as_mut().stream()?.poll_flush(cx);
        if let (Poll::Ready(Ok(())), Some((_, seat))) = (&flushed, &self.stream) {
            seat.flushed();
        }
        flushed
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream()?.poll_shutdown(cx)
    }
}
