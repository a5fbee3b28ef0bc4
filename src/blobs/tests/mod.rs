//! Contract tests of every blob store.

mod memory;

use super::{Blob, BlobDigest, BlobError, BlobStore, Draft};
use std::io::{Read, Seek, SeekFrom};

/// Checks the contract on an empty store.
pub(super) fn check(blobs: &dyn BlobStore) {
    what_has_no_name_is_not_there(blobs);
    a_blob_is_read_from_any_byte_on(blobs);
    a_name_goes_to_the_last_that_got_it(blobs);
    a_draft_has_an_end(blobs);
    a_file_is_adopted(blobs);
    shelves_are_listed(blobs);
}

fn draft(blobs: &dyn BlobStore, bytes: &[u8]) -> Draft {
    let mut draft = Draft::new(blobs.unnamed().unwrap(), 100);
    // In pieces, as bytes arrive.
    bytes.chunks(2).for_each(|piece| draft.append(piece).unwrap());
    draft
}

fn read_all(draft: &Draft) -> Vec<u8> {
    text(draft.open().unwrap()).into_bytes()
}

fn text(mut blob: Box<dyn Blob>) -> String {
    let mut text = String::new();
    blob.read_to_string(&mut text).unwrap();
    text
}

fn names(blobs: &dyn BlobStore, shelf: &str) -> Vec<String> {
    let mut names: Vec<String> = blobs.list(shelf).unwrap().into_iter().map(|entry| entry.name).collect();
    names.sort();
    names
}

fn what_has_no_name_is_not_there(blobs: &dyn BlobStore) {
    let unnamed = draft(blobs, b"abc");
    assert_eq!(read_all(&unnamed), b"abc");
    assert_eq!(unnamed.digest(), BlobDigest::of(&b"abc"[..]).unwrap());
    assert!(names(blobs, "").is_empty() && names(blobs, "meshes").is_empty());
    drop(unnamed);
    assert!(blobs.open("meshes/a.msh").unwrap().is_none());
    blobs.delete("meshes/a.msh").unwrap();
}

fn a_blob_is_read_from_any_byte_on(blobs: &dyn BlobStore) {
    let digest = draft(blobs, b"abcdef").keep("meshes/a.msh").unwrap();
    assert_eq!(digest, BlobDigest::of(&b"abcdef"[..]).unwrap());
    let mut blob = blobs.open("meshes/a.msh").unwrap().unwrap();
    assert_eq!(blob.seek(SeekFrom::End(0)).unwrap(), 6);
    blob.seek(SeekFrom::Start(4)).unwrap();
    // An open blob can be read to its end after deletion.
    blobs.delete("meshes/a.msh").unwrap();
    assert!(blobs.open("meshes/a.msh").unwrap().is_none());
    assert_eq!(text(blob), "ef");
}

fn a_name_goes_to_the_last_that_got_it(blobs: &dyn BlobStore) {
    let [first, second] = [b"first", b"again"].map(|bytes| draft(blobs, bytes));
    first.keep("a").unwrap();
    let before = blobs.open("a").unwrap().unwrap();
    second.keep("a").unwrap();
    assert_eq!((text(before).as_str(), text(blobs.open("a").unwrap().unwrap()).as_str()), ("first", "again"));
    blobs.delete("a").unwrap();
}

fn a_draft_has_an_end(blobs: &dyn BlobStore) {
    let mut draft = Draft::new(blobs.unnamed().unwrap(), 3);
    draft.append(b"abc").unwrap();
    assert!(matches!(draft.append(b"d"), Err(BlobError::TooLarge { most: 3 })));
    assert_eq!(read_all(&draft), b"abc");
}

fn a_file_is_adopted(blobs: &dyn BlobStore) {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    assert!(blobs.adopt(&file, "recordings/run.mcap").is_err());
    std::fs::write(&file, b"abc").unwrap();
    let digest = blobs.adopt(&file, "recordings/run.mcap").unwrap();
    assert_eq!(digest, BlobDigest::of(&b"abc"[..]).unwrap());
    assert!(!file.exists());
    assert_eq!(text(blobs.open("recordings/run.mcap").unwrap().unwrap()), "abc");
    blobs.delete("recordings/run.mcap").unwrap();
}

fn shelves_are_listed(blobs: &dyn BlobStore) {
    for name in ["meshes/b", "results/c", "meshes/a"] {
        draft(blobs, b"abc").keep(name).unwrap();
    }
    assert_eq!(names(blobs, "meshes"), ["meshes/a", "meshes/b"]);
    assert_eq!(names(blobs, "results"), ["results/c"]);
    assert!(names(blobs, "recordings").is_empty() && names(blobs, "").is_empty());
    for name in ["meshes/a", "meshes/b", "results/c"] {
        blobs.delete(name).unwrap();
    }
    assert!(names(blobs, "meshes").is_empty());
}
