//! Formatting of numbers for display.

/// Formats with four significant digits.
pub fn number(value: f64) -> String {
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
    }
}
