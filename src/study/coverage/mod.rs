//! Coverage of the error bars: scenes with exact solutions, over meshes, speeds, steps and integrators.

mod cases;

pub use cases::{Case, cases};

use super::run::run_scene;
use super::single::{RunRequest, ending_name};
use crate::scene::{Budget, NoFiles, load_parsed};
use crate::step::{Ending, Interrupt};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;

/// A result of a run with a known exact value.
#[derive(Clone, Debug, Serialize)]
pub struct Number {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// Varied parameters of the run.
    pub run: String,
    /// Name of the number in the summary.
    pub quantity: &'static str,
    /// Exact value of the number.
    pub exact: f64,
    /// Value computed by the run.
    pub value: f64,
    /// Half-width of the error bar.
    pub error_bar: f64,
}

impl Number {
    /// Whether the exact value lies within the error bar.
    pub fn is_covered(&self) -> bool {
        self.error() <= self.error_bar
    }
    /// Deviation from the exact value.
    pub fn error(&self) -> f64 {
        (self.value - self.exact).abs()
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
    pub fn share(&self, which: impl Fn(&Number) -> bool) -> (f64, usize) {
        let picked = self.numbers.iter().filter(|number| which(number));
        let (all, covered) = (picked.clone().count(), picked.filter(|number| number.is_covered()).count());
        (covered as f64 / all.max(1) as f64, all)
    }
}

/// Runs every case with its error bars, in parallel on all threads.
pub fn study_coverage(cases: &[Case], interrupt: &(dyn Fn() -> Option<Interrupt> + Sync)) -> CoverageStudy {
    let runs: Vec<Result<Vec<Result<Number, NoClaim>>, NoClaim>> =
        cases.par_iter().map(|case| eval_case(case, interrupt)).collect();
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
    // Run the case with its error bars.
    let result = run_scene(RunRequest {
        scene: &loaded.scene,
        sinks: Vec::new(),
        also: None,
        threads: 1,
        interrupt,
        progress: &mut |_| {},
    });
    let result = result.map_err(|error| no_claim(error.to_string()))?;
    if result.outcome.ending != Ending::Finished {
        return Err(no_claim(format!("ended as {}", ending_name(&result.outcome.ending))));
    }
    let values =
        serde_json::to_value(result.summary.values()).map_err(|error| no_claim(error.to_string()))?;
    // Compare each exact value with the number and its error bar.
    let number = |(pointer, exact): &(&'static str, f64)| {
        let quantity = pointer.rsplit('/').next().unwrap_or_default();
        let found = values.pointer(pointer);
        let part = |name: &str| found.and_then(|q| q.pointer(name)).and_then(Value::as_f64);
        let (Some(value), Some(error_bar)) = (part("/value"), part("/error/total")) else {
            let why = &result.summary.error_bars;
            return Err(no_claim(format!("{quantity} has no error bar: {why}")));
        };
        let (scenario, run) = (case.scenario, case.label.clone());
        Ok(Number { scenario, run, quantity, exact: *exact, value, error_bar })
    };
    Ok(case.exact.iter().map(number).collect())
}
