//! Quantiles: parameter values for fractions of a population.

use super::document::{Change, Distribution, ParameterDocument};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Fraction of the population below the default low end; the high end is symmetric.
const LOW_END: f64 = 0.05;

impl ParameterDocument {
    /// Range of the parameter; `None` if neither its ends nor a distribution are given.
    pub fn range(&self) -> Option<[f64; 2]> {
        // Between sources, the ends are theirs.
        let low_end =
            if matches!(self.distribution, Some(Distribution::Library { .. })) { 0.0 } else { LOW_END };
        let of = |probability: f64| self.distribution.as_ref()?.quantile(probability, &self.change);
        Some([self.low.or_else(|| of(low_end))?, self.high.or_else(|| of(1.0 - low_end))?])
    }

    /// Value below which a fraction of the population lies, 0 < probability < 1; `None` without a range.
    pub fn quantile(&self, probability: f64) -> Option<f64> {
        if let Some(distribution) = &self.distribution {
            return distribution.quantile(probability, &self.change);
        }
        let [low, high] = self.range()?;
        Some(low + (high - low) * probability)
    }
}

impl Distribution {
    /// Value of a change below which a fraction of the population lies, 0 < probability < 1; `None` where the library states none.
    pub fn quantile(&self, probability: f64, change: &Change) -> Option<f64> {
        Some(match self {
            Self::Normal { mean, standard_deviation } => {
                mean + standard_deviation * normal_quantile(probability)
            }
            Self::LogNormal { median, coefficient_of_variation } => {
                median * (log_sigma(*coefficient_of_variation) * normal_quantile(probability)).exp()
            }
            Self::Library { set } => {
                let [least, most] = change.spread_in(set)?;
                least * (most / least).powf(probability)
            }
        })
    }
}

/// Standard deviation of the logarithm of a log-normal variable: √ln(1 + CV²).
pub fn log_sigma(coefficient_of_variation: f64) -> f64 {
    coefficient_of_variation.powi(2).ln_1p().sqrt()
}

/// Quantile of the standard normal distribution, Φ⁻¹(p), 0 < p < 1; infinite at the ends.
///
/// Newton's iteration on Φ(x) = ½ erfc(−x/√2) from the logistic approximation; in the lower half, where Φ keeps its
/// relative accuracy, and by symmetry in the upper.
pub fn normal_quantile(p: f64) -> f64 {
    const ITERATIONS: usize = 50;
    if p > 0.5 {
        return -normal_quantile(1.0 - p);
    }
    if !(p > 0.0) {
        return if p == 0.0 { f64::NEG_INFINITY } else { f64::NAN };
    }
    let mut x = (p / (1.0 - p)).ln() / 1.702;
    for _ in 0..ITERATIONS {
        let below = 0.5 * libm::erfc(-x * FRAC_1_SQRT_2);
        // On the logarithm of Φ, which is concave: the iteration converges monotonically.
        let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
        let step = (below / p).ln() * below / density;
        x -= step;
        if step.abs() <= 1e-15 * x.abs().max(1.0) {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // R: qnorm(c(0.5, 0.95, 0.05, 0.975, 1e-10)).
        let table = [
            (0.5, 0.0),
            (0.95, 1.644_853_626_951_472_6),
            (0.05, -1.644_853_626_951_472_6),
            (0.975, 1.959_963_984_540_054),
            (1e-10, -6.361_340_902_404_056),
        ];
        for (p, exact) in table {
            assert!((normal_quantile(p) - exact).abs() < 1e-12, "{p}: {} {exact}", normal_quantile(p));
        }
    }

    #[test]
    fn log_normal_numbers_have_their_median_and_variation() {
        let distribution = Distribution::LogNormal { median: 3.0, coefficient_of_variation: 0.5 };
        let quantile = |probability: f64| {
            distribution.quantile(probability, &Change::Friction { between: None }).unwrap()
        };
        assert!((quantile(0.5) - 3.0).abs() < 1e-15);
        // Mean and standard deviation by the midpoint rule over quantiles.
        let n = 200_000;
        let values = || (0..n).map(|i| quantile((f64::from(i) + 0.5) / f64::from(n)));
        let mean = values().sum::<f64>() / f64::from(n);
        let variance = values().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(n);
        assert!((variance.sqrt() / mean - 0.5).abs() < 2e-3, "{}", variance.sqrt() / mean);
    }

    #[test]
    fn between_sources_values_are_spread_evenly_in_their_logarithm() {
        let fat = ParameterDocument {
            name: "fat".into(),
            change: Change::StiffnessFactor { body: "thigh".into(), part: "fat".into() },
            low: None,
            high: None,
            distribution: Some(Distribution::Library { set: "fat/engelbrektsson_2011_ogden".into() }),
        };
        // 3.04 to 5.15 kPa before any relaxation, of which the set has 3.3: 0.3 that stay, ten times that in its branch.
        let [low, high] = fat.range().unwrap();
        assert!((low - 3040.0 / 3300.0).abs() < 1e-12 && (high - 5150.0 / 3300.0).abs() < 1e-12);
        assert!((fat.quantile(0.5).unwrap() - (3040.0_f64 * 5150.0).sqrt() / 3300.0).abs() < 1e-12);
        let other = ParameterDocument { change: Change::Friction { between: None }, ..fat };
        assert_eq!(other.range(), None);
    }
}
