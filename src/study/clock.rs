//! The time that a sequence of meshes may take: by the clock, or by the estimates of their plans, which are the same on every
//! machine.

use crate::plan::PlanReport;
use crate::scene::document::AccuracyDocument;
use crate::step::Interrupt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Time in units of the limit after which a run ends that takes more steps than estimated [-].
const LATITUDE: f64 = 1.5;

/// The time that all meshes together may take.
pub(super) struct Clock {
    wall: Wall,
    /// Estimated run time of the completed levels [s]; `None` where the clock on the wall counts.
    estimated_s: Option<f64>,
}

impl Clock {
    /// Starts with what was requested.
    pub fn new(requested: &AccuracyDocument) -> Self {
        let (begin, limit_s) = (Instant::now(), requested.time_budget_s);
        Self { wall: Wall { begin, limit_s }, estimated_s: requested.reproducible.then_some(0.0) }
    }

    /// What may stop a run: nothing where the estimates count.
    pub fn wall(&self) -> Wall {
        let limit_s = if self.estimated_s.is_some() { f64::INFINITY } else { self.wall.limit_s };
        Wall { limit_s, ..self.wall }
    }

    /// Whether the estimates count, rather than the clock on the wall.
    pub fn is_estimated(&self) -> bool {
        self.estimated_s.is_some()
    }

    /// Counts a completed level, with the steps that it took: strain and contact shorten them.
    pub fn count(&mut self, report: &PlanReport, steps: u64) {
        let more = steps as f64 / report.expected_steps.max(1) as f64;
        self.estimated_s = self.estimated_s.map(|seconds| seconds + report.expected_run_time_s * more);
    }

    /// Time spent so far, by the clock that counts [s].
    pub fn elapsed_s(&self) -> f64 {
        self.estimated_s.unwrap_or_else(|| self.wall.elapsed_s())
    }

    /// Steps after which a run is discarded, by the estimates of its plan: those that it was estimated to take, or more as long as the time
    /// remains within 1½ times the limit. `None` where the clock on the wall counts.
    pub fn most_steps(&self, report: &PlanReport) -> Option<u64> {
        let elapsed_s = self.estimated_s?;
        let runs = (LATITUDE * self.wall.limit_s - elapsed_s) / report.expected_run_time_s;
        let expected = report.expected_steps.max(1);
        // Saturates: a limit without end has no steps.
        #[allow(clippy::cast_sign_loss)]
        Some((runs.max(1.0) * expected as f64) as u64)
    }

    /// Whether so many seconds more are too many.
    pub fn is_over_after(&self, seconds: f64) -> bool {
        self.elapsed_s() + seconds > self.wall.limit_s
    }
}

/// The time on the wall, and its limit.
#[derive(Clone, Copy)]
pub(super) struct Wall {
    begin: Instant,
    limit_s: f64,
}

impl Wall {
    fn elapsed_s(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    /// What stops a run: what the caller asks for, and the limit, once there is a result to fall back on; then the run is discarded.
    pub fn interrupt(
        &self,
        requested: Option<Interrupt>,
        has_result: bool,
        discards: &AtomicBool,
    ) -> Option<Interrupt> {
        let is_over = requested == Some(Interrupt::Deadline)
            || (requested.is_none() && self.elapsed_s() > self.limit_s);
        if !(is_over && has_result) {
            return requested;
        }
        discards.store(true, Ordering::Relaxed);
        Some(Interrupt::Deadline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_takes_no_more_steps_than_one_and_a_half_times_the_limit_allows() {
        let report = |seconds: f64| PlanReport {
            expected_run_time_s: seconds,
            expected_steps: 1000,
            ..PlanReport::default()
        };
        let requested =
            AccuracyDocument { time_budget_s: 50.0, reproducible: true, ..AccuracyDocument::default() };
        let mut clock = Clock::new(&requested);
        // 75 s for runs of 10 s.
        assert_eq!(clock.most_steps(&report(10.0)), Some(7500));
        clock.count(&report(10.0), 2500);
        assert_eq!(clock.most_steps(&report(10.0)), Some(5000));
        // A run that was begun may take what it was expected to take.
        assert_eq!(clock.most_steps(&report(70.0)), Some(1000));
        let by_the_wall = Clock::new(&AccuracyDocument { reproducible: false, ..requested });
        assert_eq!(by_the_wall.most_steps(&report(10.0)), None);
    }
}
