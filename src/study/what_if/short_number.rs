//! Short formatting of numbers in names.

/// Formats with six significant digits, without trailing zeros; very large and very small numbers in scientific
/// notation.
pub(super) fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    let is_plain = rounded == 0.0 || !rounded.is_finite() || (1e-4..1e7).contains(&rounded.abs());
    if is_plain { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn names_have_short_numbers() {
        let all = [120.0, 0.006, -0.1 - 0.2, 0.0, 123_456.78, 1e300, -2.5e-7].map(short);
        assert_eq!(all, ["120", "0.006", "-0.3", "0", "123457", "1e300", "-2.5e-7"]);
    }
}
