//! Error against run time: one scene computed with many settings, with the cost and the error of each.
//!
//! A ladder changes one setting at a time ([`Setting`]): meshes for each formulation, time steps, tolerances of the
//! contact solver. Errors refer to the exact value if the scene has one, otherwise to the limit of the finest meshes
//! ([`extrapolate`](crate::measure::convergence::extrapolate)), with its uncertainty.

mod chart;
mod front;
mod geometry;
mod reference;
mod row;

pub use chart::chart;
pub use front::{Advice, TARGETS};
pub use geometry::Geometry;
pub use reference::Approach;
pub use row::Row;

use super::Setting;
use super::single::{ending_name, is_stop};
use super::variant::Variants;
pub use crate::measure::convergence::Reference;
use crate::measure::{QuantityOfInterest, QuantityTitle};
use crate::scene::document::{ContactSolver, Formulation, SceneDocument};
use crate::scene::{Budget, MeshSource};
use crate::step::{Ending, Interrupt};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::RangeInclusive;

/// Admissible coarsest meshes: −1 halves the numbers of elements of generated meshes.
pub const COARSEST: RangeInclusive<i32> = -4..=0;
/// Admissible finest meshes: one level more is sixteen times the work.
pub const FINEST: RangeInclusive<i32> = 0..=4;
/// Default range of meshes.
pub const USUAL_LEVELS: RangeInclusive<i32> = -1..=1;

/// Ending of a setting that was not run.
const OMITTED: &str = "omitted";

/// Request for an error study.
pub struct ErrorRequest<'a> {
    /// Scene with a definite time integration: that of a validated scene, not `auto`, which each setting would choose
    /// anew.
    pub document: &'a SceneDocument,
    /// Source of its meshes.
    pub source: &'a dyn MeshSource,
    /// Budget of a run: settings beyond it are reported and omitted.
    pub budget: &'a Budget,
    /// Settings to run, in this order.
    pub ladder: &'a [Setting],
    /// Exact values, and those of another code, if known.
    pub known: &'a BTreeMap<QuantityOfInterest, Reference>,
    /// Threads of each run.
    pub threads: usize,
    /// Called before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Called before each run with its index, the number of runs, and its setting.
    pub progress: &'a mut dyn FnMut(usize, usize, &Setting),
}

/// Results of the error study.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorStudy {
    /// Name of the scene.
    pub scene: String,
    /// Threads of each run.
    pub threads: usize,
    /// Titles and units of the numbers, by their names.
    pub quantities: BTreeMap<QuantityOfInterest, QuantityTitle>,
    /// References for the errors.
    pub references: BTreeMap<QuantityOfInterest, Reference>,
    /// Convergence of the scene's own meshes to the exact values; quantities with a single mesh are omitted.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub approaches: BTreeMap<QuantityOfInterest, Approach>,
    /// Runs in the order of the ladder.
    pub rows: Vec<Row>,
    /// Part of the change from the scene's own mesh to the next finer one due to the surface; empty if not requested.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub geometry: BTreeMap<QuantityOfInterest, Geometry>,
    /// Cheapest setting for each quantity and target.
    pub advice: Vec<Advice>,
    /// Why it was stopped early: `cancelled` or `deadline`; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
}

/// Ingredients of the ladder of settings.
#[derive(Clone, Debug)]
pub struct Ladder<'a> {
    /// Mesh levels, from coarse to fine.
    pub levels: RangeInclusive<i32>,
    /// Whether there is a mesh between each level and the next, √2 times as fine; meshes from files have none.
    pub half_levels: bool,
    /// Formulations in addition to the scene's own.
    pub formulations: &'a [Formulation],
    /// Implicit steps on the scene's own mesh in addition to its own time integration [s].
    pub implicit_steps_s: &'a [f64],
    /// Solvers of contact problems on the scene's own mesh, with its own time integration and with each of those steps.
    pub contact_solvers: &'a [ContactSolver],
    /// Whether the next finer mesh is also run with its new nodes on the facets, which isolates the effect of the true
    /// surface.
    pub geometry: bool,
    /// Whether integrators and redistributed mass are combined with every mesh and formulation; otherwise they are run
    /// on the scene's own mesh.
    pub combined: bool,
}

impl Ladder<'_> {
    /// Meshes for each formulation, then time steps, tolerances, masses, implicit steps and contact solvers on the
    /// scene's own mesh; then, if requested, combinations.
    pub fn settings(&self) -> Vec<Setting> {
        let steps = [2.0, 4.0].map(|step_divisor| Setting { step_divisor, ..Setting::OWN });
        let tolerances = [1e-3, 1e-6].map(|t| Setting { contact_tolerance: Some(t), ..Setting::OWN });
        let masses =
            [0.5, 0.75, 0.9].map(|fraction| Setting { mass_redistribution: Some(fraction), ..Setting::OWN });
        let implicit =
            self.implicit_steps_s.iter().map(|h| Setting { implicit_step_s: Some(*h), ..Setting::OWN });
        let mut settings = self.meshes();
        settings.extend(self.geometry.then_some(geometry::ON_FACETS));
        settings.extend(steps.into_iter().chain(tolerances).chain(masses).chain(implicit.clone()));
        for solver in self.contact_solvers {
            let steppings = std::iter::once(Setting::OWN).chain(implicit.clone());
            settings.extend(steppings.map(|s| Setting { contact_solver: Some(*solver), ..s }));
        }
        if self.combined {
            for setting in self.meshes().into_iter().flat_map(|mesh| self.combinations(mesh)) {
                if !settings.contains(&setting) {
                    settings.push(setting);
                }
            }
        }
        settings
    }

    /// All meshes, in the scene's own formulation and in each of the others.
    fn meshes(&self) -> Vec<Setting> {
        let formulations = std::iter::once(None).chain(self.formulations.iter().copied().map(Some));
        let of_level = |mesh_level: i32| {
            let below = Setting { mesh_level, mesh_factor: FRAC_1_SQRT_2, ..Setting::OWN };
            let has_below = self.half_levels && mesh_level > *self.levels.start();
            has_below.then_some(below).into_iter().chain([Setting { mesh_level, ..Setting::OWN }])
        };
        let of_formulation = |formulation| {
            self.levels.clone().flat_map(of_level).map(move |mesh| Setting { formulation, ..mesh })
        };
        formulations.flat_map(of_formulation).collect()
    }

    /// A mesh with reduced boundary mass, and with implicit steps in proportion to its elements.
    fn combinations(&self, mesh: Setting) -> impl Iterator<Item = Setting> {
        let lighter = Setting { mass_redistribution: Some(0.5), ..mesh };
        let shorter = 0.5_f64.powi(mesh.mesh_level) / mesh.mesh_factor;
        let implicit = self.implicit_steps_s.iter();
        let implicit = implicit.map(move |h| Setting { implicit_step_s: Some(h * shorter), ..mesh });
        std::iter::once(lighter).chain(implicit)
    }
}

/// Runs every setting of the ladder and compares the results.
pub fn study_error(request: &mut ErrorRequest) -> ErrorStudy {
    let (mut rows, mut stopped) = (Vec::<Row>::new(), None);
    // Run the ladder until it ends or is stopped.
    let mut ladder = request.ladder.to_vec();
    while let Some(setting) = ladder.get(rows.len()).copied() {
        (request.progress)(rows.len(), ladder.len(), &setting);
        // "Half the step" refers to the actual steps on the scene's own mesh, whatever limited them.
        let own = rows.iter().find(|row| row.setting == Setting::OWN && row.is_finished());
        let longest = own.map(|row| request.document.end_time_s / row.steps as f64 / setting.step_divisor);
        let row = measure(request, setting, longest.filter(|_| setting.step_divisor > 1.0));
        let has_none = row.ending == OMITTED && setting.mesh_level < 0 && is_mesh(&setting);
        stopped = Some(row.ending.clone()).filter(|ending| is_stop(ending));
        rows.push(row);
        if stopped.is_some() {
            break;
        }
        if has_none && !request.document.has_mesh_file() {
            ladder = with_half_levels(&ladder, rows.len());
        }
    }
    // References, errors and advice need all runs.
    let references = reference::references(&rows, request.known);
    for row in &mut rows {
        row.errors = reference::errors(&row.values, &references);
    }
    let approaches = reference::approaches(&rows, request.known);
    let advice = front::advice(&rows, &references);
    let geometry = geometry::geometry(&rows);
    ErrorStudy {
        scene: request.document.name.clone(),
        threads: request.threads,
        quantities: QuantityOfInterest::titles(
            request.document.measures.stress_thresholds_pa.first().copied(),
        ),
        references,
        approaches,
        rows,
        geometry,
        advice,
        stopped,
    }
}

/// Whether a setting is a level of the scene's own mesh and nothing else.
fn is_mesh(setting: &Setting) -> bool {
    *setting == Setting { mesh_level: setting.mesh_level, ..Setting::OWN }
}

/// A ladder of which the first runs are done, with a mesh below each remaining level: where a generator cannot make a mesh so coarse, too few
/// are left for a limit.
fn with_half_levels(ladder: &[Setting], done: usize) -> Vec<Setting> {
    let (done, rest) = ladder.split_at(done);
    let below = |of: &Setting| is_mesh(of).then_some(Setting { mesh_factor: FRAC_1_SQRT_2, ..*of });
    let rest =
        rest.iter().flat_map(|of| below(of).filter(|it| !ladder.contains(it)).into_iter().chain([*of]));
    done.iter().copied().chain(rest).collect()
}

/// `longest`: upper bound of the step [s], if the setting reduces it.
fn measure(request: &ErrorRequest, setting: Setting, longest: Option<f64>) -> Row {
    let row = Row {
        setting,
        name: setting.name(),
        ending: OMITTED.into(),
        reason: None,
        elements: 0,
        steps: 0,
        wall_s: 0.0,
        cpu_s: None,
        values: BTreeMap::new(),
        errors: BTreeMap::new(),
    };
    // A setting that cannot be run is reported with its reason.
    let variants = Variants {
        document: request.document,
        source: request.source,
        budget: request.budget,
        threads: request.threads,
        interrupt: request.interrupt,
    };
    let result = match variants.run(&setting, longest) {
        Ok(result) => result,
        Err(error) => return Row { reason: Some(error.to_string()), ..row },
    };
    let reason = match &result.outcome.ending {
        Ending::Failed { failure } => Some(failure.message.clone()),
        Ending::Finished | Ending::Cancelled => None,
    };
    let values =
        QuantityOfInterest::ALL.into_iter().filter_map(|q| Some((q, q.of(result.summary.values())?)));
    let mean_step = request.document.end_time_s / result.outcome.steps.max(1) as f64;
    let is_whole = result.outcome.ending == Ending::Finished;
    Row {
        name: if is_whole { setting.name_with_mean_step(mean_step) } else { row.name.clone() },
        elements: result.plan_report.elements,
        steps: result.outcome.steps,
        wall_s: result.wall_s,
        cpu_s: result.cpu_s,
        // Partial values of a failed run are no results.
        values: if is_whole { values.collect() } else { BTreeMap::new() },
        ending: ending_name(&result.outcome.ending),
        reason,
        ..row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_that_cannot_be_so_coarse_is_replaced_by_those_between() {
        let level = |mesh_level| Setting { mesh_level, ..Setting::OWN };
        let half_step = Setting { step_divisor: 2.0, ..Setting::OWN };
        let ladder = [level(-1), level(0), level(1), half_step];
        let names = |ladder: &[Setting]| ladder.iter().map(Setting::name).collect::<Vec<_>>();
        let longer = with_half_levels(&ladder, 1);
        let expected = ["mesh -1", "mesh -½", "mesh 0", "mesh +½", "mesh +1", "mesh 0, step / 2"];
        assert_eq!(names(&longer), expected);
        assert_eq!(with_half_levels(&longer, 1), longer);
    }

    #[test]
    fn half_levels_are_between_the_levels() {
        let ladder = Ladder {
            levels: -2..=2,
            half_levels: true,
            formulations: &[],
            implicit_steps_s: &[],
            contact_solvers: &[],
            geometry: false,
            combined: false,
        };
        let names: Vec<String> = ladder.settings().iter().take(9).map(Setting::name).collect();
        let meshes =
            ["-2", "-1½", "-1", "-½", "0", "+½", "+1", "+1½", "+2"].map(|level| format!("mesh {level}"));
        assert_eq!(names, meshes);
    }
}
