//! What the plan kept, what it left out, and why.

use serde::Serialize;

/// The plan in figures and words.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of elements.
    pub elements: usize,
    /// Bytes of the plan and one state, about.
    pub memory_bytes: u64,
    /// Stable step at the start [s].
    pub stable_step_s: f64,
    /// Steps to the end at that step.
    pub expected_steps: u64,
    /// Expected run time on one core [s], from a fixed table of costs (never a stopwatch).
    pub expected_run_time_s: f64,
    /// Element, material and count of each block; slave, master and friction of each pair; …
    pub kept: Vec<String>,
    /// What is absent, each with its reason.
    pub left_out: Vec<LeftOut>,
}

/// Something that the plan does without.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}
