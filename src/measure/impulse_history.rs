//! The impulse of a contact pair over time, kept compactly, and the largest mean force over a window of it.

use super::contact_patch::ContactPatch;
use crate::mechanics::tensor::Vec3;
use std::collections::VecDeque;

/// Most samples that a history keeps; when it is full, every second one goes.
const MOST_SAMPLES: usize = 16_384;

/// The fewest samples that a history of a longer run has.
pub const FEWEST_SAMPLES: usize = MOST_SAMPLES / 2;

/// What is known of a pair at one time: all of it sums over the time before, so that differences are means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpulseSample {
    /// Time [s].
    pub time: f64,
    /// Impulse on the slave so far [N s].
    pub impulse: Vec3,
    /// ∫ of 1, area [m²], long and short axis [m], nodes across [-] over the time with contact so far [s].
    patch: [f64; 5],
}

impl ImpulseSample {
    /// The next one, at which the patch went from `before` to `after`.
    #[must_use]
    pub fn next(&self, time: f64, impulse: Vec3, before: &ContactPatch, after: &ContactPatch) -> Self {
        let of = |p: &ContactPatch| {
            let is_pressed = f64::from(u8::from(p.nodes > 0));
            [is_pressed, p.area, p.axes[0], p.axes[1], f64::from(p.nodes_across)]
        };
        let (before, after, half) = (of(before), of(after), 0.5 * (time - self.time));
        let patch = std::array::from_fn(|i| self.patch[i] + half * (before[i] + after[i]));
        Self { time, impulse, patch }
    }

    /// Between two, in proportion to the time [s]; before the first there was nothing.
    fn between(a: &Self, b: &Self, time: f64) -> Self {
        let share = if b.time > a.time { ((time - a.time) / (b.time - a.time)).clamp(0.0, 1.0) } else { 0.0 };
        Self {
            time,
            impulse: a.impulse + (b.impulse - a.impulse) * share,
            patch: std::array::from_fn(|i| a.patch[i] + (b.patch[i] - a.patch[i]) * share),
        }
    }

    /// Mean patch from `self` to `end`, over the time with contact.
    fn mean_patch(&self, end: &Self) -> MeanPatch {
        let [pressed, area, long, short, across]: [f64; 5] =
            std::array::from_fn(|i| end.patch[i] - self.patch[i]);
        if pressed <= 0.0 {
            return MeanPatch::default();
        }
        #[allow(clippy::cast_sign_loss)] // never negative
        let nodes_across = (across / pressed).round() as u32;
        MeanPatch { area: area / pressed, axes: [long / pressed, short / pressed], nodes_across }
    }
}

/// A patch, its mean over a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanPatch {
    /// Area [m²].
    pub area: f64,
    /// Long and short axis [m].
    pub axes: [f64; 2],
    /// Nodes across the short axis, rounded [-].
    pub nodes_across: u32,
}

/// The largest force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PeakForce {
    /// Of a window |ΔI| / τ, or as filtered [N].
    pub force: f64,
    /// Middle of the window, or when the filtered force is largest [s].
    pub time: f64,
    /// The mean patch in the window.
    pub patch: MeanPatch,
    /// What the place of the window among the steps does to the force [N]: nothing where steps are short, or the window a whole
    /// number of them.
    pub placing: f64,
}

/// A window that slides along the samples, and the largest mean force in it. Its memory is bounded by the samples of one window.
#[derive(Clone, Debug)]
pub struct SlidingWindow {
    /// τ > 0 [s].
    window: f64,
    /// Samples of the last window, and one before it.
    samples: VecDeque<ImpulseSample>,
    peak: PeakForce,
    /// The largest force of the windows that begin at a sample, and of those that end at one [N].
    largest: [f64; 2],
}

impl SlidingWindow {
    /// Of this length τ > 0 [s].
    pub fn new(window: f64) -> Self {
        Self { window, samples: VecDeque::new(), peak: PeakForce::default(), largest: [0.0; 2] }
    }

    /// Its length τ [s].
    pub fn length(&self) -> f64 {
        self.window
    }

    /// The largest mean force so far.
    pub fn peak(&self) -> PeakForce {
        PeakForce { placing: (self.largest[0] - self.largest[1]).abs(), ..self.peak }
    }

    /// Slides the window to end at `sample`.
    pub fn accumulate(&mut self, sample: ImpulseSample) {
        let before = self.samples.back().copied().unwrap_or(sample);
        self.samples.push_back(sample);
        // The impulse is linear between samples, so the largest change is over a window that begins or ends at one.
        let begin = sample.time - self.window;
        let first = self.samples.partition_point(|s| s.time <= before.time - self.window);
        for i in first..self.samples.partition_point(|s| s.time <= begin) {
            let from = self.samples[i];
            self.compare(&from, &ImpulseSample::between(&before, &sample, from.time + self.window), 0);
        }
        while self.samples.len() > 1 && self.samples[1].time <= begin {
            self.samples.pop_front();
        }
        self.compare(&self.at(begin), &sample, 1);
    }

    /// Compares the mean force of a window with the peak; `end` is which end of it is at a sample.
    fn compare(&mut self, from: &ImpulseSample, to: &ImpulseSample, end: usize) {
        let force = (to.impulse - from.impulse).norm() / self.window;
        self.largest[end] = self.largest[end].max(force);
        if force > self.peak.force {
            let time = (from.time + 0.5 * self.window).max(0.0);
            self.peak = PeakForce { force, time, patch: from.mean_patch(to), placing: 0.0 };
        }
    }

    /// At a time of the window [s]; before the first sample there was nothing.
    fn at(&self, time: f64) -> ImpulseSample {
        match (self.samples.front(), self.samples.get(1)) {
            (Some(a), Some(b)) if a.time <= time => ImpulseSample::between(a, b, time),
            (Some(a), None) if a.time <= time => ImpulseSample { time, ..*a },
            _ => ImpulseSample { time, ..ImpulseSample::default() },
        }
    }
}

/// The samples of a pair from its first contact on. What is between two of them is linear, so each mean over whole samples is exact;
/// while nothing is pressed nothing is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpulseHistory {
    /// The latest while nothing has been pressed.
    before: ImpulseSample,
    samples: Vec<ImpulseSample>,
    /// Steps with contact from one kept sample to the next.
    stride: u32,
    /// Steps since the last one that is kept.
    since: u32,
}

impl Default for ImpulseHistory {
    fn default() -> Self {
        Self { before: ImpulseSample::default(), samples: Vec::new(), stride: 1, since: 0 }
    }
}

impl ImpulseHistory {
    /// Takes in the next step. The memory is taken at the first contact, once.
    pub fn accumulate(&mut self, sample: ImpulseSample) {
        if self.samples.is_empty() {
            if sample.impulse == Vec3::zeros() {
                self.before = sample;
                return;
            }
            self.samples.reserve_exact(MOST_SAMPLES);
            self.samples.push(self.before);
        }
        if let [.., before, last] = &mut self.samples[..]
            && before.impulse == last.impulse
            && last.impulse == sample.impulse
        {
            *last = sample;
            return;
        }
        match self.samples.last_mut() {
            // The last one is always the latest; it stays when its turn has come.
            Some(last) if self.since > 0 && self.since < self.stride => *last = sample,
            _ => {
                self.since = 0;
                self.samples.push(sample);
            }
        }
        self.since += 1;
        if self.samples.len() == MOST_SAMPLES {
            self.thin();
        }
    }

    /// Drops every second sample but the last.
    fn thin(&mut self) {
        let last = self.samples.len() - 1;
        let mut index = 0;
        self.samples.retain(|_| {
            index += 1;
            (index - 1) % 2 == 0 || index - 1 == last
        });
        self.stride *= 2;
    }

    /// The samples, ascending in time.
    pub fn samples(&self) -> &[ImpulseSample] {
        &self.samples
    }

    /// The largest mean force over a window τ > 0 [s].
    pub fn peak_over(&self, window: f64) -> PeakForce {
        let mut sliding = SlidingWindow::new(window);
        self.samples.iter().for_each(|sample| sliding.accumulate(*sample));
        sliding.peak()
    }

    /// Mean patch from one time to another [s].
    pub fn mean_patch(&self, from: f64, to: f64) -> MeanPatch {
        self.at(from).mean_patch(&self.at(to))
    }

    /// At a time [s]; before the first sample there was nothing, after the last it is the last.
    pub fn at(&self, time: f64) -> ImpulseSample {
        let after = self.samples.partition_point(|s| s.time <= time);
        match (after.checked_sub(1).map(|i| &self.samples[i]), self.samples.get(after)) {
            (Some(a), Some(b)) => ImpulseSample::between(a, b, time),
            (Some(a), None) => ImpulseSample { time, ..*a },
            (None, _) => ImpulseSample { time, ..ImpulseSample::default() },
        }
    }
}
