//! Control of a running job: stopping it, and why.

use crate::step::Interrupt;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

/// Why a running job is to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StopReason {
    /// Cancelled or deleted by its owner.
    Cancel,
    /// The wall-clock limit is exceeded.
    Deadline,
    /// The service shuts down: the job returns to the queue.
    Shutdown,
}

const GO_ON: u8 = 0;
const DEADLINE: u8 = 1;
const SHUTDOWN: u8 = 2;
const CANCEL: u8 = 3;

/// Control of one running job, shared by its worker and those who may stop it.
#[derive(Debug)]
pub struct RunControl {
    reason: AtomicU8,
    started: Instant,
    deadline: Duration,
}

impl RunControl {
    /// Control of a job that starts now and may run for `deadline`.
    pub fn new(deadline: Duration) -> Self {
        Self { reason: AtomicU8::new(GO_ON), started: Instant::now(), deadline }
    }

    /// Requests the job to stop. A shutdown overrides the deadline, as it ends what an ended run waits for, and a cancellation both: a
    /// job unwanted by its owner must not restart with the service.
    pub fn stop(&self, reason: StopReason) {
        let code = match reason {
            StopReason::Cancel => CANCEL,
            StopReason::Deadline => DEADLINE,
            StopReason::Shutdown => SHUTDOWN,
        };
        self.reason.fetch_max(code, Ordering::SeqCst);
    }

    /// Reason of the request to stop, if there was one.
    pub fn reason(&self) -> Option<StopReason> {
        match self.reason.load(Ordering::SeqCst) {
            CANCEL => Some(StopReason::Cancel),
            DEADLINE => Some(StopReason::Deadline),
            SHUTDOWN => Some(StopReason::Shutdown),
            _ => None,
        }
    }

    /// Interrupt for the stepper, polled before every step.
    pub fn interrupt(&self) -> Option<Interrupt> {
        if self.reason().is_none() && self.started.elapsed() > self.deadline {
            self.stop(StopReason::Deadline);
        }
        self.reason().map(|reason| match reason {
            StopReason::Deadline => Interrupt::Deadline,
            StopReason::Cancel | StopReason::Shutdown => Interrupt::Cancel,
        })
    }

    /// Running time so far.
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancel_overrules_shutdown_and_that_the_deadline() {
        let control = RunControl::new(Duration::from_secs(60));
        assert_eq!(control.interrupt(), None);
        control.stop(StopReason::Deadline);
        assert_eq!(control.interrupt(), Some(Interrupt::Deadline));
        control.stop(StopReason::Shutdown);
        control.stop(StopReason::Deadline);
        assert_eq!(control.interrupt(), Some(Interrupt::Cancel));
        control.stop(StopReason::Cancel);
        assert_eq!(control.reason(), Some(StopReason::Cancel));
        control.stop(StopReason::Shutdown);
        assert_eq!(control.reason(), Some(StopReason::Cancel));
    }

    #[test]
    fn deadline_stops_by_itself() {
        let control = RunControl::new(Duration::ZERO);
        std::thread::sleep(Duration::from_millis(2));
        assert_eq!(control.interrupt(), Some(Interrupt::Deadline));
        assert_eq!(control.reason(), Some(StopReason::Deadline));
    }
}
