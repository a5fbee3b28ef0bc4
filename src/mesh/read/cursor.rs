//! A position in the bytes of a file, and parsing of numbers there.

use crate::mechanics::tensor::Vec3;
use crate::mesh::{MeshError, Place};

/// Encoding of the numbers of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    /// Text, separated by white space.
    Text,
    /// Binary, least significant byte first.
    LittleEndian,
    /// Binary, most significant byte first.
    BigEndian,
}

/// A sequential reader of a file that reports the place of errors.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    offset: usize,
    /// Encoding of the numbers from here on.
    pub(super) numbers: Numbers,
}

/// Place of a byte offset: its line in a text file.
pub(super) fn place_of(bytes: &[u8], offset: usize, numbers: Numbers) -> Place {
    match numbers {
        Numbers::Text => Place::Line(bytes[..offset.min(bytes.len())].split(|&b| b == b'\n').count()),
        _ => Place::Byte(offset),
    }
}

/// Found text, truncated for a message.
pub(super) fn shown(found: &[u8]) -> String {
    let text = String::from_utf8_lossy(found);
    let short: String = text.chars().take(40).collect();
    if short.len() < text.len() { format!("{short:?}…") } else { format!("{short:?}") }
}

/// A finite real number as Fortran writes it: the exponent after E or D, or after its sign alone (`1.0-3`).
pub(super) fn fortran_real(text: &str) -> Option<f64> {
    let text = text.trim().replace(['D', 'd'], "e");
    let value = text.parse::<f64>().ok().or_else(|| {
        let sign = text.rfind(['+', '-']).filter(|&at| at > 0)?;
        let (mantissa, exponent) = text.split_at(sign);
        format!("{mantissa}e{exponent}").parse().ok()
    });
    value.filter(|value| value.is_finite())
}

/// Coordinates as Fortran writes them, of which an empty one is zero; `error` makes an error of a message.
pub(super) fn fortran_position<'a>(
    fields: impl Iterator<Item = &'a str>,
    error: impl Fn(String) -> MeshError,
) -> Result<Vec3, MeshError> {
    let mut position = Vec3::zeros();
    for (x, field) in position.iter_mut().zip(fields).filter(|(_, field)| !field.is_empty()) {
        let found = || error(format!("expected a finite coordinate, found {}", shown(field.as_bytes())));
        *x = fortran_real(field).ok_or_else(found)?;
    }
    Ok(position)
}

impl<'a> Cursor<'a> {
    /// Starts at the beginning of a file, with numbers as text.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, offset: 0, numbers: Numbers::Text }
    }

    /// Starts at `start`, and ends before `end`; places are those of the whole file.
    pub(super) fn within(bytes: &'a [u8], start: usize, end: usize) -> Self {
        Self { bytes: &bytes[..end], offset: start, numbers: Numbers::Text }
    }

    /// Byte offset of the next item: after white space in a text file.
    pub(super) fn offset(&mut self) -> usize {
        if self.numbers == Numbers::Text {
            self.skip_white_space();
        }
        self.offset
    }

    /// An error at a given byte offset.
    pub(super) fn error_at(&self, offset: usize, message: impl Into<String>) -> MeshError {
        MeshError::Malformed { place: place_of(self.bytes, offset, self.numbers), message: message.into() }
    }

    /// An error at the current position.
    pub(super) fn error(&self, message: impl Into<String>) -> MeshError {
        self.error_at(self.offset, message)
    }

    /// Bytes from the current offset to the end of the file.
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.offset..]
    }

    /// Whether only white space is left.
    pub(super) fn at_end(&self) -> bool {
        self.rest().trim_ascii_start().is_empty()
    }

    /// The rest of the line, trimmed; moves the cursor past the line break.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.offset += (end + 1).min(rest.len());
        rest[..end].trim_ascii()
    }

    /// The next non-blank line.
    pub(super) fn filled_line(&mut self) -> &'a [u8] {
        self.skip_white_space();
        self.line()
    }

    fn skip_white_space(&mut self) {
        self.offset = self.bytes.len() - self.rest().trim_ascii_start().len();
    }

    /// The next word of text; empty at the end of the file.
    pub(super) fn word(&mut self) -> &'a [u8] {
        self.skip_white_space();
        let rest = self.rest();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.offset += end;
        &rest[..end]
    }

    /// The next word of text, and where it begins.
    pub(super) fn placed_word(&mut self) -> (usize, &'a [u8]) {
        self.skip_white_space();
        (self.offset, self.word())
    }

    /// The next word of text as a number.
    pub(super) fn parsed<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, MeshError> {
        let (start, word) = self.placed_word();
        std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| self.error_at(start, format!("expected {what}, found {}", shown(word))))
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], MeshError> {
        let Some((taken, _)) = self.rest().split_at_checked(count) else {
            return Err(self.error(format!("expected {count} bytes of {what}, found the end of the file")));
        };
        self.offset += count;
        Ok(taken)
    }

    /// The next `N` bytes, in little-endian order.
    fn number_bytes<const N: usize>(&mut self, what: &str) -> Result<[u8; N], MeshError> {
        let Some(bytes) = self.rest().first_chunk::<N>() else {
            return Err(self.error(format!("expected {what}, found the end of the file")));
        };
        self.offset += N;
        let mut bytes = *bytes;
        if self.numbers == Numbers::BigEndian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// A signed number: a C `int` in binary.
    pub(super) fn int(&mut self, what: &str) -> Result<i32, MeshError> {
        match self.numbers {
            Numbers::Text => self.parsed(what),
            _ => self.number_bytes(what).map(i32::from_le_bytes),
        }
    }

    /// A count or a tag: a C `size_t` of eight bytes in binary.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, MeshError> {
        match self.numbers {
            Numbers::Text => self.parsed(what),
            _ => self.number_bytes(what).map(u64::from_le_bytes),
        }
    }

    /// A real number: a C `double` in binary; it must be finite.
    pub(super) fn double(&mut self, what: &str) -> Result<f64, MeshError> {
        let start = self.offset;
        let value: f64 = match self.numbers {
            Numbers::Text => self.parsed(what)?,
            _ => f64::from_le_bytes(self.number_bytes(what)?),
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error_at(start, format!("{what} is {value}, not a finite number")))
        }
    }

    /// Checks that the rest of the file can contain `count` items of at least `words` words of text or `bytes` bytes of
    /// binary, before memory for them is allocated.
    pub(super) fn counted(&self, count: u64, words: u64, bytes: u64, what: &str) -> Result<usize, MeshError> {
        // A word takes a character and a separator, which the last one may lack.
        let each = if self.numbers == Numbers::Text { 2 * words } else { bytes };
        let left = self.rest().len() as u64 + 1;
        match usize::try_from(count) {
            Ok(fitting) if count.saturating_mul(each) <= left => Ok(fitting),
            _ => {
                Err(self.error(format!("{count} {what} are declared, but only {} bytes are left", left - 1)))
            }
        }
    }

    /// Requires the line `$End…` of a section, after white space.
    pub(super) fn end_section(&mut self, name: &str) -> Result<(), MeshError> {
        self.skip_white_space();
        let start = self.offset;
        let line = self.line();
        if line.strip_prefix(b"$End") == Some(name.as_bytes()) {
            Ok(())
        } else {
            Err(self.error_at(start, format!("expected $End{name}, found {}", shown(line))))
        }
    }

    /// Skips a section up to its line `$End…`.
    pub(super) fn skip_section(&mut self, name: &str) -> Result<(), MeshError> {
        let start = self.offset;
        let end = format!("$End{name}");
        let found = self
            .rest()
            .windows(end.len())
            .enumerate()
            .position(|(i, window)| window == end.as_bytes() && (i == 0 || self.rest()[i - 1] == b'\n'));
        match found {
            Some(position) => {
                self.offset += position;
                self.line();
                Ok(())
            }
            None => Err(self.error_at(start, format!("the section ${name} has no {end}"))),
        }
    }
}
