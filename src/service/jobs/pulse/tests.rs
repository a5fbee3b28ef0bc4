//! The pulse of a store that fails.

use super::*;
use crate::blobs::{Blob, BlobDigest, BlobEntry, FolderBlobs, Unnamed};
use crate::service::config::ServiceConfig;
use crate::service::jobs::data_folder::DataFolder;
use crate::service::jobs::queue::{Queue, Storage};
use crate::service::jobs::simulator::Simulator;
use crate::service::jobs::store::tests::{new, queue_of};
use crate::service::jobs::store::{NewJob, StoreAddress, Submitted};
use crate::service::jobs::{JobKind, JobState, worker};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A folder behind a network that may fail.
#[derive(Debug)]
pub struct Distant {
    folder: FolderBlobs,
    pub is_down: AtomicBool,
    /// Whether it refuses recordings, and takes all else.
    refuses: AtomicBool,
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
    fn adopt(&self, file: &Path, name: &str) -> Result<BlobDigest, BlobError> {
        if self.refuses.load(Ordering::SeqCst) {
            return Err(BlobError::of(name)(ErrorKind::PermissionDenied.into()));
        }
        self.reached()?.adopt(file, name)
    }
}

pub fn distant(dir: &Path) -> Arc<Distant> {
    Arc::new(Distant {
        folder: FolderBlobs::open(dir).unwrap(),
        is_down: AtomicBool::default(),
        refuses: AtomicBool::default(),
    })
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

/// Waits until something is so.
async fn eventually(what: &str, mut is_so: impl AsyncFnMut() -> bool) {
    let begun = Instant::now();
    while !is_so().await {
        assert!(begun.elapsed() < Duration::from_secs(60), "{what}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_recording_that_a_store_refuses_waits_for_it() {
    let dir = tempfile::tempdir().unwrap();
    let (folder, blobs) = (DataFolder::open(dir.path()).unwrap(), distant(dir.path()));
    let pulse = Arc::new(Pulse::of(Arc::clone(&blobs) as Arc<dyn BlobStore>, None));
    let jobs = StoreAddress::in_folder(dir.path()).open().await.unwrap();
    let document = include_bytes!("../../../../tests/recording/small_ball_on_block.json").to_vec();
    let job = NewJob { kind: JobKind::Simulation, document, ..new("refused") };
    let Submitted::Created(job) = jobs.submit(&job, queue_of(1)).await.unwrap() else { panic!() };
    let config = Arc::new(ServiceConfig { workers: 1, ..ServiceConfig::default() });
    let engine = Arc::new(Simulator::new(&config.runs));
    let storage = Storage { jobs, blobs: Arc::clone(&blobs) as _, pulse: Some(pulse), folder };
    let queue = Queue::new(storage, config, engine, Arc::default());
    let row = async || queue.store.job("anna", job.id).await.unwrap().unwrap();

    blobs.refuses.store(true, Ordering::SeqCst);
    let workers = worker::start(&queue).unwrap();
    eventually("the run waits", async || {
        matches!(queue.check_storage(), Err(JobsError::EndsWait { ends: 1 }))
    })
    .await;
    // Longer than a disk may refuse it.
    tokio::time::sleep(Duration::from_secs(3)).await;
    assert_eq!(row().await.state, JobState::Running);
    queue.check_disk().unwrap();

    blobs.refuses.store(false, Ordering::SeqCst);
    eventually("the recording is kept", async || row().await.state == JobState::Succeeded).await;
    assert_eq!(row().await.attempts, 1);
    queue.check_storage().unwrap();
    queue.close();
    let ended = move || workers.into_iter().for_each(|worker| worker.join().unwrap());
    tokio::task::spawn_blocking(ended).await.unwrap();
}
