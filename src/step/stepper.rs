//! Interface of an integrator, explicit or implicit, to the time loop.

use super::energy::Energy;
use super::failure::Stop;
use super::interrupt::Ask;
use super::phase::Phase;
use super::state::State;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;

/// Extremes of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extremes {
    pub smallest_step: f64,
    pub smallest_j: f64,
    pub most_contacts: usize,
    pub balance_error: f64,
    /// Active elements, summed over the steps since the clock started.
    pub evaluated_elements: u64,
}

impl Extremes {
    /// Extremes before the first step.
    pub const NONE: Self = Self {
        smallest_step: f64::INFINITY,
        smallest_j: f64::INFINITY,
        most_contacts: 0,
        balance_error: 0.0,
        evaluated_elements: 0,
    };
}

/// An integrator: holds the work arrays of a step, and carries nothing between steps that is not derived from the
/// state.
pub(super) trait Stepper {
    /// Computes everything at t_n up to the end velocity: forces, step size (at most `longest`, to reach the next time
    /// that must be met exactly; 0 at the last), contact. The state is unchanged until [`Stepper::advance`], so that a
    /// copy of it restarts the run with the same bits.
    ///
    /// `interrupt` is called during long steps.
    fn solve(&mut self, state: &State, phase: Phase, longest: f64, interrupt: Ask) -> Result<(), Stop>;
    /// Balances the ledger at t_n, after [`Stepper::solve`].
    fn balance(&mut self, state: &State);
    /// Advances to t_{n+1}, and projects out the penetration left by linearisation.
    fn advance(&mut self, state: &mut State, phase: Phase);
    /// Contacts and reactions of the last [`Stepper::solve`].
    fn contacts(&self) -> (&[Contact], &[Reaction]);
    /// The time over which those reactions act [s].
    fn mean_step(&self, state: &State) -> f64;
    /// Velocity whose mean with that of the state is the velocity at t_n [m/s].
    fn v_after<'a>(&'a self, state: &'a State) -> &'a [Vec3];
    /// The balance at t_n, after [`Stepper::balance`].
    fn energy(&self) -> &Energy;
    /// Extremes of the run so far.
    fn extremes(&self) -> &Extremes;
    /// Contact solves that ended above the scene's tolerance: their number, and the largest residual.
    fn unconverged(&self) -> (u64, f64);
    /// Stores the history of the elements at t_n, after [`Stepper::solve`], if any material relaxes.
    fn note_history(&mut self) {}
    /// The history stored last, chunk by chunk.
    fn history(&self) -> &[Vec<Row>] {
        &[]
    }
    /// Warnings for the user.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }
}
