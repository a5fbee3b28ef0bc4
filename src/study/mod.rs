//! Studies: from the one run of a scene to many.

pub mod single;

pub use single::{Phase, Progress, RunError, RunRequest, RunResult, run_scene};
