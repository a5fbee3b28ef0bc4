//! The force of a recorded contact pair, averaged over time as in the summary.

use super::read::{RecordedPair, Series};
use crate::measure::channel_class::filtered_force;
use crate::scene::document::ForceFilter;

/// Averaging of a force over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Average {
    /// Over a window of this length [s].
    Window(f64),
    /// Filtered instead of averaged.
    Filter(ForceFilter),
}

/// Largest product of duration and filter class of a filtered recording [-]; scenes beyond it are refused.
const LONGEST_FILTERED: f64 = 1e3;

impl RecordedPair {
    /// Averaged force at each time [N]; empty where the recording is too long to be filtered.
    pub fn averaged_force(&self, average: Average) -> Series {
        let filter = match average {
            Average::Window(window) => return self.windowed_force(window),
            Average::Filter(filter) => filter,
        };
        let (Some(&first), Some(&last)) = (self.time_s.first(), self.time_s.last()) else {
            return Series::new();
        };
        let is_short = last >= first && (last - first) * filter.class() <= LONGEST_FILTERED;
        if !is_short {
            return Series::new();
        }
        // Filter, then take the nearest sample for each recorded time.
        let forces = filtered_force(|time| self.impulse_at(time).into(), [first, last], filter.class());
        let at = |&time: &f64| {
            let nearest = forces.partition_point(|(t, _)| *t < time).min(forces.len() - 1);
            (time, forces[nearest].1.norm())
        };
        self.time_s.iter().map(at).collect()
    }

    /// Mean force over a window that ends at each time, |I(t) − I(t − τ)|/τ [N], assigned to the middle of the window.
    pub fn windowed_force(&self, window: f64) -> Series {
        let force = |(&time, impulse): (&f64, &[f64; 3])| {
            let before = self.impulse_at(time - window);
            let squares = impulse.iter().zip(before).map(|(now, before)| (now - before).powi(2)).sum::<f64>();
            ((time - 0.5 * window).max(0.0), squares.sqrt() / window)
        };
        self.time_s.iter().zip(&self.impulse_n_s).map(force).collect()
    }

    /// Linear interpolation; zero before the start.
    fn impulse_at(&self, time: f64) -> [f64; 3] {
        let after = self.time_s.partition_point(|t| *t < time);
        let Some(before) = after.checked_sub(1) else { return [0.0; 3] };
        let (a, b) = (self.impulse_n_s[before], self.impulse_n_s[after.min(self.impulse_n_s.len() - 1)]);
        let (from, to) = (self.time_s[before], self.time_s[after.min(self.time_s.len() - 1)]);
        let fraction = if to > from { (time - from) / (to - from) } else { 0.0 };
        std::array::from_fn(|i| a[i] + fraction * (b[i] - a[i]))
    }
}
