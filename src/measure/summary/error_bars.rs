//! Error bars: numerical errors of the results, estimated from other runs of the same scene.
//!
//! One or more runs use other meshes: coarser ones, or a finer one where the mesh cannot be coarsened. On the coarsest of
//! all meshes one run halves the time step, and one loosens the contact tolerance. The meshes compared with the run itself
//! give the mesh error, the other two compared with a run on the same mesh give the errors of step and solver. First order
//! is assumed: with two meshes a factor of safety is applied; with more, a curve is fitted, whose scatter widens the bar.

use super::super::convergence::{PRE_ASYMPTOTIC, assumed_error, assumed_step_error, fitted_uncertainty};
use super::listed::{Listed, NODES_ACROSS};
use super::of_interest::QuantityOfInterest;
use super::quantity::{ErrorEstimate, Estimate};
use super::results::{Impact, Results};
use crate::scene::document::RequestedNumber;

/// Relative rounding error of sums of many numbers [-].
const ROUNDING: f64 = 1e-12;

/// Least mesh error of a number relative to it, in units of the median of all numbers [-]: where most numbers change by much from mesh
/// to mesh, one that hardly does so may agree by chance.
const LEAST_FRACTION: f64 = 0.05;

/// Source of the error bars.
#[derive(Clone, Debug, Default)]
pub enum ErrorBars {
    /// Error bars were not requested.
    #[default]
    NotRequested,
    /// No error bars, with the reason.
    Unknown(String),
    /// Other runs of the same scene.
    From(Box<ComparedRuns>),
}

impl std::fmt::Display for ErrorBars {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotRequested => f.write_str("not estimated: error bars were not requested"),
            Self::Unknown(why) => write!(f, "not estimated: {why}"),
            Self::From(runs) => f.write_str(&runs.in_words()),
        }
    }
}

/// Results of a run that the run itself is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// Summary numbers of the run.
    results: Results,
    /// Largest von Mises stress below each of the requested depths [Pa], see [`ComparedRuns::error_below`].
    von_mises_below_pa: Vec<f64>,
    /// Number of its steps.
    pub steps: u64,
}

impl Compared {
    /// From the results of a run, and the stresses below the requested depths.
    pub fn new(results: &Results, von_mises_below_pa: Vec<f64>, steps: u64) -> Self {
        Self { results: results.clone(), von_mises_below_pa, steps }
    }

    /// Relative difference of a number from that of another run [-]; `None` where one of them has none.
    pub fn change(&self, from: &Self, number: RequestedNumber) -> Option<f64> {
        let results = self.over_windows_of(&from.results);
        let [value, from] = [&results, &from.results].map(|r| QuantityOfInterest::from(number).of(r));
        Some((value? / from? - 1.0).abs()).filter(|change| change.is_finite())
    }

    /// Whether the run has a number.
    pub fn has(&self, number: RequestedNumber) -> bool {
        QuantityOfInterest::from(number).of(&self.results).is_some()
    }

    /// The results, with forces over the windows of the `own` ones.
    fn over_windows_of(&self, own: &Results) -> Results {
        let mut results = self.results.clone();
        for (impact, own) in results.impacts.iter_mut().zip(&own.impacts) {
            own.force_window_s
                .filter(|window| *window > 0.0)
                .into_iter()
                .for_each(|w| impact.average_over(w));
        }
        results
    }

    /// The numbers in listing order, with forces over the windows of the `own` results.
    fn numbers(&self, own: &Results) -> Vec<f64> {
        let mut results = self.over_windows_of(own);
        // A number that this run lacks gives no error.
        let value = |listed: Option<Listed>| listed.map_or(f64::NAN, |listed| listed.quantity.value);
        results.list_mut().into_iter().map(value).collect()
    }
}

/// A run on another mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Element size relative to that of the run itself [-], not 1; the one closest to it if it varies.
    pub size: f64,
    /// Results on this mesh.
    pub run: Compared,
}

/// The runs that error bars are estimated from.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedRuns {
    /// Runs on other meshes, the coarsest first; at least one.
    pub levels: Vec<Level>,
    /// Whether the finer of all meshes are the coarser ones split on their facets, so that their surfaces are the same.
    pub on_facets: bool,
    /// Whether a direction has the same number of elements in all meshes, so that they do not show its error.
    pub keeps_a_direction: bool,
    /// Run on the coarsest of all meshes, which the next two are compared with.
    pub base: Compared,
    /// Run on that mesh with half the time step.
    pub small_steps: Compared,
    /// Run on that mesh with a looser contact tolerance.
    pub loose_contact: Compared,
    /// What the bulk moduli change; `None` where that was not looked at.
    pub bulk_modulus: Option<BulkModulusChange>,
}

/// What the bulk moduli of a run change.
#[derive(Clone, Debug, PartialEq)]
pub struct BulkModulusChange {
    /// Runs on one mesh with the bulk moduli that are compared with, and with those of the run itself, if their difference is a part of the
    /// error bars.
    pub in_bars: Option<[Compared; 2]>,
    /// Finding as a part of a sentence.
    pub words: String,
}

/// Values of one number in the compared runs.
struct Values<'a> {
    /// Values in the runs of [`ComparedRuns::levels`].
    levels: &'a [f64],
    base: f64,
    small_steps: f64,
    loose_contact: f64,
}

/// Error contributions to one number, from the compared runs.
struct Differences {
    mesh: f64,
    step: f64,
    contact: f64,
    bulk_modulus: f64,
}

impl ComparedRuns {
    /// Where the error bars come from, and what is not in them.
    fn in_words(&self) -> String {
        let sizes: Vec<String> = self.levels.iter().map(|level| format!("{:.2}", level.size)).collect();
        let sizes = sizes.join(", ");
        let runs = if self.levels.iter().all(|level| level.size < 1.0) {
            format!("a run with every element split into eight (element size × {sizes})")
        } else {
            format!("runs on coarser meshes (element size × {sizes})")
        };
        let rule = match self.levels.len() {
            1 => "first order assumed, factor of safety 3",
            _ => {
                "a fit of order 1, ¾ or ½ to all meshes, factor of safety 1.25 (3 with fewer than five nodes across the contact), widened by its scatter; of the steps first order, factor of safety 3"
            }
        };
        let facets = if self.on_facets {
            "; splitting keeps the facets of a mesh, so their distance from a curved surface is not in the error bars"
        } else {
            ""
        };
        let directions = if self.keeps_a_direction {
            "; directions with equally many elements in all of these meshes are not in the error bars"
        } else {
            ""
        };
        let bulk = self.bulk_modulus.as_ref().map_or(String::new(), |change| format!("; {}", change.words));
        format!("estimated from {runs}: {rule}{facets}{directions}{bulk}")
    }

    /// All runs, in the order of their fields.
    fn all(&self) -> impl Iterator<Item = &Compared> {
        let others = [&self.base, &self.small_steps, &self.loose_contact];
        self.levels.iter().map(|level| &level.run).chain(others)
    }

    /// Error of the largest von Mises stress below a depth [Pa]: `own` is that of the requested depth with this index,
    /// in a run of `own_steps` steps. `None` if it is unknown.
    pub fn error_below(&self, index: usize, own: f64, own_steps: u64) -> Option<f64> {
        self.all().all(|run| run.von_mises_below_pa.len() > index).then_some(())?;
        let of = |run: &Compared| run.von_mises_below_pa[index];
        let levels: Vec<f64> = self.levels.iter().map(|level| of(&level.run)).collect();
        let [base, small_steps, loose_contact] = [&self.base, &self.small_steps, &self.loose_contact].map(of);
        let found =
            self.differences(own, own_steps, &Values { levels: &levels, base, small_steps, loose_contact });
        let total = found.mesh + found.step + found.contact;
        total.is_finite().then_some(total)
    }

    /// Differences of the compared runs from a number of a run with that many steps.
    fn differences(&self, own: f64, own_steps: u64, values: &Values) -> Differences {
        let steps = (self.base.steps, self.small_steps.steps);
        Differences {
            mesh: self.mesh_error(own, values.levels),
            step: assumed_step_error(own_steps, steps, (values.base, values.small_steps)),
            // The tolerance is loosened far more than twofold: the difference itself bounds the error.
            contact: (values.loose_contact - values.base).abs(),
            bulk_modulus: 0.0,
        }
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
        self.impacts.iter_mut().filter(missed).for_each(Impact::mark_miss);
        if nothing_touched {
            self.list_mut()
                .into_iter()
                .flatten()
                .for_each(|listed| listed.quantity.error = ErrorEstimate::NothingTouched);
        }
    }

    /// Sets the error bars of all numbers of a run with that many steps [s]; numbers that a compared run lacks keep
    /// theirs.
    pub(super) fn estimate_errors(&mut self, runs: &ComparedRuns, own_steps: u64, time_s: f64) {
        // The compared runs must have the same list of numbers.
        let own_step = time_s / own_steps as f64;
        let levels: Vec<Vec<f64>> = runs.levels.iter().map(|level| level.run.numbers(self)).collect();
        let [base, small_steps, loose_contact] =
            [&runs.base, &runs.small_steps, &runs.loose_contact].map(|run| run.numbers(self));
        let bulk = runs.bulk_modulus.as_ref().and_then(|change| change.in_bars.as_ref());
        let bulk = bulk.map(|both| both.each_ref().map(|run| run.numbers(self)));
        let is_contact_coarse = self.impacts.iter().any(Impact::is_coarse);
        let all_listed = self.list_mut();
        let count = all_listed.len();
        let of_bulk = bulk.iter().flatten();
        if levels
            .iter()
            .chain([&base, &small_steps, &loose_contact])
            .chain(of_bulk)
            .any(|run| run.len() != count)
        {
            return;
        }
        // Contributions of mesh, step and contact tolerance to each.
        let mut all_found = Vec::new();
        for (i, listed) in all_listed.into_iter().enumerate() {
            let Some(listed) = listed else { continue };
            let of_levels: Vec<f64> = levels.iter().map(|run| run[i]).collect();
            let values = Values {
                levels: &of_levels,
                base: base[i],
                small_steps: small_steps[i],
                loose_contact: loose_contact[i],
            };
            let differences = runs.differences(listed.quantity.value, own_steps, &values);
            let bulk_modulus = bulk.as_ref().map_or(0.0, |[reference, own]| (own[i] - reference[i]).abs());
            all_found.push((listed, Differences { bulk_modulus, ..differences }));
        }
        let least = LEAST_FRACTION * median_mesh_error(&all_found);
        let caution = if runs.levels.len() > 1 && is_contact_coarse { PRE_ASYMPTOTIC } else { 1.0 };
        for (Listed { quantity, steps_known, spacing, least_mesh_error, is_peak, is_too_coarse }, found) in
            all_found
        {
            let Differences { mesh, step, contact, bulk_modulus } = found;
            let mesh = (caution * mesh).max(least_mesh_error).max(least * quantity.value.abs());
            // The total, with the resolution.
            let resolution = f64::from(steps_known) * own_step + spacing + ROUNDING * quantity.value.abs();
            let total = mesh + step + contact + bulk_modulus + resolution;
            if total.is_finite() {
                // A pointwise peak may grow with every mesh: two meshes cannot show convergence, nor can those that keep a direction.
                let may_converge = !is_peak || (runs.levels.len() > 1 && !runs.keeps_a_direction);
                let resolved = total == 0.0 || may_converge && !is_too_coarse && total < quantity.value.abs();
                let estimate = Estimate { total, mesh, step, contact, bulk_modulus, resolution, resolved };
                quantity.error = ErrorEstimate::Estimated(estimate);
            }
        }
    }
}

impl Impact {
    /// Whether the tissue is touched, and fewer nodes lie across the largest patch than resolve it.
    fn is_coarse(&self) -> bool {
        self.on_tissue && self.has_patch() && self.nodes_across_patch[1] < NODES_ACROSS
    }
}

/// Median of the mesh errors of all numbers but peaks and zeros, relative to the number [-]; zero without any.
fn median_mesh_error(found: &[(Listed, Differences)]) -> f64 {
    let is_sum = |(listed, _): &&(Listed, Differences)| !listed.is_peak && listed.quantity.value != 0.0;
    let relative = found.iter().filter(is_sum);
    let relative = relative.map(|(listed, found)| found.mesh / listed.quantity.value.abs());
    let mut relative: Vec<f64> = relative.filter(|error| error.is_finite()).collect();
    relative.sort_by(f64::total_cmp);
    relative.get(relative.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::summary::{GateResult, Headline, Quantity};

    fn results(value: f64) -> Results {
        let quantity = || Quantity::new(value, GateResult::Passed);
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
            largest_patch_time_s: None,
            nodes_across_patch: [5, 5],
            friction_dissipation_j: quantity(),
            numerical_contact_dissipation_j: quantity(),
        };
        Results { nothing_touched: false, impacts: vec![impact], tissue: None, headline: Headline::default() }
    }

    fn compared(value: f64, steps: u64) -> Compared {
        Compared::new(&results(value), vec![value], steps)
    }

    fn estimate(quantity: &Quantity) -> Estimate {
        let ErrorEstimate::Estimated(error) = quantity.error else { panic!("{quantity:?}") };
        error
    }

    fn runs(values: [f64; 3]) -> ComparedRuns {
        let [coarse, small_steps, loose] = values;
        ComparedRuns {
            levels: vec![Level { size: 2.0, run: compared(coarse, 100) }],
            on_facets: false,
            keeps_a_direction: false,
            base: compared(coarse, 100),
            small_steps: compared(small_steps, 200),
            loose_contact: compared(loose, 100),
            bulk_modulus: None,
        }
    }

    #[test]
    fn other_bulk_moduli_are_named_and_widen_the_bar_by_their_difference_where_they_are_in_it() {
        let mut runs = runs([9.0, 9.1, 8.99]);
        let with_headline = |value: f64, steps: u64| {
            let headline = Headline { impact: Some(0), ..Headline::default() };
            Compared::new(&Results { headline, ..results(value) }, vec![value], steps)
        };
        let [reference, lowered] = [with_headline(9.0, 200), with_headline(8.8, 100)];
        let change = lowered.change(&reference, RequestedNumber::Impulse).unwrap();
        assert!((change - 0.2 / 9.0).abs() < 1e-12, "{change}");
        assert_eq!(lowered.change(&reference, RequestedNumber::Deflection), None);
        let in_bars = Some([reference, lowered]);
        let lowered = BulkModulusChange { in_bars, words: "bulk moduli × 0.25".into() };
        let outside = BulkModulusChange { in_bars: None, ..lowered.clone() };
        let mut without = results(10.0);
        without.estimate_errors(&ComparedRuns { bulk_modulus: Some(outside), ..runs.clone() }, 200, 1.0);
        let error = estimate(&without.impacts[0].impulse_n_s);
        assert!(error.bulk_modulus == 0.0 && (error.total - 3.31).abs() < 1e-9, "{error:?}");
        runs.bulk_modulus = Some(lowered);
        let mut own = results(10.0);
        own.estimate_errors(&runs, 200, 1.0);
        let error = estimate(&own.impacts[0].impulse_n_s);
        assert!((error.bulk_modulus - 0.2).abs() < 1e-12 && (error.total - 3.51).abs() < 1e-9, "{error:?}");
        assert!(ErrorBars::From(Box::new(runs)).to_string().ends_with("; bulk moduli × 0.25"));
    }

    #[test]
    fn meshes_that_keep_a_direction_say_so() {
        let of = |keeps_a_direction| ComparedRuns { keeps_a_direction, ..runs([9.0, 9.1, 8.99]) };
        let says = |runs: ComparedRuns| {
            ErrorBars::From(Box::new(runs)).to_string().contains("equally many elements")
        };
        assert!(says(of(true)) && !says(of(false)));
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
    fn a_finer_mesh_gives_the_error_of_the_given_one_and_the_facets_are_named() {
        // 10 + h at h = 1 and ½: the error of the run itself is twice that of the finer one.
        let mut runs = runs([11.0, 11.1, 10.99]);
        (runs.levels, runs.on_facets) = (vec![Level { size: 0.5, run: compared(10.5, 200) }], true);
        let mut own = results(11.0);
        own.estimate_errors(&runs, 100, 1.0);
        let error = estimate(&own.impacts[0].peak_force_n);
        assert!((error.mesh - 3.0).abs() < 1e-12 && (error.step - 0.6).abs() < 1e-9, "{error:?}");
        let words = ErrorBars::From(Box::new(runs)).to_string();
        assert!(
            words.contains("element size × 0.50") && words.contains("curved surface is not in"),
            "{words}"
        );
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
        all.levels = vec![
            Level { size: 4.0, run: compared(14.0, 100) },
            Level { size: 2.0, run: compared(12.0, 100) },
        ];
        let mut own = results(11.0);
        own.estimate_errors(&all, 200, 1.0);
        let smooth = estimate(&own.impacts[0].impulse_n_s);
        assert!((smooth.mesh - 1.25).abs() < 1e-12, "{smooth:?}");
        // With few nodes across the contact it is not known that they converge.
        let mut coarse = results(11.0);
        coarse.impacts[0].nodes_across_patch = [4, 4];
        coarse.estimate_errors(&all, 200, 1.0);
        let coarse = estimate(&coarse.impacts[0].impulse_n_s);
        assert!((coarse.mesh - 3.0).abs() < 1e-12, "{coarse:?}");
        // Non-monotonic values.
        own = results(13.0);
        own.estimate_errors(&all, 200, 1.0);
        assert!(estimate(&own.impacts[0].impulse_n_s).mesh > 2.0 * smooth.mesh);
    }

    #[test]
    fn a_number_that_agrees_by_chance_has_a_fraction_of_the_error_of_the_others() {
        let mut runs = runs([9.0; 3]);
        runs.levels[0].run.results.impacts[0].impulse_n_s.value = 10.0;
        let mut own = results(10.0);
        own.estimate_errors(&runs, 100, 1.0);
        let [force, impulse] = [&own.impacts[0].peak_force_n, &own.impacts[0].impulse_n_s].map(estimate);
        assert!((force.mesh - 3.0).abs() < 1e-12, "{force:?}");
        assert!((impulse.mesh - LEAST_FRACTION * 3.0).abs() < 1e-12, "{impulse:?}");
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
