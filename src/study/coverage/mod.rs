//! Whether error bars contain the truth: scenes whose answers are known exactly, over meshes, speeds, steps and integrators.

mod cases;

pub use cases::{Case, cases};

use super::run::run_scene;
use super::single::{RunRequest, ending_name};
use crate::scene::{Budget, NoFiles, load_parsed};
use crate::step::{Ending, Interrupt};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;

/// A number of a run whose exact value is known.
#[derive(Clone, Debug, Serialize)]
pub struct Number {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// What is varied in it.
    pub run: String,
    /// Name of the number in the summary.
    pub quantity: &'static str,
    /// Its exact value.
    pub exact: f64,
    /// What the run says.
    pub value: f64,
    /// Its error bar, to either side.
    pub error_bar: f64,
}

impl Number {
    /// Whether the exact value is within the error bar.
    pub fn is_covered(&self) -> bool {
        self.error() <= self.error_bar
    }
    /// How far off it is.
    pub fn error(&self) -> f64 {
        (self.value - self.exact).abs()
    }
}

/// A run or a number that makes no claim.
#[derive(Clone, Debug, Serialize)]
pub struct NoClaim {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// What is varied in it.
    pub run: String,
    /// Why.
    pub reason: String,
}

/// What came out.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CoverageStudy {
    /// Runs that finished.
    pub runs: usize,
    /// Their numbers, in the order of the cases.
    pub numbers: Vec<Number>,
    /// What has no number or no error bar.
    pub without: Vec<NoClaim>,
}

impl CoverageStudy {
    /// Share of the numbers that `which` picks whose exact value is within the error bar [-], and how many they are.
    pub fn share(&self, which: impl Fn(&Number) -> bool) -> (f64, usize) {
        let picked = self.numbers.iter().filter(|number| which(number));
        let (all, covered) = (picked.clone().count(), picked.filter(|number| number.is_covered()).count());
        (covered as f64 / all.max(1) as f64, all)
    }
}

/// Runs every case with its error bars, as many at once as there are threads.
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
