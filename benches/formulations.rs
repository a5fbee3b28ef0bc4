//! Error against run time of the element formulations: `ball_on_block` on three meshes, to 25 and to 50 µs, one
//! thread, without recording.
//!
//! `cargo bench --bench formulations` prints a table: impulse, its error relative to the result of an independent
//! code (penalty contact, three meshes, uncertain by 2 to 3 %) on the finest mesh, and the processor time of the run
//! to 50 µs.

use contuse::scene::{Budget, FolderSource, load};
use contuse::step::Ending;
use contuse::study::{RunRequest, run_scene};
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

const MESHES: [&str; 3] = ["scene.json", "scene_L1.json", "scene_L2.json"];
const FORMULATIONS: [&str; 3] = ["mean_dilatation", "full", "reduced"];
/// Times [s] and the impulse of the independent code there [N s].
const REFERENCE: [(f64, f64); 2] = [(25e-6, 0.0244), (50e-6, 0.0752)];

fn main() -> Result<(), Box<dyn Error>> {
    println!("| mesh | formulation | impulse at 25 µs | error | at 50 µs | error | steps | s |");
    println!("|---|---|---|---|---|---|---|---|");
    for mesh in MESHES {
        for formulation in FORMULATIONS {
            let mut line = format!("| `{mesh}` | {formulation} |");
            let mut last = None;
            for (end, reference) in REFERENCE {
                let found = measure(mesh, formulation, end)?;
                let error = 100.0 * (found.impulse / reference - 1.0);
                line = format!("{line} {:.4} | {error:+.1} % |", found.impulse);
                last = Some(found);
            }
            if let Some(last) = last {
                println!("{line} {} | {:.2} |", last.steps, last.cpu_s);
            }
        }
    }
    Ok(())
}

struct Found {
    /// Impulse of the contact at the end [N s].
    impulse: f64,
    steps: u64,
    cpu_s: f64,
}

fn measure(mesh: &str, formulation: &str, end: f64) -> Result<Found, Box<dyn Error>> {
    // The scenario with another end time and formulation, without error bars and fields.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ball_on_block");
    let mut document: Value = serde_json::from_slice(&std::fs::read(folder.join(mesh))?)?;
    document["end_time_s"] = json!(end);
    document["solver"] = json!({"error_bars": "none"});
    document["record"] = json!({"fields": [], "field_times_s": []});
    for body in document["bodies"].as_array_mut().into_iter().flatten() {
        for part in body["parts"].as_array_mut().into_iter().flatten() {
            part["formulation"] = json!(formulation);
        }
    }
    let document_json = serde_json::to_vec(&document)?;
    let scene = load(&document_json, &FolderSource::new(&folder), &Budget::COMMAND_LINE)?.scene;
    let result = run_scene(RunRequest {
        scene: &scene,
        sinks: Vec::new(),
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_| {},
        also: None,
    })?;
    if result.outcome.ending != Ending::Finished {
        return Err(format!("{:?}", result.outcome.ending).into());
    }
    let impact = result.summary.values().impacts.first().ok_or("no impact")?;
    Ok(Found {
        impulse: impact.impulse_n_s.value,
        steps: result.outcome.steps,
        cpu_s: result.cpu_s.unwrap_or(f64::NAN),
    })
}
