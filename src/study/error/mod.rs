//! Error against run time: one scene computed with many settings, what each costs and how far it is off.
//!
//! A ladder changes one thing at a time ([`Setting`]): meshes for each formulation, time steps, tolerances of the contact
//! solver. Errors are against the exact value where the scene has one, else against what the finest meshes converge to
//! ([`extrapolate`](crate::measure::convergence::extrapolate)), with that limit's own uncertainty.

mod chart;
mod front;
mod geometry;
pub mod quantity;
mod reference;
mod row;

pub use chart::chart;
pub use front::{Advice, TARGETS};
pub use geometry::Geometry;
pub use quantity::Quantity;
pub use reference::Approach;
pub use row::Row;

use super::Setting;
use super::single::{ending_name, is_stop};
use super::variant::Variants;
pub use crate::measure::convergence::Reference;
use crate::scene::document::{ContactSolver, Formulation, SceneDocument};
use crate::scene::{Budget, MeshSource};
use crate::step::{Ending, Interrupt};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Coarsest meshes that may be asked for: −1 halves the numbers of elements of generated meshes.
pub const COARSEST: RangeInclusive<i32> = -4..=0;
/// Finest meshes that may be asked for: a level more is sixteen times the work.
pub const FINEST: RangeInclusive<i32> = 0..=4;
/// The coarsest and the finest mesh where nothing is asked for.
pub const USUAL_LEVELS: RangeInclusive<i32> = -1..=1;

/// What to study.
pub struct ErrorRequest<'a> {
    /// The scene, of one way of stepping: that of a validated scene, not `auto`, which each setting would choose anew.
    pub document: &'a SceneDocument,
    /// Its meshes.
    pub source: &'a dyn MeshSource,
    /// What a run may cost: settings beyond it are told and left out.
    pub budget: &'a Budget,
    /// The settings.
    pub ladder: &'a [Setting],
    /// Exact values, where they are known.
    pub exact: &'a BTreeMap<Quantity, f64>,
    /// Threads of each run.
    pub threads: usize,
    /// Asked before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Told before each run: its number, how many there are, and its setting.
    pub progress: &'a mut dyn FnMut(usize, usize, &Setting),
}

/// What came out.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorStudy {
    /// Name of the scene.
    pub scene: String,
    /// Threads of each run.
    pub threads: usize,
    /// What errors are measured against.
    pub references: BTreeMap<Quantity, Reference>,
    /// How the scene's own meshes approach the exact values; without those of which one mesh says nothing.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub approaches: BTreeMap<Quantity, Approach>,
    /// The runs, in the order of the ladder.
    pub rows: Vec<Row>,
    /// What of the change from the scene's own mesh to the next finer one is the surface's; empty where it was not asked for.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub geometry: BTreeMap<Quantity, Geometry>,
    /// For each quantity and target the cheapest setting that reaches it.
    pub advice: Vec<Advice>,
    /// Why it was stopped before its end: `cancelled` or `deadline`; absent when it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
}

/// What the settings of a ladder are made of.
#[derive(Clone, Debug)]
pub struct Ladder<'a> {
    /// Meshes, each finer than the last.
    pub levels: RangeInclusive<i32>,
    /// Formulations beside the scene's own.
    pub formulations: &'a [Formulation],
    /// Implicit steps on the scene's own mesh beside its own stepping [s].
    pub implicit_steps_s: &'a [f64],
    /// Solvers of contact problems on the scene's own mesh, with its own stepping and with each of those steps.
    pub contact_solvers: &'a [ContactSolver],
    /// Whether the next finer mesh is also run with its new nodes on the facets, which tells what the true surface does.
    pub geometry: bool,
    /// Whether integrators and redistributed mass are combined with every mesh and formulation; otherwise they are tried on the
    /// scene's own mesh.
    pub combined: bool,
}

impl Ladder<'_> {
    /// Meshes for each formulation, then time steps, tolerances, masses, implicit steps and contact solvers on the scene's own
    /// mesh; then, where they are asked for, combinations.
    pub fn settings(&self) -> Vec<Setting> {
        let steps = [2.0, 4.0].map(|step_divisor| Setting { step_divisor, ..Setting::OWN });
        let tolerances = [1e-3, 1e-6].map(|t| Setting { contact_tolerance: Some(t), ..Setting::OWN });
        let masses =
            [0.5, 0.75, 0.9].map(|share| Setting { mass_redistribution: Some(share), ..Setting::OWN });
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

    /// Every mesh, in the scene's own formulation and in each of the others.
    fn meshes(&self) -> Vec<Setting> {
        let formulations = std::iter::once(None).chain(self.formulations.iter().copied().map(Some));
        let of_formulation = |formulation| {
            self.levels.clone().map(move |mesh_level| Setting { mesh_level, formulation, ..Setting::OWN })
        };
        formulations.flat_map(of_formulation).collect()
    }

    /// A mesh with lighter skins, and with implicit steps that go with its elements.
    fn combinations(&self, mesh: Setting) -> impl Iterator<Item = Setting> {
        let lighter = Setting { mass_redistribution: Some(0.5), ..mesh };
        let shorter = 0.5_f64.powi(mesh.mesh_level);
        let implicit = self.implicit_steps_s.iter();
        let implicit = implicit.map(move |h| Setting { implicit_step_s: Some(h * shorter), ..mesh });
        std::iter::once(lighter).chain(implicit)
    }
}

/// Runs every setting of the ladder and compares them.
pub fn study_error(request: &mut ErrorRequest) -> ErrorStudy {
    let (mut rows, mut stopped) = (Vec::<Row>::new(), None);
    for (number, setting) in request.ladder.iter().enumerate() {
        (request.progress)(number, request.ladder.len(), setting);
        // "Half the step" means half of those that the scene's own mesh was run with, whatever had cut them.
        let own = rows.iter().find(|row| row.setting == Setting::OWN && row.is_finished());
        let longest = own.map(|row| request.document.end_time_s / row.steps as f64 / setting.step_divisor);
        let row = measure(request, *setting, longest.filter(|_| setting.step_divisor > 1.0));
        stopped = Some(row.ending.clone()).filter(|ending| is_stop(ending));
        rows.push(row);
        if stopped.is_some() {
            break;
        }
    }
    let references = reference::references(&rows, request.exact);
    for row in &mut rows {
        row.errors = reference::errors(&row.values, &references);
    }
    let approaches = reference::approaches(&rows, request.exact);
    let advice = front::advice(&rows, &references);
    let geometry = geometry::geometry(&rows);
    ErrorStudy {
        scene: request.document.name.clone(),
        threads: request.threads,
        references,
        approaches,
        rows,
        geometry,
        advice,
        stopped,
    }
}

/// `longest`: the longest step [s], where the setting asks for shorter ones.
fn measure(request: &ErrorRequest, setting: Setting, longest: Option<f64>) -> Row {
    let row = Row {
        setting,
        name: setting.name(),
        ending: "left_out".into(),
        reason: None,
        elements: 0,
        steps: 0,
        wall_s: 0.0,
        cpu_s: None,
        values: BTreeMap::new(),
        errors: BTreeMap::new(),
    };
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
    let values = Quantity::ALL.into_iter().filter_map(|q| Some((q, q.of(&result.summary)?)));
    let mean_step = request.document.end_time_s / result.outcome.steps.max(1) as f64;
    let is_whole = result.outcome.ending == Ending::Finished;
    Row {
        name: if is_whole { setting.name_with_mean_step(mean_step) } else { row.name.clone() },
        elements: result.plan_report.elements,
        steps: result.outcome.steps,
        wall_s: result.wall_s,
        cpu_s: result.cpu_s,
        // What a failed run had until then is no answer to the question.
        values: if is_whole { values.collect() } else { BTreeMap::new() },
        ending: ending_name(&result.outcome.ending),
        reason,
        ..row
    }
}
