//! The volume in which a field exceeds a value, and the value that it exceeds in a volume.
//!
//! The largest value of a field at a point may grow with every refinement of the mesh, at an edge of the contact patch for
//! instance. The value exceeded in a given volume, a quantile of the distribution of the field over the volume, has a
//! limit wherever the field itself has one almost everywhere.

use std::f64::consts::PI;

/// The volume in which a measure exceeds a threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dose {
    /// Threshold, in the unit of the measure.
    pub threshold: f64,
    /// Reference volume above it at the latest field time [m³].
    pub volume: f64,
    /// Largest such volume at any field time so far [m³].
    pub largest_volume: f64,
    /// Largest volume represented by one of the points above the threshold, at any field time so far [m³].
    pub largest_point: f64,
}

impl Dose {
    /// Doses above each of some thresholds.
    pub fn of(thresholds: &[f64]) -> Vec<Self> {
        thresholds.iter().map(|&threshold| Self { threshold, ..Self::default() }).collect()
    }

    /// Begins a pass over all points.
    pub fn begin(&mut self) {
        self.volume = 0.0;
    }

    /// Adds a point, with its reference volume [m³], to doses in ascending order of their thresholds.
    pub fn add(doses: &mut [Self], value: f64, volume: f64) {
        for dose in doses.iter_mut().take_while(|dose| value > dose.threshold) {
            dose.volume += volume;
            dose.largest_point = dose.largest_point.max(volume);
        }
    }

    /// Ends a pass: keeps the largest volume so far.
    pub fn end(&mut self) {
        self.largest_volume = self.largest_volume.max(self.volume);
    }
}

/// Uncertainty of a volume that is a sum over points whose cubes have edges of this length: half an edge in both
/// directions, all around a ball of that volume, whose surface is the smallest.
pub fn sampling_error(volume: f64, point_spacing: f64) -> f64 {
    0.5 * point_spacing * (36.0 * PI * volume.powi(2)).cbrt()
}

/// Points that a volume must have for its value to be no peak at a few of them: those of eight hexahedra.
const ENOUGH_POINTS: f64 = 64.0;

/// The largest value reached by points that together represent a given volume, maximum over the field times.
///
/// At one time, with the points in descending order, it is the value at which the sum of their reference volumes reaches
/// the given one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExceededIn {
    /// Volume in which the value is exceeded [m³].
    pub volume: f64,
    /// The value so far; 0 until the points that exceed 0 represent the volume.
    pub value: f64,
    /// Field time of that value [s].
    pub time: f64,
    /// Largest volume represented by one of the points at that time [m³].
    largest_point: f64,
    /// The same in a volume that is larger by its [`sampling_error`].
    outer: f64,
    /// Values above `outer` in the current pass, with their volumes: no others can raise it.
    points: Vec<(f64, f64)>,
}

impl ExceededIn {
    /// The value exceeded in a volume [m³].
    pub fn new(volume: f64) -> Self {
        Self { volume, ..Self::default() }
    }

    /// How far the value is known: its difference from that in a volume larger by the sampling error.
    pub fn resolution(&self) -> f64 {
        self.value - self.outer
    }

    /// Whether only a few points represent the volume: then the value is no better than a peak at a point.
    pub fn is_peak(&self) -> bool {
        ENOUGH_POINTS * self.largest_point > self.volume
    }

    /// Begins a pass over all points.
    pub fn begin(&mut self) {
        self.points.clear();
    }

    /// Adds a point, with its reference volume [m³].
    pub fn add(&mut self, value: f64, volume: f64) {
        if value > self.outer {
            self.points.push((value, volume));
        }
    }

    /// Ends the pass, at a time [s].
    pub fn end(&mut self, time: f64) {
        self.points.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let (mut sum, mut largest_point, mut wanted) = (0.0, 0.0_f64, self.volume);
        for &(value, volume) in &self.points {
            sum += volume;
            largest_point = largest_point.max(volume);
            if wanted <= self.volume && sum >= wanted {
                // The volume itself is reached.
                if value > self.value {
                    (self.value, self.time, self.largest_point) = (value, time, largest_point);
                }
                wanted += sampling_error(self.volume, largest_point.cbrt());
            }
            if wanted > self.volume && sum >= wanted {
                self.outer = self.outer.max(value);
                break;
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;

    /// Points of equal volume on a line, at whose middles a field is evaluated.
    fn sampled(count: u32, field: impl Fn(f64) -> f64) -> ExceededIn {
        let mut exceeded = ExceededIn::new(0.1);
        exceeded.begin();
        for i in 0..count {
            exceeded.add(field((f64::from(i) + 0.5) / f64::from(count)), 1.0 / f64::from(count));
        }
        exceeded.end(1.0);
        exceeded
    }

    #[test]
    fn it_has_a_limit_where_the_peak_has_none() {
        // x^(−1/2) exceeds √10 in x < 1/10; its peak √(2 n) has no limit.
        for count in [15, 64, 1001, 8192] {
            let found = sampled(count, |x| x.powf(-0.5));
            let error = (found.value - 10_f64.sqrt()).abs();
            assert!(error < 20.0 / f64::from(count) && error < found.resolution(), "{count}: {found:?}");
            assert_eq!(found.is_peak(), count < 640, "{count} points, a tenth of them in the volume");
        }
    }

    #[test]
    fn it_is_the_maximum_over_time() {
        let mut exceeded = ExceededIn::new(2.0);
        for (time, values) in [(1.0, [3.0, 5.0, 4.0]), (2.0, [9.0, 2.0, 1.0]), (3.0, [4.5, 6.0, 0.0])] {
            exceeded.begin();
            for value in values {
                exceeded.add(value, 1.0);
            }
            exceeded.end(time);
        }
        assert_eq!((exceeded.value, exceeded.time), (4.5, 3.0));
        // Half the edge of a cube around a ball of 2 m³ is more than the third point.
        assert_eq!(exceeded.resolution(), 4.5);
    }

    #[test]
    fn points_that_do_not_fill_the_volume_exceed_nothing_in_it() {
        let mut exceeded = ExceededIn::new(2.0);
        exceeded.begin();
        exceeded.add(7.0, 1.5);
        exceeded.end(1.0);
        assert_eq!((exceeded.value, exceeded.resolution()), (0.0, 0.0));
    }

    /// A ball of radius 10 sampled by a grid of spacing 1: wherever it lies, the sum of the cell volumes has an error of less
    /// than half a spacing times its surface.
    #[test]
    fn a_sampled_volume_is_known_to_half_a_spacing_all_around() {
        let exact = 4.0 / 3.0 * PI * 1000.0;
        for shift in [0.0, 0.1, 0.25, 0.4, 0.5] {
            let line = || (-12..=12).map(|i| f64::from(i) + shift);
            let inside = |x: f64, y: f64| line().filter(|z| x * x + y * y + z * z < 100.0).count();
            let count: usize =
                line().flat_map(|x| line().map(move |y| (x, y))).map(|(x, y)| inside(x, y)).sum();
            let (sampled, error) = (count as f64, sampling_error(count as f64, 1.0));
            assert!((sampled - exact).abs() < error, "{sampled} ± {error} of {exact}");
            assert!((error / (0.5 * 4.0 * PI * 100.0) - 1.0).abs() < 0.02, "{error}");
        }
        assert!(sampling_error(0.0, 1.0) <= 0.0, "nothing has no surface");
    }
}
