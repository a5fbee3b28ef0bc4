//! What a killed writer leaves can be read, up to its last whole chunk.

use super::{read, record, scene};
use contuse::record::{partial_path, reindex_incomplete, snapshot};
use contuse::report::RecordedRun;
use std::path::Path;
use std::sync::Mutex;

/// What stands on the disk in the middle of a run, as a kill would leave it.
fn partial_bytes(folder: &Path, at: u64) -> Vec<u8> {
    let path = folder.join("run.mcap");
    let bytes = Mutex::new(Vec::new());
    record(&scene(&[]), &path, 1, &|requested| {
        if requested == at {
            *bytes.lock().unwrap() = std::fs::read(partial_path(&path)).unwrap();
        }
        None
    });
    bytes.into_inner().unwrap()
}

fn salvage(folder: &Path, bytes: &[u8]) -> Result<contuse::record::Salvaged, contuse::record::RecordError> {
    let path = folder.join("killed.mcap");
    std::fs::write(partial_path(&path), bytes).unwrap();
    reindex_incomplete(&path)
}

#[test]
fn a_killed_run_is_readable_and_marked() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = partial_bytes(folder.path(), 25);
    let salvaged = salvage(folder.path(), &bytes).unwrap();
    assert!(salvaged.messages > 10 && salvaged.time_s > 0.0, "{salvaged:?}");
    let path = folder.path().join("killed.mcap");
    assert!(!partial_path(&path).exists());
    let contents = read(&path);
    assert_eq!((&contents.ending["ending"][..], &contents.ending["complete"][..]), ("worker_lost", "false"));
    assert_eq!(contents.attachments, ["scene.json", "plan_report.json"]);
    assert_eq!(contents.topics.values().map(Vec::len).sum::<usize>() as u64, salvaged.messages);
}

#[test]
fn every_cut_keeps_what_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    record(&scene(&[]), &folder.path().join("run.mcap"), 1, &|_| None);
    let whole = std::fs::read(folder.path().join("run.mcap")).unwrap();
    let mut last = 0;
    // The header is 8 + 9 + a few bytes; a cut in it leaves no recording.
    for cut in (1..=40).map(|i| whole.len() * i / 40) {
        let Ok(salvaged) = salvage(folder.path(), &whole[..cut]) else {
            panic!("cut at {cut} of {}", whole.len())
        };
        assert!(salvaged.messages >= last, "less is left of more: {cut}");
        last = salvaged.messages;
        assert_eq!(read(&folder.path().join("killed.mcap")).ending["complete"], "false");
    }
    let all: usize = read(&folder.path().join("run.mcap")).topics.values().map(Vec::len).sum();
    assert_eq!(last, all as u64);
}

#[test]
fn a_damaged_chunk_is_the_end_of_what_is_good() {
    let folder = tempfile::tempdir().unwrap();
    record(&scene(&[]), &folder.path().join("run.mcap"), 1, &|_| None);
    let mut bytes = std::fs::read(folder.path().join("run.mcap")).unwrap();
    // A byte in the middle of the messages of a chunk: what is between chunks can be lost without loss.
    let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
    let chunk = &chunks[chunks.len() / 2];
    bytes[(chunk.chunk_start_offset + chunk.chunk_length / 2) as usize] ^= 0x55;
    let salvaged = salvage(folder.path(), &bytes).unwrap();
    let all: usize = read(&folder.path().join("run.mcap")).topics.values().map(Vec::len).sum();
    assert!(salvaged.messages > 0 && salvaged.messages < all as u64);
    read(&folder.path().join("killed.mcap"));
}

#[test]
fn lengths_that_are_not_there_are_the_end_of_what_is_good() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = partial_bytes(folder.path(), 25);
    let good = salvage(folder.path(), &bytes).unwrap();
    let record = |opcode: u8, length: u64| [&[opcode][..], &length.to_le_bytes(), &[0; 100]].concat();
    // A chunk of zstd that claims to unpack to a petabyte: times, size, checksum, compression, packed size.
    let zstd =
        [&[0; 16][..], &(1_u64 << 50).to_le_bytes(), &[1, 2, 3, 4, 4, 0, 0, 0], b"zstd", &[1; 8]].concat();
    let chunk = [&[6][..], &u64::MAX.to_le_bytes(), &zstd].concat();
    let tails =
        [record(6, 1 << 52), record(6, 1 << 63), record(9, 1 << 62), record(9, 30), chunk, vec![6; 5000]];
    for tail in tails {
        let salvaged = salvage(folder.path(), &[&bytes[..], &tail].concat()).unwrap();
        assert_eq!(salvaged, good);
        read(&folder.path().join("killed.mcap"));
    }
}

#[test]
fn a_mutated_recording_is_reported_and_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&scene(&[]), &path, 1, &|_| None);
    RecordedRun::read(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut random = 1_u64;
    for _ in 0..200 {
        let mut bytes = whole.clone();
        for _ in 0..4 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (random >> 33) as usize % bytes.len();
            bytes[at] = (random >> 25) as u8;
        }
        // Either answer is good: no panic, and no allocation of what the bytes claim.
        let _ = salvage(folder.path(), &bytes);
        std::fs::write(&path, &bytes).unwrap();
        let _ = RecordedRun::read(&path);
    }
}

#[test]
fn what_is_no_recording_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = salvage(folder.path(), b"no recording at all, but long enough for a header");
    assert!(refused.unwrap_err().into_io().is_err());
    assert!(
        !folder.path().join("killed.mcap").exists()
            && !folder.path().join("killed.salvaged.partial").exists()
    );
    assert!(reindex_incomplete(&folder.path().join("nothing.mcap")).is_err());
}

#[test]
fn where_no_file_can_be_made_what_a_killed_run_left_stays() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = partial_bytes(folder.path(), 25);
    let in_the_way = folder.path().join("killed.salvaged.partial");
    std::fs::create_dir(&in_the_way).unwrap();
    let refused = salvage(folder.path(), &bytes);
    assert!(refused.unwrap_err().into_io().is_ok());
    std::fs::remove_dir(&in_the_way).unwrap();
    reindex_incomplete(&folder.path().join("killed.mcap")).unwrap();
}

#[test]
fn a_running_recording_can_be_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let (path, target) = (folder.path().join("run.mcap"), folder.path().join("look.mcap"));
    let seen = Mutex::new(None);
    record(&scene(&[]), &path, 1, &|requested| {
        if requested == 20 {
            *seen.lock().unwrap() = Some(snapshot(&path, &target).unwrap());
        }
        None
    });
    let seen = seen.into_inner().unwrap().unwrap();
    assert!(seen.messages > 10);
    assert_eq!(read(&target).ending["ending"], "running");
    assert_eq!(read(&path).ending["ending"], "finished", "looking does not disturb");
}
