//! Compact history of the impulse of a contact pair, and the largest mean force over a window of it.

use super::contact_patch::ContactPatch;
use crate::mechanics::tensor::Vec3;
use std::collections::VecDeque;

/// Maximum number of samples in a history; when it is full, every second one is dropped.
const MOST_SAMPLES: usize = 16_384;

/// Minimum number of samples in the history of a longer run.
pub const FEWEST_SAMPLES: usize = MOST_SAMPLES / 2;

/// Running integrals of a pair up to one time; their differences give means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpulseSample {
    /// Time of the sample [s].
    pub time: f64,
    /// Impulse on the slave so far [N s].
    pub impulse: Vec3,
    /// ∫ of 1, area [m²], long and short axis [m], nodes across [-] over the time with contact so far [s].
    patch: [f64; 5],
}

impl ImpulseSample {
    /// The next sample, with the patch changing from `before` to `after`.
    #[must_use]
    pub fn next(&self, time: f64, impulse: Vec3, before: &ContactPatch, after: &ContactPatch) -> Self {
        let of = |p: &ContactPatch| {
            let is_pressed = f64::from(u8::from(p.area > 0.0));
            [is_pressed, p.area, p.axes[0], p.axes[1], f64::from(p.nodes_across)]
        };
        let (before, after, half) = (of(before), of(after), 0.5 * (time - self.time));
        let patch = std::array::from_fn(|i| self.patch[i] + half * (before[i] + after[i]));
        Self { time, impulse, patch }
    }

    /// Linear interpolation between two samples at a time [s]; zero before the first.
    fn between(a: &Self, b: &Self, time: f64) -> Self {
        let fraction =
            if b.time > a.time { ((time - a.time) / (b.time - a.time)).clamp(0.0, 1.0) } else { 0.0 };
        Self {
            time,
            impulse: a.impulse + (b.impulse - a.impulse) * fraction,
            patch: std::array::from_fn(|i| a.patch[i] + (b.patch[i] - a.patch[i]) * fraction),
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

/// Contact patch averaged over a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanPatch {
    /// Mean area of the patch [m²].
    pub area: f64,
    /// Long and short axis [m].
    pub axes: [f64; 2],
    /// Nodes across the short axis, rounded [-].
    pub nodes_across: u32,
}

/// Peak force of a pair, averaged or filtered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PeakForce {
    /// Mean force of the window |ΔI| / τ, or filtered force [N].
    pub force: f64,
    /// Middle of the window from where it has contact on, or time of the largest filtered force [s].
    pub time: f64,
    /// Mean patch in the window.
    pub patch: MeanPatch,
    /// Effect of the position of the window relative to the steps on the force [N]: none if steps are short, or the
    /// window spans an integer number of them.
    pub placing: f64,
}

/// A window sliding along the samples, and the largest mean force in it. Its memory is bounded by the samples of one
/// window.
#[derive(Clone, Debug)]
pub struct SlidingWindow {
    /// Length τ > 0 [s].
    window: f64,
    /// Samples in the current window, and one before it.
    samples: VecDeque<ImpulseSample>,
    peak: PeakForce,
    /// Largest force of the windows beginning at a sample, and of those ending at one [N].
    largest: [f64; 2],
}

impl SlidingWindow {
    /// A window of length τ > 0 [s].
    pub fn new(window: f64) -> Self {
        Self { window, samples: VecDeque::new(), peak: PeakForce::default(), largest: [0.0; 2] }
    }

    /// Largest mean force so far.
    pub fn peak(&self) -> PeakForce {
        PeakForce { placing: (self.largest[0] - self.largest[1]).abs(), ..self.peak }
    }

    /// Slides the window to end at `sample`.
    pub fn accumulate(&mut self, sample: ImpulseSample) {
        let before = self.samples.back().copied().unwrap_or(sample);
        self.samples.push_back(sample);
        // The impulse is linear between samples, so it changes most over a window that begins or ends at a sample.
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

    /// Compares the mean force of a window with the peak; `end` says which of its ends is at a sample.
    fn compare(&mut self, from: &ImpulseSample, to: &ImpulseSample, end: usize) {
        let force = (to.impulse - from.impulse).norm() / self.window;
        self.largest[end] = self.largest[end].max(force);
        if force > self.peak.force {
            // It may begin before contact does.
            let inside = self.samples.iter().skip_while(|sample| sample.time < from.time);
            let before = inside.take_while(|sample| sample.impulse == from.impulse).last();
            let begin = before.map_or(from.time, |sample| sample.time).max(0.0);
            let time = 0.5 * (begin + from.time + self.window);
            self.peak = PeakForce { force, time, patch: from.mean_patch(to), placing: 0.0 };
        }
    }

    /// Sample interpolated at a time of the window [s]; zero before the first sample.
    fn at(&self, time: f64) -> ImpulseSample {
        match (self.samples.front(), self.samples.get(1)) {
            (Some(a), Some(b)) if a.time <= time => ImpulseSample::between(a, b, time),
            (Some(a), None) if a.time <= time => ImpulseSample { time, ..*a },
            _ => ImpulseSample { time, ..ImpulseSample::default() },
        }
    }
}

/// Samples of a pair from its first contact on. Interpolation between them is linear, so means over whole samples are
/// exact; nothing is kept while there is no contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpulseHistory {
    /// Latest sample before the first contact.
    before: ImpulseSample,
    samples: Vec<ImpulseSample>,
    /// Steps with contact between successive kept samples.
    stride: u32,
    /// Steps since the last kept sample.
    since: u32,
}

impl Default for ImpulseHistory {
    fn default() -> Self {
        Self { before: ImpulseSample::default(), samples: Vec::new(), stride: 1, since: 0 }
    }
}

impl ImpulseHistory {
    /// Accumulates the next step. Memory is allocated once, at the first contact.
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
            // The last entry is always the latest sample; it becomes permanent once a full stride has passed.
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

    /// Drops every second sample except the last.
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

    /// Largest mean force over a window τ > 0 [s].
    pub fn peak_over(&self, window: f64) -> PeakForce {
        let mut sliding = SlidingWindow::new(window);
        self.samples.iter().for_each(|sample| sliding.accumulate(*sample));
        sliding.peak()
    }

    /// Mean patch between two times [s].
    pub fn mean_patch(&self, from: f64, to: f64) -> MeanPatch {
        self.at(from).mean_patch(&self.at(to))
    }

    /// Sample interpolated at a time [s]; zero before the first sample, constant after the last.
    pub fn at(&self, time: f64) -> ImpulseSample {
        let after = self.samples.partition_point(|s| s.time <= time);
        match (after.checked_sub(1).map(|i| &self.samples[i]), self.samples.get(after)) {
            (Some(a), Some(b)) => ImpulseSample::between(a, b, time),
            (Some(a), None) => ImpulseSample { time, ..*a },
            (None, _) => ImpulseSample { time, ..ImpulseSample::default() },
        }
    }
}
