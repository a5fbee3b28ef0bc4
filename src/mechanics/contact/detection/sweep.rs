//! Which of many boxes a box meets, by a sweep along the longest axis.

use crate::tensor::Vec3;

/// Boxes in the order of their low ends, with buffers that are kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Sweep {
    /// Low and high corner of each box [m], and its number.
    sorted: Vec<([Vec3; 2], u32)>,
    /// Axis of the order.
    axis: usize,
    /// Longest box along it [m].
    longest: f64,
    met: Vec<u32>,
}

impl Sweep {
    /// Room for so many boxes.
    pub fn with_capacity(most: usize) -> Self {
        Self { sorted: Vec::with_capacity(most), met: Vec::with_capacity(most), ..Self::default() }
    }

    /// Sorts boxes, whose numbers are their places.
    pub fn sort(&mut self, boxes: impl Iterator<Item = [Vec3; 2]>) {
        self.sorted.clear();
        self.sorted.extend(boxes.zip(0..));
        let all = self.sorted.iter().map(|(of_it, _)| *of_it).reduce(|[a, b], [c, d]| [a.inf(&c), b.sup(&d)]);
        self.axis = all.map_or(0, |[low, high]| (high - low).imax());
        let axis = self.axis;
        self.longest = self.sorted.iter().map(|([low, high], _)| high[axis] - low[axis]).fold(0.0, f64::max);
        self.sorted.sort_unstable_by(|([a, _], i), ([b, _], j)| a[axis].total_cmp(&b[axis]).then(i.cmp(j)));
    }

    /// Numbers of the boxes that meet this one, of the first `count`, ascending.
    pub fn met_by(&mut self, [low, high]: &[Vec3; 2], count: usize) -> &[u32] {
        let Self { sorted, axis, longest, met } = self;
        let axis = *axis;
        let first = sorted.partition_point(|([l, _], _)| l[axis] < low[axis] - *longest);
        met.clear();
        met.extend(
            sorted[first..]
                .iter()
                .take_while(|([l, _], _)| l[axis] <= high[axis])
                .filter(|([l, h], number)| {
                    (*number as usize) < count && (0..3).all(|i| l[i] <= high[i] && low[i] <= h[i])
                })
                .map(|(_, number)| *number),
        );
        met.sort_unstable();
        met
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_that_meet_are_those_of_the_plain_search() {
        let wave = |i: usize, k: usize| (i as f64 * [1.7, 2.9, 0.61][k]).sin();
        let of = |i: usize| {
            let low = Vec3::new(wave(i, 0) * 4.0, wave(i, 1), wave(i, 2));
            [low, low + Vec3::new(0.3 + 0.2 * wave(i, 1), 0.3, 0.2)]
        };
        let mut sweep = Sweep::with_capacity(0);
        for n in [0, 1, 40, 200] {
            sweep.sort((0..n).map(of));
            let mut found = 0;
            for (probe, count) in (0..60).flat_map(|i| [(of(i + 1000), n), (of(i + 2000), n / 3)]) {
                let meets = |other: [Vec3; 2]| {
                    (0..3).all(|i| probe[0][i] <= other[1][i] && other[0][i] <= probe[1][i])
                };
                let expected: Vec<u32> = (0..count as u32).filter(|i| meets(of(*i as usize))).collect();
                assert_eq!(sweep.met_by(&probe, count), expected);
                found += expected.len();
            }
            assert!(n < 40 || found > n / 8, "{found}");
        }
    }
}
