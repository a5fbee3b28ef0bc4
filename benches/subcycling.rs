//! What subcycling saves and changes: whole runs with it, and with every element evaluated in every step.
//!
//! `cargo bench --bench subcycling`. Runs alternate, twice each on one thread; the lower time counts. The thigh scenes keep the end
//! times of their scenarios; the ball strikes a block of gel like those of the ordinary impacts of `contuse study stability`.

use contuse::scene::{Budget, FolderSource, load};
use contuse::study::{RunRequest, RunResult, run_scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() {
    println!(
        "scene | time whole, subcycled [s] | steps | evaluated [%] | balance [%] | peak force [N] | impulse [N s]"
    );
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for name in ["ball_on_block", "flashball_thigh", "flashball_44mm_on_thigh", "steel_ball_on_thigh"] {
        let folder = scenarios.join(name);
        let text = std::fs::read_to_string(folder.join("scene.json")).unwrap_or_default();
        let Ok(scene) = serde_json::from_str::<Value>(&text) else { continue };
        compare(name, &scene, folder);
    }
    for speed in [12, 30, 50] {
        compare(&format!("ball on gel, {speed} m/s"), &ball_on_gel(speed), scenarios.clone());
    }
}

/// A rigid ball of 72 mm and 160 g over a block of gel of 4 800 elements.
fn ball_on_gel(speed: u32) -> Value {
    json!({
        "name": "ball on gel", "end_time_s": 0.003,
        "bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -f64::from(speed)],
             "rigid": {"shape": {"kind": "ball", "radius_m": 0.036}, "mass_kg": 0.16, "center_m": [0, 0, 0.0362]}},
            {"name": "gel", "role": "tissue", "fixed": [{"set": "z_min"}],
             "mesh": {"generator": {"kind": "block", "min_m": [-0.1, -0.1, -0.06], "max_m": [0.1, 0.1, 0], "elements": [20, 20, 12]}},
             "parts": [{"part": "*", "density_kg_per_m3": 1030, "shear_viscosity_pa_s": 5,
                        "material": {"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 5e7}}]}
        ],
        "contact": {"friction": 0.3}
    })
}

/// Prints a line of the table.
fn compare(name: &str, scene: &Value, folder: PathBuf) {
    let source = FolderSource::new(folder);
    let mut best: [Option<(f64, RunResult)>; 2] = [None, None];
    for turn in 0..4 {
        let which = turn % 2;
        let mut scene = scene.clone();
        if scene["integrator"].is_null() {
            scene["integrator"] = json!({"kind": "explicit"});
        }
        scene["integrator"]["subcycling"] = json!(which == 1);
        scene["solver"]["error_bars"] = json!("none");
        if let Some(scene) = scene.as_object_mut() {
            scene.remove("accuracy");
        }
        let Ok(loaded) = load(scene.to_string().as_bytes(), &source, &Budget::COMMAND_LINE) else { return };
        let begin = Instant::now();
        let request = RunRequest {
            scene: &loaded.scene,
            sinks: Vec::new(),
            also: None,
            threads: 1,
            interrupt: &|| None,
            progress: &mut |_| {},
        };
        let Ok(result) = run_scene(request) else { return };
        let seconds = begin.elapsed().as_secs_f64();
        if best[which].as_ref().is_none_or(|(least, _)| seconds < *least) {
            best[which] = Some((seconds, result));
        }
    }
    let [Some(whole), Some(subcycled)] = best else { return };
    let both =
        |value: &dyn Fn(&(f64, RunResult)) -> String| format!("{}, {}", value(&whole), value(&subcycled));
    let evaluated = |(_, result): &(f64, RunResult)| {
        let outcome = &result.outcome;
        let fraction = outcome.evaluated_element_steps as f64 / outcome.element_steps.max(1) as f64;
        format!("{:.0}", 100.0 * fraction)
    };
    let impact = |result: &RunResult| {
        result.summary.values().impacts.first().map(|i| (i.peak_force_n.value, i.impulse_n_s.value))
    };
    println!(
        "{name} | {} | {} | {} | {} | {} | {}",
        both(&|(seconds, _)| format!("{seconds:.2}")),
        both(&|(_, result)| result.outcome.steps.to_string()),
        both(&evaluated),
        both(&|(_, result)| format!("{:.3}", 100.0 * result.outcome.balance_error)),
        both(&|(_, result)| impact(result).map_or_else(String::new, |(force, _)| format!("{force:.0}"))),
        both(&|(_, result)| impact(result).map_or_else(String::new, |(_, impulse)| format!("{impulse:.4}"))),
    );
}
