//! `contuse contact-problem`: solve saved frictional contact problems, and compare solvers on them.

use super::performance_profile::{Timing, profile_picture};
use super::picture::{picture_path, write_by_name};
use super::{CliError, Exit};
use crate::mechanics::contact::solution::problem::{ContactProblem, LARGEST};
use crate::mechanics::contact::solution::solvers::{LARGEST_OF_MOTION, Method, Options, SolveReport, solve};
use crate::record::{NamedContactProblem, read_contact_problem};
use crate::scene::Problems;
use crate::study::process_cpu_s;
use clap::Args;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `contuse contact-problem`.
#[derive(Args, Debug)]
pub struct ContactProblemArgs {
    /// JSON files with one contact problem each.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Largest scaled error of a converged solution.
    #[arg(long, default_value_t = 1e-8)]
    pub tol: f64,
    /// Name of the solver.
    #[arg(long, default_value = "hybrid")]
    pub solver: String,
    /// Stop each solution after this processor time in seconds, with the best iterate.
    #[arg(long, value_name = "S")]
    pub time_limit: Option<f64>,
    /// Solve each problem this many times and report the shortest processor time.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub repeat: u32,
    /// Start from the reactions in this file, by the names of the problems: what `--json` has printed, as it is or
    /// changed. Without it all problems start from rest.
    #[arg(long, value_name = "FILE")]
    pub start: Option<PathBuf>,
    /// Print the answer as JSON, including the reactions.
    #[arg(long)]
    pub json: bool,
    /// Run every solver, and draw the performance profile (Dolan & Moré 2002): as PNG if the file name ends in .png,
    /// otherwise as SVG.
    #[arg(long, value_name = "FILE", conflicts_with = "json", value_parser = picture_path)]
    pub profile: Option<PathBuf>,
}

/// Reactions of the problem of a name.
#[derive(Debug, Deserialize)]
struct Start {
    name: String,
    r: Vec<f64>,
}

/// Result of one solution.
#[derive(Debug, Serialize)]
struct Row {
    name: String,
    solver: &'static str,
    iterations: usize,
    error_plain: f64,
    error_scaled: f64,
    /// What is not stopped, relative to the free velocities and to the motion [-].
    error_of_free: f64,
    error_of_motion: f64,
    /// Shortest processor time of the repetitions [s]; null if the system does not provide it.
    cpu_s: Option<f64>,
    converged: bool,
    /// Whether reactions were found to grow without bound.
    is_jammed: bool,
    r: Vec<f64>,
}

/// Solves the problems. Exit code 0 if all are solved, 2 if a file or a flag is wrong, 3 if any is not solved.
///
/// # Errors
/// All errors in the files and the flags.
pub fn contact_problem(args: &ContactProblemArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let method = method(&args.solver)?;
    if !(args.tol > 0.0 && args.tol <= LARGEST_OF_MOTION) {
        let message = format!("--tol {}: it must be above 0 and at most {LARGEST_OF_MOTION}", args.tol);
        return Err(CliError::Usage(message));
    }
    if args.time_limit.is_some_and(|limit| !(limit > 0.0)) {
        return Err(CliError::Usage("--time-limit must be above 0".into()));
    }
    let problems = read_all(&args.files)?;
    let starts = starts(&problems, args.start.as_deref())?;
    if let Some(path) = &args.profile {
        return profile(args, (&problems, &starts), path, out);
    }
    let rows = solve_all((&problems, &starts), method, args);
    if args.json {
        let text = serde_json::to_string(&rows).map_err(|error| CliError::Other(Box::new(error)))?;
        writeln!(out, "{text}")?;
    } else {
        write_table(&rows, out)?;
    }
    Ok(if rows.iter().all(|row| row.converged) { Exit::Success } else { Exit::RunFailed })
}

fn method(name: &str) -> Result<Method, CliError> {
    Method::from_name(name).ok_or_else(|| {
        let names = Method::ALL.map(Method::name).join(", ");
        CliError::Usage(format!("--solver {name}: there is no such solver; there are {names}"))
    })
}

/// Reads all problems from all files, or collects the errors of all files.
fn read_all(files: &[PathBuf]) -> Result<Vec<NamedContactProblem>, CliError> {
    let (mut read, mut wrong) = (Vec::new(), Vec::new());
    for path in files {
        let bytes = std::fs::read(path).map_err(|source| CliError::Input { path: path.clone(), source })?;
        match read_contact_problem(&bytes, &format!("{}#", path.display())) {
            Ok(problem) => read.push(problem),
            Err(Problems(problems)) => wrong.extend(problems),
        }
    }
    if wrong.is_empty() { Ok(read) } else { Err(wrong.into_iter().collect::<Problems>().into()) }
}

/// Reactions from which each problem starts.
fn starts(problems: &[NamedContactProblem], file: Option<&Path>) -> Result<Vec<Vec<f64>>, CliError> {
    let lengths = problems.iter().map(|named| named.problem.q().len());
    let Some(path) = file else { return Ok(lengths.map(|length| vec![0.0; length]).collect()) };
    let bytes = std::fs::read(path).map_err(|source| CliError::Input { path: path.to_owned(), source })?;
    let wrong = |what: String| CliError::Usage(format!("--start {}: {what}", path.display()));
    let given: Vec<Start> = serde_json::from_slice(&bytes)
        .map_err(|error| wrong(format!("it must be what contact-problem --json prints: {error}")))?;
    let of_problem = |(named, length): (&NamedContactProblem, usize)| {
        let found = given.iter().find(|start| start.name == named.name);
        let found = found.ok_or_else(|| wrong(format!("it has no reactions of {}", named.name)))?;
        let (name, count) = (&named.name, found.r.len());
        if count != length {
            return Err(wrong(format!("{count} reactions of {name}, which needs {length}")));
        }
        match found.r.iter().position(|r| r.abs() > LARGEST) {
            Some(at) => Err(wrong(format!("r[{at}] of {name} is {:e}, at most {LARGEST:e}", found.r[at]))),
            None => Ok(found.r.clone()),
        }
    };
    problems.iter().zip(lengths).map(of_problem).collect()
}

fn solve_all(
    (problems, starts): (&[NamedContactProblem], &[Vec<f64>]),
    method: Method,
    args: &ContactProblemArgs,
) -> Vec<Row> {
    problems.iter().zip(starts).map(|(named, start)| solve_one(named, start, method, args)).collect()
}

fn solve_one(named: &NamedContactProblem, start: &[f64], method: Method, args: &ContactProblemArgs) -> Row {
    let mut r = start.to_vec();
    let mut shortest: Option<f64> = None;
    let mut report = timed(&named.problem, method, args, &mut r, &mut shortest);
    for _ in 1..args.repeat {
        r.copy_from_slice(start);
        report = timed(&named.problem, method, args, &mut r, &mut shortest);
    }
    Row {
        name: named.name.clone(),
        solver: report.solver.name(),
        iterations: report.iterations,
        error_plain: report.error_plain,
        error_scaled: report.error_scaled,
        error_of_free: report.error_of_free,
        error_of_motion: report.error_of_motion,
        cpu_s: shortest,
        converged: report.converged,
        is_jammed: report.is_jammed,
        r,
    }
}

/// Solves once from `r`; updates `shortest` with its processor time.
fn timed(
    problem: &ContactProblem,
    method: Method,
    args: &ContactProblemArgs,
    r: &mut [f64],
    shortest: &mut Option<f64>,
) -> SolveReport {
    let start = process_cpu_s();
    let elapsed = || process_cpu_s().zip(start).map(|(now, start)| now - start);
    let part = || args.time_limit.zip(elapsed()).map_or(0.0, |(limit, now)| now / limit);
    let spent: Option<&dyn Fn() -> f64> = args.time_limit.is_some().then_some(&part);
    let report = solve(problem, r, &Options { tolerance: args.tol, method, spent, ..Options::default() });
    *shortest = elapsed().map(|now| shortest.map_or(now, |least| least.min(now)));
    report
}

fn write_table(rows: &[Row], out: &mut dyn Write) -> io::Result<()> {
    let width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max(7);
    writeln!(
        out,
        "{:width$}  contacts  {:14}  iterations  scaled error  plain error  of free  of motion     cpu [ms]",
        "problem", "solver"
    )?;
    for row in rows {
        let cpu = row.cpu_s.map_or_else(|| "-".to_owned(), |s| format!("{:.4}", 1e3 * s));
        writeln!(
            out,
            "{:width$}  {:8}  {:14}  {:10}  {:12.2e}  {:11.2e}  {:7.1e}  {:9.1e}  {cpu:>11}{}",
            row.name,
            row.r.len() / 3,
            row.solver,
            row.iterations,
            row.error_scaled,
            row.error_plain,
            row.error_of_free,
            row.error_of_motion,
            match (row.converged, row.is_jammed) {
                (true, _) => "",
                (_, true) => "  probably no solution: reactions grow without bound",
                _ => "  not converged",
            }
        )?;
    }
    Ok(())
}

/// Solves all problems with all solvers, and draws the profile.
fn profile(
    args: &ContactProblemArgs,
    problems: (&[NamedContactProblem], &[Vec<f64>]),
    path: &Path,
    out: &mut dyn Write,
) -> Result<Exit, CliError> {
    let mut timings = Vec::new();
    for method in Method::ALL {
        let rows = solve_all(problems, method, args);
        let solved = rows.iter().filter(|row| row.converged).count();
        writeln!(out, "\n{}: {solved} of {} solved\n", method.name(), rows.len())?;
        write_table(&rows, out)?;
        let cpu_s = rows.iter().map(|row| row.cpu_s.filter(|_| row.converged)).collect();
        timings.push(Timing { solver: method.name(), cpu_s });
    }
    write_by_name(path, || profile_picture(args.tol, &timings))?;
    Ok(Exit::Success)
}
