//! `contuse validate`: errors in a scene, and its properties.

use super::keep::KeepArgs;
use super::plan::{duration, report_of};
use super::{CliError, Exit};
use crate::plan::PlanReport;
use crate::scene::summary::BodySummary;
use crate::scene::{Budget, Loaded, Problem, Problems, load_file};
use clap::Args;
use serde_json::json;
use std::io::{self, Write};
use std::path::PathBuf;

/// Arguments of `contuse validate`.
#[derive(Args, Debug)]
pub struct ValidateArgs {
    /// Scene document; its mesh files are in the same folder.
    pub scene: PathBuf,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
    /// Omitted items to restore in the estimate.
    #[command(flatten)]
    pub keep: KeepArgs,
}

/// Checks a scene and reports the findings. Exit code 0 if it can run, 2 if it cannot.
///
/// # Errors
/// If the answer cannot be written.
pub fn validate(args: &ValidateArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let outcome = load_file(&args.scene, &Budget::COMMAND_LINE).map(|mut loaded| {
        loaded.scene.restore(&args.keep.keep);
        loaded
    });
    // A valid scene is compiled to show its plan.
    let plan = outcome.as_ref().ok().map(|loaded| report_of(&loaded.scene)).transpose()?;
    let exit = if outcome.is_ok() { Exit::Success } else { Exit::InvalidInput };
    if args.json {
        writeln!(out, "{:#}", as_json(&outcome, plan.as_ref()))?;
        return Ok(exit);
    }
    match &outcome {
        Ok(loaded) => {
            write_bodies(&loaded.bodies, out)?;
            let e = &loaded.estimate;
            writeln!(
                out,
                "estimate: {} elements, {} nodes, at least {} steps, {} MB of memory, {} frames",
                e.elements,
                e.nodes,
                e.steps,
                e.memory_bytes.div_ceil(1_000_000),
                e.frames
            )?;
            plan.iter().try_for_each(|plan| write_plan(plan, out))?;
            writeln!(out, "content: {}", loaded.scene.content_hash)?;
            write_problems(&loaded.warnings, out)?;
            writeln!(out, "the scene is valid, with {} warning(s)", loaded.warnings.len())?;
        }
        Err(problems) => {
            write_problems(&problems.0, out)?;
            let (errors, warnings) = (problems.error_count(), problems.warning_count());
            writeln!(out, "the scene is not valid: {errors} error(s), {warnings} warning(s)")?;
        }
    }
    Ok(exit)
}

fn as_json(outcome: &Result<Loaded, Problems>, plan: Option<&PlanReport>) -> serde_json::Value {
    match outcome {
        Ok(loaded) => json!({
            "valid": true,
            "problems": loaded.warnings,
            "bodies": loaded.bodies,
            "estimate": loaded.estimate,
            "plan": plan,
            "content_hash": loaded.scene.content_hash,
        }),
        Err(problems) => json!({ "valid": false, "problems": problems }),
    }
}

/// Summary of the plan in a few lines; `contuse plan` gives the details.
fn write_plan(plan: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    if let Some(choice) = &plan.integrator.choice {
        writeln!(out, "{} steps, chosen by cost: {}", choice.chosen, choice.in_words())?;
    }
    let omitted: Vec<&str> = plan.omitted.iter().map(|l| l.what.as_str()).collect();
    writeln!(
        out,
        "plan: at least {} {} steps of {:.4} µs, {} on one core; omitted: {}",
        plan.expected_steps,
        plan.integrator.kind,
        1e6 * plan.integrator.step_s,
        duration(plan.expected_run_time_s),
        omitted.join("; ")
    )?;
    plan.capped_bulk_moduli.iter().try_for_each(|capped| writeln!(out, "{capped}"))
}

fn write_bodies(bodies: &[BodySummary], out: &mut dyn Write) -> io::Result<()> {
    for body in bodies {
        let [low, high] = body.bounding_box_m;
        let size: Vec<String> = low.iter().zip(high).map(|(a, b)| format!("{:.4}", b - a)).collect();
        writeln!(
            out,
            "body {}: {} elements, {} nodes, {:.6e} kg, {:.6e} m³, {} m",
            body.name,
            body.elements,
            body.nodes,
            body.mass_kg,
            body.volume_m3,
            size.join(" × ")
        )?;
        if let Some(quality) = &body.quality {
            writeln!(
                out,
                "  quality: scaled Jacobian ≥ {:.3} (element {}), aspect ratio ≤ {:.1}, shortest edge {:.3e} m",
                quality.min_scaled_jacobian,
                quality.worst_element,
                quality.max_aspect_ratio,
                quality.min_edge_m
            )?;
        }
        for part in &body.parts {
            writeln!(out, "  part {}: {} elements, {:.6e} kg", part.name, part.elements, part.mass_kg)?;
        }
        for note in &body.notes {
            writeln!(out, "  note: {note}")?;
        }
    }
    Ok(())
}

fn write_problems(problems: &[Problem], out: &mut dyn Write) -> io::Result<()> {
    for problem in problems {
        let severity = if problem.is_error() { "error" } else { "warning" };
        let place = if problem.pointer.is_empty() { "the document" } else { &problem.pointer };
        writeln!(out, "{severity}: {place}: {} [{}]", problem.message, problem.code)?;
        if !problem.value.is_null() {
            writeln!(out, "    found:  {}", problem.value)?;
        }
        for (label, text) in [("limit: ", &problem.limit), ("remedy:", &problem.remedy)] {
            if !text.is_empty() {
                writeln!(out, "    {label} {text}")?;
            }
        }
    }
    Ok(())
}
