//! `contuse plan`: the plan of a scene, what was omitted and why, and the expected cost.

use super::json::write_json;
use super::keep::KeepArgs;
use super::{CliError, Exit};
use crate::plan::{PlanReport, compile};
use crate::scene::{Budget, Scene, load_file};
use clap::Args;
use std::io::{self, Write};
use std::path::PathBuf;

/// Arguments of `contuse plan`.
#[derive(Args, Debug)]
pub struct PlanArgs {
    /// Scene document; its mesh files are in the same folder.
    pub scene: PathBuf,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
    /// Omitted items to restore in this plan.
    #[command(flatten)]
    pub keep: KeepArgs,
}

/// Compiles a scene and shows its plan, without running it.
///
/// # Errors
/// The errors in the scene.
pub fn plan(args: &PlanArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let mut loaded = load_file(&args.scene, &Budget::COMMAND_LINE)?;
    loaded.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    loaded.scene.restore(&args.keep.keep);
    let report = report_of(&loaded.scene)?;
    if args.json {
        write_json(&report, out)?;
    } else {
        write_report(&loaded.scene.document.name, loaded.scene.document.end_time_s, &report, out)?;
    }
    Ok(Exit::Success)
}

/// Compiles a scene and returns the report of its plan.
pub(super) fn report_of(scene: &Scene) -> Result<PlanReport, CliError> {
    Ok(compile(scene).map_err(|error| CliError::Other(Box::new(error)))?.report)
}

fn write_report(name: &str, end_time_s: f64, report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{name}: {} elements, {} nodes", report.elements, report.nodes)?;
    writeln!(
        out,
        "at least {} steps to {:.4} ms: {} on one core if every element is active, {} of memory",
        report.expected_steps,
        1e3 * end_time_s,
        duration(report.expected_run_time_s),
        bytes(report.memory_bytes)
    )?;
    write_elements(report, out)?;
    write_named_materials(report, out)?;
    if let Some(capped) = &report.capped_bulk_moduli {
        writeln!(out, "\n{capped}")?;
    }
    write_refinements(report, out)?;
    write_step(report, out)?;
    write_rigid_bodies(report, out)?;
    write_contact(report, out)?;
    write_memory(report, out)?;
    write_omitted(report, out)
}

fn write_elements(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "\nElements")?;
    let header = ["part", "number", "law", "formulation", "critical step", "M el.-steps/s"];
    let rows = report.blocks.iter().map(|block| {
        let fibres = if block.fibre_families == 0 {
            String::new()
        } else {
            format!(", {} fibre families", block.fibre_families)
        };
        [
            format!("{}/{}", block.body, block.parts.join(",")),
            block.elements.to_string(),
            format!("{}{fibres}", block.law),
            block.formulation.clone(),
            format!("{:.4} µs", 1e6 * block.smallest_stable_step_s),
            format!("{:.1}", 1e-6 * block.element_steps_per_s),
        ]
    });
    write_table(&header, &rows.collect::<Vec<_>>(), out)?;
    match report.block_count - report.blocks.len() {
        0 => Ok(()),
        others => writeln!(out, "and {others} other blocks"),
    }
}

fn write_named_materials(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    if report.named_materials.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nMaterials of the library")?;
    for named in &report.named_materials {
        writeln!(out, "  {}/{}: {}, {}", named.body, named.part, named.library, named.resolved)?;
        named.sources.iter().try_for_each(|source| writeln!(out, "    {source}"))?;
    }
    Ok(())
}

fn write_refinements(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    if report.refinements.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nLocal refinement")?;
    report.refinements.iter().try_for_each(|refinement| writeln!(out, "  {}", refinement.in_words()))
}

fn write_step(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    let step = &report.stable_step;
    writeln!(out, "\nStep")?;
    if let Some(choice) = &report.integrator.choice {
        writeln!(out, "  {}, chosen by cost: {}", choice.chosen, choice.in_words())?;
    }
    // Implicit runs: size of the linear systems.
    if let Some(systems) = &report.integrator.systems {
        writeln!(
            out,
            "  {:.4} µs, implicit: {} unknowns, factor of {:.2} M entries, {:.3} GFLOP a factorisation",
            1e6 * report.integrator.step_s,
            systems.unknowns,
            1e-6 * systems.factor_entries as f64,
            1e-9 * systems.factor_flops
        )?;
        writeln!(out, "  an explicit step could be this long:")?;
    }
    // Critical time step and its distribution over the elements.
    let limit = if step.limited_by_scene {
        "the scene's max_step_s is shorter".to_owned()
    } else {
        format!("{} of the critical time step", step.safety_factor)
    };
    writeln!(out, "  {:.4} µs at the start: {limit}", 1e6 * report.stable_step_s)?;
    writeln!(
        out,
        "  critical time step {:.4} µs, from element {} of part {} of {}",
        1e6 * step.smallest_s,
        step.element,
        step.part,
        step.body
    )?;
    for within in &step.distribution {
        writeln!(
            out,
            "  within {} times that: {} elements, {:.1} %",
            within.times_smallest,
            within.elements,
            100.0 * within.fraction
        )?;
    }
    Ok(())
}

fn write_rigid_bodies(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    if report.rigid_bodies.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nRigid bodies")?;
    let header = ["body", "shape", "mass", "moments of inertia"];
    let rows = report.rigid_bodies.iter().map(|body| {
        let moments = body.inertia_kg_m2.map(|moment| format!("{moment:.3e}")).join(", ");
        [
            body.body.clone(),
            body.shape.clone(),
            format!("{:.4e} kg", body.mass_kg),
            format!("{moments} kg m²"),
        ]
    });
    write_table(&header, &rows.collect::<Vec<_>>(), out)
}

fn write_contact(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    if report.pairs.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nContact")?;
    let header = ["pair", "slave nodes", "master faces", "friction", "unknowns per contact"];
    let rows = report.pairs.iter().map(|pair| {
        [
            pair.name.clone(),
            pair.slave_nodes.to_string(),
            pair.master_faces.map_or_else(|| pair.master_in_words(), |faces| faces.to_string()),
            pair.friction.to_string(),
            pair.unknowns_per_contact.to_string(),
        ]
    });
    write_table(&header, &rows.collect::<Vec<_>>(), out)?;
    match report.pair_count - report.pairs.len() {
        0 => Ok(()),
        others => writeln!(out, "and {others} other pairs"),
    }
}

fn write_memory(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    let memory = &report.memory;
    writeln!(out, "\nMemory, {:.0} bytes per element", memory.bytes_per_element)?;
    let parts = [
        ("program", memory.program_bytes),
        ("start", memory.start_bytes),
        ("scene", memory.scene_bytes),
        ("plan", memory.plan_bytes),
        ("elements", memory.elements_bytes),
        ("state", memory.state_bytes),
        ("work arrays", memory.step_bytes),
        ("contact", memory.contact_bytes),
        ("fields", memory.fields_bytes),
        ("measures", memory.measures_bytes),
        ("frames", memory.frames_bytes),
    ];
    parts.into_iter().try_for_each(|(name, size)| writeln!(out, "  {name:<18} {:>10}", bytes(size)))
}

fn write_omitted(report: &PlanReport, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "\nOmitted")?;
    for left in &report.omitted {
        let switch = left.switch.map(|keep| format!(" [--keep {keep}]")).unwrap_or_default();
        writeln!(out, "  {}: {}{switch}", left.what, left.why)?;
    }
    if !report.restored.is_empty() {
        let names: Vec<&str> = report.restored.iter().map(|keep| keep.name()).collect();
        writeln!(out, "\nRestored: {}", names.join(", "))?;
    }
    Ok(())
}

/// Writes a table with columns as wide as necessary.
pub(super) fn write_table(
    header: &[impl AsRef<str>],
    rows: &[impl AsRef<[String]>],
    out: &mut dyn Write,
) -> io::Result<()> {
    let header: Vec<&str> = header.iter().map(AsRef::as_ref).collect();
    let cells = |row: &[String]| row.iter().map(|cell| cell.chars().count()).collect::<Vec<_>>();
    let mut widths: Vec<usize> = header.iter().map(|name| name.chars().count()).collect();
    for row in rows {
        widths.iter_mut().zip(cells(row.as_ref())).for_each(|(width, cell)| *width = (*width).max(cell));
    }
    let mut write = |row: &mut dyn Iterator<Item = &str>| {
        let padded: Vec<String> = row.zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        writeln!(out, "  {}", padded.join("  ").trim_end())
    };
    write(&mut header.iter().copied())?;
    rows.iter().try_for_each(|row| write(&mut row.as_ref().iter().map(String::as_str)))
}

/// Formats a number of bytes.
pub(super) fn bytes(count: u64) -> String {
    let count = count as f64;
    if count < 1e6 { format!("{:.1} kB", 1e-3 * count) } else { format!("{:.1} MB", 1e-6 * count) }
}

/// Formats a duration [s].
pub(super) fn duration(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.1} ms", 1e3 * seconds) } else { format!("{seconds:.2} s") }
}
