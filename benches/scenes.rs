//! Whole scenes: CPU time of a run.
fn main() {}
