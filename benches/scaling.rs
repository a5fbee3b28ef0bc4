//! Whole runs of a block that hits a wall, from 2 000 to 1 000 000 elements: time per element-step and memory per
//! element against size, the saving by inactive elements, and the gain of threads.
//!
//! `cargo bench --bench scaling`, or without the largest size `cargo bench --bench scaling -- 100000`. Each line is
//! the best of a few runs; times are of the wall clock, so that threads show, and other programs on the machine
//! lengthen them. The gain that the machine itself allows two threads is measured by two independent runs of one
//! thread side by side. A run steps a block of Mooney–Rivlin rubber into a frictionless wall at 20 m/s, without
//! recording.

use contuse::plan::{Plan, compile};
use contuse::scene::document::Keep;
use contuse::scene::{Budget, FolderSource, Scene, load};
use contuse::step::{Ending, Outcome, RunOptions, run};
use contuse::study::process::peak_memory_bytes;
use serde_json::json;
use std::time::Instant;

/// Elements along each axis, the first into the wall, and the number of steps and of runs.
const CASES: [([u32; 3], u32, u32); 3] =
    [([20, 10, 10], 100, 20), ([50, 50, 40], 60, 3), ([100, 100, 100], 20, 1)];
/// Edge of an element [m].
const EDGE: f64 = 1e-3;
/// Approximate critical time step of the scene [s].
const STEP: f64 = 3.0e-6;

fn main() {
    let most = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(usize::MAX);
    println!(
        "elements | threads | inactive skipped | steps | evaluated | s | ns/element-step evaluated | ns/element-step | plan+state B/element"
    );
    for (counts, steps, runs) in CASES {
        if counts.iter().product::<u32>() as usize > most {
            break;
        }
        for (threads, keep) in [(1, true), (2, true), (1, false), (2, false)] {
            if let Err(error) = measure(counts, steps, runs, threads, keep) {
                eprintln!("{error}");
            }
        }
        match side_by_side(counts, steps, runs) {
            Ok((alone, together)) => println!(
                "{} | two runs of one thread side by side: {together:.3} s, one alone: {alone:.3} s; two threads can gain {:.2}",
                counts.iter().product::<u32>(),
                2.0 * alone / together
            ),
            Err(error) => eprintln!("{error}"),
        }
    }
    if let Some(peak) = peak_memory_bytes() {
        println!("peak memory of the process: {:.1} MB", 1e-6 * peak as f64);
    }
}

fn scene(counts: [u32; 3], steps: u32, keep: bool) -> Result<Scene, String> {
    let size = counts.map(|n| EDGE * f64::from(n));
    let keep = if keep { vec![Keep::InactiveElements] } else { Vec::new() };
    let document = json!({
        "name": "block on wall", "end_time_s": STEP * f64::from(steps),
        "bodies": [{
            "name": "block", "velocity_m_per_s": [-20, 0, 0],
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": size, "elements": counts}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000,
                       "material": {"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 1e8}}]
        }],
        "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [1, 0, 0]}],
        "record": {"fields": [], "field_times_s": []}, "solver": {"keep": keep},
        "integrator": {"kind": "explicit", "max_step_s": STEP}
    });
    let document = document.to_string();
    let loaded = load(document.as_bytes(), &FolderSource::new("."), &Budget::COMMAND_LINE);
    Ok(loaded.map_err(|problems| problems.to_string())?.scene)
}

fn measure(counts: [u32; 3], steps: u32, runs: u32, threads: usize, keep: bool) -> Result<(), String> {
    let plan = compile(&scene(counts, steps, keep)?).map_err(|e| e.to_string())?;
    let mut best = f64::INFINITY;
    let mut last = None;
    for _ in 0..runs {
        let (seconds, outcome) = timed(&plan, threads)?;
        best = best.min(seconds);
        last = Some(outcome);
    }
    let Some(outcome) = last else { return Ok(()) };
    let evaluated = outcome.evaluated_element_steps as f64;
    println!(
        "{} | {threads} | {} | {} | {:.1} % | {best:.3} | {:.1} | {:.1} | {:.0}",
        plan.element_count(),
        if keep { "no" } else { "yes" },
        outcome.steps,
        100.0 * evaluated / outcome.element_steps as f64,
        1e9 * best / evaluated,
        1e9 * best / outcome.element_steps as f64,
        plan.report.memory.bytes_per_element,
    );
    Ok(())
}

fn timed(plan: &Plan, threads: usize) -> Result<(f64, Outcome), String> {
    let clock = Instant::now();
    let (outcome, _) = run(plan, &RunOptions { threads, interrupt: &|| None }, &mut []);
    let seconds = clock.elapsed().as_secs_f64();
    if outcome.ending == Ending::Finished {
        Ok((seconds, outcome))
    } else {
        Err(format!("{:?}", outcome.ending))
    }
}

/// Wall time [s] of a run of one thread alone, and of two such runs at once; each the best of `runs`, alternately.
fn side_by_side(counts: [u32; 3], steps: u32, runs: u32) -> Result<(f64, f64), String> {
    let plan = compile(&scene(counts, steps, true)?).map_err(|e| e.to_string())?;
    let (mut alone, mut together) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..runs {
        alone = alone.min(timed(&plan, 1)?.0);
        let clock = Instant::now();
        std::thread::scope(|scope| {
            let other = scope.spawn(|| timed(&plan, 1).map(drop));
            let own = timed(&plan, 1).map(drop);
            own.and(other.join().unwrap_or_else(|_| Err("the other run panicked".into())))
        })?;
        together = together.min(clock.elapsed().as_secs_f64());
    }
    Ok((alone, together))
}
