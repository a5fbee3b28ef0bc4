//! A recorder that keeps the histories in memory, for tests and studies.

use crate::measure::{MeasuredEnd, MeasuredFrame, Sink};
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::step::{Energy, Outcome, RecorderError};

/// Sums of one step.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Time of the step [s].
    pub time: f64,
    /// Number of the step.
    pub step: u64,
    /// Energy ledger of the step.
    pub energy: Energy,
    /// Resultant force on the slave of each pair in this step [N].
    pub forces: Vec<Vec3>,
    /// Number of contacts with r_n > 0.
    pub active_contacts: usize,
}

/// Motion at one field time.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Field time of the snapshot [s].
    pub time: f64,
    /// Displacement [m], nodes × 3.
    pub u: Vec<Vec3>,
    /// Mean velocity of the adjacent half steps, relative to the rigid-body velocities V of the bodies [m/s], nodes × 3.
    pub v: Vec<Vec3>,
}

/// Stores every step's sums (at the plan's cadence) and the motion at the field times.
#[derive(Clone, Debug, Default)]
pub struct MemoryRecorder {
    /// Samples of every `every_steps` steps, and of the field times.
    pub samples: Vec<Sample>,
    /// Snapshots of the field times.
    pub snapshots: Vec<Snapshot>,
    /// Outcome of the run, once it has ended.
    pub outcome: Option<Outcome>,
    frames: u64,
}

impl Sink for MemoryRecorder {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        *self = Self::default();
        Ok(())
    }

    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        let MeasuredFrame { frame, measures } = *measured;
        if self.frames.is_multiple_of(u64::from(frame.plan.every_steps.max(1))) || frame.is_field_time {
            self.samples.push(Sample {
                time: frame.time,
                step: frame.step,
                energy: frame.energy.clone(),
                forces: measures.pairs.values().map(|pair| pair.force.now().force).collect(),
                active_contacts: frame.reactions.iter().filter(|r| r.impulse[0] > 0.0).count(),
            });
        }
        self.frames += 1;
        if frame.is_field_time {
            let halves = frame.v.iter().zip(frame.v_after);
            let v = halves.map(|(before, after)| (before + after) * 0.5).collect();
            self.snapshots.push(Snapshot { time: frame.time, u: frame.u.to_vec(), v });
        }
        Ok(())
    }

    fn finish(&mut self, end: &MeasuredEnd) -> Result<(), RecorderError> {
        self.outcome = Some(end.outcome.clone());
        Ok(())
    }
}
