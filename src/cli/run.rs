//! `contuse run`: run a scene and record it.

use super::keep::KeepArgs;
use super::plan::bytes;
use super::recording_output::{self, check_outputs, recorders};
use super::{CliError, Exit};
use crate::measure::summary::Shown;
use crate::measure::{Sink, Summary, render_table};
use crate::record::{ContactProblemRecorder, RecordingInfo, partial_path};
use crate::scene::document::{ErrorBarsDocument, Keep, SceneDocument};
use crate::scene::{Budget, FolderSource, Loaded, load};
use crate::step::{Ending, Failure, Interrupt, Recorder};
use crate::study::error::Row;
use crate::study::{Phase, Progress, RunRequest, RunResult, run_scene};
use clap::Args;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::io::{self, IsTerminal as _, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two ticks of the progress bar.
const TICK: Duration = Duration::from_millis(200);
/// What the progress bar says until the run begins.
const LOADING: &str = "loading: reading and meshing";
/// Steps of the progress bar.
const BAR_LENGTH: u64 = 1000;

/// Arguments of `contuse run`.
#[allow(clippy::struct_excessive_bools)] // one a flag
#[derive(Args, Debug)]
pub struct RunArgs {
    /// Scene document; its mesh files are in the same folder.
    pub scene: PathBuf,
    /// Outputs to write; their suffixes choose the formats.
    #[arg(short, long, help = recording_output::help())]
    pub output: Vec<PathBuf>,
    /// Print only the summary, as JSON.
    #[arg(long)]
    pub json: bool,
    /// Number of threads, of which a small scene uses fewer; all cores by default. Results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Suppress the progress bar and the table.
    #[arg(short, long)]
    pub quiet: bool,
    /// Stop after this wall time in seconds.
    #[arg(long, allow_negative_numbers = true)]
    pub deadline_s: Option<f64>,
    /// Skip the extra runs that estimate error bars.
    #[arg(long)]
    pub no_error_bars: bool,
    /// Refine the mesh until the error bars of peak force, impulse and energy given to the tissue are at most this,
    /// such as 5%.
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true, conflicts_with = "no_error_bars")]
    pub accuracy: Option<f64>,
    /// Time limit of all meshes together, such as 30s or 2min [default: 60s].
    #[arg(long, value_name = "TIME", value_parser = seconds, conflicts_with = "no_error_bars")]
    pub within: Option<f64>,
    /// Lower the bulk moduli as far as the accuracy allows, by runs on the coarsest mesh.
    #[arg(long, conflicts_with_all = ["no_error_bars", "as_is"])]
    pub lower_bulk_modulus: bool,
    /// Run the meshes as given, and estimate error bars for them.
    #[arg(long, conflicts_with_all = ["accuracy", "within"])]
    pub as_is: bool,
    /// Save the contact problems of the run to this folder, one JSON file every twentieth step with contacts.
    #[arg(long, value_name = "DIR")]
    pub save_contact_problems: Option<PathBuf>,
    /// Omitted items to restore in this run.
    #[command(flatten)]
    pub keep: KeepArgs,
}

/// Runs a scene; the summary goes to `out`, progress and errors to standard error.
///
/// # Errors
/// Errors in the scene or the flags. A run that fails with a diagnosis, or whose results are withheld, is reported here
/// and sets the exit code.
pub fn run(args: &RunArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    // Flags, scene and output path are checked before the run.
    let deadline = deadline(args.deadline_s)?;
    let bar = progress_bar(args);
    let (document_json, mut loaded) = read_scene(&args.scene)?;
    bar.reset_eta();
    loaded.scene.restore(&args.keep.keep);
    if args.save_contact_problems.is_some() {
        // They are those of the whole.
        loaded.scene.restore(&[Keep::MirrorImages]);
    }
    ask(args, &mut loaded.scene.document);
    let paths = match &args.output[..] {
        [] => vec![default_output(&loaded.scene.document.name)],
        paths => paths.to_vec(),
    };
    check_outputs(&paths, &loaded.scene)?;
    if !args.quiet {
        bar.suspend(|| loaded.warnings.iter().for_each(|warning| eprintln!("{warning}")));
    }

    // Ctrl-C and the deadline interrupt the run.
    let cancelled = watch_for_ctrl_c()?;
    let interrupt = || {
        if cancelled.load(Ordering::Relaxed) {
            return Some(Interrupt::Cancel);
        }
        deadline.is_some_and(|time| Instant::now() >= time).then_some(Interrupt::Deadline)
    };
    // Run with a recording, and optionally with saved contact problems.
    let name = &loaded.scene.document.name;
    let mut problems = args.save_contact_problems.clone().map(|dir| ContactProblemRecorder::new(dir, name));
    let mut recorders = recorders(&paths, &RecordingInfo::of(&loaded.scene, &document_json))?;
    let result = run_scene(RunRequest {
        scene: &loaded.scene,
        sinks: recorders.iter_mut().map(|recorder| &mut **recorder as &mut dyn Sink).collect(),
        also: problems.as_mut().map(|recorder| recorder as &mut dyn Recorder),
        threads: args.threads.map_or_else(available_threads, usize::from),
        interrupt: &interrupt,
        progress: &mut |progress| show(&bar, &progress),
    });
    bar.finish_and_clear();
    let result = result.map_err(|error| CliError::Other(Box::new(error)))?;
    report(args, out, &result, &paths)?;
    if let (Some(saved), false) = (&problems, args.quiet) {
        eprintln!("{} contact problem(s) saved", saved.files());
    }
    Ok(exit_of(&result.outcome.ending, &result.summary.results))
}

/// Applies the flags on error bars and accuracy to the document, or the implied accuracy.
fn ask(args: &RunArgs, document: &mut SceneDocument) {
    if args.accuracy.is_some() || args.within.is_some() {
        let accuracy = document.accuracy.get_or_insert_default();
        accuracy.relative = args.accuracy.unwrap_or(accuracy.relative);
        accuracy.time_budget_s = args.within.unwrap_or(accuracy.time_budget_s);
    } else if args.no_error_bars || args.as_is {
        document.accuracy = None;
    } else {
        document.imply_accuracy();
    }
    if let Some(accuracy) = &mut document.accuracy {
        accuracy.lower_bulk_modulus |= args.lower_bulk_modulus;
    }
    if args.no_error_bars {
        document.solver.error_bars = ErrorBarsDocument::None;
    }
}

/// Parses "5%" or "0.5 %" as a fraction. The sign is required: 0.1 would be read as a fraction by some, as a percentage by others.
fn percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    let number = number.ok_or_else(|| format!("{text} is not a percentage; give 5%"))?;
    if number > 0.0 && number <= 100.0 {
        Ok(number / 100.0)
    } else {
        Err(format!("{text} is not above 0 % and at most 100 %"))
    }
}

/// Parses "30s", "30" or "2min" as seconds.
fn seconds(text: &str) -> Result<f64, String> {
    let (number, unit) = match (text.strip_suffix("min"), text.strip_suffix('s')) {
        (Some(minutes), _) => (minutes, 60.0),
        (None, Some(seconds)) => (seconds, 1.0),
        (None, None) => (text, 1.0),
    };
    let number: f64 = number.trim().parse().map_err(|_| format!("{text} is not a time; give 30s or 2min"))?;
    let time = number * unit;
    if time > 0.0 && time.is_finite() { Ok(time) } else { Err(format!("{text} is not above 0 s")) }
}

/// Time at which to stop.
pub(super) fn deadline(seconds: Option<f64>) -> Result<Option<Instant>, CliError> {
    let Some(seconds) = seconds else { return Ok(None) };
    let duration = Duration::try_from_secs_f64(seconds).map_err(|error| {
        CliError::Usage(format!("--deadline-s {seconds}: {error}; give seconds from now on, such as 60"))
    })?;
    Ok(Instant::now().checked_add(duration))
}

/// The bytes of the document, for the recording, and the loaded scene.
pub(super) fn read_scene(path: &Path) -> Result<(Vec<u8>, Loaded), CliError> {
    let bytes = std::fs::read(path).map_err(|source| CliError::Input { path: path.to_owned(), source })?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let loaded = load(&bytes, &FolderSource::new(folder), &Budget::COMMAND_LINE)?;
    Ok((bytes, loaded))
}

/// Output path from the scene's name, in the current folder.
fn default_output(name: &str) -> PathBuf {
    let plain = |c: char| if c.is_alphanumeric() || "_-. ".contains(c) { c } else { '_' };
    // Systems limit the length of file names.
    let stem: String = name.chars().map(plain).take(60).collect();
    let stem = stem.trim_matches(['.', ' ']);
    PathBuf::from(format!("{}.mcap", if stem.is_empty() { "recording" } else { stem }))
}

/// Says on a terminal which run of a study begins.
pub(super) fn announce(number: usize, count: usize, setting: &str) {
    if io::stderr().is_terminal() {
        eprintln!("run {} of {count}: {setting}", number + 1);
    }
}

/// Exit code of a study with these runs: 4 if it was stopped, 3 if no run finished.
pub(super) fn exit_of_study(stopped: Option<&String>, rows: &[Row]) -> Exit {
    match stopped {
        Some(_) => Exit::Cancelled,
        None if rows.iter().any(Row::is_finished) => Exit::Success,
        None => Exit::RunFailed,
    }
}

/// A flag set by Ctrl-C (or SIGTERM); the second Ctrl-C ends the process immediately, as usual.
pub(super) fn watch_for_ctrl_c() -> Result<Arc<AtomicBool>, CliError> {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    const KILLED_BY_INTERRUPT: i32 = 128 + 2;
    let flag = Arc::new(AtomicBool::new(false));
    // The order matters: the first signal finds the flag clear, and then sets it.
    signal_hook::flag::register_conditional_shutdown(SIGINT, KILLED_BY_INTERRUPT, Arc::clone(&flag))?;
    signal_hook::flag::register(SIGINT, Arc::clone(&flag))?;
    signal_hook::flag::register(SIGTERM, Arc::clone(&flag))?;
    // Exceeding the file size limit of the process then is a write error with a diagnosis, instead of termination.
    signal_hook::flag::register(SIGXFSZ, Arc::default())?;
    Ok(flag)
}

pub(super) fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Progress bar on standard error, only on a terminal. It ticks by itself, since meshing a large scan takes minutes without a report.
fn progress_bar(args: &RunArgs) -> ProgressBar {
    if args.quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(BAR_LENGTH).with_finish(ProgressFinish::AndClear).with_message(LOADING);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} % {msg} {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(TICK);
    bar
}

#[allow(clippy::cast_sign_loss)] // a fraction is never negative
fn show(bar: &ProgressBar, progress: &Progress) {
    // Runs for the error bars, which come first, say nothing about the pace of the run itself.
    if progress.progress <= 0.0 {
        bar.reset_eta();
    }
    bar.set_position((progress.progress * BAR_LENGTH as f64) as u64);
    bar.set_message(match progress.phase {
        Phase::Waiting | Phase::Loading => LOADING.to_owned(),
        Phase::EstimatingErrors => {
            progress.accuracy.map_or("estimating errors".to_owned(), |place| format!("mesh {}", place.run))
        }
        Phase::DynamicRelaxation => "dynamic relaxation".to_owned(),
        Phase::Preload => "preload".to_owned(),
        Phase::Stepping | Phase::Closing | Phase::Done => {
            let left = bar.eta().as_secs();
            format!("t = {:.2} µs, step {} ({left} s left)", 1e6 * progress.simulated_time_s, progress.step)
        }
    });
}

fn report(
    args: &RunArgs,
    out: &mut dyn Write,
    result: &RunResult,
    paths: &[PathBuf],
) -> Result<(), CliError> {
    if args.json {
        writeln!(out, "{}", json_of(&result.summary)?)?;
    } else if !args.quiet {
        write!(out, "{}", render_table(&result.summary))?;
        let cpu = result.cpu_s.map(|s| format!(", {s:.2} s of processor time")).unwrap_or_default();
        let memory =
            result.peak_memory_bytes.map(|peak| format!(", {} of memory", bytes(peak))).unwrap_or_default();
        let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        writeln!(out, "\n{:.2} s{cpu}{memory}; recording: {}", result.wall_s, paths.join(", "))?;
    }
    if let Ending::Failed { failure } = &result.outcome.ending {
        out.flush()?;
        eprint!("{}", diagnosis(failure));
        for partial in paths.iter().map(|path| partial_path(path)).filter(|partial| partial.exists()) {
            eprintln!("  recording unfinished: {}", partial.display());
        }
    } else if let Shown::Withheld { reason, remedy, .. } = &result.summary.results {
        out.flush()?;
        eprintln!("contuse: the results are withheld: {reason}\n  remedy: {remedy}");
    }
    Ok(())
}

fn json_of(summary: &Summary) -> Result<String, CliError> {
    summary.to_json().map_err(|error| CliError::Other(Box::new(error)))
}

/// Formats a failure in full: cause, place, time, remedy.
fn diagnosis(failure: &Failure) -> String {
    let what = format!("contuse: the run failed: {}\n  {}\n", failure.cause.name(), failure.message);
    let when = failure.time_s.zip(failure.step);
    let when = when.map(|(time_s, step)| format!("  when: t = {time_s:.6e} s, step {step}\n"));
    let place = failure.place().map(|place| format!("  where: {place}\n"));
    what + &when.unwrap_or_default() + &place.unwrap_or_default() + &format!("  remedy: {}\n", failure.remedy)
}

/// Exit code for the outcome of a run.
fn exit_of(ending: &Ending, results: &Shown) -> Exit {
    match (ending, results) {
        (Ending::Finished, Shown::Results(_)) => Exit::Success,
        (Ending::Finished, Shown::Withheld { .. }) => Exit::Withheld,
        (Ending::Cancelled, _) => Exit::Cancelled,
        (Ending::Failed { .. }, _) => Exit::RunFailed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::Results;
    use crate::measure::summary::Headline;
    use crate::step::{ElementPlace, FailureCause};

    #[test]
    fn times_have_units() {
        assert_eq!(["30", "30s", "0.5 min", "2min"].map(seconds), [30.0, 30.0, 30.0, 120.0].map(Ok));
        for wrong in ["", "s", "0s", "-1s", "1h", "infmin", "NaN"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn names_become_file_names() {
        assert_eq!(default_output("flashball_thigh"), Path::new("flashball_thigh.mcap"));
        assert_eq!(default_output("../a b/c"), Path::new("_a b_c.mcap"));
        assert_eq!(default_output("…/"), Path::new("__.mcap"));
        assert_eq!(default_output(".."), Path::new("recording.mcap"));
    }

    #[test]
    fn a_diagnosis_says_what_where_when_and_what_to_do() {
        let element = ElementPlace {
            body: "thigh".into(),
            part: "muscle".into(),
            element: 7,
            position_m: Some([0.1, 0.0, -0.2]),
        };
        let failure = Failure {
            cause: FailureCause::ElementInverted,
            message: "J = -0.1.".into(),
            remedy: "Refine.".into(),
            time_s: Some(1.5e-5),
            step: Some(42),
            element: Some(element),
        };
        let text = diagnosis(&failure);
        for part in [
            "element_inverted",
            "J = -0.1.",
            "1.500000e-5 s",
            "step 42",
            "element 7",
            "muscle",
            "thigh",
            "Refine.",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }

    #[test]
    fn endings_have_exit_codes() {
        let values = || Results {
            nothing_touched: false,
            impacts: Vec::new(),
            tissue: None,
            headline: Headline::default(),
        };
        let withheld = Shown::Withheld { reason: String::new(), remedy: "", values: values() };
        assert_eq!(exit_of(&Ending::Finished, &Shown::Results(values())), Exit::Success);
        assert_eq!(exit_of(&Ending::Finished, &withheld), Exit::Withheld);
        assert_eq!(exit_of(&Ending::Cancelled, &withheld), Exit::Cancelled);
    }

    #[test]
    fn a_deadline_must_be_a_time() {
        assert!(deadline(Some(-1.0)).is_err() && deadline(Some(f64::NAN)).is_err());
        assert!(deadline(Some(2.0)).is_ok_and(|d| d.is_some()));
        assert!(deadline(None).is_ok_and(|d| d.is_none()));
    }
}
