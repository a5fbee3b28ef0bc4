//! The sequence of meshes of a scene that is run to an accuracy, what they take, and the error bars that they give.

use super::bulk_modulus_choice::{BulkModulusEffect, effect_of_cap, untried_cap};
use super::error_bars::{compared_runs, error_bars, keeps_a_direction, relative_size, steps_and_contact};
use super::setting::Setting;
use super::variant::{Variants, split};
use crate::measure::{Compared, ComparedRuns, ErrorBars, Level};
use crate::plan::{CompileError, Plan, compile};
use crate::scene::document::{AccuracyDocument, MeshDocument, SceneDocument};
use crate::scene::{Budget, Scene};
use crate::step::Interrupt;
use std::cell::OnceCell;
use std::f64::consts::SQRT_2;

/// Minimum number of elements of the first mesh, if the scene's own has as many [-].
const FEWEST_ELEMENTS: f64 = 100.0;
/// Number of coarser meshes for the error bars, if there are as many.
pub(super) const LEVELS_USED: usize = 2;
/// Numbers of elements of the coarsest mesh relative to the scene's own [-].
const COARSEST: f64 = 0.25;
/// Most elements of a direction in which √2 times the number is no refinement by √2 (1 stays 1, 2 becomes 3) [-].
const THIN: u32 = 2;
/// Most numbers of elements of a mesh on which the bulk modulus of water is tried, relative to the scene's own [-]: where the scene has 50 MPa, the
/// run takes at most 0.4 of the time of one on the scene's own mesh.
const COARSE: f64 = 0.5;
/// Order of the run time in 1/h: elements and steps.
const ORDER_OF_TIME: f64 = 4.0;
/// The least it can be: a thin direction keeps its elements, and they limit the step.
const LEAST_ORDER_OF_TIME: f64 = 2.0;
/// Factor of safety on a predicted time: contact, and steps limited by strain, grow slightly faster.
const CAUTION: f64 = 1.2;

/// How the numbers of elements grow above the scene's own mesh. Below it thin directions keep their elements whatever the ratio, so that
/// it is √2 for every generated mesh.
#[derive(Clone, Copy)]
enum Growth {
    /// By √2 from one level to the next, rounded.
    Roots,
    /// 2, 3, 4, 6, 8 … times, about √2 from the first of them on: also with one element in a direction, levels do not differ in the ratio of
    /// thickness to width.
    Wholes,
    /// By 2: elements of a mesh from a file are split.
    Splits,
}

impl Growth {
    fn of(document: &SceneDocument) -> Self {
        let counts = document.bodies.iter().filter_map(|body| body.mesh.as_ref()).map(MeshDocument::counts);
        let is_thin = |counts: Vec<u32>| counts.into_iter().any(|count| count <= THIN);
        match document.has_mesh_file() {
            true => Self::Splits,
            false if counts.into_iter().any(is_thin) => Self::Wholes,
            false => Self::Roots,
        }
    }

    /// Numbers of elements of a level relative to the scene's own [-].
    fn factor(self, level: i32) -> f64 {
        match self {
            Self::Splits if level > 0 => 2_f64.powi(level),
            Self::Wholes if level > 0 && level % 2 == 0 => 1.5 * 2_f64.powi(level / 2),
            Self::Wholes if level > 0 => 2_f64.powi(level / 2 + 1),
            _ => SQRT_2.powi(level),
        }
    }
}

/// The sequence of meshes of a scene.
pub(super) struct Meshes<'a> {
    scene: &'a Scene,
    /// Whatever their runs need but the scene.
    pub variants: Variants<'a>,
    growth: Growth,
    /// What its bulk moduli change, once that is known.
    pub bulk_modulus: OnceCell<BulkModulusEffect>,
}

/// A completed level that may serve error bars.
pub(super) struct Done {
    /// Its number: 0 is the scene's own mesh.
    pub level: i32,
    /// The scene on its mesh.
    pub scene: Scene,
    /// Its run, and the time that it took [s].
    pub run: Compared,
    pub seconds: f64,
    /// The same with shorter steps, and with a looser contact tolerance, once an error bar needs them.
    pub others: OnceCell<Result<[Compared; 2], String>>,
}

/// The mesh of a level.
pub(super) struct LevelMesh {
    /// Its number: 0 is the scene's own mesh.
    pub level: i32,
    /// The scene on it.
    pub scene: Scene,
    /// Its plan, if that was made to estimate its time.
    pub plan: Option<Plan>,
}

impl LevelMesh {
    /// Estimated run time [s].
    pub fn expected_s(&mut self) -> Result<f64, CompileError> {
        let plan = self.plan.take().map_or_else(|| compile(&self.scene), Ok)?;
        Ok(self.plan.insert(plan).report.expected_run_time_s)
    }
}

/// The level after one, and its time.
pub(super) struct Ahead {
    /// The mesh, or why there is none; `None` if it is not made yet.
    pub next: Option<Result<LevelMesh, String>>,
    /// Its run time in units of that of the level itself [-].
    pub growth: f64,
}

impl<'a> Meshes<'a> {
    /// Those of a scene.
    pub fn of(
        scene: &'a Scene,
        threads: usize,
        interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    ) -> Self {
        let document = &scene.document;
        let variants = Variants {
            document,
            source: &scene.kept_files,
            budget: &Budget::COMMAND_LINE,
            threads,
            interrupt,
        };
        Self { scene, variants, growth: Growth::of(document), bulk_modulus: OnceCell::new() }
    }

    /// The level of the scene itself.
    pub fn own(&self) -> LevelMesh {
        LevelMesh { level: 0, scene: self.scene.clone(), plan: None }
    }

    /// The first level: some below the scene's own mesh, as long as a few elements are left and the mesh can be made so coarse.
    pub fn first(&self) -> LevelMesh {
        let elements = |level: i32| self.scene.element_count() as f64 * self.factor(level).powi(3);
        let below = if self.scene.document.has_mesh_file() { 0.0 } else { COARSEST.log(SQRT_2).round() };
        (below as i32..0)
            .filter(|level| elements(*level) >= FEWEST_ELEMENTS)
            .find_map(|level| self.at(level).ok())
            .unwrap_or_else(|| self.own())
    }

    /// The level after `level`, whose own estimated run time is `own_s` [s]. A mesh that is certainly too fine for the time that is left is
    /// not even made.
    pub fn look_ahead(&self, is_over_after: impl Fn(f64) -> bool, own_s: f64, level: i32) -> Ahead {
        let ratio = self.factor(level + 1) / self.factor(level);
        let [least, usual] = [LEAST_ORDER_OF_TIME, ORDER_OF_TIME].map(|order| ratio.powf(order));
        if is_over_after(least * own_s) {
            let next = Err("it would take longer than the estimates allow".into());
            return Ahead { next: Some(next), growth: usual };
        }
        let estimated = |mut mesh: LevelMesh| {
            let seconds = mesh.expected_s().map_err(|error| error.to_string())?;
            Ok((mesh, seconds))
        };
        match self.at(level + 1).and_then(estimated) {
            Ok((mesh, seconds)) => Ahead { next: Some(Ok(mesh)), growth: seconds / own_s },
            Err(why) => Ahead { next: Some(Err(why)), growth: f64::INFINITY },
        }
    }

    /// Run time of the level after one in units of its own [-]: h⁻¹ steps, and elements as their number grew from the level `before`,
    /// where thin directions and regions refined to a given size keep theirs; once its own time is known, no faster than that grew, since
    /// part of the work is the same on all meshes. Infinite for more elements than there may be.
    pub fn growth_of_time(
        &self,
        LevelMesh { level, scene, .. }: &LevelMesh,
        before: Option<&Done>,
        seconds: Option<f64>,
    ) -> f64 {
        let elements = scene.element_count() as f64;
        let (mut dimensions, mut order) = (ORDER_OF_TIME - 1.0, ORDER_OF_TIME);
        if let Some(before) = before {
            let ratio = self.factor(*level) / self.factor(before.level);
            let grown = elements / before.scene.element_count() as f64;
            dimensions = grown.log(ratio).clamp(1.0, dimensions);
            let measured =
                seconds.map_or(order, |seconds| (seconds / before.seconds.max(f64::MIN_POSITIVE)).log(ratio));
            order = measured.clamp(LEAST_ORDER_OF_TIME, dimensions + 1.0);
        }
        let ratio = self.factor(level + 1) / self.factor(*level);
        if elements * ratio.powf(dimensions) > Budget::COMMAND_LINE.elements as f64 {
            return f64::INFINITY;
        }
        ratio.powf(order) * CAUTION
    }

    /// Numbers of elements of a level relative to the scene's own [-].
    pub fn factor(&self, level: i32) -> f64 {
        self.growth.factor(level)
    }

    /// Mesh of a level (0 for that of the document itself), or the reason why there is none: it cannot be made, or exceeds the budget.
    pub fn at(&self, level: i32) -> Result<LevelMesh, String> {
        let scene = if level == 0 {
            self.scene.clone()
        } else if self.scene.document.has_mesh_file() {
            split(self.scene, level.unsigned_abs())?
        } else {
            let setting = Setting { mesh_factor: self.factor(level), ..Setting::OWN };
            let scene = self.variants.scene(&setting, None, None);
            scene.map_err(|error| format!("no run on another mesh: {error}"))?
        };
        Ok(LevelMesh { level, scene, plan: None })
    }

    /// Element size of a completed level relative to that of a finer one [-].
    fn size(&self, coarse: &Done, fine: &Scene, level: i32) -> f64 {
        if self.scene.document.has_mesh_file() {
            self.factor(level) / self.factor(coarse.level)
        } else {
            relative_size(&fine.document, &coarse.scene.document)
        }
    }

    /// Error bars of a level: from the coarser ones, or, where it is the only one, those of any run; with what its bulk moduli change.
    pub fn bars(
        &self,
        done: &[Done],
        mesh: &mut LevelMesh,
        is_only: bool,
        requested: &AccuracyDocument,
    ) -> ErrorBars {
        let mut bars = if is_only {
            error_bars(&mesh.scene, &[], self.variants.threads, self.variants.interrupt)
        } else {
            self.bars_of_levels(done, &mesh.scene, mesh.level)
        };
        let of_cap = |first: &Done| {
            self.bulk_modulus.get_or_init(|| self.effect_of_cap(first, requested));
        };
        done.first().into_iter().for_each(of_cap);
        if let Some(BulkModulusEffect { change, warning }) = self.bulk_modulus.get() {
            mesh.scene.warnings.extend(warning.clone());
            if let ErrorBars::From(runs) = &mut bars {
                runs.bulk_modulus.clone_from(change);
            }
        }
        bars
    }

    /// What the bulk moduli of the scene in place of that of water change on the first mesh; not tried where that is not much coarser than the
    /// scene's own, so that the run would take longer than the others.
    fn effect_of_cap(&self, first: &Done, requested: &AccuracyDocument) -> BulkModulusEffect {
        if self.factor(first.level) > COARSE {
            return untried_cap(&first.scene);
        }
        effect_of_cap((&first.scene, &first.run), requested, &self.variants)
    }

    fn bars_of_levels(&self, done: &[Done], mesh: &Scene, level: i32) -> ErrorBars {
        let used = &done[done.len().saturating_sub(LEVELS_USED)..];
        let Some(coarsest) = used.first() else {
            return ErrorBars::Unknown("there is no coarser mesh to compare with".into());
        };
        // Steps and contact on the coarsest of them.
        let others = coarsest
            .others
            .get_or_init(|| steps_and_contact(&self.variants, (&coarsest.scene, coarsest.run.steps), &[]));
        let of = |done: &Done| Level { size: self.size(done, mesh, level), run: done.run.clone() };
        let levels = used.iter().map(of).collect();
        // Splitting divides every direction.
        let keeps_a_direction = !self.scene.document.has_mesh_file()
            && keeps_a_direction(&mesh.document, &coarsest.scene.document);
        others.clone().map_or_else(ErrorBars::Unknown, |others| {
            let runs = compared_runs(&self.scene.document, coarsest.run.clone(), others, levels);
            ErrorBars::From(Box::new(ComparedRuns { keeps_a_direction, ..runs }))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::float_cmp)] // powers of two are exact
    fn thin_layers_have_whole_numbers_of_elements_on_every_finer_mesh() {
        let factors = |growth: Growth| (0..7).map(|level| growth.factor(level)).collect::<Vec<_>>();
        assert_eq!(factors(Growth::Wholes), [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0]);
        assert_eq!(factors(Growth::Splits)[..4], [1.0, 2.0, 4.0, 8.0]);
        for growth in [Growth::Roots, Growth::Wholes, Growth::Splits] {
            assert_eq!(growth.factor(-1), 1.0 / SQRT_2);
        }
    }
}
