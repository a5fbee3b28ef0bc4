//! Error bars: numerical errors of the results, estimated from cheaper runs of the same scene.
//!
//! One or more runs use coarser meshes; on the coarsest of them one run halves the time step, and one loosens the
//! contact tolerance. The meshes compared with the run itself give the mesh error, the other two compared with the
//! first give the errors of step and solver. First order is assumed: with two meshes a factor of safety is applied;
//! with more, a line is fitted, whose scatter widens the bar.

use super::super::convergence::{assumed_error, assumed_step_error, fitted_uncertainty};
use super::listed::Listed;
use super::quantity::{ErrorEstimate, Estimate};
use super::results::{Impact, Results};

/// Relative rounding error of sums of many numbers [-].
const ROUNDING: f64 = 1e-12;

/// Source of the error bars.
#[derive(Clone, Debug, Default)]
pub enum ErrorBars {
    /// Error bars were not requested.
    #[default]
    NotAsked,
    /// No error bars, with the reason.
    Unknown(String),
    /// Cheaper runs of the same scene.
    From(Box<CheaperRuns>),
}

impl std::fmt::Display for ErrorBars {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotAsked => f.write_str("not estimated: error bars were not requested"),
            Self::Unknown(why) => write!(f, "not estimated: {why}"),
            Self::From(runs) => {
                let sizes: Vec<String> =
                    runs.levels.iter().map(|level| format!("{:.2}", level.size)).collect();
                let rule = match sizes.len() {
                    1 => "first order assumed, factor of safety 3",
                    _ => {
                        "a fit of order 1, ¾ or ½ to all meshes, factor of safety 1.25, widened by its scatter; of the steps first order, factor of safety 3"
                    }
                };
                write!(
                    f,
                    "estimated from runs on coarser meshes (element size × {}): {rule}",
                    sizes.join(", ")
                )
            }
        }
    }
}

/// Results of one cheaper run.
#[derive(Clone, Debug, PartialEq)]
pub struct Cheaper {
    /// Summary numbers of the run.
    results: Results,
    /// Largest von Mises stress below each of the requested depths [Pa], see [`CheaperRuns::error_below`].
    von_mises_below_pa: Vec<f64>,
    /// Number of its steps.
    pub steps: u64,
}

impl Cheaper {
    /// From the results of a run, and the stresses below the requested depths.
    pub fn new(results: &Results, von_mises_below_pa: Vec<f64>, steps: u64) -> Self {
        Self { results: results.clone(), von_mises_below_pa, steps }
    }

    /// The numbers in listing order, with forces over the windows of the `own` results.
    fn numbers(&self, own: &Results) -> Vec<f64> {
        let mut results = self.results.clone();
        for (impact, own) in results.impacts.iter_mut().zip(&own.impacts) {
            own.force_window_s
                .filter(|window| *window > 0.0)
                .into_iter()
                .for_each(|w| impact.average_over(w));
        }
        // A number that this run has not gives no error.
        let value = |listed: Option<Listed>| listed.map_or(f64::NAN, |listed| listed.quantity.value);
        results.list_mut().into_iter().map(value).collect()
    }
}

/// A run on a coarser mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Element size relative to that of the run itself [-]; the minimum if it varies.
    pub size: f64,
    /// Results on this mesh.
    pub run: Cheaper,
}

/// The cheaper runs that error bars are estimated from.
#[derive(Clone, Debug, PartialEq)]
pub struct CheaperRuns {
    /// Runs on coarser meshes, the coarsest first; at least one.
    pub levels: Vec<Level>,
    /// Run on the coarsest mesh with half the time step.
    pub small_steps: Cheaper,
    /// Run on the coarsest mesh with a looser contact tolerance.
    pub loose_contact: Cheaper,
}

/// Values of one number in the cheaper runs.
struct Values<'a> {
    /// Values in the runs of [`CheaperRuns::levels`].
    levels: &'a [f64],
    small_steps: f64,
    loose_contact: f64,
}

/// Error contributions to one number, from the cheaper runs.
struct Differences {
    mesh: f64,
    step: f64,
    contact: f64,
}

impl CheaperRuns {
    /// All cheaper runs, in the order of their fields.
    fn all(&self) -> impl Iterator<Item = &Cheaper> {
        self.levels.iter().map(|level| &level.run).chain([&self.small_steps, &self.loose_contact])
    }

    /// Error of the largest von Mises stress below a depth [Pa]: `own` is that of the requested depth with this index,
    /// in a run of `own_steps` steps. `None` if it is unknown.
    pub fn error_below(&self, index: usize, own: f64, own_steps: u64) -> Option<f64> {
        self.all().all(|run| run.von_mises_below_pa.len() > index).then_some(())?;
        let of = |run: &Cheaper| run.von_mises_below_pa[index];
        let levels: Vec<f64> = self.levels.iter().map(|level| of(&level.run)).collect();
        let values = Values {
            levels: &levels,
            small_steps: of(&self.small_steps),
            loose_contact: of(&self.loose_contact),
        };
        let found = self.differences(own, own_steps, &values)?;
        let total = found.mesh + found.step + found.contact;
        total.is_finite().then_some(total)
    }

    /// Differences of the cheaper runs from a number of a run with that many steps; `None` without any.
    fn differences(&self, own: f64, own_steps: u64, values: &Values) -> Option<Differences> {
        let (coarsest, value) = (self.levels.first()?, *values.levels.first()?);
        let steps = (coarsest.run.steps, self.small_steps.steps);
        Some(Differences {
            mesh: self.mesh_error(own, values.levels),
            step: assumed_step_error(own_steps, steps, (value, values.small_steps)),
            // The tolerance is loosened far more than twofold: the difference itself bounds the error.
            contact: (values.loose_contact - value).abs(),
        })
    }

    /// Mesh error by the rule for the number of meshes.
    fn mesh_error(&self, own: f64, values: &[f64]) -> f64 {
        if let ([level], [value]) = (&self.levels[..], values) {
            return assumed_error(*value, own, level.size);
        }
        let mut levels: Vec<_> =
            self.levels.iter().map(|level| level.size).zip(values.iter().copied()).collect();
        levels.push((1.0, own));
        fitted_uncertainty(&levels)
    }
}

impl Results {
    /// If nothing touched, marks every number that would describe the impact as without an error.
    pub(super) fn mark_misses(&mut self) {
        let nothing_touched = self.nothing_touched;
        let missed = |impact: &&mut Impact| impact.contact_span_s.is_none();
        for impact in self.impacts.iter_mut().filter(missed) {
            impact.quantities_mut().into_iter().for_each(|q| q.error = ErrorEstimate::NothingTouched);
        }
        if nothing_touched {
            self.list_mut()
                .into_iter()
                .flatten()
                .for_each(|listed| listed.quantity.error = ErrorEstimate::NothingTouched);
        }
    }

    /// Sets the error bars of all numbers of a run with that many steps [s]; numbers that a cheaper run lacks keep
    /// theirs.
    pub(super) fn estimate_errors(&mut self, runs: &CheaperRuns, own_steps: u64, time_s: f64) {
        // The cheaper runs must have the same list of numbers.
        let own_step = time_s / own_steps as f64;
        let levels: Vec<Vec<f64>> = runs.levels.iter().map(|level| level.run.numbers(self)).collect();
        let [small_steps, loose_contact] =
            [&runs.small_steps, &runs.loose_contact].map(|run| run.numbers(self));
        let mut all_listed = self.list_mut();
        let count = all_listed.len();
        if levels.iter().chain([&small_steps, &loose_contact]).any(|run| run.len() != count) {
            return;
        }
        for (i, listed) in all_listed.iter_mut().enumerate() {
            let Some(Listed { quantity, steps_known, spacing, missing, is_peak }) = listed else { continue };
            // Contributions of mesh, step and contact tolerance, plus the resolution.
            let of_levels: Vec<f64> = levels.iter().map(|run| run[i]).collect();
            let values =
                Values { levels: &of_levels, small_steps: small_steps[i], loose_contact: loose_contact[i] };
            let Some(Differences { mesh, step, contact }) =
                runs.differences(quantity.value, own_steps, &values)
            else {
                continue;
            };
            let mesh = mesh.max(*missing);
            let resolution = f64::from(*steps_known) * own_step + *spacing + ROUNDING * quantity.value.abs();
            let total = mesh + step + contact + resolution;
            if total.is_finite() {
                // A pointwise peak may grow with every mesh: two meshes cannot show convergence.
                let may_converge = !*is_peak || runs.levels.len() > 1;
                let resolved = total == 0.0 || may_converge && total < quantity.value.abs();
                let estimate = Estimate { total, mesh, step, contact, resolution, resolved };
                quantity.error = ErrorEstimate::Estimated(estimate);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::summary::{GateResult, Headline, Quantity};

    fn results(value: f64) -> Results {
        let quantity = || Quantity { value, error: ErrorEstimate::NotEstimated, gate: GateResult::Passed };
        let impact = Impact {
            pair: "a–b".into(),
            between: ["a".into(), "b".into()],
            on_tissue: true,
            peak_force_n: quantity(),
            peak_force_time_s: quantity(),
            force_average: "mean over 5 µs".into(),
            force_window_s: Some(5e-6),
            force_filter: None,
            history: None,
            peak_force_placing_n: 0.0,
            peak_step_force_n: quantity(),
            impulse_n_s: quantity(),
            impulse_on: "b".into(),
            impulse_vector_n_s: [0.0; 3],
            contact_duration_s: quantity(),
            contact_span_s: Some([0.0, 1.0]),
            contact_ended: true,
            touches_in_points: false,
            patch_area_mm2: quantity(),
            patch_long_axis_mm: quantity(),
            patch_short_axis_mm: quantity(),
            largest_patch_area_mm2: quantity(),
            nodes_across_patch: [5, 5],
            friction_dissipation_j: quantity(),
            numerical_contact_dissipation_j: quantity(),
        };
        Results { nothing_touched: false, impacts: vec![impact], tissue: None, headline: Headline::default() }
    }

    fn cheaper(value: f64, steps: u64) -> Cheaper {
        Cheaper::new(&results(value), vec![value], steps)
    }

    fn estimate(quantity: &Quantity) -> Estimate {
        let ErrorEstimate::Estimated(error) = quantity.error else { panic!("{quantity:?}") };
        error
    }

    fn runs(values: [f64; 3]) -> CheaperRuns {
        let [coarse, small_steps, loose] = values;
        CheaperRuns {
            levels: vec![Level { size: 2.0, run: cheaper(coarse, 100) }],
            small_steps: cheaper(small_steps, 200),
            loose_contact: cheaper(loose, 100),
        }
    }

    #[test]
    fn errors_come_from_the_differences() {
        let mut own = results(10.0);
        own.estimate_errors(&runs([9.0, 9.1, 8.99]), 200, 1.0);
        let error = estimate(&own.impacts[0].peak_force_n);
        assert!((error.mesh - 3.0).abs() < 1e-12 && (error.step - 0.3).abs() < 1e-12, "{error:?}");
        assert!((error.contact - 0.01).abs() < 1e-12 && (error.total - 3.31).abs() < 1e-9, "{error:?}");
        assert!(error.resolved);
        // A duration is resolved to its first and its last step.
        let duration = estimate(&own.impacts[0].contact_duration_s);
        assert!((duration.resolution - 2.0 / 200.0).abs() < 1e-9, "{duration:?}");
        // A quantity that does not converge has no error bar.
        assert_eq!(own.impacts[0].peak_step_force_n.error, ErrorEstimate::NotEstimated);
    }

    #[test]
    fn steps_as_long_as_on_the_coarser_mesh_have_twice_the_error() {
        let mut own = results(10.0);
        own.estimate_errors(&runs([10.0, 10.1, 10.0]), 100, 1.0);
        let error = estimate(&own.impacts[0].peak_force_n);
        assert!((error.step - 0.6).abs() < 1e-9, "{error:?}");
    }

    #[test]
    fn three_meshes_are_fitted_and_their_scatter_widens_the_bar() {
        // 10 + h at h = 4, 2, 1.
        let mut all = runs([14.0, 14.0, 14.0]);
        all.levels =
            vec![Level { size: 4.0, run: cheaper(14.0, 100) }, Level { size: 2.0, run: cheaper(12.0, 100) }];
        let mut own = results(11.0);
        own.estimate_errors(&all, 200, 1.0);
        let smooth = estimate(&own.impacts[0].impulse_n_s);
        assert!((smooth.mesh - 1.25).abs() < 1e-12, "{smooth:?}");
        // Non-monotonic values.
        own = results(13.0);
        own.estimate_errors(&all, 200, 1.0);
        assert!(estimate(&own.impacts[0].impulse_n_s).mesh > 2.0 * smooth.mesh);
    }

    #[test]
    fn stresses_below_a_depth_have_errors_where_all_runs_have_them() {
        let mut runs = runs([9.0, 9.1, 8.99]);
        let error = runs.error_below(0, 10.0, 200).unwrap();
        assert!((error - 3.31).abs() < 1e-12, "{error}");
        assert_eq!(runs.error_below(1, 10.0, 200), None);
        runs.loose_contact.von_mises_below_pa.clear();
        assert_eq!(runs.error_below(0, 10.0, 200), None);
    }

    #[test]
    fn nothing_at_all_is_resolved() {
        let mut own = results(0.0);
        own.impacts[0].contact_span_s = None;
        own.estimate_errors(&runs([0.0; 3]), 200, 1.0);
        let [force, duration] =
            [&own.impacts[0].peak_force_n, &own.impacts[0].contact_duration_s].map(estimate);
        assert!(force.resolved && force.total == 0.0, "{force:?}");
        assert!(
            duration.resolved && duration.total == 0.0,
            "what never touched has no first step: {duration:?}"
        );
    }

    #[test]
    fn a_number_below_its_error_is_not_resolved() {
        let mut own = results(1.0);
        own.estimate_errors(&runs([2.0; 3]), 200, 1.0);
        assert!(!estimate(&own.impacts[0].impulse_n_s).resolved);
    }
}
