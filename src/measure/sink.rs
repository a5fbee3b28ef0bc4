//! Frames with what the measures say of them, made once, and the sinks that see them.

use super::measures::Measures;
use super::summary::Summary;
use crate::plan::Plan;
use crate::step::{Frame, Outcome, Recorder, RecorderError};

/// A frame that has been measured.
#[derive(Clone, Copy)]
pub struct MeasuredFrame<'a> {
    /// The frame.
    pub frame: &'a Frame<'a>,
    /// What is measured up to it: forces, patches, energies; stresses and fields as of the latest field time.
    pub measures: &'a Measures,
}

impl MeasuredFrame<'_> {
    /// The summary of the run up to here.
    pub fn summary(&self) -> Summary {
        Summary::compose(self.measures, self.frame.plan, None)
    }
}

/// A measured run that has ended.
#[derive(Clone, Copy)]
pub struct MeasuredEnd<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// What has been measured.
    pub measures: &'a Measures,
    /// How the run ended.
    pub outcome: &'a Outcome,
    /// The summary of the run.
    pub summary: &'a Summary,
}

/// What measured frames go to: a file, memory, a progress bar. It may work on another thread than the steps.
pub trait Sink: Send {
    /// Before the first step.
    ///
    /// # Errors
    /// When the sink cannot be opened.
    fn start(&mut self, _plan: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }
    /// At every step, also those that are not due: the sink keeps the plan's cadence.
    ///
    /// # Errors
    /// When the sink cannot be written; the run then ends as failed.
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError>;
    /// After the last step, however the run ended, also when this or another sink has failed before.
    ///
    /// # Errors
    /// When the sink cannot be closed.
    fn finish(&mut self, _end: &MeasuredEnd) -> Result<(), RecorderError> {
        Ok(())
    }
    /// Instead of [`Sink::finish`]: the run is discarded, and what the sink holds of an earlier one stays.
    fn discard(&mut self) {}
}

/// A recorder that measures each frame once and hands it to any number of sinks, in their order.
///
/// A sink that fails keeps no other one from the frame; the run is told of the first failure.
pub struct MeasuringRecorder<'a> {
    measures: Measures,
    sinks: Vec<&'a mut dyn Sink>,
}

impl<'a> MeasuringRecorder<'a> {
    /// With the measures of a run that has not begun, and no sink.
    pub fn new(measures: Measures) -> Self {
        Self { measures, sinks: Vec::new() }
    }

    /// With one more sink.
    #[must_use]
    pub fn with(mut self, sink: &'a mut dyn Sink) -> Self {
        self.sinks.push(sink);
        self
    }

    /// What has been measured.
    pub fn measures(&self) -> &Measures {
        &self.measures
    }

    /// The summary of a run that ended so.
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

/// The first failure. Every sink is asked, those after one that fails too.
fn first_failure(results: impl Iterator<Item = Result<(), RecorderError>>) -> Result<(), RecorderError> {
    let mut first = Ok(());
    for result in results {
        first = first.and(result);
    }
    first
}
