//! Statistics over many cases: sensitivities, spread, correlations, Sobol indices.

use super::sampling::Random;
use crate::measure::QuantityOfInterest;
use serde::Serialize;

/// Number of bootstrap samples for an interval.
const RESAMPLES: usize = 1000;
/// Tail probability on each side of an interval: 90 % lie within.
const TAIL: f64 = 0.05;
/// Relative differences below this are rounding.
const ROUNDING: f64 = 1e-12;

/// Effect of one parameter on one number, with the others as in the base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Number affected by the parameter.
    pub quantity: QuantityOfInterest,
    /// Name of the parameter.
    pub parameter: String,
    /// Parameter at the low end, in the base, and at the high end.
    pub parameter_values: [f64; 3],
    /// Value of the number at each of these.
    pub values: [f64; 3],
    /// Change of the number from the low to the high end.
    pub change: f64,
    /// Whether the base lies within the range. If not, it is excluded from `span`, `is_monotone` and `elasticity`.
    pub is_base_in_range: bool,
    /// Largest difference among the three values: exceeds |change| if the response is not monotonic.
    pub span: f64,
    /// `change` over the range of the parameter: change per unit.
    pub per_unit: f64,
    /// Relative change of the number over relative change of the parameter, over the range [-]: relative to the base,
    /// or to the mean of both ends if the base lies outside of the range; absent if one of them is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elasticity: Option<f64>,
    /// Whether the value of the base lies between those of the two ends; two ends alone are always monotonic.
    pub is_monotone: bool,
    /// Rank of the parameter by span for this number, from 1.
    pub rank: usize,
    /// Whether the span exceeds the numerical error of the number in the base; absent if that is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exceeds_numerical_error: Option<bool>,
}

impl Sensitivity {
    /// From the values at the low end, in the base and at the high end; the rank is assigned later.
    pub fn new(
        quantity: QuantityOfInterest,
        parameter: &str,
        parameter_values: [f64; 3],
        values: [f64; 3],
        numerical_error: Option<f64>,
    ) -> Self {
        let [low, base, high] = parameter_values;
        // An end that equals the base up to rounding is the base.
        let slack = ROUNDING * low.abs().max(high.abs());
        let is_base_in_range = low - slack <= base && base <= high + slack;
        let change = values[2] - values[0];
        let per_unit = change / (high - low);
        // Differences at the level of rounding count as none.
        let rounding = ROUNDING * values.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        let [rise, further] = [values[1] - values[0], values[2] - values[1]]
            .map(|step| if step.abs() > rounding { step } else { 0.0 });
        let [least, greatest] =
            values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)]);
        let span = if is_base_in_range { greatest - least } else { change.abs() };
        // Elasticity relative to the base, or to the mid-range if the base is outside.
        let [parameter_there, value_there] = if is_base_in_range {
            [base, values[1]]
        } else {
            [0.5 * (low + high), 0.5 * (values[0] + values[2])]
        };
        let elasticity =
            (value_there != 0.0 && parameter_there != 0.0).then(|| per_unit * parameter_there / value_there);
        Self {
            quantity,
            parameter: parameter.to_owned(),
            parameter_values,
            values,
            change,
            is_base_in_range,
            span,
            per_unit,
            elasticity,
            is_monotone: !is_base_in_range || rise * further >= 0.0,
            rank: 0,
            exceeds_numerical_error: numerical_error.map(|error| span > error),
        }
    }
}

/// Ranks the entries of each quantity, largest first.
pub fn rank<T>(
    all: &mut [T],
    of: impl Fn(&T) -> (QuantityOfInterest, f64),
    rank: impl Fn(&mut T) -> &mut usize,
) {
    for quantity in QuantityOfInterest::ALL {
        let mut order: Vec<(usize, f64)> = all
            .iter()
            .map(&of)
            .enumerate()
            .filter(|(_, (q, _))| *q == quantity)
            .map(|(index, (_, size))| (index, size.abs()))
            .collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        for (place, (index, _)) in order.into_iter().enumerate() {
            *rank(&mut all[index]) = place + 1;
        }
    }
}

/// Distribution of a number over the sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Number with this distribution.
    pub quantity: QuantityOfInterest,
    /// Number of cases with a value.
    pub count: usize,
    /// Mean of the sample.
    pub mean: f64,
    /// Sample standard deviation (n − 1).
    pub standard_deviation: f64,
    /// Minimum of the sample.
    pub least: f64,
    /// 5th percentile of the sample.
    pub p5: f64,
    /// Median of the sample.
    pub median: f64,
    /// 95th percentile of the sample.
    pub p95: f64,
    /// Maximum of the sample.
    pub greatest: f64,
    /// Whether the central 90 % of the sample span more than the numerical error of the number in the base; absent if
    /// that is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exceeds_numerical_error: Option<bool>,
}

impl Spread {
    /// From at least two values, and the numerical error of one.
    pub fn new(quantity: QuantityOfInterest, values: &[f64], numerical_error: Option<f64>) -> Option<Self> {
        if values.len() < 2 {
            return None;
        }
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let mean = sorted.iter().sum::<f64>() / n;
        let variance = sorted.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let [least, p5, median, p95, greatest] = [0.0, 0.05, 0.5, 0.95, 1.0].map(|p| percentile(&sorted, p));
        Some(Self {
            quantity,
            count: values.len(),
            mean,
            standard_deviation: variance.sqrt(),
            least,
            p5,
            median,
            p95,
            greatest,
            exceeds_numerical_error: numerical_error.map(|error| p95 - p5 > error),
        })
    }
}

/// Percentile by linear interpolation between the order statistics (definition 7 of Hyndman & Fan 1996).
fn percentile(sorted: &[f64], fraction: f64) -> f64 {
    let place = fraction * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64)
}

/// Correlation of a number with a parameter over the sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Correlation {
    /// Number correlated with the parameter.
    pub quantity: QuantityOfInterest,
    /// Name of the parameter.
    pub parameter: String,
    /// Spearman's rank correlation, −1 … 1 [-].
    pub spearman: f64,
    /// Rank of the parameter by |correlation|, from 1.
    pub rank: usize,
}

/// Spearman's rank correlation; ties have their mean rank. `None` if one of the two is constant up to rounding.
pub fn spearman(x: &[f64], y: &[f64]) -> Option<f64> {
    if is_constant(x) || is_constant(y) {
        return None;
    }
    let [x, y] = [x, y].map(mean_ranks);
    let mean = (x.len() as f64 - 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let scale = (product(&x, &x) * product(&y, &y)).sqrt();
    (scale > 0.0).then(|| product(&x, &y) / scale)
}

fn is_constant(values: &[f64]) -> bool {
    let [least, greatest] =
        values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)]);
    greatest - least <= ROUNDING * least.abs().max(greatest.abs())
}

fn mean_ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    for tied in order.chunk_by(|a, b| values[*a].total_cmp(&values[*b]).is_eq()) {
        let first = order.partition_point(|i| values[*i].total_cmp(&values[tied[0]]).is_lt());
        for i in tied {
            ranks[*i] = first as f64 + (tied.len() as f64 - 1.0) / 2.0;
        }
    }
    ranks
}

/// Fraction of a number's variance due to a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SobolIndex {
    /// Number whose variance is decomposed.
    pub quantity: QuantityOfInterest,
    /// Name of the parameter.
    pub parameter: String,
    /// First-order index: the parameter by itself [-].
    pub first: f64,
    /// 90 % bootstrap interval of the first-order index.
    pub first_interval: [f64; 2],
    /// Total index: including all interactions [-].
    pub total: f64,
    /// 90 % bootstrap interval of the total index.
    pub total_interval: [f64; 2],
    /// Whether the sample is large enough: both indices lie between 0 and 1, in intervals narrower than one half.
    pub is_converged: bool,
    /// Rank of the parameter by total index, from 1.
    pub rank: usize,
}

/// One row of the design: the number in A, in B, and in A with each column of B.
#[derive(Clone, Debug)]
pub struct SobolRow {
    /// Value in the row of A, f(A).
    pub a: f64,
    /// Value in the row of B, f(B).
    pub b: f64,
    /// Values f(A_B^(i)), one for each parameter.
    pub mixed: Vec<f64>,
}

/// Whether an index is determined well enough by the two ends of its interval.
pub fn is_converged([index, low, high]: [f64; 3]) -> bool {
    (-0.05..=1.05).contains(&index) && high - low <= 0.5
}

/// First-order and total index of every parameter, with their bootstrap intervals; `None` if the number does not vary.
///
/// S_i = ⟨f_B (f_ABi − f_A)⟩ / V (Saltelli et al. 2010, table 2 b), T_i = ⟨(f_A − f_ABi)²⟩ / 2V (Jansen 1999), V of A
/// and B together. Subtracting the overall mean first leaves the expectation of the estimate unchanged and reduces its
/// variance.
#[allow(clippy::type_complexity)] // a row of numbers
pub fn sobol_indices(rows: &[SobolRow], seed: u64) -> Option<Vec<([f64; 3], [f64; 3])>> {
    // Subtract the overall mean.
    let parameters = rows.first()?.mixed.len();
    let mean = rows.iter().map(|row| row.a + row.b).sum::<f64>() / (2.0 * rows.len() as f64);
    let rows: Vec<SobolRow> = rows
        .iter()
        .map(|row| SobolRow {
            a: row.a - mean,
            b: row.b - mean,
            mixed: row.mixed.iter().map(|f| f - mean).collect(),
        })
        .collect();
    let all: Vec<&SobolRow> = rows.iter().collect();
    let estimate = indices(&all, parameters)?;
    // Bootstrap samples of the indices.
    let mut random = Random::new(seed ^ 0x5eed);
    let mut resampled = vec![[Vec::new(), Vec::new()]; parameters];
    for _ in 0..RESAMPLES {
        let drawn: Vec<&SobolRow> = (0..rows.len()).map(|_| &rows[random.below(rows.len())]).collect();
        for (kept, drawn) in resampled.iter_mut().zip(indices(&drawn, parameters).into_iter().flatten()) {
            kept.iter_mut().zip(drawn).for_each(|(kept, index)| kept.push(index));
        }
    }
    let interval = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        [percentile(values, TAIL), percentile(values, 1.0 - TAIL)]
    };
    let with_interval = |(index, [first, total]): ([f64; 2], &mut [Vec<f64>; 2])| {
        let ([a, b], [c, d]) = (interval(first), interval(total));
        ([index[0], a, b], [index[1], c, d])
    };
    Some(estimate.into_iter().zip(&mut resampled).map(with_interval).collect())
}

/// First-order and total index of every parameter.
fn indices(rows: &[&SobolRow], parameters: usize) -> Option<Vec<[f64; 2]>> {
    let n = rows.len() as f64;
    let mean = rows.iter().map(|row| row.a + row.b).sum::<f64>() / (2.0 * n);
    let variance = rows.iter().map(|r| (r.a - mean).powi(2) + (r.b - mean).powi(2)).sum::<f64>() / (2.0 * n);
    let of = |i: usize| {
        let first = rows.iter().map(|r| r.b * (r.mixed[i] - r.a)).sum::<f64>() / n;
        let total = rows.iter().map(|r| (r.a - r.mixed[i]).powi(2)).sum::<f64>() / (2.0 * n);
        [first / variance, total / variance]
    };
    (variance > 0.0).then(|| (0..parameters).map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::super::document::SampleMethod;
    use super::super::sampling::points;
    use super::*;
    use std::f64::consts::PI;

    /// sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1, x in −π … π (Ishigami & Homma 1990).
    fn ishigami(x: &[f64]) -> f64 {
        let x: Vec<f64> = x.iter().map(|u| PI * (2.0 * u - 1.0)).collect();
        x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
    }

    #[test]
    fn indices_of_the_function_of_ishigami() {
        let rows: Vec<SobolRow> = points(SampleMethod::Sobol, 4096, 6, 3)
            .iter()
            .map(|p| {
                let mixed = (0..3).map(|i| {
                    let mut x = p[..3].to_vec();
                    x[i] = p[3 + i];
                    ishigami(&x)
                });
                SobolRow { a: ishigami(&p[..3]), b: ishigami(&p[3..]), mixed: mixed.collect() }
            })
            .collect();
        let indices = sobol_indices(&rows, 3).unwrap();
        // Closed forms: V = a²/8 + bπ⁴/5 + b²π⁸/18 + 1/2, V1 = (1 + bπ⁴/5)²/2, V2 = a²/8, V13 = b²π⁸ (1/18 − 1/50).
        let (a, b) = (7.0_f64, 0.1_f64);
        let variance = a * a / 8.0 + b * PI.powi(4) / 5.0 + b * b * PI.powi(8) / 18.0 + 0.5;
        let first = (1.0 + b * PI.powi(4) / 5.0).powi(2) / 2.0 / variance;
        let (second, both) =
            (a * a / 8.0 / variance, b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0) / variance);
        let exact = [[first, first + both], [second, second], [0.0, both]];
        for (([s, s_low, s_high], [t, t_low, t_high]), [s_exact, t_exact]) in indices.into_iter().zip(exact) {
            assert!((s - s_exact).abs() < 0.02 && (t - t_exact).abs() < 0.02, "{s} {s_exact}, {t} {t_exact}");
            assert!(s_low <= s && s <= s_high && t_low <= t && t <= t_high);
        }
    }

    #[test]
    fn what_goes_up_and_down_ranks_by_how_far() {
        let of = |name: &str, values: [f64; 3]| {
            Sensitivity::new(QuantityOfInterest::PeakForceN, name, [-45.0, 0.0, 45.0], values, Some(20.0))
        };
        let mut all = [of("speed", [2500.0, 2730.0, 2900.0]), of("angle", [1303.0, 2730.0, 1287.0])];
        rank(&mut all, |s| (s.quantity, s.span), |s| &mut s.rank);
        let [speed, angle] = all;
        assert_eq!((speed.rank, angle.rank), (2, 1));
        assert!((angle.change + 16.0).abs() < 1e-9 && (angle.span - 1443.0).abs() < 1e-9);
        assert_eq!((angle.is_monotone, angle.exceeds_numerical_error), (false, Some(true)));
    }

    #[test]
    fn a_base_outside_of_the_range_is_omitted() {
        let of = |parameter_values: [f64; 3], values: [f64; 3]| {
            Sensitivity::new(QuantityOfInterest::PeakForceN, "speed", parameter_values, values, Some(300.0))
        };
        let outside = of([50.0, 100.0, 60.0], [800.0, 2734.0, 1046.0]);
        assert_eq!((outside.is_base_in_range, outside.is_monotone), (false, true));
        assert_eq!((outside.span, outside.exceeds_numerical_error), (246.0, Some(false)));
        // At the mid-range: 246 of 923 over 10 of 55.
        assert!((outside.elasticity.unwrap() - (246.0 / 923.0) / (10.0 / 55.0)).abs() < 1e-12);
        let about_zero = of([-5.0, 100.0, 5.0], [800.0, 2734.0, 1046.0]);
        assert_eq!(about_zero.elasticity, None);
        // A base at an end is within the range, up to rounding.
        for base in [50.0, 50.0 - 7e-15] {
            let at_end = of([50.0, base, 60.0], [800.0, 800.0, 1046.0]);
            assert!(at_end.is_base_in_range && at_end.is_monotone);
            assert!((at_end.elasticity.unwrap() - (246.0 / 800.0) / (10.0 / 50.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn indices_of_too_few_points_are_not_converged() {
        assert!(is_converged([0.4, 0.3, 0.5]) && is_converged([-0.01, -0.05, 0.02]));
        assert!(
            !is_converged([1.08, 0.9, 1.2])
                && !is_converged([-0.09, -0.1, 0.0])
                && !is_converged([0.5, 0.1, 0.9])
        );
    }

    #[test]
    fn ranks_and_percentiles() {
        assert_eq!(spearman(&[1.0, 2.0, 3.0, 4.0], &[1.0, 8.0, 27.0, 64.0]), Some(1.0));
        assert_eq!(spearman(&[1.0, 2.0, 3.0], &[5.0, 5.0, 5.0]), None);
        // By hand: ranks 1, 0, 3½, 3½, 2 about their mean, 5½ / √(10 · 9½).
        let rho = spearman(&[1.0, 2.0, 3.0, 4.0, 5.0], &[2.0, 1.0, 4.0, 4.0, 3.0]).unwrap();
        assert!((rho - 5.5 / 95.0_f64.sqrt()).abs() < 1e-15, "{rho}");
        let spread =
            Spread::new(QuantityOfInterest::PeakForceN, &[4.0, 1.0, 3.0, 2.0, 5.0], Some(3.7)).unwrap();
        assert_eq!(spread.exceeds_numerical_error, Some(false), "3.6 apart");
        let values = [spread.least, spread.median, spread.greatest, spread.mean];
        assert!(values.iter().zip([1.0, 3.0, 5.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-15));
        assert!((spread.p5 - 1.2).abs() < 1e-12 && (spread.p95 - 4.8).abs() < 1e-12);
    }
}
