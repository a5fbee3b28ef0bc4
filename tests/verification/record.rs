//! What the tests compare, kept for `docs/verification.md`.
//!
//! Where `CONTUSE_VERIFICATION_RECORDS` names a folder, every comparison made by [`assert_close`], [`assert_within`],
//! [`assert_at_most`] and [`assert_order`] and every picture of [`picture`] is written there, one file a test, and
//! `cargo run --example verification_report` makes a page of them. So a new case is a new test, and nothing else: its file's first
//! paragraphs are the case and its source, the words given to the comparisons name the rows.

use serde_json::{Value, json};
use std::io::Write as _;
use std::path::PathBuf;

/// |got − expected| ≤ tolerance · |expected|.
#[track_caller]
pub fn assert_close(got: f64, expected: f64, tolerance: f64, what: &str) {
    record(
        &json!({"what": what, "exact": expected, "computed": got, "tolerance": tolerance * expected.abs()}),
    );
    assert!(
        (got - expected).abs() <= tolerance * expected.abs(),
        "{what}: {got} against {expected} (off by {:.3e} of it, tolerance {tolerance:.1e})",
        (got / expected - 1.0).abs()
    );
}

/// |got − expected| ≤ within, in the number's own unit.
#[track_caller]
pub fn assert_within(got: f64, expected: f64, within: f64, what: &str) {
    record(&json!({"what": what, "exact": expected, "computed": got, "tolerance": within}));
    assert!((got - expected).abs() <= within, "{what}: {got} against {expected}, not within {within:e}");
}

/// |error| ≤ most, for what is exactly zero.
#[track_caller]
pub fn assert_at_most(error: f64, most: f64, what: &str) {
    record(&json!({"what": what, "exact": 0.0, "computed": error, "tolerance": most}));
    assert!(error.abs() <= most, "{what}: {error:e} is more than {most:e}");
}

/// The observed order of convergence of `errors` on meshes or steps, each of half the size of the one before, from the first to the
/// last; at least `least`.
#[track_caller]
pub fn assert_order(errors: &[f64], least: f64, what: &str) {
    let (first, last) = (errors[0].abs(), errors[errors.len() - 1].abs());
    let order = (first / last).log2() / (errors.len() - 1) as f64;
    record(&json!({"what": what, "errors": errors, "order": order, "least_order": least}));
    assert!(order >= least, "{what}: order {order:.2} of {errors:?} is less than {least}");
}

/// A curve of a picture: its name and its points.
pub type Curve<'a> = (&'a str, Vec<(f64, f64)>);

/// A picture of curves, for the page only.
pub fn picture(title: &str, [x_axis, y_axis]: [&str; 2], curves: &[Curve]) {
    let curves: Vec<Value> =
        curves.iter().map(|(name, points)| json!({"name": name, "points": points})).collect();
    record(&json!({"picture": title, "x": x_axis, "y": y_axis, "curves": curves}));
}

/// A line of the test's file; nothing where no record is requested.
fn record(line: &Value) {
    let Some(folder) = std::env::var_os("CONTUSE_VERIFICATION_RECORDS").map(PathBuf::from) else { return };
    // The harness gives each test a thread of its own, with the test's name.
    let name = std::thread::current().name().unwrap_or("main").replace("::", ".");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("{name}.jsonl"));
    let mut file = std::fs::OpenOptions::new().create(true).append(true).open(path).unwrap();
    writeln!(file, "{line}").unwrap();
}
