//! Strain rates of the points of a part, beside those of the tests of its law.

use crate::mechanics::force::PointBatch;
use std::ops::Range;

/// The points of an element, a bit each, that have been deformed as fast as in the slowest test, and faster than in any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reached {
    slowest: u8,
    beyond: u8,
}

/// Strain rates of one part: each point counts by the largest that it had so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartRates {
    /// Slowest and fastest test [1/s]; `None` where they are not given.
    pub tested: Option<[f64; 2]>,
    /// Largest strain rate of a point so far [1/s]; 0 where the plan compares none.
    pub largest: f64,
    /// Reference volume of the points that have been as fast as the slowest test [m³].
    reached: f64,
    /// Reference volume of the points that have been faster than any test [m³].
    pub faster: f64,
}

impl PartRates {
    /// No rates yet, beside those of the slowest and the fastest test [1/s].
    pub fn of(tested: Option<[f64; 2]>) -> Self {
        Self { tested, ..Self::default() }
    }

    /// Volume of the points that have always been slower than the slowest test, of a part of a reference volume [m³].
    pub fn slower(&self, volume: f64) -> f64 {
        // Nothing is slower than a test at rest, moved or not.
        let is_compared = self.tested.is_some_and(|[slowest, _]| slowest > 0.0);
        if is_compared { (volume - self.reached).max(0.0) } else { 0.0 }
    }

    /// Accumulates the points in some lanes of a batch, each of them for a number of images; `reached` has those of all its lanes.
    pub fn accumulate(
        &mut self,
        reached: &mut [Reached],
        lanes: Range<usize>,
        points: &PointBatch,
        images: f64,
    ) {
        let [slowest, fastest] = self.tested.unwrap_or([f64::INFINITY; 2]);
        for lane in lanes {
            for q in 0..points.count {
                let (rate, volume) = (points.strain_rate[q][lane], images * points.volume[q][lane]);
                self.largest = self.largest.max(rate);
                if rate >= slowest && mark(&mut reached[lane].slowest, q) {
                    self.reached += volume;
                }
                if rate > fastest && mark(&mut reached[lane].beyond, q) {
                    self.faster += volume;
                }
            }
        }
    }
}

/// Sets the bit of a point; whether it was not set before.
fn mark(bits: &mut u8, point: usize) -> bool {
    let bit = 1 << point;
    let is_new = *bits & bit == 0;
    *bits |= bit;
    is_new
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points of 1 m³ in the only lane that counts, with these rates.
    fn points(rates: [f64; 2]) -> PointBatch {
        let mut points = PointBatch { count: 2, ..PointBatch::default() };
        for (q, rate) in rates.into_iter().enumerate() {
            (points.strain_rate[q][0], points.volume[q][0]) = (rate, 1.0);
        }
        points
    }

    #[test]
    #[allow(clippy::float_cmp)] // sums of ones are exact
    fn a_point_counts_by_its_own_largest_rate() {
        let mut rates = PartRates::of(Some([10.0, 100.0]));
        let mut reached = [Reached::default()];
        let found = |rates: &PartRates| (rates.slower(4.0), rates.faster);
        for (at, expected) in [
            ([5.0, 5.0], (4.0, 0.0)),
            ([50.0, 5.0], (3.0, 0.0)),
            // What was fast once stays so, and counts once.
            ([5.0, 200.0], (2.0, 1.0)),
            ([50.0, 200.0], (2.0, 1.0)),
            ([101.0, 0.0], (2.0, 2.0)),
        ] {
            rates.accumulate(&mut reached, 0..1, &points(at), 1.0);
            assert_eq!(found(&rates), expected, "{at:?}");
        }
        assert_eq!(rates.largest, 200.0);
    }

    #[test]
    #[allow(clippy::float_cmp)]
    fn nothing_is_slower_than_tests_at_rest_or_than_none() {
        for tested in [None, Some([0.0, 100.0])] {
            let mut rates = PartRates::of(tested);
            rates.accumulate(&mut [Reached::default()], 0..1, &points([5.0, 0.0]), 1.0);
            assert_eq!((rates.slower(4.0), rates.faster, rates.largest), (0.0, 0.0, 5.0), "{tested:?}");
        }
    }
}
