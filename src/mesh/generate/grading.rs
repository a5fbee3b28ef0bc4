//! Positions of nodes along a line: uniform, or graded towards a point.

/// Growth of the element size away from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grading {
    /// Size ratio of the element farthest from the point to the smallest one [-], ≥ 1.
    pub ratio: f64,
    /// Distance from the point within which all elements are smallest [m], ≥ 0.
    pub uniform_within: f64,
}

impl Grading {
    /// Elements of equal size.
    pub const UNIFORM: Self = Self { ratio: 1.0, uniform_within: 0.0 };

    /// Elements that grow from the point on, without a uniform region.
    pub fn from_point(ratio: f64) -> Self {
        Self { ratio, uniform_within: 0.0 }
    }
}

/// `count + 1` positions from `low` to `high`, with elements smallest at `focus` and growing away from it.
///
/// The element size is h ∝ 1 up to the distance w = `uniform_within` from the focus and grows linearly beyond,
/// h ∝ 1 + g (d − w), g = (ρ − 1)/(D − w), to ρ at the farthest end D. The positions divide the count, N(d) = d up to w and
/// w + ln(1 + g (d − w))/g beyond, equally. The positions for `2 count` therefore contain those for `count`: the meshes of
/// a study are nested. (The focus itself is a node only if it lies half way and `count` is even: forcing one there would
/// break the nesting.) `ratio` ≥ 1; the focus must lie between the ends.
pub fn graded(low: f64, high: f64, focus: f64, grading: Grading, count: u32) -> Vec<f64> {
    let farthest = (focus - low).max(high - focus);
    let plateau = grading.uniform_within.min(farthest);
    // No growth where the uniform region reaches the ends.
    let growth = if plateau < farthest { (grading.ratio - 1.0) / (farthest - plateau) } else { 0.0 };
    // Signed number of elements between the focus and x, and its inverse; linear in the limit of no growth.
    let elements = |x: f64| {
        let d = (x - focus).abs();
        let beyond = d - plateau;
        let of = if growth > 0.0 && beyond > 0.0 { plateau + (growth * beyond).ln_1p() / growth } else { d };
        of.copysign(x - focus)
    };
    let position = |n: f64| {
        let beyond = n.abs() - plateau;
        let d = if growth > 0.0 && beyond > 0.0 {
            plateau + (growth * beyond).exp_m1() / growth
        } else {
            n.abs()
        };
        focus + d.copysign(n)
    };
    let (first, last) = (elements(low), elements(high));
    (0..=count)
        .map(|i| match i {
            0 => low,
            i if i == count => high,
            i => position(first + (last - first) * f64::from(i) / f64::from(count)),
        })
        .collect()
}

/// Each interval between ascending positions divided into `factor` equal ones.
pub(super) fn subdivided(positions: &[f64], factor: u32) -> Vec<f64> {
    let mut out: Vec<f64> = positions
        .windows(2)
        .flat_map(|w| (0..factor).map(|i| w[0] + (w[1] - w[0]) * f64::from(i) / f64::from(factor)))
        .collect();
    out.extend(positions.last());
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ratio_one_is_uniform() {
        for (i, x) in graded(-1.0, 3.0, 0.5, Grading::UNIFORM, 8).iter().enumerate() {
            assert!((x - (-1.0 + 0.5 * i as f64)).abs() < 1e-14);
        }
    }

    #[test]
    fn the_largest_element_is_ratio_times_the_smallest_in_the_limit_of_many() {
        let x = graded(0.0, 2.0, 0.5, Grading::from_point(5.0), 4000);
        let sizes: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((sizes[3999] / smallest - 5.0).abs() < 0.01);
    }

    #[test]
    fn elements_are_uniform_within_the_plateau_and_grow_to_the_ratio_beyond() {
        let x = graded(-1.0, 1.0, 0.0, Grading { ratio: 6.0, uniform_within: 0.25 }, 2000);
        let sizes: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        let inside: Vec<f64> =
            x.windows(2).filter(|w| w[0] > -0.25 && w[1] < 0.25).map(|w| w[1] - w[0]).collect();
        assert!(inside.len() > 400 && inside.iter().all(|s| (s / inside[0] - 1.0).abs() < 1e-9));
        assert!((sizes[0] / inside[0] - 6.0).abs() < 0.02);
    }

    proptest! {
        #[test]
        fn positions_ascend_and_are_nested(
            focus in 0.0..1.0_f64, ratio in 1.0..50.0_f64, uniform_within in 0.0..1.2_f64, count in 1_u32..20,
        ) {
            let grading = Grading { ratio, uniform_within };
            let coarse = graded(0.0, 1.0, focus, grading, count);
            let fine = graded(0.0, 1.0, focus, grading, 2 * count);
            prop_assert!(fine.windows(2).all(|w| w[0] < w[1]));
            prop_assert_eq!((fine[0], fine[2 * count as usize]), (0.0, 1.0));
            for (i, x) in coarse.iter().enumerate() {
                prop_assert!((x - fine[2 * i]).abs() < 1e-12);
            }
        }
    }
}
