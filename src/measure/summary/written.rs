//! Formatting of numbers for display.

use super::quantity::{ErrorEstimate, Quantity};

/// Formats with four significant digits.
pub fn number(value: f64) -> String {
    // A sum of nothing is −0.
    let value = value + 0.0;
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-3..1e6).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let digits = if magnitude == 0.0 { 0 } else { (3 - magnitude.log10().floor() as i32).clamp(0, 6) };
    format!("{value:.*}", digits.unsigned_abs() as usize)
}

/// Formats a time in the appropriate unit.
pub(super) fn seconds(time: f64) -> String {
    match time.abs() {
        t if t >= 1.0 || t == 0.0 => format!("{} s", number(time)),
        t if t >= 1e-3 => format!("{} ms", number(1e3 * time)),
        _ => format!("{} µs", number(1e6 * time)),
    }
}

/// Formats with two significant digits, as precise as an error can be.
pub fn rounded(error: f64) -> String {
    if error == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e7).contains(&error) {
        return format!("{error:.1e}");
    }
    let decimals = 1 - error.log10().floor() as i32;
    if decimals >= 0 {
        format!("{error:.*}", decimals.unsigned_abs() as usize)
    } else {
        let unit = 10_f64.powi(-decimals);
        format!("{}", (error / unit).round() * unit)
    }
}

/// The formatted number, in brackets unless it is resolved.
pub(super) fn bracketed(quantity: &Quantity, shown: String) -> String {
    if quantity.error.is_resolved() { shown } else { format!("({shown})") }
}

/// A time, in brackets unless it is resolved.
pub(super) fn time(quantity: &Quantity) -> String {
    bracketed(quantity, seconds(quantity.value))
}

/// The factor and the unit, after a space, in which a quantity is shown.
fn shown_in(unit: &str) -> (f64, String) {
    match unit {
        "-" => (1.0, String::new()),
        "Pa" | "J/m³" => (1e-3, format!(" k{unit}")),
        unit => (1.0, format!(" {unit}")),
    }
}

/// A number with its unit; in brackets if its error is unknown or exceeds the value.
pub(super) fn with_unit(quantity: &Quantity, unit: &str) -> String {
    if unit == "s" {
        return time(quantity);
    }
    let (scale, unit) = shown_in(unit);
    format!("{}{unit}", bracketed(quantity, number(scale * quantity.value)))
}

/// "± 200 N (mesh 150, step 45, contact 5)"; of a time the total.
pub(super) fn error_of(quantity: &Quantity, unit: &str) -> String {
    let error = match &quantity.error {
        ErrorEstimate::Estimated(error) => error,
        ErrorEstimate::NotEstimated => return "error not estimated".into(),
        ErrorEstimate::NothingTouched => return "nothing touched".into(),
    };
    if unit == "s" {
        return format!("± {}", seconds(error.total));
    }
    let (scale, unit) = shown_in(unit);
    let [total, mesh, step, contact] =
        [error.total, error.mesh, error.step, error.contact].map(|e| rounded(scale * e));
    // Others are shown only where they are more than rounding.
    let notable = [("bulk modulus", error.bulk_modulus), ("resolution", error.resolution)];
    let notable = notable.into_iter().filter(|(_, part)| *part > 0.01 * error.total);
    let others: Vec<String> =
        notable.map(|(name, part)| format!(", {name} {}", rounded(scale * part))).collect();
    let others = others.concat();
    let verdict = if error.resolved { "" } else { ": NOT RESOLVED" };
    format!("± {total}{unit} (mesh {mesh}, step {step}, contact {contact}{others}){verdict}")
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
            [1234.5678, 0.012_345, 0.0, 3.0e-9, 12.0].map(number),
            ["1235", "0.01235", "0", "3.000e-9", "12.00"]
        );
        assert_eq!([1e-4, 0.0021, 2.5].map(seconds), ["100.0 µs", "2.100 ms", "2.500 s"]);
        let of_nothing: f64 = [].iter().sum();
        assert_eq!(seconds(of_nothing), "0 s");
    }
}
