//! Recordings, from the outside: whole after every ending, equal for equal runs, and saved after a crash.
//!
//! `tests/python/check_recording.py` reads them with readers that are not Contuse's own.
#![allow(clippy::unwrap_used, clippy::expect_used)] // tests may panic

mod eroded;
mod own_thread;
mod salvage;
mod series;
mod sinks;
mod whole;

use contuse::plan::{Plan, compile};
use contuse::record::{McapRecorder, RecordingInfo};
use contuse::scene::{Budget, FolderSource, Loaded, load};
use contuse::step::{Interrupt, RunOptions};
use contuse::study::{Progress, RunRequest, RunResult, run_scene};
use mcap::records::Metadata;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

const SCENE: &str = include_str!("small_ball_on_block.json");

/// The small scene, with some of its text replaced.
fn scene(replacements: &[(&str, &str)]) -> (String, Loaded) {
    let mut text = SCENE.to_owned();
    for (from, to) in replacements {
        assert!(text.contains(from), "{from} is not in the scene");
        text = text.replace(from, to);
    }
    let loaded =
        load(text.as_bytes(), &FolderSource::new("."), &Budget::COMMAND_LINE).expect("the scene is valid");
    (text, loaded)
}

/// The plan of the small scene.
fn small_plan() -> Plan {
    compile(&scene(&[]).1.scene).expect("it compiles")
}

const NOT_INTERRUPTED: RunOptions = RunOptions { threads: 1, interrupt: &|| None };

/// Runs a scene into a file; `interrupt` is requested with the number of times that it has been requested.
fn record(
    (document, loaded): &(String, Loaded),
    path: &Path,
    threads: usize,
    interrupt: &(dyn Fn(u64) -> Option<Interrupt> + Sync),
) -> (RunResult, Vec<Progress>) {
    let (requested, mut reported) = (AtomicU64::new(0), Vec::new());
    let info = RecordingInfo::of(&loaded.scene, document.as_bytes());
    let mut recorder = McapRecorder::new(path, info);
    let result = run_scene(RunRequest {
        scene: &loaded.scene,
        sinks: vec![&mut recorder],
        also: None,
        threads,
        interrupt: &|| interrupt(requested.fetch_add(1, Ordering::Relaxed)),
        progress: &mut |progress| reported.push(progress),
    });
    (result.expect("the scene compiles"), reported)
}

/// What is in a file, by the reader of the mcap crate.
struct Contents {
    /// Messages by topic: log times.
    topics: BTreeMap<String, Vec<u64>>,
    /// The metadata record `contuse.ending`.
    ending: BTreeMap<String, String>,
    /// Names of the attachments.
    attachments: Vec<String>,
}

fn read(path: &Path) -> Contents {
    let bytes = std::fs::read(path).expect("the recording is there");
    let summary = mcap::Summary::read(&bytes).expect("it has a footer").expect("it has a summary section");
    let mut topics: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).expect("it begins as it should") {
        let message = message.expect("every message can be read");
        topics.entry(message.channel.topic.clone()).or_default().push(message.log_time);
    }
    let count: usize = topics.values().map(Vec::len).sum();
    assert_eq!(summary.stats.expect("it has statistics").message_count, count as u64);
    let endings = summary.metadata_indexes.iter().filter(|m| m.name == "contuse.ending");
    let endings: Vec<Metadata> = endings.map(|index| mcap::read::metadata(&bytes, index).unwrap()).collect();
    let [ending] = &endings[..] else { panic!("{} endings", endings.len()) };
    assert!(summary.metadata_indexes.iter().any(|m| m.name == "contuse.run"));
    Contents {
        topics,
        ending: ending.metadata.clone(),
        attachments: summary.attachment_indexes.iter().map(|a| a.name.clone()).collect(),
    }
}
