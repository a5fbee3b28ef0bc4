//! Bulk data entries: fields of 8 or 16 columns, or separated by commas, with their continuations.

use std::borrow::Cow;

/// Data fields of an entry beyond which its continuations are omitted: no element has so many.
const MOST_FIELDS: usize = 64;

/// An entry with its continuations.
pub(super) struct Card {
    /// Its name in capitals, without the asterisk of large fields.
    pub(super) name: String,
    /// Data fields, trimmed; as many for each line as its format has.
    pub(super) fields: Vec<String>,
    /// Byte offset of its first line.
    pub(super) offset: usize,
}

impl Card {
    /// A field, trimmed; empty if the entry has it not.
    pub(super) fn get(&self, index: usize) -> &str {
        self.fields.get(index).map_or("", String::as_str)
    }
}

/// Iterator over the entries of a file. What stands before `BEGIN BULK`, if a line says so, and after `ENDDATA` is not part of
/// the bulk data.
pub(super) struct Cards<'a> {
    bytes: &'a [u8],
    offset: usize,
    /// The entry whose continuations may follow.
    next: Option<Card>,
    /// Whether `ENDDATA` has ended the bulk data.
    pub(super) is_ended: bool,
}

impl<'a> Cards<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut cards = Self { bytes, offset: 0, next: None, is_ended: false };
        let mut before = Self { bytes, offset: 0, next: None, is_ended: false };
        while let Some((_, line)) = before.line() {
            let mut words = line.split_whitespace();
            let is =
                |word: Option<&str>, name: &str| word.is_some_and(|word| word.eq_ignore_ascii_case(name));
            if is(words.next(), "BEGIN") && is(words.next(), "BULK") {
                cards.offset = before.offset;
                break;
            }
        }
        cards
    }

    /// The next line with its byte offset: without comment, with tabs as spaces, and not blank.
    fn line(&mut self) -> Option<(usize, String)> {
        while self.offset < self.bytes.len() {
            let start = self.offset;
            let rest = &self.bytes[start..];
            let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            self.offset = (start + length + 1).min(self.bytes.len());
            let line = rest[..length].split(|&b| b == b'$').next().unwrap_or_default();
            if !line.trim_ascii().is_empty() {
                return Some((start, without_tabs(&String::from_utf8_lossy(line.trim_ascii_end()))));
            }
        }
        None
    }
}

/// Tabs lead to the next multiple of 8 columns.
fn without_tabs(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    let mut column = 0;
    for c in line.chars() {
        let width = if c == '\t' { 8 - column % 8 } else { 1 };
        out.extend(std::iter::repeat_n(if c == '\t' { ' ' } else { c }, width));
        column += width;
    }
    out
}

/// First field and data fields of a line.
fn fields(line: &str) -> (Cow<'_, str>, Vec<String>) {
    let trimmed = |field: &str| field.trim().to_owned();
    if line.contains(',') {
        let mut all = line.split(',');
        let first = all.next().unwrap_or_default().trim();
        let count = if first.contains('*') { 4 } else { 8 };
        let mut data: Vec<String> = all.take(count).map(trimmed).collect();
        data.resize(count, String::new());
        return (first.into(), data);
    }
    let characters: Vec<char> = line.chars().collect();
    let columns = |from: usize, to: usize| -> String {
        let (from, to) = (from.min(characters.len()), to.min(characters.len()));
        characters[from..to].iter().collect()
    };
    let first = columns(0, 8).trim().to_owned();
    let width = if first.contains('*') { 16 } else { 8 };
    let data = (8..72).step_by(width).map(|start| trimmed(&columns(start, start + width))).collect();
    (first.into(), data)
}

impl Iterator for Cards<'_> {
    type Item = Card;

    fn next(&mut self) -> Option<Card> {
        while let Some((offset, line)) = self.line() {
            let (first, data) = fields(&line);
            match &mut self.next {
                Some(card) if first.is_empty() || first.starts_with(['+', '*']) => {
                    if card.fields.len() < MOST_FIELDS {
                        card.fields.extend(data);
                    }
                }
                _ => {
                    let name = first.trim_end_matches('*').trim().to_ascii_uppercase();
                    if name == "ENDDATA" {
                        self.offset = self.bytes.len();
                        self.is_ended = true;
                        break;
                    }
                    let done = self.next.replace(Card { name, fields: data, offset });
                    if done.is_some() {
                        return done;
                    }
                }
            }
        }
        self.next.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names and fields of all entries, without blank fields at the end.
    fn cards(text: &str) -> Vec<(String, Vec<String>)> {
        let without_end = |mut fields: Vec<String>| {
            fields.truncate(fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1));
            fields
        };
        Cards::new(text.as_bytes()).map(|card| (card.name, without_end(card.fields))).collect()
    }

    #[test]
    fn every_layout_of_an_entry() {
        let grid = vec![("GRID".to_owned(), ["7", "", "1.5", "-2.", "3.0-1"].map(str::to_owned).to_vec())];
        assert_eq!(cards("GRID           7             1.5     -2.   3.0-1"), grid);
        assert_eq!(cards("grid,7,,1.5,-2. , 3.0-1 $ comment"), grid);
        assert_eq!(cards("GRID\t7\t\t1.5\t-2.\t3.0-1"), grid);
        let large = "GRID*                  7                             1.5             -2.*A\n*A                 3.0-1\n";
        assert_eq!(cards(large), grid);
        assert_eq!(cards("GRID*,7,,1.5,-2.\n*,3.0-1"), grid);
    }

    #[test]
    fn continuations_and_the_limits_of_the_bulk_data() {
        let text = "SOL 101\nCEND\nSPC = 1\nBEGIN BULK\n$\nCHEXA,1,2,3,4,5,6,7,8,+\n+,9,10\nGRID,1\n\n        ,x\nENDDATA\nGRID,2\n";
        let found = cards(text);
        assert_eq!(found[0].1.join(" "), "1 2 3 4 5 6 7 8 9 10");
        assert_eq!((found.len(), found[1].1.last().map(String::as_str)), (2, Some("x")));
    }
}
