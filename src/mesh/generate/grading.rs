//! Where the nodes of a line lie: uniform, or finer towards a point.

/// `count + 1` positions from `low` to `high`, elements smallest at `focus` and `ratio` times as large at the end
/// farthest from it.
///
/// The element size grows linearly with the distance d from the focus, h ∝ 1 + (ρ − 1) d/D with D the farthest end, and
/// the positions share its count N(d) = D/(ρ − 1) ln(1 + (ρ − 1) d/D) equally. So the positions for `2 count` hold those
/// for `count`: meshes of a study are nested. (A node at the focus itself comes only of itself when it lies half way and
/// `count` is even: forcing one there would break the nesting.) `ratio` ≥ 1; the focus must lie between the ends.
pub fn graded(low: f64, high: f64, focus: f64, ratio: f64, count: u32) -> Vec<f64> {
    let farthest = (focus - low).max(high - focus);
    let growth = (ratio - 1.0) / farthest;
    // Signed number of elements between the focus and x, and its inverse; linear as the growth vanishes.
    let elements = |x: f64| {
        let d = (x - focus).abs();
        (if growth > 0.0 { (growth * d).ln_1p() / growth } else { d }).copysign(x - focus)
    };
    let position = |n: f64| {
        let d = if growth > 0.0 { (growth * n.abs()).exp_m1() / growth } else { n.abs() };
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

/// Each interval of ascending positions cut into `factor` equal pieces.
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
        for (i, x) in graded(-1.0, 3.0, 0.5, 1.0, 8).iter().enumerate() {
            assert!((x - (-1.0 + 0.5 * i as f64)).abs() < 1e-14);
        }
    }

    #[test]
    fn the_largest_element_is_ratio_times_the_smallest_in_the_limit_of_many() {
        let x = graded(0.0, 2.0, 0.5, 5.0, 4000);
        let sizes: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((sizes[3999] / smallest - 5.0).abs() < 0.01);
    }

    proptest! {
        #[test]
        fn positions_ascend_and_are_nested(
            focus in 0.0..1.0_f64, ratio in 1.0..50.0_f64, count in 1_u32..20,
        ) {
            let coarse = graded(0.0, 1.0, focus, ratio, count);
            let fine = graded(0.0, 1.0, focus, ratio, 2 * count);
            prop_assert!(fine.windows(2).all(|w| w[0] < w[1]));
            prop_assert_eq!((fine[0], fine[2 * count as usize]), (0.0, 1.0));
            for (i, x) in coarse.iter().enumerate() {
                prop_assert!((x - fine[2 * i]).abs() < 1e-12);
            }
        }
    }
}
