//! The loop.

use super::frame::{Outcome, Recorder};
use super::state::State;
use crate::plan::Plan;

/// Why a run is asked to stop before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interrupt {
    /// Somebody stopped it.
    Cancel,
    /// The wall-clock budget ran out.
    Deadline,
}

/// How to run, apart from what.
pub struct RunOptions<'a> {
    /// Worker threads of this run; the bits are the same for any number.
    pub threads: usize,
    /// Asked before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
}

/// Runs a plan to its end, or to the diagnosis of why not. Recorders are started, fed and finished on every path.
pub fn run(plan: &Plan, options: &RunOptions, recorders: &mut [&mut dyn Recorder]) -> (Outcome, State) {
    let _ = (plan, options, recorders);
    unimplemented!("skeleton")
}
