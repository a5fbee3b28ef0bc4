//! Work that is done to its end, also when whoever asked for it leaves.

use super::JobsError;
use tracing::Instrument as _;

/// Does work in a task of its own: a client that hangs up ends its request, and not what has begun in the store, of which the rest in memory
/// and on the disk has to follow.
///
/// # Errors
/// Those of the work; or if it panics, or the service ends before.
pub async fn to_end<T: Send + 'static>(
    work: impl Future<Output = Result<T, JobsError>> + Send + 'static,
) -> Result<T, JobsError> {
    let done = tokio::spawn(work.in_current_span()).await;
    done.unwrap_or_else(|error| Err(JobsError::file("a task of the service", std::io::Error::other(error))))
}
