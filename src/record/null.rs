//! A recorder that keeps nothing.

use crate::plan::Plan;
use crate::step::{Frame, Outcome, Recorder, RecorderError};

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NullRecorder;

impl Recorder for NullRecorder {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }
    fn record(&mut self, _: &Frame) -> Result<(), RecorderError> {
        Ok(())
    }
    fn finish(&mut self, _: &Plan, _: &Outcome) -> Result<(), RecorderError> {
        Ok(())
    }
}
