//! `contuse material fit`: parameters of a law from measured curves.

use super::input_file::read_file;
use super::json::write_json;
use super::plan::write_table;
use super::{CliError, Exit};
use crate::scene::Problem;
use crate::scene::material_fit::{FitQuestion, TestKind};
use crate::study::material_fit::{FitAnswer, FittedParameter, FittedTest, fit};
use clap::Args;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `contuse material fit`.
#[derive(Args, Debug)]
pub struct FitArgs {
    /// JSON file, or - for standard input: the law with starting values, its free parameters, the curves (docs/materials.md).
    pub file: PathBuf,
    /// Print the fit as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Fits, and writes parameters, intervals and the fitted law.
///
/// # Errors
/// All problems of the question; starting values with which the law has no stress.
pub fn material_fit(args: &FitArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let bytes = read_file(&args.file)?;
    let folder = args.file.parent().unwrap_or(Path::new(""));
    let (question, warnings) = FitQuestion::read(&bytes, &|name| std::fs::read(folder.join(name)))?;
    for warning in &warnings {
        tracing::warn!("{warning}");
    }
    let answer = fit(&question)?;
    if args.json {
        write_json(&answer, out)?;
    } else {
        write_answer(&answer, out)?;
    }
    Ok(if answer.problems.iter().any(Problem::is_error) { Exit::RunFailed } else { Exit::Success })
}

fn write_answer(answer: &FitAnswer, out: &mut dyn Write) -> Result<(), CliError> {
    let header = ["parameter", "value", "standard error", "95 % interval", "start"];
    let rows: Vec<[String; 5]> = answer.parameters.iter().map(parameter_row).collect();
    write_table(&header, &rows, out)?;
    writeln!(out)?;
    let header = ["test", "points", "range", "rms error", "largest relative error", "R²"];
    let rows: Vec<[String; 6]> = answer.tests.iter().map(test_row).collect();
    write_table(&header, &rows, out)?;
    write_numbers(answer, out)?;
    for problem in &answer.problems {
        writeln!(out, "{problem}")?;
    }
    // What is no fit is not offered to a scene.
    if answer.problems.iter().any(Problem::is_error) {
        return Ok(());
    }
    writeln!(out, "\nIn a part: \"material\":")?;
    write_json(&answer.constants.material, out)?;
    if let Some(series) = &answer.constants.prony_series {
        writeln!(out, "with \"prony_series\":")?;
        write_json(series, out)?;
    }
    Ok(())
}

fn write_numbers(answer: &FitAnswer, out: &mut dyn Write) -> io::Result<()> {
    let (points, degrees) = (answer.points, answer.degrees_of_freedom);
    writeln!(out, "\n{points} points, {degrees} degrees of freedom, {} iterations", answer.iterations)?;
    if let Some([from, to]) = answer.stretch_range {
        writeln!(out, "principal stretches {from:.4} to {to:.4}")?;
    }
    match answer.condition {
        Some(condition) => writeln!(out, "condition number {condition:.1}")?,
        None => writeln!(out, "the Jacobian is singular")?,
    }
    for (i, row) in answer.correlations.iter().enumerate() {
        for (k, correlation) in row.iter().enumerate().take(i) {
            let name = |i: usize| answer.parameters[i].pointer.as_str();
            writeln!(out, "correlation of {} and {}: {correlation:.3}", name(k), name(i))?;
        }
    }
    Ok(())
}

fn parameter_row(parameter: &FittedParameter) -> [String; 5] {
    let interval = parameter.interval.map(|[low, high]| format!("{low:.5e} to {high:.5e}"));
    [
        parameter.pointer.clone(),
        format!("{:.6e}", parameter.value),
        parameter.standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.2e}")),
        interval.unwrap_or_else(|| "-".to_owned()),
        format!("{:e}", parameter.start),
    ]
}

fn test_row(test: &FittedTest) -> [String; 6] {
    let kind = match test.kind {
        TestKind::Uniaxial => "uniaxial",
        TestKind::Equibiaxial => "equibiaxial",
        TestKind::Shear => "shear",
        TestKind::Relaxation => "relaxation",
    };
    [
        kind.to_owned(),
        test.points.to_string(),
        format!("{} to {}", test.range[0], test.range[1]),
        format!("{:.4e} Pa", test.rms_pa),
        format!("{:.2} %", 100.0 * test.largest_relative_error),
        test.r_squared.map_or_else(|| "-".to_owned(), |r| format!("{r:.6}")),
    ]
}
