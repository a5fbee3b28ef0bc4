//! `contuse what-if`: a base scene, parameters that vary, and the results.

use super::output_file::{CSV, check_output, write_file};
use super::run::{available_threads, deadline, read_scene, watch_for_ctrl_c};
use super::what_if_table::{stopped, write_answer, write_case_line, write_csv};
use super::what_if_words::{add_parameters, case, limit, parameter};
use super::{CliError, Exit};
use crate::scene::{Budget, FolderSource, Problems};
use crate::step::Interrupt;
use crate::study::what_if::document::{
    ErrorSource, LimitDocument, ParameterDocument, SampleDocument, SampleMethod, WhatIfDocument,
};
use crate::study::what_if::{Answer, Cache, Partial, WhatIfRequest, check, study_what_if};
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Arguments of `contuse what-if`.
///
/// Parameters are `speed`, `mass` (of the projectile), `around`, `along` (impact point on a limb segment), `fat`,
/// `skin` (thickness of the layer), `friction`, `stiffness:BODY/PART` (a factor), or a JSON pointer to a number of the
/// scene. A question in a file has more options.
#[derive(Args, Debug)]
pub struct WhatIfArgs {
    /// Scene document of the base; its mesh files are in the same folder.
    pub scene: PathBuf,
    /// Question as JSON, extended by the other flags. A parameter has one range: that of the file or that of a flag.
    #[arg(short, long, value_name = "FILE")]
    pub question: Option<PathBuf>,
    /// A parameter and its range: `speed=80..120`. May be given several times.
    #[arg(long, value_name = "PARAMETER=LOW..HIGH", value_parser = parameter)]
    pub vary: Vec<ParameterDocument>,
    /// A case: `speed=120,fat=0.012`. May be given several times.
    #[arg(long, value_name = "PARAMETER=VALUE,…", value_parser = case)]
    pub case: Vec<(Vec<ParameterDocument>, crate::study::what_if::document::CaseDocument)>,
    /// Every parameter at its low and its high end: sensitivities.
    #[arg(long)]
    pub one_at_a_time: bool,
    /// Number of cases sampled over all parameters: spread and correlations.
    #[arg(long, value_name = "POINTS")]
    pub sample: Option<u32>,
    /// Method by which the points of the sample are chosen.
    #[arg(long, value_enum, default_value_t = SampleMethod::Sobol)]
    pub method: SampleMethod,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Compute Sobol indices too: (parameters + 2) times as many runs.
    #[arg(long, requires = "sample")]
    pub indices: bool,
    /// Find the value up to which a limit is met: `speed:von_mises@0.01<=30e3` (stress [Pa] below 10 mm),
    /// `speed:peak_force_n<=2000`.
    #[arg(long, value_name = "PARAMETER:NUMBER<=LIMIT", value_parser = limit)]
    pub limit: Vec<LimitDocument>,
    /// Source of the error bars.
    #[arg(long, value_enum)]
    pub error_bars: Option<ErrorSource>,
    /// Number of parallel runs; all cores by default. The answer does not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Cache results in this folder, and use those already there.
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Stop after this wall time in seconds.
    #[arg(long, allow_negative_numbers = true)]
    pub deadline_s: Option<f64>,
    /// Print the answer as JSON, one event per line as they occur, the whole answer last.
    #[arg(long)]
    pub json: bool,
    /// Write the cases as CSV.
    #[arg(long)]
    pub csv: Option<PathBuf>,
}

/// Answers the question. Exit code 3 if the base itself did not finish, 4 if it was stopped, 5 if the results of the
/// base are withheld.
///
/// # Errors
/// Errors in the scene, the question or the flags.
pub fn what_if(args: &WhatIfArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    // Question and base are checked before any run.
    let question = question(args)?;
    args.csv.iter().try_for_each(|path| check_output(path, &CSV, "--csv"))?;
    let (_, base) = read_scene(&args.scene)?;
    base.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    let folder = args.scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let source = FolderSource::new(folder);
    check(&question, &base, &source, &Budget::COMMAND_LINE).map_err(Problems)?;
    let cache = match &args.cache {
        Some(folder) => Cache::in_folder(folder).map_err(|error| CliError::Other(Box::new(error)))?,
        None => Cache::default(),
    };
    // Run the cases; each answer is printed as it arrives.
    let cancelled = watch_for_ctrl_c()?;
    let deadline = deadline(args.deadline_s)?;
    let mut written = Ok(());
    let answer = study_what_if(&mut WhatIfRequest {
        question: &question,
        base: &base,
        source: &source,
        budget: &Budget::COMMAND_LINE,
        threads: args.threads.map_or_else(available_threads, usize::from),
        cache: &cache,
        shares_plans: true,
        interrupt: &|| {
            if cancelled.load(Ordering::Relaxed) {
                return Some(Interrupt::Cancel);
            }
            deadline.is_some_and(|time| Instant::now() >= time).then_some(Interrupt::Deadline)
        },
        report: &mut |partial| {
            if written.is_ok() {
                written = report(args, &partial, question.error_bars, out);
            }
        },
    });
    // Complete answer, as JSON or as tables, and CSV.
    written?;
    if let Some(stopped) = stopped(&answer) {
        eprintln!("{stopped}");
    }
    if args.json {
        let text = serde_json::to_value(&answer).map_err(|error| CliError::Other(Box::new(error)))?;
        writeln!(out, "{}", serde_json::json!({"event": "answer", "answer": text}))?;
    } else {
        write_answer(&answer, out)?;
    }
    if let Some(path) = &args.csv {
        out.flush()?;
        write_file(path, |file| write_csv(&answer, file))?;
    }
    Ok(exit_of(&answer))
}

/// Merges the question of the file with that of the flags.
fn question(args: &WhatIfArgs) -> Result<WhatIfDocument, CliError> {
    let mut question = match &args.question {
        None => WhatIfDocument::default(),
        Some(path) => {
            let bytes =
                std::fs::read(path).map_err(|source| CliError::Input { path: path.clone(), source })?;
            let wrong = |what: String| CliError::Usage(format!("{}: {what}", path.display()));
            let question: WhatIfDocument =
                serde_json::from_slice(&bytes).map_err(|error| wrong(error.to_string()))?;
            if question.scene.is_some() || question.job.is_some() {
                return Err(wrong(
                    "the base is the scene of the command line: omit `scene` and `job`".into(),
                ));
            }
            question
        }
    };
    // Flags extend the question of the file.
    let of_cases = args.case.iter().flat_map(|(parameters, _)| parameters);
    add_parameters(&mut question.parameters, &args.vary, of_cases).map_err(CliError::Usage)?;
    question.cases.extend(args.case.iter().map(|(_, case)| case.clone()));
    question.limits.extend(args.limit.iter().cloned());
    question.one_at_a_time |= args.one_at_a_time;
    if let Some(count) = args.sample {
        let method = args.method;
        question.sample = Some(SampleDocument { method, count, seed: args.seed, indices: args.indices });
    }
    question.error_bars = args.error_bars.unwrap_or(question.error_bars);
    Ok(question)
}

/// Prints a part of the answer as it becomes available.
fn report(
    args: &WhatIfArgs,
    partial: &Partial,
    errors: ErrorSource,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    match partial {
        _ if args.json => writeln!(out, "{}", serde_json::to_string(partial)?)?,
        Partial::Case { of, case, .. } => {
            // The base is printed before the runs for its error bars.
            write_case_line(case, *of, case.index == 0 && errors == ErrorSource::Base, out)?;
        }
        Partial::ErrorBars { .. } | Partial::Limit(_) => {}
    }
    out.flush()
}

fn exit_of(answer: &Answer) -> Exit {
    match answer.cases.first() {
        _ if answer.stopped.is_some() => Exit::Cancelled,
        Some(base) if base.has_finished() => Exit::Success,
        Some(base) if base.ending == "withheld" => Exit::Withheld,
        _ => Exit::RunFailed,
    }
}
