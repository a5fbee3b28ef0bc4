//! A step allocates nothing, counted by an allocator that keeps a number for each thread; and a run takes about the memory that its plan says.
#![allow(clippy::unwrap_used, clippy::expect_used)] // tests may panic

use contuse::measure::{Measures, MeasuringRecorder};
use contuse::plan::compile;
use contuse::record::{McapRecorder, RecordingInfo, on_own_thread};
use contuse::scene::{Budget, FolderSource, Loaded, load, load_file};
use contuse::step::{Ending, Frame, Recorder, RecorderError, RunOptions, run};
use serde_json::json;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::process::Command;

/// Steps until everything that is made at its first use has been made: the memory of a thread for waiting on a channel, the
/// first lists of the broad phase.
const WARM_UP: u64 = 10;
/// Allocations of a thread that waits for another for the first time: how soon the recorder's thread is behind is a matter of the clock.
const FIRST_WAITS: u64 = 4;

/// The system's allocator, which counts.
struct Counting;

thread_local! {
    /// Allocations of this thread so far.
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // A thread that is ending has no number any more.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: everything is the system allocator's; counting touches a thread-local cell without a destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as the caller promised.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What one step allocated.
#[derive(Clone, Copy, Debug)]
struct Seen {
    step: u64,
    contacts: usize,
    #[allow(dead_code)] // shown when the test fails
    is_field_time: bool,
    /// Allocations from the frame before to this one.
    allocations: u64,
}

/// Looks at the number of its thread at every frame; the last of the recorders, so that the others are in it.
struct Probe {
    last: u64,
    seen: Vec<Seen>,
}

impl Recorder for Probe {
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let now = COUNT.with(Cell::get);
        let (step, contacts, is_field_time) = (frame.step, frame.contacts.len(), frame.is_field_time);
        self.seen.push(Seen { step, contacts, is_field_time, allocations: now - self.last });
        self.last = COUNT.with(Cell::get);
        Ok(())
    }
}

/// A recorded run of a ball that strikes a block with friction, step by step.
fn look(threads: usize) -> Vec<Seen> {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ball_on_block/scene.json");
    look_at(&load_file(&scene, &Budget::COMMAND_LINE).expect("it is valid"), threads)
}

/// A recorded run, step by step.
fn look_at(loaded: &Loaded, threads: usize) -> Vec<Seen> {
    let plan = compile(&loaded.scene).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut recorder = McapRecorder::new(&path, RecordingInfo::default());
    let mut measuring = MeasuringRecorder::new(Measures::new()).with(&mut recorder);
    let mut probe = Probe { last: 0, seen: Vec::with_capacity(100_000) };
    let options = RunOptions { threads, interrupt: &|| None };
    let (outcome, _) =
        on_own_thread(&plan, &mut measuring, |recorder| run(&plan, &options, &mut [recorder, &mut probe]));
    assert_eq!(outcome.ending, Ending::Finished);
    assert!(path.exists());
    probe.seen
}

/// After the first steps nothing is allocated but for waiting: once for orders, once for answers.
fn assert_nothing_allocates(seen: &[Seen]) {
    let later = || seen.iter().filter(|s| s.step >= WARM_UP && s.allocations > 0);
    let all: u64 = later().map(|s| s.allocations).sum();
    assert!(later().count() <= 2 && all <= FIRST_WAITS, "{seen:#?}");
}

#[test]
fn a_step_in_contact_allocates_nothing() {
    let seen = look(1);
    let most = seen.iter().map(|s| s.contacts).max().unwrap();
    assert!(most > 100 && seen.len() > 60, "{most} contacts, {} steps", seen.len());
    assert_nothing_allocates(&seen);
}

#[test]
fn a_step_of_rigid_bodies_allocates_nothing() {
    let shapes = [
        json!({"kind": "box", "half_extents_m": [0.1, 0.1, 0.05]}),
        json!({"kind": "box", "half_extents_m": [0.06, 0.06, 0.05]}),
        json!({"kind": "box", "half_extents_m": [0.05, 0.05, 0.05]}),
        json!({"kind": "ball", "radius_m": 0.05}),
    ];
    let bodies = shapes.iter().enumerate().map(|(i, shape)| {
        json!({
            "name": format!("body {i}"),
            "rigid": {"shape": shape, "center_m": [0, 0, 0.05 + 0.1 * i as f64], "density_kg_per_m3": 1000},
            "spin_rad_per_s": [0, 0, i]
        })
    });
    let document = json!({
        "name": "a pile",
        "end_time_s": 0.1,
        "bodies": bodies.collect::<Vec<_>>(),
        "planes": [{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": 0.3},
        "gravity_m_per_s2": [0, 0, -9.81],
        "integrator": {"kind": "explicit", "max_step_s": 1e-3},
        "record": {"fields": []}
    });
    let source = FolderSource::new(Path::new("."));
    let loaded = load(document.to_string().as_bytes(), &source, &Budget::COMMAND_LINE).expect("it is valid");
    let seen = look_at(&loaded, 1);
    assert!(seen.len() > 90 && seen.iter().all(|s| s.contacts >= 4), "{seen:#?}");
    assert_nothing_allocates(&seen);
}

#[test]
fn with_a_pool_only_the_pool_allocates() {
    // A call into rayon's pool may extend its queue of jobs by a block, now and then.
    let seen = look(2);
    let later: Vec<u64> = seen.iter().filter(|s| s.step >= WARM_UP).map(|s| s.allocations).collect();
    println!("{later:?}");
    assert!(later.iter().sum::<u64>() <= 2 * later.len() as u64, "{later:?}");
}

#[test]
#[cfg(target_os = "linux")] // others are not asked
fn a_run_takes_about_the_memory_that_its_plan_says() {
    // One symmetric, of which a quarter is computed, one of elements of a file, and one of few.
    for name in ["flashball_thigh/scene.json", "ball_on_block/scene_L1.json", "two_bars/scene.json"] {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name);
        let planned =
            compile(&load_file(&scene, &Budget::COMMAND_LINE).unwrap().scene).unwrap().report.memory_bytes
                as f64;
        let folder = tempfile::tempdir().unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_contuse"));
        program.arg("run").arg(&scene).args(["--as-is", "--no-error-bars", "--threads", "2", "-o"]);
        let output = program.arg(folder.path().join("run.mcap")).output().unwrap();
        // `…, 89.4 MB of memory; recording: …` is its last line.
        let words = String::from_utf8(output.stdout).unwrap();
        let (before, _) = words.rsplit_once(" MB of memory").unwrap();
        let taken = 1e6 * before.rsplit(' ').next().unwrap().parse::<f64>().unwrap();
        assert!((0.8..1.25).contains(&(taken / planned)), "{name}: {taken:e} of {planned:e}");
    }
}
