//! Whether an object store keeps what it is given: asked now and then with a small object, so that no request waits for it.

#[cfg(test)]
pub(in crate::service) mod tests;

use super::store::Identity;
use super::{JobId, JobsError, ownership};
use crate::blobs::{BlobError, BlobStore, Draft};
use crate::service::shelves::PROBES;
use std::io::{self, ErrorKind};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// Time between two questions.
const INTERVAL: Duration = Duration::from_secs(15);
/// Time between two questions to a store that does not answer.
const SHORT_INTERVAL: Duration = Duration::from_secs(2);

/// What is written.
const CONTENT: &[u8] = b"contuse";

/// The last answer of an object store.
#[derive(Debug)]
pub struct Pulse {
    /// The store, without patience.
    blobs: Arc<dyn BlobStore>,
    /// The database whose blobs it has to have.
    owner: Option<Identity>,
    answers: watch::Sender<bool>,
}

impl Pulse {
    /// The pulse of a store, which has answered.
    pub fn of(blobs: Arc<dyn BlobStore>, owner: Option<Identity>) -> Self {
        Self { blobs, owner, answers: watch::channel(true).0 }
    }

    /// Whether the store answered when it was last asked.
    pub fn is_felt(&self) -> bool {
        *self.answers.borrow()
    }

    /// Waits until the store is found not to answer.
    pub async fn lost(&self) {
        // The sender is here.
        let _ = self.answers.subscribe().wait_for(|is_felt| !is_felt).await;
    }

    /// Waits until the store answers.
    pub async fn felt(&self) {
        let _ = self.answers.subscribe().wait_for(|is_felt| *is_felt).await;
    }

    /// Asks the store now. Blocks on it.
    pub fn ask(&self) -> bool {
        let blobs = self.blobs.as_ref();
        let answer = probe(blobs)
            .map_err(JobsError::from)
            .and_then(|()| self.owner.as_ref().map_or(Ok(true), |owner| ownership::check(blobs, owner)));
        let is_felt = answer.is_ok();
        if self.answers.send_replace(is_felt) != is_felt {
            match answer {
                Ok(_) => tracing::info!("the object store answers again"),
                Err(error) => tracing::error!(%error, "the object store cannot be used"),
            }
        }
        is_felt
    }

    /// Asks the store again and again, for as long as anyone is interested.
    pub async fn follow(pulse: std::sync::Weak<Self>) {
        loop {
            let Some(is_felt) = pulse.upgrade().map(|pulse| pulse.is_felt()) else { return };
            tokio::time::sleep(if is_felt { INTERVAL } else { SHORT_INTERVAL }).await;
            let Some(pulse) = pulse.upgrade() else { return };
            // It does not panic, and when the runtime ends, no one is interested.
            let _ = tokio::task::spawn_blocking(move || pulse.ask()).await;
        }
    }
}

/// Writes, reads and deletes a small blob.
///
/// # Errors
/// Why the store does not do that.
fn probe(blobs: &dyn BlobStore) -> Result<(), BlobError> {
    let name = format!("{PROBES}/{}", JobId::new_v4());
    let mut draft = Draft::new(blobs.unnamed()?, u64::MAX);
    draft.append(CONTENT)?;
    draft.keep(&name)?;
    let lost = || BlobError::of(&name)(io::Error::new(ErrorKind::InvalidData, "it is not what was written"));
    let mut read = Vec::new();
    let mut blob = blobs.open(&name)?.ok_or_else(lost)?;
    blob.read_to_end(&mut read).map_err(BlobError::of(&name))?;
    blobs.delete(&name)?;
    if read == CONTENT { Ok(()) } else { Err(lost()) }
}

/// Checks an object store before it is used.
///
/// # Errors
/// `BlobStore`: why it cannot be used, and what helps.
pub fn check(blobs: &dyn BlobStore) -> Result<(), JobsError> {
    probe(blobs).map_err(|source| JobsError::of_blob_store(blobs, source))
}
