//! Student's t distribution for a whole number of degrees of freedom.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// The t with the fraction `probability` of the distribution in −t … t, 0 < probability < 1, for `degrees` ≥ 1 degrees of freedom.
pub fn two_sided_quantile(probability: f64, degrees: usize) -> f64 {
    // By bisection of the angle θ with t = √ν tan θ, in which the probability grows from 0 to 1.
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if probability_within(middle, degrees) < probability { low = middle } else { high = middle }
    }
    (degrees as f64).sqrt() * (0.5 * (low + high)).tan()
}

/// Fraction of the distribution in −t … t (Abramowitz & Stegun, 26.7.3 and 26.7.4): with c = cos θ
///
/// ```text
/// ν odd:   2/π (θ + sin θ (c + 2/3 c³ + … + 2·4…(ν−3)/(3·5…(ν−2)) c^(ν−2)))
/// ν even:  sin θ (1 + 1/2 c² + … + 1·3…(ν−3)/(2·4…(ν−2)) c^(ν−2))
/// ```
fn probability_within(theta: f64, degrees: usize) -> f64 {
    let c = theta.cos();
    let is_odd = degrees % 2 == 1;
    let (mut term, mut sum, mut power) = if is_odd { (c, c, 1) } else { (1.0, 1.0, 0) };
    if degrees == 1 {
        return FRAC_2_PI * theta;
    }
    while power + 4 <= degrees {
        term *= (power as f64 + 1.0) / (power as f64 + 2.0) * c * c;
        sum += term;
        power += 2;
    }
    if is_odd { FRAC_2_PI * (theta + theta.sin() * sum) } else { theta.sin() * sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun, table 26.10, A = 0.95 and 0.99.
        for (degrees, at_95, at_99) in [
            (1, 12.706, 63.657),
            (2, 4.303, 9.925),
            (3, 3.182, 5.841),
            (4, 2.776, 4.604),
            (5, 2.571, 4.032),
            (10, 2.228, 3.169),
            (29, 2.045, 2.756),
            (30, 2.042, 2.750),
            (120, 1.980, 2.617),
        ] {
            assert!((two_sided_quantile(0.95, degrees) - at_95).abs() < 6e-4, "{degrees}");
            assert!((two_sided_quantile(0.99, degrees) - at_99).abs() < 6e-4, "{degrees}");
        }
        // The normal distribution.
        assert!((two_sided_quantile(0.95, 100_000) - 1.959_964).abs() < 3e-5);
    }
}
