//! The pulse of a store that fails.

use super::*;
use crate::blobs::{Blob, BlobEntry, FolderBlobs, Unnamed};
use std::sync::atomic::{AtomicBool, Ordering};

/// A folder behind a network that may fail.
#[derive(Debug)]
pub struct Distant {
    folder: FolderBlobs,
    pub is_down: AtomicBool,
}

impl Distant {
    fn reached(&self) -> Result<&FolderBlobs, BlobError> {
        let down = BlobError::of("a blob")(ErrorKind::NetworkDown.into());
        if self.is_down.load(Ordering::SeqCst) { Err(down) } else { Ok(&self.folder) }
    }
}

impl BlobStore for Distant {
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError> {
        self.reached()?.unnamed()
    }
    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, BlobError> {
        self.reached()?.open(name)
    }
    fn delete(&self, name: &str) -> Result<(), BlobError> {
        self.reached()?.delete(name)
    }
    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError> {
        self.reached()?.list(shelf)
    }
}

pub fn distant(dir: &std::path::Path) -> Arc<Distant> {
    Arc::new(Distant { folder: FolderBlobs::open(dir).unwrap(), is_down: AtomicBool::new(false) })
}

#[test]
fn a_question_leaves_nothing_and_the_answer_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let blobs = distant(dir.path());
    let pulse = Pulse::of(Arc::clone(&blobs) as Arc<dyn BlobStore>, None);
    assert!(pulse.ask() && blobs.list(PROBES).unwrap().is_empty());
    blobs.is_down.store(true, Ordering::SeqCst);
    assert!(pulse.is_felt(), "not asked yet");
    assert!(!pulse.ask() && !pulse.is_felt());
    blobs.is_down.store(false, Ordering::SeqCst);
    assert!(pulse.ask() && pulse.is_felt());
}

#[test]
fn a_store_that_cannot_be_used_is_named_with_a_remedy() {
    let dir = tempfile::tempdir().unwrap();
    let blobs = distant(dir.path());
    check(blobs.as_ref()).unwrap();
    blobs.is_down.store(true, Ordering::SeqCst);
    let text = check(blobs.as_ref()).unwrap_err().to_string();
    assert!(text.contains("--blobs (CONTUSE_BLOBS)") && text.contains("AWS_ENDPOINT_URL"), "{text}");
}
