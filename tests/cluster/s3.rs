//! The contract of blob stores with objects: in memory, and on the S3 server of `CONTUSE_TEST_BLOBS`.

use crate::blob_contract::check;
use contuse::blobs::{BlobStore as _, Draft, ObjectBlobs};
use object_store::memory::InMemory;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// More bytes than are sent at a time.
const LONG: u32 = (8 << 20) + 1_000_000;

fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap()
}

fn in_memory(drafts: &Path) -> ObjectBlobs {
    ObjectBlobs::of(Arc::new(InMemory::new()), "some/prefix", "memory", drafts).unwrap()
}

/// The S3 server for tests.
fn of_tests(drafts: &Path) -> Option<ObjectBlobs> {
    let address = crate::address("CONTUSE_TEST_BLOBS")?;
    Some(ObjectBlobs::open(&format!("{address}/{}", std::process::id()), drafts, Duration::ZERO).unwrap())
}

/// More than one part and several pieces, with bytes that depend on their place.
fn long() -> Vec<u8> {
    (0..LONG).flat_map(|i| (i / 4).to_le_bytes()[..1].to_vec()).collect()
}

fn long_blobs_are_whole(blobs: &ObjectBlobs) {
    let bytes = long();
    let mut draft = Draft::new(blobs.unnamed().unwrap(), u64::MAX);
    draft.append(&bytes).unwrap();
    draft.keep("meshes/long").unwrap();
    let mut blob = blobs.open("meshes/long").unwrap().unwrap();
    let mut read = Vec::new();
    blob.read_to_end(&mut read).unwrap();
    assert!(read == bytes);
    for at in [bytes.len() - 10, 300_000, 5] {
        let mut ten = [0; 10];
        blob.seek(SeekFrom::Start(at as u64)).unwrap();
        blob.read_exact(&mut ten).unwrap();
        assert_eq!(ten, bytes[at..at + 10]);
    }
    // A reader gets no byte of another version.
    let mut draft = Draft::new(blobs.unnamed().unwrap(), u64::MAX);
    draft.append(&vec![0; bytes.len()]).unwrap();
    draft.keep("meshes/long").unwrap();
    blob.seek(SeekFrom::Start(4_000_000)).unwrap();
    assert!(blob.read(&mut [0; 10]).is_err());
    blobs.delete("meshes/long").unwrap();
}

#[test]
fn it_keeps_what_a_store_promises() {
    let (dir, runtime) = (tempfile::tempdir().unwrap(), runtime());
    let _within = runtime.enter();
    check(&in_memory(dir.path()));
    long_blobs_are_whole(&in_memory(dir.path()));
    assert!(std::fs::read_dir(dir.path()).unwrap().next().is_none(), "no draft is left");
}

#[test]
fn s3_keeps_what_a_store_promises() {
    let (dir, runtime) = (tempfile::tempdir().unwrap(), runtime());
    let _within = runtime.enter();
    let Some(blobs) = of_tests(dir.path()) else { return };
    check(&blobs);
    long_blobs_are_whole(&blobs);
}
