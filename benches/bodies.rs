//! Whole runs of many bodies and of many contacts: processor time, peak memory and size of the recording against their
//! number.
//!
//! `cargo bench --bench bodies`; with a number only the cases up to it. All on one thread, from the document to the
//! closed recording. The peak memory is that of the process since the case began, where the system reports it.
//!
//! - Blocks of 3³ elements in a cubic grid, 0.1 mm apart, columns of two speeds in turn above a floor: every two blocks
//!   may touch, and each touches its neighbours.
//! - Two blocks whose equal faces meet flat, one node on another: explicit steps, and five implicit ones.

use contuse::record::{McapRecorder, RecordingInfo};
use contuse::scene::{Budget, FolderSource, load};
use contuse::step::Ending;
use contuse::study::{RunRequest, RunResult, run_scene};
use serde_json::{Value, json};

/// Blocks of the grid, and nodes along each side of the flat faces.
const BLOCKS: [u32; 4] = [10, 100, 300, 1000];
const EXPLICIT: [u32; 5] = [10, 32, 64, 100, 200];
const IMPLICIT: [u32; 5] = [10, 17, 25, 39, 55];

fn main() {
    let most: u32 = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(u32::MAX);
    println!(
        "case | number | steps | most contacts | loading s | whole s | ms a step | peak MB | recording MB"
    );
    for blocks in BLOCKS.into_iter().filter(|number| *number <= most) {
        show("blocks", blocks, &grid(blocks));
    }
    for side in EXPLICIT.into_iter().filter(|side| side * side <= most) {
        show("explicit contacts", side * side, &flat(side, &json!({"kind": "explicit"}), 1e-4));
    }
    for side in IMPLICIT.into_iter().filter(|side| side * side <= most) {
        show(
            "implicit contacts",
            side * side,
            &flat(side, &json!({"kind": "implicit", "step_s": 1e-5}), 5e-5),
        );
    }
}

fn rubber() -> Value {
    json!({"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7})
}

fn body(name: &str, low: [f64; 3], high: [f64; 3], elements: [u32; 3], speed: f64) -> Value {
    json!({
        "name": name, "role": "other", "velocity_m_per_s": [0, 0, -speed],
        "mesh": {"generator": {"kind": "block", "min_m": low, "max_m": high, "elements": elements}},
        "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": rubber()}]
    })
}

fn grid(count: u32) -> Value {
    let side = (1..=count).find(|side| side * side * side >= count).unwrap_or(1);
    let at = |i: u32| [i % side, i / side % side, i / side / side];
    let bodies: Vec<Value> = (0..count)
        .map(|i| {
            let low = at(i).map(|place| 0.0101 * f64::from(place));
            let low = [low[0], low[1], low[2] + 1e-5];
            let speed = if (at(i)[0] + at(i)[1]).is_multiple_of(2) { 1.0 } else { 0.5 };
            body(&format!("block {i}"), low, low.map(|x| x + 0.01), [3; 3], speed)
        })
        .collect();
    json!({
        "name": "grid", "end_time_s": 4e-4, "bodies": bodies, "gravity_m_per_s2": [0, 0, -9.81],
        "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    })
}

fn flat(nodes: u32, integrator: &Value, end: f64) -> Value {
    let elements = [nodes - 1, nodes - 1, 4];
    let mut support = body("support", [0.0; 3], [0.1, 0.1, 0.03], elements, 0.0);
    support["fixed"] = json!([{"set": "z_min"}]);
    json!({
        "name": "flat", "end_time_s": end, "integrator": integrator,
        "bodies": [body("block", [0.0, 0.0, 0.030_000_1], [0.1, 0.1, 0.060_000_1], elements, 1.0), support],
        "contact": {"friction": 0.3, "self_contact": "none"},
        "record": {"fields": [], "field_times_s": []}
    })
}

fn show(case: &str, number: u32, scene: &Value) {
    match measured(scene) {
        Ok(line) => println!("{case} | {number} | {line}"),
        Err(error) => eprintln!("{case} | {number}: {error}"),
    }
}

fn measured(scene: &Value) -> Result<String, String> {
    forget_peak();
    let start = processor_s();
    let document = scene.to_string().into_bytes();
    let mut loaded =
        load(&document, &FolderSource::new("."), &Budget::COMMAND_LINE).map_err(|e| e.to_string())?;
    loaded.scene.document.solver.error_bars = contuse::scene::document::ErrorBarsDocument::None;
    let loading = processor_s() - start;
    let path = std::env::temp_dir().join(format!("contuse_bodies_{}.mcap", std::process::id()));
    let mut recorder = McapRecorder::new(&path, RecordingInfo::of(&loaded.scene, &document));
    let result = run_scene(RunRequest {
        scene: &loaded.scene,
        sinks: vec![&mut recorder],
        also: None,
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_| {},
    });
    let bytes = std::fs::metadata(&path).map_or(0, |file| file.len());
    std::fs::remove_file(&path).map_err(|error| error.to_string())?;
    let RunResult { outcome, .. } = result.map_err(|error| error.to_string())?;
    if outcome.ending != Ending::Finished {
        return Err(format!("{:?}", outcome.ending));
    }
    let whole = processor_s() - start;
    Ok(format!(
        "{} | {} | {loading:.2} | {whole:.2} | {:.2} | {:.0} | {:.2}",
        outcome.steps,
        outcome.most_contacts,
        1e3 * (whole - loading) / outcome.steps as f64,
        peak_mb(),
        1e-6 * bytes as f64
    ))
}

/// Processor time of the process [s], where the system reports it.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Begins a new peak of the resident memory.
fn forget_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    peak.and_then(|peak| peak.split_whitespace().next()?.parse::<f64>().ok())
        .map_or(f64::NAN, |kib| 1.024e-3 * kib)
}
