//! Text of reports.

/// The text as HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The text with a capital first letter.
pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The text with numbers such as "2.2e-6" as powers of ten: "2.2 × 10⁻⁶".
pub(super) fn with_powers(text: &str) -> String {
    let is_of_number =
        |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '.' | '-' | '+' | '_');
    let (mut out, mut word) = (String::new(), String::new());
    for letter in text.chars() {
        if is_of_number(letter) {
            word.push(letter);
        } else {
            out += &power(&std::mem::take(&mut word));
            out.push(letter);
        }
    }
    out + &power(&word)
}

/// A word, as a power of ten if it is a number with an exponent.
fn power(word: &str) -> String {
    let parts = word.split_once('e').filter(|(number, _)| number.parse::<f64>().is_ok());
    let Some((number, exponent)) = parts.filter(|(_, exponent)| exponent.parse::<i32>().is_ok()) else {
        return word.to_owned();
    };
    let raised: String = exponent.chars().map(superscript).collect();
    if number == "1" { format!("10{raised}") } else { format!("{number} × 10{raised}") }
}

fn superscript(digit: char) -> char {
    match digit {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        '-' => '⁻',
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_powers_of_ten() {
        let written = "± 0.33 J (mesh 0.31, step 2.2e-12, contact 1e-6): the plate 2e-part";
        assert_eq!(
            with_powers(written),
            "± 0.33 J (mesh 0.31, step 2.2 × 10⁻¹², contact 10⁻⁶): the plate 2e-part"
        );
        assert_eq!(["0", "1.2350e8", "skin"].map(with_powers), ["0", "1.2350 × 10⁸", "skin"]);
    }
}
