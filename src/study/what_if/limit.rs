//! Finds the parameter value up to which a number stays at or below a limit, by bracketing on the model itself.

use serde::Serialize;

/// Outcome of the search for a limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Verdict {
    /// The limit is met up to a value, and exceeded just above.
    KeptUpTo {
        /// Largest bracketed value that meets the limit.
        kept_at: f64,
        /// The number at that value.
        value: f64,
        /// Bracketed value that exceeds the limit.
        broken_at: f64,
        /// The number at that value.
        value_broken: f64,
    },
    /// The limit is met from a value on, and exceeded just below.
    KeptFrom {
        /// Smallest bracketed value that meets the limit.
        kept_at: f64,
        /// The number at that value.
        value: f64,
        /// Bracketed value that exceeds the limit.
        broken_at: f64,
        /// The number at that value.
        value_broken: f64,
    },
    /// The limit is met at both ends of the range: there is no bracket.
    KeptAtBothEnds {
        /// The number at both ends.
        values: [f64; 2],
    },
    /// The limit is exceeded at both ends of the range: there is no bracket.
    BrokenAtBothEnds {
        /// The number at both ends.
        values: [f64; 2],
    },
    /// A run gave a lower bound at or below the limit, as a depth that the model cuts off: whether the limit is met there is not known.
    Open {
        /// Parameter value of that run.
        at: f64,
        /// The number is at least this.
        at_least: f64,
    },
    /// A run gave no number.
    NoNumber {
        /// Parameter value of that run.
        at: f64,
        /// Reason of the failure.
        reason: String,
    },
}

/// A number of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluated {
    /// Value of the number.
    pub value: f64,
    /// Whether the number is a lower bound: it is the value, or larger.
    pub is_lower_bound: bool,
}

impl Evaluated {
    /// A number that is the value.
    pub fn exactly(value: f64) -> Self {
        Self { value, is_lower_bound: false }
    }
}

/// Weight of the truncation step in the root estimate (κ1 of the method, over the range).
const TRUNCATION: f64 = 0.2;

/// Finds the crossing in `range`, with a final bracket of half of `tolerance` times the range.
///
/// Uses the ITP method (Oliveira & Takahashi 2020): at most one run more than bisection, and few for a smooth response.
/// If there are several crossings, one of them is found. A lower bound above the limit exceeds it; one at or below it ends the
/// search, since it does not show that the limit is met.
pub fn find_limit(
    range: [f64; 2],
    at_most: f64,
    tolerance: f64,
    number: &mut dyn FnMut(f64) -> Result<Evaluated, String>,
) -> Verdict {
    search(range, at_most, tolerance, number).unwrap_or_else(|without_answer| without_answer)
}

fn search(
    [low, high]: [f64; 2],
    at_most: f64,
    tolerance: f64,
    number: &mut dyn FnMut(f64) -> Result<Evaluated, String>,
) -> Result<Verdict, Verdict> {
    let mut number = |at: f64| match number(at) {
        Ok(Evaluated { value, is_lower_bound: true }) if value <= at_most => {
            Err(Verdict::Open { at, at_least: value })
        }
        Ok(Evaluated { value, .. }) => Ok(value),
        Err(reason) => Err(Verdict::NoNumber { at, reason }),
    };
    // The numbers are stored as they are: recovered from their excess they would lose digits, all of them near a
    // distant limit.
    let values = [number(low)?, number(high)?];
    let rises = match values.map(|value| value <= at_most) {
        [true, true] => return Ok(Verdict::KeptAtBothEnds { values }),
        [false, false] => return Ok(Verdict::BrokenAtBothEnds { values }),
        [kept_at_low, _] => kept_at_low,
    };
    // Bracket of the sign change of the increasing function g: g(a) ≤ 0 < g(b).
    let sign = if rises { 1.0 } else { -1.0 };
    let excess = |value: f64| sign * (value - at_most);
    let [(mut a, mut value_a), (mut b, mut value_b)] = [(low, values[0]), (high, values[1])];
    let half = 0.5 * tolerance * (high - low);
    let most = ((high - low) / (2.0 * half)).log2().ceil() as i32 + 1;
    for done in 0..=most {
        if b - a <= 2.0 * half {
            break;
        }
        // Truncate the secant estimate towards the middle, then project it into the admissible interval.
        let middle = 0.5 * (a + b);
        let reach = half * 2_f64.powi(most - done) - 0.5 * (b - a);
        let (at_a, at_b) = (excess(value_a), excess(value_b));
        let secant = (at_b * a - at_a * b) / (at_b - at_a);
        let towards = (middle - secant).signum();
        let truncation = TRUNCATION / (high - low) * (b - a).powi(2);
        let truncated =
            if truncation <= (middle - secant).abs() { secant + towards * truncation } else { middle };
        let x = if (truncated - middle).abs() <= reach { truncated } else { middle - towards * reach };
        // Narrow the bracket.
        let value = number(x)?;
        let is_kept = value <= at_most;
        let (end, at_end) = if is_kept == rises { (&mut a, &mut value_a) } else { (&mut b, &mut value_b) };
        (*end, *at_end) = (x, value);
    }
    Ok(if rises {
        Verdict::KeptUpTo { kept_at: a, value: value_a, broken_at: b, value_broken: value_b }
    } else {
        Verdict::KeptFrom { kept_at: b, value: value_b, broken_at: a, value_broken: value_a }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_bracketed_with_few_runs() {
        let mut runs = 0;
        let verdict = find_limit([0.0, 4.0], 8.0, 1e-3, &mut |x| {
            runs += 1;
            Ok(Evaluated::exactly(x * x * x))
        });
        let Verdict::KeptUpTo { kept_at, value, broken_at, value_broken } = verdict else {
            panic!("{verdict:?}")
        };
        assert!(kept_at <= 2.0 && 2.0 < broken_at && broken_at - kept_at <= 4e-3);
        assert!(value <= 8.0 && value_broken > 8.0 && runs <= 14, "{runs}");
    }

    #[test]
    fn falling_numbers_jumps_and_no_bracket() {
        let verdict = find_limit([1.0, 3.0], 0.5, 1e-4, &mut |x| Ok(Evaluated::exactly(1.0 / x)));
        let Verdict::KeptFrom { kept_at, broken_at, .. } = verdict else { panic!("{verdict:?}") };
        assert!(broken_at < 2.0 && 2.0 <= kept_at && kept_at - broken_at <= 2e-4);
        let verdict =
            find_limit([0.0, 1.0], 0.5, 1e-6, &mut |x| Ok(Evaluated::exactly(f64::from(u8::from(x > 0.3)))));
        let Verdict::KeptUpTo { kept_at, broken_at, .. } = verdict else { panic!("{verdict:?}") };
        assert!(kept_at <= 0.3 && 0.3 < broken_at && broken_at - kept_at <= 1e-6);
        assert_eq!(
            find_limit([0.0, 1.0], 9.0, 1e-3, &mut |x| Ok(Evaluated::exactly(x))),
            Verdict::KeptAtBothEnds { values: [0.0, 1.0] }
        );
        let verdict = find_limit([1.0, 2.0], 1e19, 1e-3, &mut |x| Ok(Evaluated::exactly(273.16 * x)));
        assert_eq!(verdict, Verdict::KeptAtBothEnds { values: [273.16, 546.32] });
        let verdict = find_limit([0.0, 1.0], -9.0, 1e-3, &mut |x| Ok(Evaluated::exactly(x)));
        assert_eq!(verdict, Verdict::BrokenAtBothEnds { values: [0.0, 1.0] });
        let verdict = find_limit([0.0, 1.0], 0.5, 1e-3, &mut |_| Err("no".into()));
        assert_eq!(verdict, Verdict::NoNumber { at: 0.0, reason: "no".into() });
    }

    #[test]
    fn lower_bounds_exceed_a_limit_and_do_not_show_that_it_is_met() {
        // The number is x; above 2 only that it is at least 2 is known.
        let mut number = |x: f64| Ok(Evaluated { value: x.min(2.0), is_lower_bound: x > 2.0 });
        let verdict = find_limit([0.0, 4.0], 1.5, 1e-3, &mut number);
        let Verdict::KeptUpTo { kept_at, broken_at, .. } = verdict else { panic!("{verdict:?}") };
        assert!(kept_at <= 1.5 && 1.5 < broken_at && broken_at - kept_at <= 4e-3);
        let open = find_limit([0.0, 4.0], 3.0, 1e-3, &mut number);
        assert_eq!(open, Verdict::Open { at: 4.0, at_least: 2.0 });
        // Exactly at the limit it may be above.
        assert_eq!(find_limit([0.0, 4.0], 2.0, 1e-3, &mut number), Verdict::Open { at: 4.0, at_least: 2.0 });
        assert_eq!(
            find_limit([3.0, 4.0], 1.0, 1e-3, &mut number),
            Verdict::BrokenAtBothEnds { values: [2.0; 2] }
        );
    }
}
