//! Impact force of a contact pair, taken from its impulse over time so that it converges with the time step.

use super::channel_class::filtered_peak;
use super::contact_patch::ContactPatch;
use super::contact_time::ContactTime;
use super::impulse_history::{ImpulseHistory, ImpulseSample, PeakForce, SlidingWindow};
use crate::mechanics::tensor::Vec3;
use crate::plan::ForceAverage;
use crate::step::Frame;

/// Default averaging window as a fraction of the contact duration [-]. The mean over it is 0.4 % below the peak of a half-sine
/// pulse, and converges with the mesh much faster than one over shorter windows, in which each node that touches is a peak.
pub const FRACTION_OF_CONTACT: f64 = 1.0 / 10.0;
/// Minimum length of that window in steps.
pub const FEWEST_STEPS: f64 = 10.0;

/// State of a pair at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairSample {
    /// Time of the sample [s].
    pub time: f64,
    /// Impulse on the slave so far [N s].
    pub impulse: Vec3,
    /// Force on the slave in this step, impulse / h̄ [N]: recorded, but not a converged quantity.
    pub force: Vec3,
    /// Contact patch at this time.
    pub patch: ContactPatch,
}

/// Accumulates the force measures of one pair, in bounded memory.
#[derive(Clone, Debug)]
pub struct ImpactForce {
    average: ForceAverage,
    /// Sliding window, if the scene specifies its length.
    sliding: Option<SlidingWindow>,
    /// Impulse history, if the window is chosen at the end.
    history: ImpulseHistory,
    now: PairSample,
    sums: ImpulseSample,
    /// Largest force of a single step, with its time [N, s].
    pub peak_step: (f64, f64),
    /// Patch of largest area so far.
    pub largest_patch: ContactPatch,
    /// Latest time with a patch of that area [s]; `None` before the first.
    pub largest_patch_time: Option<f64>,
    /// First and last time with r_n > 0 [s].
    pub contact_span: Option<[f64; 2]>,
    /// Momentum of the approach of the slave to the master, with the reduced mass of both [kg m/s].
    approach: Vec3,
    /// The steps that begin with r_n > 0, and their accumulated length [s].
    touches: ContactTime,
    touching: f64,
    /// Number of steps with contact, and of all steps.
    steps: [u64; 2],
    /// Location of the first contact [m].
    pub first_contact: Option<Vec3>,
}

impl ImpactForce {
    /// An empty accumulator with this kind of averaging; `approach` is the momentum of the slave's approach to the master, with the
    /// reduced mass of both [kg m/s].
    pub fn new(average: ForceAverage, approach: Vec3) -> Self {
        let sliding = match average {
            ForceAverage::Window(window) => Some(SlidingWindow::new(window)),
            ForceAverage::OfContact | ForceAverage::Filter(_) => None,
        };
        Self {
            average,
            sliding,
            history: ImpulseHistory::default(),
            now: PairSample::default(),
            sums: ImpulseSample::default(),
            peak_step: (0.0, 0.0),
            largest_patch: ContactPatch::default(),
            largest_patch_time: None,
            contact_span: None,
            approach,
            touches: ContactTime::default(),
            touching: 0.0,
            steps: [0; 2],
            first_contact: None,
        }
    }

    /// Latest sample of the pair.
    pub fn now(&self) -> PairSample {
        self.now
    }

    /// Whether the contact continues at the latest sample, be it between two touches of a stiff body that chatters.
    pub fn is_in_contact(&self) -> bool {
        self.now.patch.nodes > 0 || !self.touches.has_ended(self.now.time)
    }

    /// Time in contact so far [s].
    pub fn contact_time(&self) -> f64 {
        self.touches.duration()
    }

    /// Accumulates the sample of one step.
    pub fn accumulate(&mut self, sample: PairSample) {
        let before = self.now;
        self.steps[1] += 1;
        if before.patch.nodes > 0 {
            // An impulse below that which stops the approach along it leaves the bodies approaching.
            let is_approaching = before.impulse.norm_squared() < -self.approach.dot(&before.impulse);
            self.touches.add(before.time, sample.time, is_approaching);
            self.touching += sample.time - before.time;
            self.steps[0] += 1;
        }
        if sample.patch.nodes > 0 {
            let first = self.contact_span.map_or(sample.time, |span| span[0]);
            self.contact_span = Some([first, sample.time]);
            self.first_contact = self.first_contact.or(Some(sample.patch.centre));
        }
        if sample.patch.area > self.largest_patch.area {
            self.largest_patch = sample.patch;
        }
        if sample.patch.area > 0.0 && sample.patch.area >= self.largest_patch.area {
            self.largest_patch_time = Some(sample.time);
        }
        let step_force = sample.force.norm();
        if step_force > self.peak_step.0 {
            self.peak_step = (step_force, sample.time);
        }
        self.sums = self.sums.next(sample.time, sample.impulse, &before.patch, &sample.patch);
        match &mut self.sliding {
            Some(sliding) => sliding.accumulate(self.sums),
            None => self.history.accumulate(self.sums),
        }
        self.now = sample;
    }

    /// Mean step with contact [s]; before the first such step has ended, the mean of all steps.
    pub fn mean_step(&self) -> f64 {
        match self.steps {
            [0, 0] => 0.0,
            [0, all] => self.now.time / all as f64,
            [count, _] => self.touching / count as f64,
        }
    }

    /// The window that the force is averaged over [s]; `None` where it is filtered instead.
    pub fn window(&self) -> Option<f64> {
        (!matches!(self.average, ForceAverage::Filter(_))).then(|| self.touch_window())
    }

    /// The time for which a node counts as in contact after it was last pressed: that of the window over which the force is averaged, or
    /// would be if it were not filtered [s].
    pub fn touch_window(&self) -> f64 {
        match self.average {
            ForceAverage::Window(window) => window,
            ForceAverage::OfContact | ForceAverage::Filter(_) => {
                f64::max(FRACTION_OF_CONTACT * self.contact_time(), FEWEST_STEPS * self.mean_step())
            }
        }
    }

    /// Averaging requested by the scene.
    pub fn average(&self) -> ForceAverage {
        self.average
    }

    /// Peak force so far, averaged as the scene requests.
    pub fn peak(&self) -> PeakForce {
        match (self.average, &self.sliding) {
            (_, Some(sliding)) => sliding.peak(),
            (ForceAverage::Filter(filter), None) => filtered_peak(&self.history, filter.class()),
            (_, None) => self
                .window()
                .filter(|w| *w > 0.0)
                .map_or_else(PeakForce::default, |w| self.history.peak_over(w)),
        }
    }

    /// Impulse history from which the force over another window can be evaluated; `None` unless the window depends on
    /// the run.
    pub fn history(&self) -> Option<&ImpulseHistory> {
        (self.average == ForceAverage::OfContact).then_some(&self.history)
    }

    /// How the force was averaged, as text; a window that follows from the run has three digits.
    pub fn words(&self, seconds: impl Fn(f64) -> String) -> String {
        let of_run = |window: f64| seconds(format!("{window:.2e}").parse().unwrap_or(window));
        match (self.average, self.window()) {
            (ForceAverage::Filter(filter), _) => format!("filtered by SAE J211 {}", filter.name()),
            (ForceAverage::OfContact, Some(window)) if window > FRACTION_OF_CONTACT * self.contact_time() => {
                format!("mean over {}, {FEWEST_STEPS} steps", of_run(window))
            }
            (ForceAverage::OfContact, Some(window)) => {
                format!("mean over {}, 1/{:.0} of the contact", of_run(window), 1.0 / FRACTION_OF_CONTACT)
            }
            (_, window) => format!("mean over {}", seconds(window.unwrap_or_default())),
        }
    }
}

/// Resultant force on the slave of a pair in this step: Σ R_c / h̄ [N].
pub fn resultant_force(frame: &Frame, pair: u32) -> Vec3 {
    let mut impulse = Vec3::zeros();
    for (contact, reaction) in frame.contacts_of(pair) {
        for (axis, r) in contact.frame.iter().zip(reaction.impulse) {
            impulse += axis * r;
        }
    }
    if frame.mean_step > 0.0 { impulse / frame.mean_step } else { Vec3::zeros() }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::impulse_history::FEWEST_SAMPLES;
    use super::*;
    use crate::scene::document::ForceFilter;

    /// Accumulates a force F(t) with exact impulse I(t) = ∫F, averaged over a window.
    fn feed(window: f64, step: f64, end: f64, impulse: impl Fn(f64) -> f64) -> ImpactForce {
        feed_to(ForceAverage::Window(window), step, end, impulse)
    }

    /// Accumulates a force F(t) with exact impulse I(t) = ∫F, averaged as requested.
    fn feed_to(average: ForceAverage, step: f64, end: f64, impulse: impl Fn(f64) -> f64) -> ImpactForce {
        let mut measure = ImpactForce::new(average, Vec3::zeros());
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
        // A force of 7 N from 1 to 3 s.
        let measure = feed(0.5, 0.01, 5.0, |t| 7.0 * (t.clamp(1.0, 3.0) - 1.0));
        assert!((measure.peak().force - 7.0).abs() < 1e-12);
        assert!(measure.peak().time >= 1.2 && measure.peak().time <= 2.8);
        assert!((measure.contact_time() - 2.0).abs() < 0.03);
    }

    #[test]
    fn a_half_sine_is_averaged_over_the_window() {
        use std::f64::consts::PI;
        // F = sin(π t), I = (1 − cos π t)/π; a window of 0.2 about the peak averages sin(0.1 π)/(0.1 π).
        let measure = feed(0.2, 0.001, 1.0, |t| (1.0 - (PI * t.clamp(0.0, 1.0)).cos()) / PI);
        let exact = (0.1 * PI).sin() / (0.1 * PI);
        assert!((measure.peak().force - exact).abs() < 1e-6, "{} {exact}", measure.peak().force);
        assert!((measure.peak().time - 0.5).abs() < 2e-3);
        assert!(
            (measure.peak().patch.area - exact).abs() < 1e-5,
            "the patch is the mean over the window, too"
        );
        assert!((measure.peak_step.0 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_window_of_no_whole_number_of_steps_is_found_all_the_same() {
        // 1 N from 1.0 to 1.6 s, in steps of 0.4 s: the best window of 0.6 s begins at a sample, and no window ending
        // at one is as good.
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
        assert!((measure.peak().force - best / 0.6).abs() < 1e-9, "{} {}", measure.peak().force, best / 0.6);
    }

    #[test]
    fn a_window_is_a_tenth_of_the_contact_and_ten_steps_at_least() {
        use std::f64::consts::PI;
        let impulse = |t: f64| (1.0 - (PI * t.clamp(0.0, 1.0)).cos()) / PI;
        // Contact of 1 s: a window of 0.1 s, over which the mean at the peak is sin(0.05 π)/(0.05 π). Idle time
        // afterwards changes nothing.
        for end in [1.5, 9.0] {
            let fine = feed_to(ForceAverage::OfContact, 1e-4, end, impulse);
            assert!((fine.window().unwrap() - 0.1).abs() < 1e-5, "{:?}", fine.window());
            let exact = (0.05 * PI).sin() / (0.05 * PI);
            assert!((fine.peak().force - exact).abs() < 1e-6 && (fine.peak().time - 0.5).abs() < 1e-3);
        }
        // Steps of 20 ms: the window is ten of them.
        let coarse = feed_to(ForceAverage::OfContact, 0.02, 1.5, impulse);
        assert!((coarse.window().unwrap() - 0.2).abs() < 1e-12);
        assert!(coarse.words(|s| format!("{s:.1} s")).contains("0.2 s, 10 steps"));
        // Half-way: half of the contact, hence half of the window.
        let half = feed_to(ForceAverage::OfContact, 1e-4, 0.5, impulse);
        assert!((half.window().unwrap() - 0.05).abs() < 1e-5);
    }

    #[test]
    fn a_long_history_is_thinned_without_losing_impulse() {
        use std::f64::consts::PI;
        // 200 000 steps of contact: some ten thousand samples are kept, and the force over a tenth is unchanged.
        let impulse = |t: f64| (1.0 - (PI * t.clamp(0.0, 1.0)).cos()) / PI;
        let measure = feed_to(ForceAverage::OfContact, 5e-6, 1.0, impulse);
        let kept = measure.history().unwrap().samples();
        assert!((FEWEST_SAMPLES..2 * FEWEST_SAMPLES).contains(&kept.len()), "{}", kept.len());
        let last = kept.last().unwrap();
        assert!((last.time - 1.0).abs() < 1e-9 && (last.impulse.z - 2.0 / PI).abs() < 1e-9);
        let exact = (0.05 * PI).sin() / (0.05 * PI);
        assert!((measure.peak().force - exact).abs() < 1e-6, "{}", measure.peak().force);
    }

    #[test]
    fn a_class_filters_the_force() {
        // 100 N for 50 ms: CFC 1000 passes the plateau; 2 N s in 0.1 ms through CFC 60: the impulse response of the
        // filter.
        let plateau = |t: f64| 100.0 * (t - 0.01).clamp(0.0, 0.05);
        let wide = feed_to(ForceAverage::Filter(ForceFilter::Cfc1000), 1e-4, 0.1, plateau);
        assert!((wide.peak().force / 100.0 - 1.0).abs() < 0.1, "{}", wide.peak().force);
        assert!(wide.window().is_none() && wide.words(|_| String::new()).contains("CFC 1000"));
        let blow = |t: f64| 2.0 * ((t - 0.01) / 1e-4).clamp(0.0, 1.0);
        let narrow = feed_to(ForceAverage::Filter(ForceFilter::Cfc60), 1e-5, 0.1, blow);
        let exact = 2.0 * std::f64::consts::PI * 2.0775 * 60.0 / 2.0_f64.sqrt();
        assert!((narrow.peak().force / exact - 1.0).abs() < 0.01, "{} {exact}", narrow.peak().force);
        assert!((narrow.peak().time - 0.01005).abs() < 1e-3, "nothing is delayed: {}", narrow.peak().time);
    }

    #[test]
    fn a_spike_counts_as_its_impulse_over_the_window() {
        // 1 N s between t = 0.999 and 1: 1000 N in a step, 10 N over a window of 0.1 s.
        let measure = feed(0.1, 0.001, 2.0, |t| ((t - 0.999) * 1000.0).clamp(0.0, 1.0));
        assert!((measure.peak().force - 10.0).abs() < 1e-9, "{}", measure.peak().force);
        // The window reaches back before contact, its middle does not.
        assert!((0.999..=1.0).contains(&measure.peak().time), "{}", measure.peak().time);
    }
}
