//! `contuse study error`: error against run time of one scene.

use super::json::write_json;
use super::output_file::{CSV, check_output, write_file};
use super::picture::PictureArgs;
use super::plan::{duration, write_table};
use super::run::{announce, available_threads, exit_of_study, read_scene, watch_for_ctrl_c};
use super::{CliError, Exit};
use crate::measure::QuantityOfInterest;
use crate::scene::document::{ContactSolver, Formulation};
use crate::scene::{Budget, FolderSource};
use crate::step::Interrupt;
use crate::study::error::{
    Advice, Approach, COARSEST, ErrorRequest, ErrorStudy, FINEST, Geometry, Ladder, Reference, Row, TARGETS,
    USUAL_LEVELS, chart, study_error,
};
use clap::Args;
use clap::builder::RangedI64ValueParser;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Meshes of the ladder.
#[derive(Args, Debug)]
pub struct MeshArgs {
    /// Coarsest mesh: −1 halves the numbers of elements of generated meshes.
    #[arg(long, default_value_t = *USUAL_LEVELS.start(), allow_negative_numbers = true, value_parser = levels(&COARSEST))]
    pub coarsest: i32,
    /// Finest mesh: each level splits every element into eight, and takes sixteen times as long.
    #[arg(long, default_value_t = *USUAL_LEVELS.end(), allow_negative_numbers = true, value_parser = levels(&FINEST))]
    pub finest: i32,
    /// A mesh between each level and the next, √2 times as fine, so that limits are fitted to more meshes.
    #[arg(long)]
    pub half_levels: bool,
}

/// Arguments of `contuse study error`.
#[derive(Args, Debug)]
pub struct ErrorArgs {
    /// Scene document; its mesh files and `expected.json` are in the same folder.
    pub scene: PathBuf,
    /// Meshes of the ladder.
    #[command(flatten)]
    pub meshes: MeshArgs,
    /// Additional formulations, each run on all meshes.
    #[arg(long, value_delimiter = ',')]
    pub formulations: Vec<Formulation>,
    /// Additional implicit runs with steps of these lengths [s].
    #[arg(long, value_delimiter = ',')]
    pub implicit_steps: Vec<f64>,
    /// Additional solvers of contact problems (see `contuse contact-problem`), run on the scene's own mesh: with its
    /// own time integration and with each of the implicit steps.
    #[arg(long, value_delimiter = ',')]
    pub contact_solvers: Vec<ContactSolver>,
    /// Separate the geometry error: run the next finer mesh on the facets of the scene's own, too.
    #[arg(long)]
    pub geometry: bool,
    /// Combine reduced boundary mass and implicit steps with every mesh and formulation, the steps as long as the
    /// elements allow.
    #[arg(long)]
    pub combined: bool,
    /// Threads of each run; all cores by default.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
    /// Write the runs as CSV.
    #[arg(long)]
    pub csv: Option<PathBuf>,
    /// Output files of the picture.
    #[command(flatten)]
    pub picture: PictureArgs,
}

fn levels(offered: &RangeInclusive<i32>) -> RangedI64ValueParser<i32> {
    clap::value_parser!(i32).range(i64::from(*offered.start())..=i64::from(*offered.end()))
}

/// Runs the study. Exit code 3 if no setting finished, 4 if it was stopped.
///
/// # Errors
/// Errors in the scene, its `expected.json`, or the flags.
pub fn error(args: &ErrorArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    args.csv.iter().try_for_each(|path| check_output(path, &CSV, "--csv"))?;
    args.picture.check()?;
    let (_, loaded) = read_scene(&args.scene)?;
    loaded.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    let known = known_values(&args.scene)?;
    let folder = args.scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let ladder = Ladder {
        levels: args.meshes.coarsest..=args.meshes.finest,
        half_levels: args.meshes.half_levels,
        formulations: &args.formulations,
        implicit_steps_s: &args.implicit_steps,
        contact_solvers: &args.contact_solvers,
        geometry: args.geometry,
        combined: args.combined,
    };
    let cancelled = watch_for_ctrl_c()?;
    let study = study_error(&mut ErrorRequest {
        document: &loaded.scene.document,
        source: &FolderSource::new(folder),
        budget: &Budget::COMMAND_LINE,
        ladder: &ladder.settings(),
        known: &known,
        threads: args.threads.map_or_else(available_threads, usize::from),
        interrupt: &|| cancelled.load(Ordering::Relaxed).then_some(Interrupt::Cancel),
        progress: &mut |number, count, setting| announce(number, count, &setting.name()),
    });
    // Results go to the requested files and to standard output.
    if let Some(path) = &args.csv {
        write_file(path, |file| file.write_all(csv(&study).as_bytes()))?;
    }
    args.picture.write(|| chart(&study))?;
    if args.json {
        write_json(&study, out)?;
    } else {
        write_study(&study, out)?;
    }
    Ok(exit_of_study(study.stopped.as_ref(), &study.rows))
}

/// Exact values declared in `expected.json` beside the scene, `{"scene.json": {"exact": {"impulse_n_s": 0.2}}}`, and those of another
/// code, `"reference": {"impulse_n_s": {"value": 0.2, "uncertainty": 0.01}}`.
fn known_values(scene: &Path) -> Result<BTreeMap<QuantityOfInterest, Reference>, CliError> {
    let path = scene.with_file_name("expected.json");
    let Ok(bytes) = std::fs::read(&path) else { return Ok(BTreeMap::new()) };
    let wrong = |what: String| CliError::Usage(format!("{}: {what}", path.display()));
    let expected: Value = serde_json::from_slice(&bytes).map_err(|error| wrong(error.to_string()))?;
    let name = scene.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let entry = |of: &str, name: &str, value: &Value| {
        let known = || QuantityOfInterest::ALL.map(QuantityOfInterest::name).join(", ");
        let quantity = QuantityOfInterest::from_name(name)
            .ok_or_else(|| wrong(format!("{of}: no quantity is called {name:?}; there are {}", known())))?;
        let reference = match (value.as_f64(), value["value"].as_f64(), value["uncertainty"].as_f64()) {
            (Some(value), ..) => Reference::Exact { value },
            (None, Some(value), Some(uncertainty)) => Reference::Given { value, uncertainty },
            _ => return Err(wrong(format!("{of}: {name} is not a number"))),
        };
        Ok((quantity, reference))
    };
    let declared = |of: &'static str| {
        let values = expected.get(&name).and_then(|entry| entry.get(of)).and_then(Value::as_object);
        values.into_iter().flatten().map(move |(name, value)| (of, name, value))
    };
    declared("exact").chain(declared("reference")).map(|(of, name, value)| entry(of, name, value)).collect()
}

fn write_study(study: &ErrorStudy, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{}: {} runs, {} thread(s) each\n", study.scene, study.rows.len(), study.threads)?;
    writeln!(out, "References for the errors:")?;
    for (quantity, reference) in &study.references {
        let (title, unit) = (quantity.short_title(), quantity.unit());
        let approach = study.approaches.get(quantity).map(|approach| describe_approach(approach, unit));
        writeln!(out, "  {title:<18} {}{}", describe(reference, unit), approach.unwrap_or_default())?;
    }
    writeln!(out)?;
    let mut header = vec!["setting".to_owned(), "elements".into(), "steps".into(), "processor".into()];
    header.extend(study.references.keys().map(|q| q.short_title().to_owned()));
    let rows: Vec<Vec<String>> = study.rows.iter().map(|row| cells(row, study)).collect();
    write_table(&header, &rows, out)?;
    for row in study.rows.iter().filter(|row| row.reason.is_some()) {
        writeln!(out, "\n{}: {}", row.name, row.reason.as_deref().unwrap_or_default())?;
    }
    write_geometry(study, out)?;
    writeln!(out, "\nCheapest setting, the uncertainty of the reference included:")?;
    let mut header = vec![String::new()];
    header.extend(TARGETS.map(|target| format!("for {} %", 100.0 * target)));
    let rows: Vec<Vec<String>> = study.advice.chunks(TARGETS.len()).map(advice_cells).collect();
    write_table(&header, &rows, out)
}

fn write_geometry(study: &ErrorStudy, out: &mut dyn Write) -> io::Result<()> {
    if study.geometry.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nGeometry: effect of facets in place of the true surface, second order assumed:")?;
    let header = ["", "change from mesh 0 to mesh +1", "due to the surface", "error of mesh 0 due to facets"];
    let cells =
        |(quantity, Geometry { change, change_by_surface, error }): (&QuantityOfInterest, &Geometry)| {
            let changes = [change, change_by_surface].map(|change| format!("{:+.2} %", 100.0 * change));
            let [change, by_surface] = changes;
            [quantity.short_title().to_owned(), change, by_surface, format!("{:.2} %", 100.0 * error)]
        };
    let rows: Vec<[String; 4]> = study.geometry.iter().map(cells).collect();
    write_table(&header, &rows, out)
}

fn describe(reference: &Reference, unit: &str) -> String {
    let scale = if reference.value() == 0.0 { 1.0 } else { reference.value().abs() };
    let fraction = percent(reference.uncertainty() / scale);
    let what = match reference {
        Reference::Exact { .. } => "exact".into(),
        Reference::Given { .. } => format!("another code, ± {fraction}"),
        Reference::Extrapolated { order, .. } => {
            format!("limit of the meshes, observed order {order:.2}, ± {fraction}")
        }
        Reference::Fitted { meshes, .. } => format!("limit of a line through {meshes} meshes, ± {fraction}"),
        Reference::Finest { reason, .. } => format!("the finest mesh, ± {fraction}, since {reason}"),
        Reference::Unknown { reason, .. } => return format!("–: no reference, since {reason}"),
    };
    format!("{:.4e} {unit}: {what}", reference.value())
}

fn describe_approach(approach: &Approach, unit: &str) -> String {
    match approach {
        Approach::Met => ", met by every mesh".into(),
        Approach::Falls { order } => format!(", the error decreases with order {order:.2} along the meshes"),
        Approach::Stays { tends_to, .. } => {
            format!(", the error does not decrease along the meshes: they tend to {tends_to:.4e} {unit}")
        }
    }
}

/// Formats a fraction as a percentage; in scientific notation if it is large.
fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    if percent < 1e5 { format!("{percent:.2} %") } else { format!("{percent:.1e} %") }
}

fn cells(row: &Row, study: &ErrorStudy) -> Vec<String> {
    if !row.is_finished() {
        return vec![row.name.clone(), row.ending.replace('_', " ")];
    }
    let mut cells =
        vec![row.name.clone(), row.elements.to_string(), row.steps.to_string(), duration(row.cost_s())];
    cells.extend(study.references.keys().map(|q| match row.errors.get(q) {
        Some(error) => {
            format!("{}{}", percent(*error), if row.is_on_front(&study.rows, *q) { " *" } else { "" })
        }
        None => "–".into(),
    }));
    cells
}

fn advice_cells(advice: &[Advice]) -> Vec<String> {
    let title =
        advice.first().and_then(|a| a.quantity).map_or("headline numbers", QuantityOfInterest::short_title);
    let choice = |a: &Advice| match (&a.setting, a.cost_s) {
        (Some(setting), Some(cost)) => format!("{setting} ({})", duration(cost)),
        _ => "none of these".into(),
    };
    std::iter::once(title.to_owned()).chain(advice.iter().map(choice)).collect()
}

/// One line per run: setting, cost, values and relative errors.
fn csv(study: &ErrorStudy) -> String {
    let quantities: Vec<QuantityOfInterest> = study.references.keys().copied().collect();
    let mut header = vec!["setting,ending,elements,steps,wall_s,cpu_s".to_owned()];
    header.extend(quantities.iter().map(|quantity| format!("{quantity},{quantity}_relative_error")));
    let number = |value: Option<&f64>| value.map(ToString::to_string).unwrap_or_default();
    let line = |row: &Row| {
        let mut cells = vec![
            format!("\"{}\"", row.name),
            row.ending.clone(),
            row.elements.to_string(),
            row.steps.to_string(),
            row.wall_s.to_string(),
            number(row.cpu_s.as_ref()),
        ];
        let errors = quantities.iter().flat_map(|q| [row.values.get(q), row.errors.get(q)]);
        cells.extend(errors.map(number));
        cells.join(",")
    };
    let lines = std::iter::once(header.join(",")).chain(study.rows.iter().map(line));
    lines.map(|line| line + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Setting;

    #[test]
    fn large_errors_are_powers_of_ten() {
        assert_eq!([0.0123, 12.0, 1e302].map(percent), ["1.23 %", "1200.00 %", "1.0e304 %"]);
    }

    #[test]
    fn a_wrong_exact_value_and_a_missing_reference_are_reported() {
        let row = Row {
            setting: Setting::OWN,
            name: "mesh 0".into(),
            ending: "finished".into(),
            reason: None,
            elements: 1,
            steps: 1,
            wall_s: 1.0,
            cpu_s: None,
            values: BTreeMap::from([
                (QuantityOfInterest::ImpulseNS, 0.2),
                (QuantityOfInterest::PeakForceN, 1.0),
            ]),
            errors: BTreeMap::from([(QuantityOfInterest::ImpulseNS, 99.0)]),
        };
        let only_one = Reference::Unknown { value: 1.0, reason: "there is only one mesh".into() };
        let study = ErrorStudy {
            scene: "bar".into(),
            threads: 1,
            quantities: QuantityOfInterest::titles(None),
            references: BTreeMap::from([
                (QuantityOfInterest::PeakForceN, only_one),
                (QuantityOfInterest::ImpulseNS, Reference::Exact { value: 20.0 }),
            ]),
            approaches: BTreeMap::from([(
                QuantityOfInterest::ImpulseNS,
                Approach::Stays { order: -0.004, tends_to: 0.2 },
            )]),
            rows: vec![row],
            geometry: BTreeMap::new(),
            advice: Vec::new(),
            stopped: None,
        };
        let mut text = Vec::new();
        assert!(write_study(&study, &mut text).is_ok());
        let text = String::from_utf8_lossy(&text);
        for words in [
            "–: no reference, since there is only one mesh",
            "exact, the error does not decrease along the meshes: they tend to 2.0000e-1 N s",
            "9900.00 % *",
        ] {
            assert!(text.contains(words), "{words} in {text}");
        }
        assert!(!text.contains("inf") && !text.contains(" 0.00 %"), "{text}");
    }
}
