//! `contuse material`: energy and stresses of a law, at a point or along a path.

use super::input_file::read_file;
use super::material_fit::{FitArgs, material_fit};
use super::material_path::{PathName, PathRequest};
use super::{CliError, Exit, plot};
use crate::mechanics::material::{self, Material, PathPoint, Validity, eval_path, eval_point};
use crate::mechanics::tensor::Mat3;
use crate::scene::Problem;
use crate::scene::material_question::{InRange, MaterialAnswer, MaterialQuestion, MaterialQuestions, rows};
use crate::scene::problem::Pointer;
use clap::{Args, Subcommand, ValueEnum};
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// Arguments of `contuse material`.
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct MaterialArgs {
    /// Subcommand; without one, the law is evaluated.
    #[command(subcommand)]
    pub command: Option<MaterialCommand>,
    /// JSON file, or - for standard input: {"material": {…}, "F": [[…],[…],[…]]}, or a list of such.
    #[arg(required_unless_present = "library")]
    pub file: Option<PathBuf>,
    /// Set of the library to use instead of a file: its law alone, without Prony series and viscosity.
    #[arg(long, value_name = "NAME", conflicts_with = "file", requires = "path")]
    pub library: Option<String>,
    /// Output format of the answer.
    #[arg(long, value_enum, default_value_t = Format::Json)]
    pub format: Format,
    /// Follow a path from rest instead of evaluating at F.
    #[arg(long, value_enum)]
    pub path: Option<PathName>,
    /// First stretch of the path (shear: amount of shear) [default: rest].
    #[arg(long, requires = "path", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Last stretch of the path (shear: amount of shear) [default: 1.5, or 0.5 for shear].
    #[arg(long, requires = "path", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Points along the path.
    #[arg(long, requires = "path", default_value_t = 51, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub points: u32,
}

/// Subcommands of `contuse material`.
#[derive(Debug, Subcommand)]
pub enum MaterialCommand {
    /// Fit parameters to measured curves: values, 95 % intervals, and the law as a scene takes it.
    Fit(FitArgs),
}

/// Output format of the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// One JSON document with all curves.
    Json,
    /// Comma-separated values with a header.
    Csv,
    /// Plot of stress against stretch (paths only).
    Svg,
}

/// One point of a path.
#[derive(Debug, Serialize)]
struct PathRow {
    /// Stretch, or amount of shear [-].
    value: f64,
    #[serde(rename = "F")]
    deformation_gradient: [[f64; 3]; 3],
    #[serde(flatten)]
    answer: MaterialAnswer,
}

/// Evaluates the law and writes the answer.
///
/// # Errors
/// All errors in the question; a deformation at which the law has no stress.
pub fn material(args: &MaterialArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    if let Some(MaterialCommand::Fit(args)) = &args.command {
        return material_fit(args, out);
    }
    let (questions, warnings) = MaterialQuestions::read(&read_input(args)?)?;
    for warning in &warnings {
        tracing::warn!("{warning}");
    }
    match &args.path {
        None => answer_points(&questions, args.format, out)?,
        Some(name) => answer_path(
            &questions,
            &PathRequest::new(*name, [args.from, args.to], args.points)?,
            args.format,
            out,
        )?,
    }
    Ok(Exit::Success)
}

fn read_input(args: &MaterialArgs) -> Result<Vec<u8>, CliError> {
    let Some(file) = &args.file else {
        let question = serde_json::json!({"material": {"library": args.library}});
        return Ok(question.to_string().into_bytes());
    };
    read_file(file)
}

fn answer_points(questions: &MaterialQuestions, format: Format, out: &mut dyn Write) -> Result<(), CliError> {
    let answers: Vec<MaterialAnswer> =
        questions.each().map(|(place, question)| at_point(&place, question)).collect::<Result<_, _>>()?;
    warn_beyond(answers.iter());
    match format {
        Format::Json => write_json(questions, &answers, out)?,
        Format::Csv => {
            writeln!(out, "item,{ANSWER_COLUMNS}")?;
            for (i, answer) in answers.iter().enumerate() {
                writeln!(out, "{i},{}", columns(answer))?;
            }
        }
        Format::Svg => return Err(CliError::Usage("a picture needs a path: add --path uniaxial".into())),
    }
    Ok(())
}

/// Response at the F of the question.
fn at_point(place: &Pointer, question: &MaterialQuestion) -> Result<MaterialAnswer, CliError> {
    let here = place.key("F");
    let Some(F) = question.deformation_gradient else {
        let problem = Problem::error("missing_field", &here, "there is no deformation to evaluate at")
            .limit("a deformation gradient, three rows of three numbers")
            .remedy("add \"F\", or ask for a path with --path");
        return Err(problem.alone().into());
    };
    let F = Mat3::from_fn(|i, j| F[i][j]);
    let (law, validity) = law_of(question, place)?;
    let stress = eval_point(&law, &F)
        .map_err(|source| CliError::Material { place: here.as_str().to_owned(), source })?;
    finite(MaterialAnswer::new(&F, &stress, &validity), &here)
}

fn answer_path(
    questions: &MaterialQuestions,
    request: &PathRequest,
    format: Format,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let curves: Vec<Vec<PathRow>> = questions
        .each()
        .map(|(place, question)| along(request, &place, question))
        .collect::<Result<_, _>>()?;
    warn_beyond(curves.iter().flatten().map(|row| &row.answer));
    match format {
        Format::Json => write_json(questions, &curves, out)?,
        Format::Csv => {
            writeln!(out, "item,{},{ANSWER_COLUMNS}", request.name.value_name())?;
            for (i, curve) in curves.iter().enumerate() {
                for row in curve {
                    writeln!(out, "{i},{},{}", row.value, columns(&row.answer))?;
                }
            }
        }
        Format::Svg => out.write_all(picture(questions, request.name, &curves)?.as_bytes())?,
    }
    Ok(())
}

/// Evaluates a path point by point.
fn along(
    request: &PathRequest,
    place: &Pointer,
    question: &MaterialQuestion,
) -> Result<Vec<PathRow>, CliError> {
    let (law, validity) = law_of(question, place)?;
    let path = request.name.path();
    let points = eval_path(&law, law.fibre_directions(), path, &request.values)
        .map_err(|source| CliError::Material { place: place.key("material").as_str().to_owned(), source })?;
    points.iter().map(|point| row(point, &validity, place)).collect()
}

fn row(point: &PathPoint, validity: &Validity, place: &Pointer) -> Result<PathRow, CliError> {
    let answer = finite(MaterialAnswer::new(&point.F, &point.stress, validity), place)?;
    Ok(PathRow { value: point.value, deformation_gradient: rows(&point.F), answer })
}

/// The law of a question, and its range of validity.
fn law_of(question: &MaterialQuestion, place: &Pointer) -> Result<(Material, Validity), CliError> {
    let law = question.material.to_material().ok_or_else(|| CliError::Material {
        place: place.key("material").as_str().to_owned(),
        source: material::MaterialError::NoSuchFibres,
    })?;
    Ok((law, question.material.valid_to().range_of(&law)))
}

/// Warns of answers beyond the ranges of their laws.
fn warn_beyond<'a>(answers: impl Iterator<Item = &'a MaterialAnswer>) {
    let ranges: Vec<InRange> = answers.map(|answer| answer.range).collect();
    let count = |range: InRange| ranges.iter().filter(|of| **of == range).count();
    let (extrapolated, beyond) = (count(InRange::Extrapolated), count(InRange::BeyondLimit));
    if extrapolated + beyond > 0 {
        tracing::warn!(
            "{} of {} points are beyond the range that the law is fitted to, or that is usual for it, {beyond} of them beyond its limit (`range`)",
            extrapolated + beyond,
            ranges.len()
        );
    }
}

/// Rejects an overflow: JSON cannot represent infinity.
fn finite(answer: MaterialAnswer, place: &Pointer) -> Result<MaterialAnswer, CliError> {
    if answer.is_finite() {
        return Ok(answer);
    }
    let problem = Problem::error("overflow", place, "the stress is beyond the range of numbers")
        .limit("finite")
        .remedy("give a smaller deformation");
    Err(problem.alone().into())
}

/// Writes one answer for one question, a list for a list.
fn write_json<T: Serialize>(
    questions: &MaterialQuestions,
    answers: &[T],
    out: &mut dyn Write,
) -> io::Result<()> {
    match (questions, answers) {
        (MaterialQuestions::One(_), [answer]) => serde_json::to_writer_pretty(&mut *out, answer)?,
        _ => serde_json::to_writer_pretty(&mut *out, answers)?,
    }
    writeln!(out)
}

const ANSWER_COLUMNS: &str = "J,psi_j_per_m3,\
    P_xx_pa,P_xy_pa,P_xz_pa,P_yx_pa,P_yy_pa,P_yz_pa,P_zx_pa,P_zy_pa,P_zz_pa,\
    cauchy_xx_pa,cauchy_yy_pa,cauchy_zz_pa,cauchy_xy_pa,cauchy_yz_pa,cauchy_xz_pa,range";

fn columns(answer: &MaterialAnswer) -> String {
    let s = &answer.cauchy_pa;
    let cauchy = [s[0][0], s[1][1], s[2][2], s[0][1], s[1][2], s[0][2]];
    let numbers = [answer.jacobian, answer.psi_j_per_m3];
    let all = numbers.iter().chain(answer.first_piola_pa.iter().flatten()).chain(&cauchy);
    let range = answer.range.name().to_owned();
    all.map(f64::to_string).chain([range]).collect::<Vec<_>>().join(",")
}

fn picture(
    questions: &MaterialQuestions,
    name: PathName,
    curves: &[Vec<PathRow>],
) -> Result<String, CliError> {
    let mut lines = Vec::new();
    for ((i, curve), (_, question)) in curves.iter().enumerate().zip(questions.each()) {
        let law = question.material.law_name();
        let label = if curves.len() == 1 { law.to_owned() } else { format!("{i}: {law}") };
        for &(component, (r, c)) in name.components() {
            let points = |of: fn(&MaterialAnswer) -> &[[f64; 3]; 3]| {
                curve.iter().map(|row| (row.value, of(&row.answer)[r][c])).collect()
            };
            lines.push(plot::Line {
                label: format!("{label}, Cauchy {component}"),
                points: points(|a| &a.cauchy_pa),
            });
            lines.push(plot::Line {
                label: format!("{label}, nominal {component}"),
                points: points(|a| &a.first_piola_pa),
            });
        }
    }
    plot::stress_plot(name.title(), name.axis(), &lines).map_err(CliError::Picture)
}
