//! The cycle of subcycling, see `subcycles.rs`: which elements are evaluated at a time, and how long their forces act.

/// Most steps between two evaluations of an element.
pub(super) const LONGEST: u32 = 4;
/// Times that differ by less than this fraction of a step are the same [-].
pub(super) const SAME_TIME: f64 = 1e-6;

/// Times between the evaluations of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Steps of the cycle from one evaluation to the next, a power of two.
    pub(super) every: u32,
    /// Time since the last evaluation [s]; 0 for the last step.
    pub(super) behind: f64,
    /// Time to the next one [s]; 0 for the step to come.
    pub(super) ahead: f64,
    /// Smallest critical time step in the evaluations of the cycle [s]: viscosity shortens it in some steps and not in others.
    pub(super) stable: f64,
}

impl Interval {
    pub(super) const EVERY_STEP: Self = Self { every: 1, behind: 0.0, ahead: 0.0, stable: 0.0 };

    /// Sets how many steps [s] of the cycle it takes to the next evaluation.
    pub(super) fn set_every(&mut self, every: u32, step: f64) {
        self.every = every;
        self.ahead = if every > 1 { f64::from(every) * step } else { 0.0 };
    }
}

/// The cycle that a run is in; part of its state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Subcycles {
    /// Number of steps, a power of two; 0 where all elements are evaluated in every step.
    pub(super) length: u32,
    /// Those that are over.
    pub(super) done: u32,
    /// Whether the time is that of the end of a step of the cycle: one that is too long is divided.
    pub(super) on_grid: bool,
    /// Beginning [s].
    pub(super) start: f64,
    /// Step [s].
    pub(super) step: f64,
    /// Longest step of the cycle that is to begin [s]; 0 if none is.
    pub(super) longest: f64,
    /// Whether elements come from intervals longer than the last step.
    pub(super) is_behind: bool,
    /// Interval of each batch, chunk by chunk.
    pub(super) intervals: Vec<Vec<Interval>>,
}

impl Subcycles {
    /// Whether some elements are evaluated less often than others.
    pub fn are_active(&self) -> bool {
        self.length > 0 || self.is_behind
    }

    /// Whether all elements are evaluated at t_n.
    pub fn are_synchronised(&self) -> bool {
        self.length == 0 || (self.on_grid && self.done == 0)
    }

    /// Time that the next step must not exceed [s]; `None` outside a cycle.
    pub fn next_time(&self) -> Option<f64> {
        (self.length > 0).then(|| self.start + f64::from(self.done + 1) * self.step)
    }

    /// Step of the cycle [s]; 0 outside one.
    pub fn step(&self) -> f64 {
        if self.length > 0 { self.step } else { 0.0 }
    }

    /// What an evaluation at t_n reads; `last` is the step before [s].
    pub(super) fn of_chunk(&self, chunk: usize, last: f64) -> Option<ChunkCycle<'_>> {
        let intervals = self.intervals.get(chunk).filter(|_| self.are_active())?;
        let done = if self.on_grid { self.done } else { 1 };
        Some(ChunkCycle { intervals, done, last })
    }

    /// Takes those of a state at `time`, and begins the cycle that is to begin there; `remaining` is the time to the next one that must be
    /// met [s].
    pub fn take(&mut self, of_state: &Self, time: f64, remaining: f64) {
        let Self { length, done, on_grid, start, step, longest, is_behind, intervals } = self;
        (*length, *done, *on_grid, *start) =
            (of_state.length, of_state.done, of_state.on_grid, of_state.start);
        (*step, *longest, *is_behind) = (of_state.step, of_state.longest, of_state.is_behind);
        intervals.clone_from(&of_state.intervals);
        if *longest <= 0.0 {
            return;
        }
        let steps = (remaining / *longest - SAME_TIME).ceil().max(1.0);
        let most = power_of_two(steps, LONGEST);
        (*length, *done, *on_grid) = (if most > 1 { most } else { 0 }, 0, true);
        (*start, *step, *longest) = (time, remaining / steps, 0.0);
        for interval in intervals.iter_mut().flatten() {
            interval.set_every(interval.every.min(most), *step);
        }
    }
}

/// The cycle as a chunk sees it in one evaluation.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChunkCycle<'a> {
    intervals: &'a [Interval],
    done: u32,
    last: f64,
}

/// How long the forces of a batch act at t_n, beside `h̄` where they are `in_steps` [s].
#[derive(Clone, Copy, Debug)]
pub(super) struct Kick {
    /// Whether they act over the mean step h̄, as those of elements that are evaluated in every step do.
    pub in_steps: bool,
    /// Further duration [s].
    pub duration: f64,
    /// Difference of the intervals ahead and behind, without that of the steps where they are `in_steps` [s].
    pub change: f64,
}

impl ChunkCycle<'_> {
    /// Batches to evaluate, a bit each.
    pub fn due(&self) -> u32 {
        let is_due = |(_, interval): &(usize, &Interval)| self.done.is_multiple_of(interval.every);
        self.intervals.iter().enumerate().filter(is_due).map(|(i, _)| 1 << i).sum()
    }

    /// Time since the last evaluation of a batch [s].
    pub fn since(&self, batch: usize) -> f64 {
        let behind = self.intervals[batch].behind;
        if behind > 0.0 { behind } else { self.last }
    }

    /// How the forces of a batch act; `None` where they do in every step, before and after.
    pub fn kick(&self, batch: usize) -> Option<Kick> {
        let Interval { behind, ahead, .. } = self.intervals[batch];
        let since = self.since(batch);
        if ahead > 0.0 {
            // ½ (T₋ + T₊)
            return Some(Kick { in_steps: false, duration: 0.5 * (since + ahead), change: ahead - since });
        }
        // ½ (T₋ + h₊) = h̄ + ½ (T₋ − h₋)
        let more = since - self.last;
        (behind > 0.0).then_some(Kick { in_steps: true, duration: 0.5 * more, change: -more })
    }
}

/// Largest power of two up to `value` and `most`; at least 1.
pub(super) fn power_of_two(value: f64, most: u32) -> u32 {
    let mut power = most;
    while power > 1 && !(f64::from(power) <= value) {
        power /= 2;
    }
    power
}
