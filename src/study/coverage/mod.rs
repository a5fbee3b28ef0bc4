//! Coverage of the error bars: scenes with exact solutions, over meshes, speeds, steps and integrators; and impacts on
//! tissue, against much finer meshes.

mod cases;
mod converged;
mod impacts;
mod numbers;

pub use cases::{Case, cases};
pub use converged::study_impacts;
pub use impacts::{Impact, impacts};

use super::run::run_scene;
use super::single::{RunRequest, ending_name};
use crate::measure::Summary;
use crate::scene::{Budget, NoFiles, Scene, load_parsed};
use crate::step::{Ending, Interrupt};
use numbers::WithBar;
use rayon::prelude::*;
use serde::Serialize;

/// A result of a run whose exact value, or that of a much finer mesh, is known.
#[derive(Clone, Debug, Serialize)]
pub struct Number {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// Varied parameters of the run.
    pub run: String,
    /// Kind of its error bars: `two levels`, `three levels`, or those of the meshes of an `accuracy`.
    pub bars: &'static str,
    /// Whether constants of the error bars were chosen on this scenario.
    pub chosen_on: bool,
    /// Name of the number in the summary.
    pub quantity: String,
    /// Exact value of the number, or that on a much finer mesh.
    pub exact: f64,
    /// Value computed by the run.
    pub value: f64,
    /// Error: the deviation from the exact value; from that of a finer mesh, divided by the fraction of the error that it is at
    /// first order.
    pub error: f64,
    /// Half-width of the error bar.
    pub error_bar: f64,
    /// Whether the summary prints it as a plain number.
    pub resolved: bool,
}

impl Number {
    /// Whether the exact value lies within the error bar.
    pub fn is_covered(&self) -> bool {
        self.error <= self.error_bar
    }
}

/// A run or a number without an error bar.
#[derive(Clone, Debug, Serialize)]
pub struct NoClaim {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// Varied parameters of the run.
    pub run: String,
    /// Why there is no error bar.
    pub reason: String,
}

/// Results of the coverage study.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CoverageStudy {
    /// Number of finished runs.
    pub runs: usize,
    /// Their numbers, in the order of the cases.
    pub numbers: Vec<Number>,
    /// Runs and numbers without a value or an error bar.
    pub without: Vec<NoClaim>,
}

impl CoverageStudy {
    /// Fraction of the numbers selected by `which` whose exact value is within the error bar [-], and their count.
    pub fn fraction(&self, which: impl Fn(&Number) -> bool) -> (f64, usize) {
        let picked = self.numbers.iter().filter(|number| which(number));
        let (all, covered) = (picked.clone().count(), picked.filter(|number| number.is_covered()).count());
        (covered as f64 / all.max(1) as f64, all)
    }
}

/// Runs all items in parallel, on threads of their own: each waits for the thread of its recorder, whose measures use those that all share.
fn each<T: Sync, R: Send>(items: &[T], run: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    match rayon::ThreadPoolBuilder::new().build() {
        Ok(pool) => pool.install(|| items.par_iter().with_max_len(1).map(&run).collect()),
        Err(_) => items.iter().map(run).collect(),
    }
}

/// Runs every case with its error bars, in parallel on all threads.
pub fn study_coverage(cases: &[Case], interrupt: &(dyn Fn() -> Option<Interrupt> + Sync)) -> CoverageStudy {
    let runs: Vec<Result<Vec<Result<Number, NoClaim>>, NoClaim>> =
        each(cases, |case| eval_case(case, interrupt));
    let mut study = CoverageStudy::default();
    for run in runs {
        match run {
            Err(reason) => study.without.push(reason),
            Ok(numbers) => {
                study.runs += 1;
                for number in numbers {
                    match number {
                        Ok(number) => study.numbers.push(number),
                        Err(reason) => study.without.push(reason),
                    }
                }
            }
        }
    }
    study
}

fn eval_case(
    case: &Case,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> Result<Vec<Result<Number, NoClaim>>, NoClaim> {
    let no_claim = |reason: String| NoClaim { scenario: case.scenario, run: case.label.clone(), reason };
    let loaded = load_parsed(&case.document.clone().into(), &NoFiles, &Budget::COMMAND_LINE)
        .map_err(|problems| no_claim(problems.to_string()))?;
    let summary = run_finished(&loaded.scene, interrupt).map_err(&no_claim)?;
    let results = serde_json::to_value(summary.values()).map_err(|error| no_claim(error.to_string()))?;
    // Compare each exact value with the number and its error bar.
    let number = |(pointer, exact): &(&'static str, f64)| {
        let Some(found) = WithBar::at(&results, pointer) else {
            return Err(no_claim(format!("{pointer} has no error bar: {}", summary.error_bars)));
        };
        Ok(Number {
            scenario: case.scenario,
            run: case.label.clone(),
            bars: "two levels",
            chosen_on: false,
            quantity: found.quantity(),
            exact: *exact,
            value: found.value,
            error: (found.value - exact).abs(),
            error_bar: found.error_bar,
            resolved: found.resolved,
        })
    };
    Ok(case.exact.iter().map(number).collect())
}

/// Summary of a run that must finish, with the error bars that the scene asks for.
fn run_finished(
    scene: &Scene,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> Result<Summary, String> {
    let request =
        RunRequest { scene, sinks: Vec::new(), also: None, threads: 1, interrupt, progress: &mut |_| {} };
    let result = run_scene(request).map_err(|error| error.to_string())?;
    match &result.outcome.ending {
        Ending::Finished => Ok(result.summary),
        ending => Err(format!("ended as {}", ending_name(ending))),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    #[test]
    fn items_wait_for_threads_that_use_the_shared_ones() {
        let items: Vec<u64> = (0..64).collect();
        let sum = |below: &u64| (0..*below).into_par_iter().sum::<u64>();
        let sums = each(&items, |n| std::thread::scope(|scope| scope.spawn(|| sum(n)).join().unwrap()));
        assert!(items.iter().zip(&sums).all(|(n, sum)| 2 * sum == n * n.saturating_sub(1)));
    }
}
