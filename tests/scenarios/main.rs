//! Every scenario that ships runs, ends as its `expected.json` says, and gives the numbers there.
//!
//! `expected.json` has an entry for each scene document of its folder:
//!
//! ```json
//! {
//!   "scene.json": {
//!     "ending": "finished",
//!     "slow": false,
//!     "exact": {"impulse_n_s": 0.2},
//!     "reference": {"peak_force_n": {"value": 0.3, "uncertainty": 0.01}},
//!     "quantities": [
//!       {"quantity": {"impulse_n_s": {"at_s": 5e-5}}, "value": 0.0752, "relative_tolerance": 0.05, "source": "..."},
//!       {"quantity": "balance_error", "at_most": 0.01, "source": "..."}
//!     ]
//!   }
//! }
//! ```
//!
//! The words for quantities are those of [`Quantity`]. `ending` is `finished` or the cause of the failure. Slow scenes run
//! with `cargo test --release --test scenarios -- --ignored`.
#![allow(clippy::unwrap_used)] // a test may stop at the first surprise

mod quantity;
mod seen;

use contuse::plan::compile;
use contuse::scene::{Budget, load_file};
use contuse::step::{Ending, RunOptions, run};
use quantity::Quantity;
use seen::Seen;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, available_parallelism};
use std::time::Instant;

/// What is expected of one scene.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    ending: String,
    #[serde(default)]
    slow: bool,
    /// Exact values of the quantities that `contuse study error` asks for, by their names there.
    #[serde(default)]
    exact: BTreeMap<String, f64>,
    /// Values of another code, likewise.
    #[serde(default)]
    reference: BTreeMap<String, KnownValue>,
    quantities: Vec<Expectation>,
}

/// A value with its uncertainty.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownValue {
    value: f64,
    uncertainty: f64,
}

/// One number: near a value, or within a bound.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Expectation {
    quantity: Quantity,
    value: Option<f64>,
    relative_tolerance: Option<f64>,
    absolute_tolerance: Option<f64>,
    at_most: Option<f64>,
    at_least: Option<f64>,
    /// Where the number comes from, and why the tolerance is what it is.
    source: String,
}

impl Expectation {
    /// What is wrong with the number, if anything.
    fn check(&self, got: f64) -> Result<(), String> {
        let limits =
            match (self.value, self.relative_tolerance, self.absolute_tolerance, self.at_most, self.at_least)
            {
                (Some(value), Some(fraction), None, None, None) => {
                    (value - fraction * value.abs(), value + fraction * value.abs())
                }
                (Some(value), None, Some(room), None, None) => (value - room, value + room),
                (None, None, None, Some(most), None) => (f64::NEG_INFINITY, most),
                (None, None, None, None, Some(least)) => (least, f64::INFINITY),
                _ => return Err("give a value with one tolerance, or at_most, or at_least".into()),
            };
        if self.source.is_empty() {
            return Err("a number has a source".into());
        }
        if (limits.0..=limits.1).contains(&got) { Ok(()) } else { Err(format!("{got} is not in {limits:?}")) }
    }
}

/// Folders of the scenarios and of those for validation, in order.
fn folders() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let below = |folder: &Path| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let entries = below(&root).chain(below(&root.join("validation")));
    let mut folders: Vec<PathBuf> =
        entries.filter(|path| path.is_dir() && !path.ends_with("validation")).collect();
    folders.sort();
    folders
}

/// The expectations of a folder, by scene document; complete.
fn expectations(folder: &Path) -> BTreeMap<String, Expected> {
    let path = folder.join("expected.json");
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let expected: BTreeMap<String, Expected> =
        serde_json::from_slice(&bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let names =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut scenes: Vec<String> = names
        .filter(|name| Path::new(name).extension().is_some_and(|e| e == "json") && name != "expected.json")
        .collect();
    scenes.sort();
    for name in expected.values().flat_map(|scene| scene.exact.keys().chain(scene.reference.keys())) {
        assert!(
            contuse::measure::QuantityOfInterest::from_name(name).is_some(),
            "no quantity is called {name}"
        );
    }
    for known in expected.values().flat_map(|scene| scene.reference.values()) {
        assert!(known.uncertainty > 0.0 && known.uncertainty < 0.1 * known.value, "{known:?}");
    }
    assert!(expected.keys().eq(scenes.iter()), "{}: expected.json speaks of other scenes", folder.display());
    expected
}

/// Runs a scene; what is wrong with it.
fn check(folder: &Path, name: &str, expected: &Expected) -> Vec<String> {
    let path = folder.join(name);
    let here = |what: String| format!("{}: {what}", path.display());
    let loaded = match load_file(&path, &Budget::COMMAND_LINE) {
        Ok(loaded) => loaded,
        Err(problems) => return vec![here(format!("refused: {:#?}", problems.0))],
    };
    let plan = compile(&loaded.scene).unwrap();
    let mut seen = Seen::new(&loaded.scene, &plan, expected.quantities.iter().map(|e| &e.quantity));
    let clock = Instant::now();
    let (outcome, _) = run(&plan, &RunOptions { threads: 1, interrupt: &|| None }, &mut [&mut seen]);
    println!("{}: {} steps in {:.1?}", path.display(), outcome.steps, clock.elapsed());

    let mut wrong = Vec::new();
    let ending = match &outcome.ending {
        Ending::Finished => "finished".into(),
        Ending::Cancelled => "cancelled".into(),
        Ending::Failed { failure } => {
            serde_json::to_value(failure.cause).unwrap().as_str().unwrap().to_owned()
        }
    };
    if ending != expected.ending {
        wrong.push(here(format!("ended as {ending}, not as {}: {:?}", expected.ending, outcome.ending)));
    }
    for expectation in &expected.quantities {
        let got = expectation.quantity.eval(&seen, &outcome);
        println!("    {:?} = {got}", expectation.quantity);
        if let Err(what) = expectation.check(got) {
            wrong.push(here(format!("{:?}: {what} ({})", expectation.quantity, expectation.source)));
        }
    }
    wrong
}

/// Runs all scenes, as many at a time as there are cores.
fn check_all(slow: bool) {
    let of_folder = |folder: PathBuf| {
        expectations(&folder).into_iter().map(move |(name, expected)| (folder.clone(), name, expected))
    };
    let scenes: Vec<_> =
        folders().into_iter().flat_map(of_folder).filter(|(_, _, expected)| expected.slow == slow).collect();
    assert!(scenes.len() > 5, "{}", scenes.len());
    let next = AtomicUsize::new(0);
    let check_next = || {
        let mut wrong = Vec::new();
        while let Some((folder, name, expected)) = scenes.get(next.fetch_add(1, Ordering::Relaxed)) {
            wrong.extend(check(folder, name, expected));
        }
        wrong
    };
    let cores = available_parallelism().map_or(1, NonZero::get);
    let wrong = thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(check_next)).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_scenario_gives_its_expected_numbers() {
    check_all(false);
}

#[test]
#[ignore = "minutes: the finest meshes"]
fn every_slow_scenario_gives_its_expected_numbers() {
    check_all(true);
}
