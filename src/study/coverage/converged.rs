//! Coverage on impacts without a known answer: each number against that of a much finer mesh.
//!
//! The finer mesh has an error of its own. At first order the difference of the two meshes is the fraction 1 − h_ref/h of the error,
//! so it is divided by that fraction, lest a reference with the same error flatter the error bars.

use super::impacts::Impact;
use super::numbers::{WithBar, value_at};
use super::{CoverageStudy, NoClaim, Number, each, run_finished};
use crate::scene::document::{AccuracyDocument, ErrorBarsDocument, SceneDocument};
use crate::scene::{Budget, NoFiles, Scene, load_document, load_parsed};
use crate::step::Interrupt;
use crate::study::error_bars::relative_size;
use crate::study::setting::Setting;
use serde_json::Value;

/// Where the error bars of a run come from.
#[derive(Clone, Copy, PartialEq)]
enum Bars {
    /// Coarser meshes, on request.
    Levels(ErrorBarsDocument),
    /// The sequence of meshes of an accuracy.
    Accuracy,
}

/// All kinds of error bars, with their names.
const BARS: [(&str, Bars); 3] = [
    ("two levels", Bars::Levels(ErrorBarsDocument::TwoLevels)),
    ("three levels", Bars::Levels(ErrorBarsDocument::ThreeLevels)),
    ("accuracy", Bars::Accuracy),
];

/// Estimated time of the sequences of an accuracy [s]: most of them end on the mesh that they begin below.
const SEQUENCE_S: f64 = 1.0;
/// Least ratio of the element sizes of a mesh and of that which it is compared with, lest the difference is a small part of the error [-].
const LEAST_RATIO: f64 = 1.9;

/// Results of a run and the document that it is of.
type Run = Result<(SceneDocument, Value), String>;

/// Runs all impacts on all of their meshes with each kind of error bars, in parallel on all threads.
pub fn study_impacts(
    impacts: &[Impact],
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> CoverageStudy {
    // All runs, the long ones first: the references, and each mesh with each kind of error bars.
    let references = impacts.iter().map(|impact| (impact, impact.reference, None));
    let mut runs: Vec<_> = references.collect();
    for impact in impacts {
        let meshes = impact.meshes.iter().rev();
        let kinds = BARS.into_iter().filter(|(_, bars)| *bars != Bars::Accuracy || impact.with_accuracy);
        runs.extend(meshes.flat_map(|mesh| kinds.clone().map(|bars| (impact, *mesh, Some(bars)))));
    }
    let done: Vec<Run> = each(&runs, |(impact, mesh, bars)| {
        let bars = bars.map_or(Bars::Levels(ErrorBarsDocument::None), |(_, bars)| bars);
        run_on(impact, *mesh, bars, interrupt)
    });
    // Each run against the reference of its impact.
    let (references, compared) = done.split_at(impacts.len());
    let mut study = CoverageStudy::default();
    for ((impact, mesh, bars), run) in runs[impacts.len()..].iter().zip(compared) {
        let reference = impacts.iter().position(|other| std::ptr::eq(other, *impact)).map(|i| &references[i]);
        let bars = bars.map_or("", |(name, _)| name);
        let label = format!("numbers of elements × {mesh:.2}, {bars}");
        let no_claim = |reason: &str| NoClaim {
            scenario: impact.scenario,
            run: label.clone(),
            reason: reason.to_owned(),
        };
        match (reference, run) {
            (Some(Ok(reference)), Ok(run)) if relative_size(&reference.0, &run.0) < LEAST_RATIO => {
                study.without.push(no_claim("its finest mesh is too fine to be compared"));
            }
            (Some(Ok(reference)), Ok(run)) => {
                study.runs += 1;
                study.numbers.extend(compare(impact, (&label, bars), run, reference));
            }
            (Some(Err(reason)), _) => study.without.push(no_claim(&format!("no reference: {reason}"))),
            (_, Err(reason)) => study.without.push(no_claim(reason)),
            (None, _) => {}
        }
    }
    study
}

/// Runs an impact on a mesh, or from there to an accuracy; the document is that of the finest mesh.
fn run_on(
    impact: &Impact,
    mesh_factor: f64,
    bars: Bars,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> Run {
    let problems = |problems: crate::scene::Problems| problems.to_string();
    let own =
        load_parsed(&impact.document.clone().into(), &NoFiles, &Budget::COMMAND_LINE).map_err(problems)?;
    let on_mesh = |mesh_factor: f64| {
        let setting = Setting { mesh_factor, ..Setting::OWN };
        setting.apply(&own.scene.document).ok_or("there is no such mesh")
    };
    let mut document = on_mesh(mesh_factor)?;
    match bars {
        Bars::Levels(levels) => document.solver.error_bars = levels,
        Bars::Accuracy => {
            document.solver.error_bars = ErrorBarsDocument::default();
            document.accuracy = Some(sequence());
        }
    }
    let scene: Scene = load_document(document, &NoFiles, &Budget::COMMAND_LINE).map_err(problems)?.scene;
    let summary = run_finished(&scene, interrupt)?;
    let results = serde_json::to_value(summary.values()).map_err(|error| error.to_string())?;
    if bars != Bars::Levels(ErrorBarsDocument::None) && !summary.error_bars.starts_with("estimated") {
        return Err(summary.error_bars);
    }
    let finest = summary.accuracy.map(|accuracy| on_mesh(accuracy.mesh_factor * mesh_factor));
    Ok((finest.unwrap_or(Ok(scene.document))?, results))
}

/// An accuracy that no mesh reaches: the sequence ends with its time, on every machine alike.
fn sequence() -> AccuracyDocument {
    AccuracyDocument { relative: 1e-6, time_budget_s: SEQUENCE_S, reproducible: true, ..Default::default() }
}

/// The numbers of a run that have error bars, with their errors.
fn compare(
    impact: &Impact,
    (label, bars): (&str, &'static str),
    (document, results): &(SceneDocument, Value),
    (reference, exact): &(SceneDocument, Value),
) -> Vec<Number> {
    let ratio = relative_size(reference, document);
    let number = |found: WithBar| {
        let exact = value_at(exact, &found.pointer)?;
        // A zero that stays zero is no prediction.
        (exact != 0.0 || found.value != 0.0).then(|| Number {
            scenario: impact.scenario,
            run: label.to_owned(),
            bars,
            chosen_on: impact.chosen_on,
            quantity: found.quantity(),
            exact,
            value: found.value,
            error: (found.value - exact).abs() * ratio / (ratio - 1.0),
            error_bar: found.error_bar,
            resolved: found.resolved,
        })
    };
    WithBar::all(results).into_iter().filter_map(number).collect()
}
