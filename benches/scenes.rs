//! Whole scenes on one thread, with and without a recording; an item is one element stepped once.
//!
//! `cargo bench --bench scenes`. The scene is loaded before the clock starts; compiling, stepping, measuring and recording
//! are timed. The columns are wall time, which other programs on the machine lengthen; the median processor time of the
//! process is printed below the table.

use contuse::measure::Sink;
use contuse::record::{McapRecorder, RecordingInfo};
use contuse::scene::document::ErrorBarsDocument;
use contuse::scene::{Budget, Loaded, load_file};
use contuse::study::{RunRequest, RunResult, run_scene};
use divan::Bencher;
use divan::counter::ItemsCount;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// One line for each case that ran.
static CPU_TIMES: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn main() {
    divan::main();
    for line in CPU_TIMES.lock().unwrap_or_else(PoisonError::into_inner).iter() {
        println!("{line}");
    }
}

/// A scenario, with or without a recording.
#[derive(Clone, Copy)]
struct Case {
    scenario: &'static str,
    document: &'static str,
    recorded: bool,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let how = if self.recorded { "recorded" } else { "not recorded" };
        write!(f, "{}/{}, {how}", self.scenario, self.document)
    }
}

fn cases() -> impl Iterator<Item = Case> {
    let scenes = [("ball_on_block", "scene.json"), ("flashball_thigh", "scene_elastic.json")];
    scenes
        .into_iter()
        .flat_map(|(scenario, document)| [false, true].map(|recorded| Case { scenario, document, recorded }))
}

/// The scene and its document; `None`, with a message on standard error, if it cannot be loaded.
fn load(case: &Case) -> Option<(Vec<u8>, Loaded)> {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(case.scenario).join(case.document);
    let document = std::fs::read(&path).map_err(|error| eprintln!("{}: {error}", path.display())).ok()?;
    let mut loaded =
        load_file(&path, &Budget::COMMAND_LINE).map_err(|problems| eprintln!("{problems}")).ok()?;
    // Only the run itself is timed, not the cheaper ones for its error bars.
    loaded.scene.document.solver.error_bars = ErrorBarsDocument::None;
    Some((document, loaded))
}

fn run(document_json: &[u8], loaded: &Loaded, recording: Option<&Path>) -> Option<RunResult> {
    let recorder_to = |path| McapRecorder::new(path, RecordingInfo::of(&loaded.scene, document_json));
    let mut recorder = recording.map(recorder_to);
    let request = RunRequest {
        scene: &loaded.scene,
        sinks: recorder.iter_mut().map(|recorder| recorder as &mut dyn Sink).collect(),
        also: None,
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_| {},
    };
    run_scene(request).map_err(|error| eprintln!("{error}")).ok()
}

/// From the loaded scene to the summary, and to the closed recording if there is one.
#[divan::bench(args = cases(), sample_count = 20)]
fn whole_scene(bencher: Bencher, case: Case) {
    let Some((document, loaded)) = load(&case) else { return };
    let folder = std::env::temp_dir();
    let recording: Option<PathBuf> =
        case.recorded.then(|| folder.join(format!("contuse-bench-{}.mcap", std::process::id())));
    let Some(first) = run(&document, &loaded, recording.as_deref()) else { return };
    let mut cpu_s = Vec::new();
    bencher.counter(ItemsCount::new(first.outcome.element_steps)).bench_local(|| {
        let result = run(&document, &loaded, recording.as_deref());
        cpu_s.extend(result.and_then(|r| r.cpu_s));
    });
    cpu_s.sort_by(f64::total_cmp);
    let median = cpu_s.get(cpu_s.len() / 2).copied().unwrap_or(f64::NAN);
    let (elements, steps) = (first.plan_report.elements, first.outcome.steps);
    let line = format!("{case}: {elements} elements, {steps} steps, {median:.3} s of processor time");
    CPU_TIMES.lock().unwrap_or_else(PoisonError::into_inner).push(line);
    if let Some(path) = &recording
        && let Err(error) = std::fs::remove_file(path)
    {
        eprintln!("{}: {error}", path.display());
    }
}
