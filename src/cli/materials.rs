//! `contuse materials`: the named sets of the library, with their sources.

use super::json::write_json;
use super::plan::write_table;
use super::{CliError, Exit};
use crate::mechanics::material::Validity;
use crate::scene::materials::library::{MaterialSet, SourceSpread, find, sets, unknown};
use crate::scene::problem::Pointer;
use clap::Args;
use std::io::{self, Write};

/// Arguments of `contuse materials`.
#[derive(Args, Debug)]
pub struct MaterialsArgs {
    /// Name of one set, to see all of it, or of a family, to list it: muscle.
    pub name: Option<String>,
    /// Print the sets as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Lists the sets, or shows one.
///
/// # Errors
/// When there is no set or family of that name.
pub fn materials(args: &MaterialsArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let name = args.name.as_deref();
    let listed: Vec<&MaterialSet> =
        sets().iter().filter(|set| name.is_none_or(|family| set.family() == family)).collect();
    match (name.and_then(find), name) {
        (Some(set), _) if args.json => write_json(set, out)?,
        (Some(set), _) => write_set(set, out)?,
        (None, Some(name)) if listed.is_empty() => {
            return Err(unknown(name, &Pointer::root()).alone().into());
        }
        (None, _) if args.json => write_json(&listed, out)?,
        (None, _) => write_list(&listed, out)?,
    }
    Ok(Exit::Success)
}

fn write_list(listed: &[&MaterialSet], out: &mut dyn Write) -> io::Result<()> {
    let header = ["name", "law", "G slow", "G sudden", "viscosity", "Prony", "stretches", "source"];
    let rows: Vec<[String; 8]> = listed.iter().map(|set| row(set)).collect();
    write_table(&header, &rows, out)?;
    writeln!(
        out,
        "\nG is the shear modulus at small strains, under slow and under sudden loading. `contuse materials NAME` shows all of a set."
    )
}

fn row(set: &MaterialSet) -> [String; 8] {
    let [slow, sudden] = set.slow_and_sudden_moduli_pa();
    let branches = set.prony_series.as_ref().map(|prony| {
        let times = prony.branches.iter().map(|branch| branch.relaxation_time_s);
        let (least, most) = times.fold((f64::INFINITY, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
        if least < most { format!("{least:.2e} to {most:.2e} s") } else { format!("{least:.2e} s") }
    });
    [
        set.name.clone(),
        set.material.law_name().to_owned(),
        pascals(slow),
        pascals(sudden),
        set.shear_viscosity_pa_s.map_or_else(|| "-".to_owned(), |eta| format!("{eta} Pa s")),
        branches.unwrap_or_else(|| "-".to_owned()),
        stretches(set),
        set.short_source().to_owned(),
    ]
}

/// The stretches that are stated, in brackets those of the law where none are.
fn stretches(set: &MaterialSet) -> String {
    match (set.material.valid_to().stretch, validity(set)) {
        (Some([from, to]), _) => format!("{from} to {to}"),
        (None, Some(Validity { fitted, .. })) => format!("({} to {})", fitted.stretch[0], fitted.stretch[1]),
        (None, None) => "-".to_owned(),
    }
}

fn validity(set: &MaterialSet) -> Option<Validity> {
    Some(set.material.valid_to().range_of(&set.law()?))
}

fn pascals(value: f64) -> String {
    match value {
        v if v >= 1e6 => format!("{:.3} MPa", 1e-6 * v),
        v if v >= 1e3 => format!("{:.3} kPa", 1e-3 * v),
        v => format!("{v:.1} Pa"),
    }
}

fn write_set(set: &MaterialSet, out: &mut dyn Write) -> Result<(), CliError> {
    let [slow, sudden] = set.slow_and_sudden_moduli_pa();
    writeln!(out, "{}: {}\n", set.name, set.tissue)?;
    let mut line = |what: &str, text: &str| writeln!(out, "{what:<16}  {text}");
    line(
        "shear modulus",
        &format!("{} under slow, {} under sudden loading", pascals(slow), pascals(sudden)),
    )?;
    line("density", &format!("{} kg/m³: {}", set.density_kg_per_m3, set.density_from))?;
    line("bulk modulus", &set.bulk_modulus_from)?;
    if let Some(eta) = set.shear_viscosity_pa_s {
        line("shear viscosity", &format!("{eta} Pa s"))?;
    }
    if let Some(range) = validity(set) {
        let ([from, to], [least, most]) = (range.fitted.stretch, range.limit.stretch);
        let given = set.material.valid_to();
        let whose = if given.stretch.is_some() { "" } else { " (usual for the law)" };
        let beyond = if given.limit_stretch.is_some() { "results withheld" } else { "peaks omitted" };
        line("stretches", &format!("{from} to {to}{whose}; {beyond} beyond {least} to {most}"))?;
    }
    if let Some([from, to]) = set.material.valid_to().strain_rate_per_s {
        line("strain rates", &if from < to { format!("{from} to {to} /s") } else { format!("{to} /s") })?;
    }
    line("temperature", &set.temperature)?;
    line("strain", &set.strain_range)?;
    line("rate", &set.rate_range)?;
    line("fitted", &set.fitted)?;
    line("derived here", &set.derived)?;
    if let Some(fit) = &set.fit {
        line(
            "fit",
            &format!("{} points, at most {:.0} % off", fit.points.len(), 100.0 * fit.relative_error),
        )?;
    }
    for text in &set.contradictions {
        line("contradiction", text)?;
    }
    for SourceSpread { parameter, least, most, from } in &set.spread {
        line("spread", &format!("{parameter} {least} to {most}: {from}"))?;
    }
    for source in &set.sources {
        line("source", &format!("{} <{}> (read: {})", source.citation, source.url, source.read))?;
    }
    writeln!(out, "\nIn a part: \"material\": {{\"library\": \"{}\"}}, which stands for", set.name)?;
    write_json(&set.material, out)?;
    if let Some(prony) = &set.prony_series {
        writeln!(out, "with \"prony_series\":")?;
        write_json(prony, out)?;
    }
    Ok(())
}
