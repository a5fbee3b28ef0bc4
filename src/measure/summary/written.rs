//! Formatting of numbers for display.

use super::quantity::{ErrorEstimate, Interval, Quantity};
use std::borrow::Cow;
use std::ops::Range;

/// Magnitudes that are written without exponent.
const PLAIN: Range<f64> = 1e-4..1e7;

/// Decimal exponent of the first digit, after rounding to so many digits; 0 of zero.
fn order(value: f64, digits: usize) -> i32 {
    let written = format!("{value:.*e}", digits - 1);
    written.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or_default()
}

/// Rounds to a multiple of 10^place.
fn to_place(value: f64, place: i32) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let unit = 10_f64.powi(place);
    // Zero, which a sum of nothing writes as −0.
    if (value / unit).abs() < 0.5 {
        return "0".into();
    }
    let value = if place > 0 { (value / unit).round() * unit } else { value };
    let digits = |count: i32| count.max(0).unsigned_abs() as usize;
    if PLAIN.contains(&value.abs()) {
        format!("{value:.*}", digits(-place))
    } else {
        format!("{value:.*e}", digits(order((value / unit).round() * unit, 12) - place))
    }
}

/// Rounds to four significant digits.
pub fn number(value: f64) -> String {
    to_place(value, order(value, 4) - 3)
}

/// Rounds to two significant digits, as precise as an error can be.
pub fn rounded(error: f64) -> String {
    to_place(error, order(error, 2) - 1)
}

/// A number that people set: six significant digits, without trailing zeros.
pub fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    let is_plain = rounded == 0.0 || !rounded.is_finite() || PLAIN.contains(&rounded.abs());
    if is_plain { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Rounds a value to the last digit of its error, and to four significant digits at most; those where its error is not known.
///
/// The text of a summary, the report and FHIR write every number with an error so.
pub fn within(value: f64, half_width: Option<f64>) -> String {
    match half_width.filter(|half_width| *half_width > 0.0 && half_width.is_finite()) {
        Some(half_width) => to_place(value, (order(half_width, 2) - 1).max(order(value, 4) - 3)),
        None => number(value),
    }
}

/// A value and its doubt: in brackets unless it is resolved, as "≥" where it is a lower bound. One that rounds to zero bounds nothing.
pub fn marked(value: &str, is_resolved: bool, is_lower_bound: bool) -> String {
    let bound = if is_lower_bound && value != "0" { "≥ " } else { "" };
    if is_resolved { format!("{bound}{value}") } else { format!("({bound}{value})") }
}

/// The end of what is possible, which is known better than the error: to three significant digits.
fn limit(value: f64) -> String {
    to_place(value, order(value, 3) - 2)
}

/// The interval of a value with its error, in units of 1/scale: "± 0.50", "between 5.80 and 8.00" or "up to 8.00". An end that is
/// what is possible has three digits, the others end where the error does. The error of a lower bound is that of its lower end, "± 0.50",
/// whatever is possible above it. `None` without an estimate.
pub fn interval(quantity: &Quantity, scale: f64) -> Option<String> {
    let error = quantity.error.half_width()?;
    let most = quantity.value + error;
    let end = |value: f64| within(scale * value, Some(scale * error));
    let upper = |upper: f64| if upper < most { limit(scale * upper) } else { end(upper) };
    Some(match quantity.interval()? {
        Interval::Around(_) | Interval::From(_) => format!("± {}", rounded(scale * error)),
        Interval::Between([low, high]) => format!("between {} and {}", end(low), upper(high)),
        Interval::UpTo(high) => format!("up to {}", upper(high)),
    })
}

/// The factor and the unit in which a time [s] is read.
pub fn unit_of_time(time: f64) -> (f64, &'static str) {
    match time.abs() {
        t if t >= 1.0 || t == 0.0 => (1.0, "s"),
        t if t >= 1e-3 => (1e3, "ms"),
        _ => (1e6, "µs"),
    }
}

/// The factor and the unit in which a volume [mm³] is read.
fn unit_of_volume(mm3: f64) -> (f64, &'static str) {
    if mm3.abs() < 1e3 { (1.0, "mm³") } else { (1e-3, "cm³") }
}

/// Formats a time [s] in the appropriate unit.
pub fn seconds(time: f64) -> String {
    let (scale, unit) = unit_of_time(time);
    format!("{} {unit}", number(scale * time))
}

/// A time [s] as [`short`] numbers are written.
pub(super) fn short_time(time: f64) -> String {
    let (scale, unit) = unit_of_time(time);
    format!("{} {unit}", short(scale * time))
}

/// Formats a volume [mm³] in the appropriate unit.
pub(super) fn volume(mm3: f64) -> String {
    let (scale, unit) = unit_of_volume(mm3);
    format!("{} {unit}", number(scale * mm3))
}

/// The factor and the unit, after a space, in which a quantity is shown.
pub(super) fn shown_in(value: f64, unit: &str) -> (f64, Cow<'static, str>) {
    let spaced = |(scale, unit): (f64, &str)| (scale, format!(" {unit}").into());
    match unit {
        "-" => (1.0, "".into()),
        "s" => spaced(unit_of_time(value)),
        "mm³" => spaced(unit_of_volume(value)),
        "Pa" | "J/m³" => (1e-3, format!(" k{unit}").into()),
        unit => spaced((1.0, unit)),
    }
}

/// The marked value of a quantity, in units of 1/scale.
fn value_of(quantity: &Quantity, scale: f64) -> String {
    let Quantity { value, error, is_lower_bound, .. } = quantity;
    let digits = within(scale * value, error.half_width().map(|half_width| scale * half_width));
    marked(&digits, error.is_resolved(), *is_lower_bound)
}

/// The marked value of a quantity with its unit.
pub(super) fn with_unit(quantity: &Quantity, unit: &str) -> String {
    let (scale, unit) = shown_in(quantity.value, unit);
    format!("{}{unit}", value_of(quantity, scale))
}

/// The marked value of a quantity, without a unit.
pub(super) fn bare(quantity: &Quantity) -> String {
    value_of(quantity, 1.0)
}

/// "± 200 N (mesh 150, step 45, contact 5)", or the ends of what is possible; of a time the total.
pub(super) fn error_of(quantity: &Quantity, unit: &str) -> String {
    let error = match &quantity.error {
        ErrorEstimate::Estimated(error) => error,
        ErrorEstimate::NotEstimated => return "error not estimated".into(),
        ErrorEstimate::NothingTouched => return "nothing touched".into(),
    };
    let (scale, in_unit) = shown_in(quantity.value, unit);
    let [mesh, step, contact] = [error.mesh, error.step, error.contact].map(|e| rounded(scale * e));
    let interval = interval(quantity, scale).unwrap_or_default();
    if unit == "s" {
        return format!("{interval}{in_unit}");
    }
    // Others are shown only where they are more than rounding.
    let notable = [("bulk modulus", error.bulk_modulus), ("resolution", error.resolution)];
    let notable = notable.into_iter().filter(|(_, part)| *part > 0.01 * error.total);
    let others: Vec<String> =
        notable.map(|(name, part)| format!(", {name} {}", rounded(scale * part))).collect();
    let others = others.concat();
    let verdict = if error.resolved { "" } else { ": NOT RESOLVED" };
    format!("{interval}{in_unit} (mesh {mesh}, step {step}, contact {contact}{others}){verdict}")
}

/// A fraction in percent.
pub(super) fn percent(fraction: f64) -> String {
    format!("{} %", number(100.0 * fraction))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(
            [1234.5678, 0.012_345, 0.0, 3.0e-9, 12.0, 35649.0, -9.999_96].map(number),
            ["1235", "0.01235", "0", "3.000e-9", "12.00", "35650", "-10.00"]
        );
        assert_eq!([1e-4, 0.0021, 2.5].map(seconds), ["100.0 µs", "2.100 ms", "2.500 s"]);
        assert_eq!([2e-5, 0.00155].map(short_time), ["20 µs", "1.55 ms"]);
        assert_eq!([0.5, 999.0, 3e6].map(volume), ["0.5000 mm³", "999.0 mm³", "3000 cm³"]);
        let large = Quantity::with_mesh_error(31_234.0, 1234.0, true);
        assert_eq!(with_unit(&large, "mm³"), "31.2 cm³");
        assert!(error_of(&large, "mm³").starts_with("± 1.2 cm³ (mesh 1.2,"));
        let of_nothing: f64 = [].iter().sum();
        assert_eq!(seconds(of_nothing), "0 s");
    }
    #[test]
    fn names_have_short_numbers() {
        let all = [120.0, 0.006, -0.1 - 0.2, 0.0, 123_456.78, 1e300, -2.5e-7].map(short);
        assert_eq!(all, ["120", "0.006", "-0.3", "0", "123457", "1e300", "-2.5e-7"]);
    }

    #[test]
    fn a_value_has_no_digit_beyond_its_error() {
        let written = |value, error| format!("{} ± {}", within(value, Some(error)), rounded(error));
        for (value, error, expected) in [
            (2095.4, 147.0, "2100 ± 150"),
            (0.169, 0.006, "0.1690 ± 0.0060"),
            (35649.0, 8600.0, "35600 ± 8600"),
            (9.96, 0.997, "10.0 ± 1.0"),
            (-25.86, 2.5, "-25.9 ± 2.5"),
            (270.0, 53_000.0, "0 ± 53000"),
            (600.0, 5300.0, "600 ± 5300"),
            (5.4e-11, 2.2e-6, "0 ± 2.2e-6"),
            (3.21e-5, 8.7e-6, "3.21e-5 ± 8.7e-6"),
            (9.6e-5, 1.2e-5, "9.6e-5 ± 1.2e-5"),
            (1.2345e8, 1.5e6, "1.235e8 ± 1500000"),
            // Four digits at most.
            (2095.4, 1e-6, "2095 ± 1.0e-6"),
        ] {
            assert_eq!(written(value, error), expected);
        }
        let unknown = [None, Some(0.0), Some(f64::NAN), Some(f64::INFINITY)];
        assert!(unknown.iter().all(|error| within(2095.4, *error) == "2095"));
        assert_eq!([f64::NAN, f64::INFINITY].map(number), ["NaN", "inf"]);
    }

    #[test]
    fn a_number_shows_its_doubt() {
        let unresolved = Quantity::with_mesh_error(2729.5, 5270.0, false);
        assert_eq!(with_unit(&unresolved, "N"), "(2700) N");
        assert_eq!(with_unit(&Quantity { is_lower_bound: true, ..unresolved }, "N"), "(≥ 2700) N");
        let resolved = Quantity::with_mesh_error(1e-4, 2.603e-6, true);
        let bound = Quantity { is_lower_bound: true, ..resolved.clone() };
        assert_eq!(with_unit(&bound, "s"), "≥ 100.0 µs");
        let nothing =
            Quantity { value: 1e-9, is_lower_bound: true, ..Quantity::with_mesh_error(0.0, 1e-6, false) };
        assert_eq!(with_unit(&nothing, "-"), "(0)");
        assert_eq!(error_of(&resolved, "s"), "± 2.6 µs");
        let unknown = Quantity { error: ErrorEstimate::NotEstimated, ..resolved };
        assert_eq!(with_unit(&unknown, "s"), "(100.0) µs");
    }

    #[test]
    fn an_error_ends_at_what_is_possible() {
        let of = |error: f64, possible| {
            let quantity = Quantity::with_mesh_error(7.8, error, error < 7.8);
            error_of(&Quantity { possible, ..quantity }, "J")
        };
        let supplied = [Some(0.0), Some(8.0)];
        assert_eq!(of(9.0, supplied), "up to 8.00 J (mesh 9.0, step 0, contact 0): NOT RESOLVED");
        assert_eq!(of(2.0, supplied), "between 5.8 and 8.00 J (mesh 2.0, step 0, contact 0)");
        assert_eq!(of(0.1, supplied), "± 0.10 J (mesh 0.10, step 0, contact 0)");
        assert_eq!(of(9.0, [Some(0.0), None]), "up to 16.8 J (mesh 9.0, step 0, contact 0): NOT RESOLVED");
        assert_eq!(of(9.0, [None; 2]), "± 9.0 J (mesh 9.0, step 0, contact 0): NOT RESOLVED");
        // More than a lower bound is possible: it has no upper end.
        let bound = Quantity::with_mesh_error(7.8, 2.0, true);
        let bound = Quantity { is_lower_bound: true, possible: supplied, ..bound };
        assert_eq!([with_unit(&bound, "J"), interval(&bound, 1.0).unwrap()], ["≥ 7.8 J", "± 2.0"]);
    }
}
