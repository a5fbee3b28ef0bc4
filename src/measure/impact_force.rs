//! Impact force of a contact pair: from its impulse over time, so that the number converges with the step.

use super::contact_patch::ContactPatch;
use crate::mechanics::tensor::Vec3;
use crate::step::Frame;
use std::collections::VecDeque;

/// What a pair does at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairSample {
    /// Time [s].
    pub time: f64,
    /// Impulse on the slave so far [N s].
    pub impulse: Vec3,
    /// Force on the slave in this step, impulse / h̄ [N]: recorded, but not a converged quantity.
    pub force: Vec3,
    /// The patch.
    pub patch: ContactPatch,
}

/// A peak of the windowed force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PeakForce {
    /// |ΔI| / τ [N].
    pub force: f64,
    /// Middle of the window [s].
    pub time: f64,
    /// The patch at that time.
    pub patch: ContactPatch,
}

/// Accumulates the force measures of one pair, in memory bounded by the steps of one window.
#[derive(Clone, Debug)]
pub struct ImpactForce {
    /// Window τ [s].
    window: f64,
    /// Samples of the last window, and one before it.
    history: VecDeque<PairSample>,
    /// Largest |ΔI|/τ.
    pub peak: PeakForce,
    /// The same of the windows that begin at a sample, and of those that end at one [N].
    largest: [f64; 2],
    /// Largest force of a single step, with its time [N, s].
    pub peak_step: (f64, f64),
    /// Largest patch so far.
    pub largest_patch: ContactPatch,
    /// First and last time with r_n > 0 [s].
    pub contact_span: Option<[f64; 2]>,
    /// Time with r_n > 0, summed over the steps that begin so [s].
    pub contact_time: f64,
    /// Where the first contact was [m].
    pub first_contact: Option<Vec3>,
}

impl ImpactForce {
    /// With window τ [s]; a window of 0 takes the force of single steps.
    pub fn new(window: f64) -> Self {
        Self {
            window,
            history: VecDeque::new(),
            peak: PeakForce::default(),
            largest: [0.0; 2],
            peak_step: (0.0, 0.0),
            largest_patch: ContactPatch::default(),
            contact_span: None,
            contact_time: 0.0,
            first_contact: None,
        }
    }

    /// The latest sample.
    pub fn now(&self) -> PairSample {
        self.history.back().copied().unwrap_or_default()
    }

    /// Whether the pair was pressed at the latest sample.
    pub fn is_touching(&self) -> bool {
        self.now().patch.nodes > 0
    }

    /// Takes in one step.
    pub fn accumulate(&mut self, sample: PairSample) {
        let before = self.now();
        if before.patch.nodes > 0 {
            self.contact_time += sample.time - before.time;
        }
        self.history.push_back(sample);
        if sample.patch.nodes > 0 {
            let first = self.contact_span.map_or(sample.time, |span| span[0]);
            self.contact_span = Some([first, sample.time]);
            self.first_contact = self.first_contact.or(Some(sample.patch.centre));
        }
        if sample.patch.area > self.largest_patch.area {
            self.largest_patch = sample.patch;
        }
        let step_force = sample.force.norm();
        if step_force > self.peak_step.0 {
            self.peak_step = (step_force, sample.time);
        }
        self.accumulate_window(sample, step_force);
    }

    /// Slides the window to end at `sample` and compares its mean force with the peak.
    fn accumulate_window(&mut self, sample: PairSample, step_force: f64) {
        if self.window <= 0.0 {
            self.history.truncate(0);
            self.history.push_back(sample);
            if step_force > self.peak.force {
                self.peak = PeakForce { force: step_force, time: sample.time, patch: sample.patch };
            }
            return;
        }
        let begin = sample.time - self.window;
        // The impulse is linear between samples, so the largest change is over a window that begins or ends at one.
        let before = self.history.len().checked_sub(2).map_or(sample, |last| self.history[last]);
        let begins = |s: &&PairSample| s.time > before.time - self.window && s.time <= begin;
        let ends = |s: &PairSample| {
            let share = (s.time + self.window - before.time) / (sample.time - before.time);
            (before.impulse + (sample.impulse - before.impulse) * share - s.impulse, s.time)
        };
        let windows: Vec<(Vec3, f64)> = self.history.iter().filter(begins).map(ends).collect();
        for (change, begin) in windows {
            self.compare(change, begin, 0);
        }
        while self.history.len() > 1 && self.history[1].time <= begin {
            self.history.pop_front();
        }
        self.compare(sample.impulse - self.impulse_at(begin), begin, 1);
    }

    /// What the place of the window among the steps does to the peak force [N]: nothing where steps are short, or the window a whole
    /// number of them.
    pub fn placing(&self) -> f64 {
        (self.largest[0] - self.largest[1]).abs()
    }

    /// Compares the mean force of the window from `begin` [s], in which the impulse changed so [N s], with the peak; `end` is which
    /// end of it is at a sample.
    fn compare(&mut self, change: Vec3, begin: f64, end: usize) {
        let force = change.norm() / self.window;
        self.largest[end] = self.largest[end].max(force);
        if force > self.peak.force {
            let time = begin + 0.5 * self.window;
            self.peak = PeakForce { force, time: time.max(0.0), patch: self.patch_near(time) };
        }
    }

    /// Impulse at a time in the history, linear between samples; what there was before the first sample is zero.
    fn impulse_at(&self, time: f64) -> Vec3 {
        match (self.history.front(), self.history.get(1)) {
            (Some(a), Some(b)) if a.time <= time && b.time > a.time => {
                a.impulse + (b.impulse - a.impulse) * ((time - a.time) / (b.time - a.time)).min(1.0)
            }
            (Some(a), _) if a.time <= time => a.impulse,
            _ => Vec3::zeros(),
        }
    }

    /// Patch of the sample nearest to a time at which the pair is pressed, if it is in the window.
    fn patch_near(&self, time: f64) -> ContactPatch {
        let distance = |s: &&PairSample| (s.time - time).abs();
        self.history
            .iter()
            .filter(|s| s.patch.nodes > 0)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .map(|s| s.patch)
            .unwrap_or_default()
    }
}

/// Resultant force on the slave of a pair in this step: Σ R_c / h̄ [N].
pub fn resultant_force(frame: &Frame, pair: u32) -> Vec3 {
    let mut impulse = Vec3::zeros();
    for (contact, reaction) in frame.contacts.iter().zip(frame.reactions).filter(|(c, _)| c.pair == pair) {
        for (axis, r) in contact.frame.iter().zip(reaction.impulse) {
            impulse += axis * r;
        }
    }
    if frame.mean_step > 0.0 { impulse / frame.mean_step } else { Vec3::zeros() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds a force F(t) with exact impulse I(t) = ∫F.
    fn feed(window: f64, step: f64, end: f64, impulse: impl Fn(f64) -> f64) -> ImpactForce {
        let mut measure = ImpactForce::new(window);
        let steps = (end / step).round() as u32;
        for n in 0..=steps {
            let t = f64::from(n) * step;
            let force = (impulse(t + 0.5 * step) - impulse(t - 0.5 * step)) / step;
            let nodes = u32::from(force > 0.0);
            let patch = ContactPatch { area: force, nodes, ..ContactPatch::default() };
            let sample =
                PairSample { time: t, impulse: Vec3::z() * impulse(t), force: Vec3::z() * force, patch };
            measure.accumulate(sample);
        }
        measure
    }

    #[test]
    fn a_plateau_has_its_own_force() {
        // 7 N from 1 to 3 s.
        let measure = feed(0.5, 0.01, 5.0, |t| 7.0 * (t.clamp(1.0, 3.0) - 1.0));
        assert!((measure.peak.force - 7.0).abs() < 1e-12);
        assert!(measure.peak.time >= 1.2 && measure.peak.time <= 2.8);
        assert!((measure.contact_time - 2.0).abs() < 0.03);
    }

    #[test]
    fn a_half_sine_is_averaged_over_the_window() {
        use std::f64::consts::PI;
        // F = sin(π t), I = (1 − cos π t)/π; a window of 0.2 about the peak averages sin(0.1 π)/(0.1 π).
        let measure = feed(0.2, 0.001, 1.0, |t| (1.0 - (PI * t.clamp(0.0, 1.0)).cos()) / PI);
        let exact = (0.1 * PI).sin() / (0.1 * PI);
        assert!((measure.peak.force - exact).abs() < 1e-6, "{} {exact}", measure.peak.force);
        assert!((measure.peak.time - 0.5).abs() < 2e-3);
        assert!(
            (measure.peak.patch.area - 1.0).abs() < 1e-5,
            "the patch is that of the middle of the window"
        );
        assert!((measure.peak_step.0 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_window_of_no_whole_number_of_steps_is_found_all_the_same() {
        // 1 N from 1.0 to 1.6 s, in steps of 0.4 s: the best window of 0.6 s begins at a sample, and none that ends at one is as good.
        let measure = feed(0.6, 0.4, 4.0, |t| t.clamp(1.2, 1.8) - 1.2);
        let sampled = |t: f64| {
            let n = (t / 0.4).floor();
            let at = |n: f64| (0.4 * n).clamp(1.2, 1.8) - 1.2;
            at(n) + (at(n + 1.0) - at(n)) * (t / 0.4 - n)
        };
        let best = (0..34_000)
            .map(|i| f64::from(i) * 1e-4)
            .map(|t| sampled(t + 0.6) - sampled(t))
            .fold(0.0, f64::max);
        assert!((measure.peak.force - best / 0.6).abs() < 1e-9, "{} {}", measure.peak.force, best / 0.6);
    }

    #[test]
    fn memory_is_bounded_by_the_window() {
        let measure = feed(0.05, 0.001, 10.0, |t| t);
        assert!(measure.history.len() <= 53, "{}", measure.history.len());
    }

    #[test]
    fn a_spike_counts_as_its_impulse_over_the_window() {
        // 1 N s between t = 0.999 and 1: 1000 N in a step, 10 N over a window of 0.1 s.
        let measure = feed(0.1, 0.001, 2.0, |t| ((t - 0.999) * 1000.0).clamp(0.0, 1.0));
        assert!((measure.peak.force - 10.0).abs() < 1e-9, "{}", measure.peak.force);
    }
}
