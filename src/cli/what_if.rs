//! `contuse what-if`: a base scene, what varies, and what comes of it.

use super::output_file::{check_writable, write_file};
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
use clap::{Args, ValueEnum};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Arguments of `contuse what-if`.
///
/// Parameters are `speed`, `mass` (of the projectile), `around`, `along` (impact point on a limb segment), `fat`, `skin` (thickness
/// of the layer), `friction`, `stiffness:BODY/PART` (a factor), or a JSON pointer to a number of the scene. A question in a file
/// can say more.
#[derive(Args, Debug)]
pub struct WhatIfArgs {
    /// The scene document of the base; its mesh files lie beside it.
    pub scene: PathBuf,
    /// The question as JSON; what the other flags ask comes on top. A parameter has one range: that of the file or that of a flag.
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
    /// So many cases spread over all parameters: spread and correlations.
    #[arg(long, value_name = "POINTS")]
    pub sample: Option<u32>,
    /// How the points of the sample are chosen.
    #[arg(long, value_enum, default_value_t = MethodName::Sobol)]
    pub method: MethodName,
    /// Seed of the sample.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Sobol indices too: (parameters + 2) times as many runs.
    #[arg(long, requires = "sample")]
    pub indices: bool,
    /// Up to which value a limit is kept: `speed:von_mises@0.01<=30e3` (stress [Pa] from 10 mm on), `speed:peak_force_n<=2000`.
    #[arg(long, value_name = "PARAMETER:NUMBER<=LIMIT", value_parser = limit)]
    pub limit: Vec<LimitDocument>,
    /// Where error bars come from.
    #[arg(long, value_enum)]
    pub error_bars: Option<ErrorName>,
    /// Runs side by side; by default all cores. The answer is the same for any number.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Remember results in this folder, and use those that are there.
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Stop after so many seconds of wall time.
    #[arg(long, allow_negative_numbers = true)]
    pub deadline_s: Option<f64>,
    /// Answer as JSON, one event a line as they come, the whole answer last.
    #[arg(long)]
    pub json: bool,
    /// Write the cases as CSV.
    #[arg(long)]
    pub csv: Option<PathBuf>,
}

/// How points are chosen, as on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum MethodName {
    /// The sequence of Sobol, shifted at random.
    Sobol,
    /// A Latin hypercube.
    LatinHypercube,
}

/// Where error bars come from, as on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ErrorName {
    /// The relative errors of the base for all cases.
    Base,
    /// Each case has its own.
    Full,
    /// There are none.
    None,
}

/// Answers. Exit code 3 when the base itself did not finish, 4 when it was stopped, 5 when the results of the base are withheld.
///
/// # Errors
/// What is wrong with the scene, the question or the flags.
pub fn what_if(args: &WhatIfArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let question = question(args)?;
    args.csv.iter().try_for_each(|path| check_writable(path, "--csv"))?;
    let (_, base) = read_scene(&args.scene)?;
    base.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    let folder = args.scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let source = FolderSource::new(folder);
    check(&question, &base, &source, &Budget::COMMAND_LINE).map_err(Problems)?;
    let cache = match &args.cache {
        Some(folder) => Cache::in_folder(folder).map_err(|error| CliError::Other(Box::new(error)))?,
        None => Cache::default(),
    };
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
        tell: &mut |partial| {
            if written.is_ok() {
                written = tell(args, &partial, question.error_bars, out);
            }
        },
    });
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

/// The question of the file and of the flags.
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
                    "the base is the scene of the command line: leave `scene` and `job` out".into(),
                ));
            }
            question
        }
    };
    let of_cases = args.case.iter().flat_map(|(parameters, _)| parameters);
    add_parameters(&mut question.parameters, &args.vary, of_cases).map_err(CliError::Usage)?;
    question.cases.extend(args.case.iter().map(|(_, case)| case.clone()));
    question.limits.extend(args.limit.iter().cloned());
    question.one_at_a_time |= args.one_at_a_time;
    if let Some(count) = args.sample {
        let method = match args.method {
            MethodName::Sobol => SampleMethod::Sobol,
            MethodName::LatinHypercube => SampleMethod::LatinHypercube,
        };
        question.sample = Some(SampleDocument { method, count, seed: args.seed, indices: args.indices });
    }
    if let Some(errors) = args.error_bars {
        question.error_bars = match errors {
            ErrorName::Base => ErrorSource::Base,
            ErrorName::Full => ErrorSource::Full,
            ErrorName::None => ErrorSource::None,
        };
    }
    Ok(question)
}

/// A part of the answer as it comes.
fn tell(
    args: &WhatIfArgs,
    partial: &Partial,
    errors: ErrorSource,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    match partial {
        _ if args.json => writeln!(out, "{}", serde_json::to_string(partial)?)?,
        Partial::Case { of, case } => {
            // The base is told before the runs that its error bars come from.
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
