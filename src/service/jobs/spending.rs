//! Resources used by a run, compared with its budget: a scene is accepted on an estimate, which its run may exceed.

use crate::record::partial_path;
use crate::scene::Budget;
use crate::step::Interrupt;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps and recorded bytes of one run.
pub(super) struct Spending<'a> {
    budget: &'a Budget,
    recording: &'a Path,
    steps: AtomicU64,
    bytes: AtomicU64,
}

impl<'a> Spending<'a> {
    /// Counters of a run that begins.
    pub fn new(budget: &'a Budget, recording: &'a Path) -> Self {
        Self { budget, recording, steps: AtomicU64::new(0), bytes: AtomicU64::new(0) }
    }

    /// Updates the steps completed and the size of the file. Once per report, not per step.
    pub fn note(&self, steps: u64) {
        let bytes = std::fs::metadata(partial_path(self.recording)).map_or(0, |file| file.len());
        self.steps.store(steps, Ordering::Relaxed);
        self.bytes.store(bytes, Ordering::Relaxed);
    }

    /// Why the run has to end, if it has.
    pub fn interrupt(&self) -> Option<Interrupt> {
        let Budget { steps, recording_bytes, .. } = *self.budget;
        if self.steps.load(Ordering::Relaxed) > steps {
            return Some(Interrupt::Steps { most: steps });
        }
        let most = recording_bytes;
        (self.bytes.load(Ordering::Relaxed) > most).then_some(Interrupt::RecordingBytes { most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_spent_ends_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("run.mcap");
        let budget = Budget { steps: 10, recording_bytes: 100, ..Budget::SERVICE };
        let spending = Spending::new(&budget, &recording);
        spending.note(10);
        assert_eq!(spending.interrupt(), None);
        spending.note(11);
        assert_eq!(spending.interrupt(), Some(Interrupt::Steps { most: 10 }));
        std::fs::write(partial_path(&recording), [0; 101]).unwrap();
        spending.note(3);
        assert_eq!(spending.interrupt(), Some(Interrupt::RecordingBytes { most: 100 }));
    }
}
