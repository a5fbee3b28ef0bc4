//! What is watched while a case runs.

use crate::plan::Plan;
use crate::step::{Frame, Outcome, Recorder, RecorderError};

/// Extremes of a run that no summary asks for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Watch {
    /// Deepest gap of a candidate contact at the start of a step [m], not negative.
    pub deepest: f64,
    initial: f64,
    largest: f64,
    lost: f64,
    scale: f64,
}

impl Watch {
    /// Largest total energy over that of the start [-].
    pub fn growth(&self) -> f64 {
        if self.initial > 0.0 { self.largest / self.initial } else { 1.0 }
    }
    /// Numerical contact dissipation as a share of the energy scale [-].
    pub fn contact_loss(&self) -> f64 {
        if self.scale > 0.0 { self.lost / self.scale } else { 0.0 }
    }
}

impl Recorder for Watch {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let depth = frame.contacts.iter().map(|contact| -contact.gap).fold(0.0, f64::max);
        self.deepest = self.deepest.max(depth);
        let energy = frame.energy;
        self.initial = energy.initial_total_j;
        self.largest = self.largest.max(energy.total_j - energy.external_work_j);
        self.lost = energy.numerical_contact_j();
        self.scale = energy.turnover_j;
        Ok(())
    }

    fn finish(&mut self, _: &Plan, _: &Outcome) -> Result<(), RecorderError> {
        Ok(())
    }
}
