//! The lines of an input file: keywords with parameters, and data lines.

use std::borrow::Cow;

/// A logical line of an input file: comments removed, continuation lines joined.
pub(super) enum Line<'a> {
    /// `*KEYWORD, NAME=value, FLAG`, with its continuation lines.
    Keyword(Keyword),
    /// Fields separated by commas, trimmed; an empty last field is omitted.
    Data {
        /// Contents of the fields.
        fields: Vec<Cow<'a, str>>,
        /// Whether the line ends in a comma.
        continues: bool,
    },
}

/// A keyword line with its parameters.
pub(super) struct Keyword {
    /// Name in capitals, words separated by one space, without the asterisk.
    pub(super) name: String,
    /// Names in capitals; values unchanged, without quotes.
    parameters: Vec<(String, String)>,
}

impl Keyword {
    /// The value of a parameter; empty for a flag.
    pub(super) fn value(&self, name: &str) -> Option<&str> {
        self.parameters.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// Whether a parameter is given.
    pub(super) fn has(&self, name: &str) -> bool {
        self.value(name).is_some()
    }

    fn parse(text: &str) -> Self {
        let mut fields = text.trim_start_matches('*').split(',').map(str::trim);
        let name = capitals(fields.next().unwrap_or_default());
        let parameters = fields
            .filter(|field| !field.is_empty())
            .map(|field| {
                let (key, value) = field.split_once('=').unwrap_or((field, ""));
                (capitals(key), value.trim().trim_matches('"').to_owned())
            })
            .collect();
        Self { name, parameters }
    }
}

/// Text in capitals, with single spaces between words.
fn capitals(text: &str) -> String {
    text.split_whitespace().map(str::to_ascii_uppercase).collect::<Vec<_>>().join(" ")
}

/// Iterator over the logical lines of a file with their byte offsets; comments (`**`) and blank lines are skipped.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, offset: 0 }
    }

    /// The next physical line that is neither blank nor a comment. Text that is not UTF-8 can only occur in names and
    /// titles, and is kept readable.
    fn physical(&mut self) -> Option<(usize, Cow<'a, str>)> {
        while self.offset < self.bytes.len() {
            let start = self.offset;
            let rest = &self.bytes[start..];
            let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            self.offset = start + (end + 1).min(rest.len());
            let line = rest[..end].trim_ascii();
            if !line.is_empty() && !line.starts_with(b"**") {
                return Some((start, String::from_utf8_lossy(line)));
            }
        }
        None
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, Line<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        let (start, line) = self.physical()?;
        if line.starts_with('*') {
            let mut text = line.into_owned();
            while text.ends_with(',') {
                let Some((_, more)) = self.physical() else { break };
                text.push_str(&more);
            }
            return Some((start, Line::Keyword(Keyword::parse(&text))));
        }
        let mut fields: Vec<Cow<'a, str>> = match line {
            Cow::Borrowed(text) => text.split(',').map(|field| Cow::Borrowed(field.trim())).collect(),
            Cow::Owned(text) => text.split(',').map(|field| Cow::Owned(field.trim().to_owned())).collect(),
        };
        let continues = fields.len() > 1 && fields.last().is_some_and(|field| field.is_empty());
        if continues {
            fields.pop();
        }
        Some((start, Line::Data { fields, continues }))
    }
}
