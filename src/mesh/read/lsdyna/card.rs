//! Data lines: fields of fixed width, or separated by commas.

use std::borrow::Cow;

/// Number of columns of a field, which a keyword or the whole file sets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Format {
    /// Numbers of nodes and elements in 8 columns.
    #[default]
    Standard,
    /// Node and element numbers in 10 columns.
    I10,
    /// All fields in 20 columns.
    Long,
}

impl Format {
    /// The format that a keyword line asks for by a sign after its name, or `default`.
    pub(super) fn of_keyword(line: &[u8], default: Self) -> Self {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        let first = words.next().unwrap_or_default();
        // The sign may stand after a space.
        let sign = words.next().filter(|word| word.len() == 1).unwrap_or(first);
        match sign.chars().last() {
            Some('+') => Self::Long,
            Some('-') => Self::Standard,
            Some('%') => Self::I10,
            _ => default,
        }
    }

    /// The format that the line `*KEYWORD` sets for the whole deck, if it does.
    pub(super) fn of_deck(line: &[u8]) -> Option<Self> {
        let text = String::from_utf8_lossy(line).to_ascii_uppercase();
        text.split_whitespace().find_map(|word| match word {
            "LONG=Y" => Some(Self::Long),
            "I10=Y" => Some(Self::I10),
            _ => None,
        })
    }

    /// Columns of a number in `*NODE` and `*ELEMENT`.
    fn number(self) -> usize {
        match self {
            Self::Standard => 8,
            Self::I10 => 10,
            Self::Long => 20,
        }
    }
}

/// Fields of one line; those beyond its end are blank.
pub(super) struct Card<'a>(Vec<Cow<'a, str>>);

impl<'a> Card<'a> {
    /// A node: its number, three coordinates, two constraints.
    pub(super) fn node(line: &'a [u8], format: Format) -> Self {
        let (number, real) = (format.number(), if format == Format::Long { 20 } else { 16 });
        Self::of(line, [number, real, real, real].into_iter().chain(std::iter::repeat(number)))
    }

    /// Numbers of an element, its part and its nodes.
    pub(super) fn element(line: &'a [u8], format: Format) -> Self {
        Self::of(line, std::iter::repeat(format.number()))
    }

    /// Any other card: fields of 10 columns.
    pub(super) fn plain(line: &'a [u8], format: Format) -> Self {
        Self::of(line, std::iter::repeat(if format == Format::Long { 20 } else { 10 }))
    }

    fn of(line: &'a [u8], mut widths: impl Iterator<Item = usize>) -> Self {
        if line.contains(&b',') {
            return Self(line.split(|&b| b == b',').map(trimmed).collect());
        }
        let (mut fields, mut rest) = (Vec::new(), line);
        while let (false, Some(width)) = (rest.is_empty(), widths.next()) {
            let (field, others) = rest.split_at(width.min(rest.len()));
            fields.push(trimmed(field));
            rest = others;
        }
        Self(fields)
    }

    /// A field, trimmed; empty if the line has it not.
    pub(super) fn get(&self, index: usize) -> &str {
        self.0.get(index).map_or("", |field| field)
    }

    /// All fields from an index on.
    pub(super) fn from(&self, index: usize) -> impl Iterator<Item = &str> {
        self.0.iter().skip(index).map(|field| &**field)
    }

    /// Whether no field from an index on has a content.
    pub(super) fn is_blank_from(&self, index: usize) -> bool {
        self.from(index).all(str::is_empty)
    }
}

fn trimmed(field: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(field.trim_ascii())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_cut_by_width_or_by_comma() {
        let card = Card::node(b"     100-1.23456789E-0012.5             3", Format::Standard);
        assert_eq!(card.from(0).collect::<Vec<_>>(), ["100", "-1.23456789E-001", "2.5", "3"]);
        let card = Card::node(b"100,1.0, ,3", Format::Standard);
        assert_eq!(card.from(0).collect::<Vec<_>>(), ["100", "1.0", "", "3"]);
        assert_eq!(Card::element(b"1234567812345678", Format::Standard).get(1), "12345678");
        assert_eq!(Card::element(b"12345678901234567890", Format::I10).get(1), "1234567890");
        assert_eq!(Card::plain(b"                   1", Format::Long).get(0), "1");
        assert_eq!(Card::plain(b"", Format::Long).get(3), "");
    }

    #[test]
    fn formats_come_from_signs_and_options() {
        let of = |line: &str| Format::of_keyword(line.as_bytes(), Format::I10);
        assert_eq!(
            [of("*NODE+"), of("*NODE +"), of("*NODE-")],
            [Format::Long, Format::Long, Format::Standard]
        );
        assert_eq!([of("*NODE%"), of("*NODE")], [Format::I10, Format::I10]);
        assert_eq!(Format::of_deck(b"*KEYWORD long=y memory=20m"), Some(Format::Long));
        assert_eq!(Format::of_deck(b"*KEYWORD"), None);
    }
}
