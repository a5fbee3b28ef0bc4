//! Frames with their measures, evaluated once, and the sinks that receive them.

use super::measures::Measures;
use super::summary::Summary;
use crate::plan::Plan;
use crate::step::{Frame, Outcome, Recorder, RecorderError};

/// A frame with its measures.
#[derive(Clone, Copy)]
pub struct MeasuredFrame<'a> {
    /// The frame of the step.
    pub frame: &'a Frame<'a>,
    /// Measures up to this frame: forces, patches, energies; stresses and fields as of the latest field time.
    pub measures: &'a Measures,
}

impl MeasuredFrame<'_> {
    /// Summary of the run up to this frame.
    pub fn summary(&self) -> Summary {
        Summary::compose(self.measures, self.frame.plan, None)
    }
}

/// A measured run that has ended.
#[derive(Clone, Copy)]
pub struct MeasuredEnd<'a> {
    /// Plan of the run.
    pub plan: &'a Plan,
    /// Measures of the whole run.
    pub measures: &'a Measures,
    /// Outcome of the run.
    pub outcome: &'a Outcome,
    /// Final summary of the run.
    pub summary: &'a Summary,
}

/// A destination of measured frames: a file, memory, a progress bar. It may run on another thread than the steps.
pub trait Sink: Send {
    /// Called before the first step.
    ///
    /// # Errors
    /// If the sink cannot be opened.
    fn start(&mut self, _plan: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }
    /// Called at every step, whether a frame is due or not: the sink follows the plan's cadence.
    ///
    /// # Errors
    /// If the sink cannot be written; the run then ends as failed.
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError>;
    /// Called after the last step, however the run ended, even if this or another sink has failed before.
    ///
    /// # Errors
    /// If the sink cannot be closed.
    fn finish(&mut self, _end: &MeasuredEnd) -> Result<(), RecorderError> {
        Ok(())
    }
    /// Instead of [`Sink::finish`]: the run is discarded, and what the sink holds of an earlier one stays.
    fn discard(&mut self) {}
}

/// A recorder that measures each frame once and passes it to any number of sinks, in their order.
///
/// The failure of a sink does not keep the frame from the others; the run receives the first failure.
pub struct MeasuringRecorder<'a> {
    measures: Measures,
    sinks: Vec<&'a mut dyn Sink>,
}

impl<'a> MeasuringRecorder<'a> {
    /// A recorder with the measures of a run that has not begun, and no sink.
    pub fn new(measures: Measures) -> Self {
        Self { measures, sinks: Vec::new() }
    }

    /// Adds a sink, which receives each frame after those before it.
    #[must_use]
    pub fn with(mut self, sink: &'a mut dyn Sink) -> Self {
        self.sinks.push(sink);
        self
    }

    /// All measures of the run so far.
    pub fn measures(&self) -> &Measures {
        &self.measures
    }

    /// Summary of a run with this outcome.
    pub fn summary(&self, plan: &Plan, outcome: &Outcome) -> Summary {
        Summary::compose(&self.measures, plan, Some(outcome))
    }
}

impl Recorder for MeasuringRecorder<'_> {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        self.measures.start(plan).map_err(|error| RecorderError(Box::new(error)))?;
        self.sinks.iter_mut().try_for_each(|sink| sink.start(plan))
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        self.measures.accumulate(frame);
        let measured = MeasuredFrame { frame, measures: &self.measures };
        first_failure(self.sinks.iter_mut().map(|sink| sink.record(&measured)))
    }

    fn finish(&mut self, plan: &Plan, outcome: &Outcome) -> Result<(), RecorderError> {
        let summary = self.summary(plan, outcome);
        let end = MeasuredEnd { plan, measures: &self.measures, outcome, summary: &summary };
        first_failure(self.sinks.iter_mut().map(|sink| sink.finish(&end)))
    }
}

/// The first failure. Every sink is called, including those after a failed one.
fn first_failure(results: impl Iterator<Item = Result<(), RecorderError>>) -> Result<(), RecorderError> {
    let mut first = Ok(());
    for result in results {
        first = first.and(result);
    }
    first
}
