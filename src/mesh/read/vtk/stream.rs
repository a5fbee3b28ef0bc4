//! Bytes of an array in an XML file: raw, or in base64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// A sequence of bytes that is read from the front.
pub(super) enum Stream<'a> {
    /// The bytes of the file as they are.
    Raw(&'a [u8]),
    /// Digits with the values of 6 bits, four for three bytes, with white space between them. Padding ends a group; another
    /// may follow.
    Base64 {
        /// The digits that are left.
        digits: &'a [u8],
        /// Decoded bytes that were not taken yet: fewer than three.
        left: Vec<u8>,
    },
}

impl<'a> Stream<'a> {
    /// A stream of digits.
    pub(super) fn base64(digits: &'a [u8]) -> Self {
        Self::Base64 { digits, left: Vec::new() }
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// A message when there are fewer, or a digit that is none.
    pub(super) fn take(&mut self, count: usize) -> Result<Vec<u8>, String> {
        let short = |there: usize| format!("{count} bytes are declared, and at most {there} are left");
        match self {
            Self::Raw(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count).ok_or_else(|| short(bytes.len()))?;
                *bytes = rest;
                Ok(taken.to_vec())
            }
            Self::Base64 { digits, left } => {
                let most = left.len() + digits.len() / 4 * 3;
                if count > most {
                    return Err(short(most));
                }
                let mut out = std::mem::take(left);
                out.reserve_exact(count.saturating_sub(out.len()) + 2);
                while out.len() < count {
                    let group = next_group(digits).ok_or_else(|| short(out.len()))?;
                    STANDARD.decode_vec(group, &mut out).map_err(|error| format!("base64: {error}"))?;
                }
                *left = out.split_off(count);
                Ok(out)
            }
        }
    }
}

/// The next four digits that are no white space; `None` when fewer are left.
fn next_group(digits: &mut &[u8]) -> Option<[u8; 4]> {
    let mut group = [0; 4];
    for place in &mut group {
        *digits = digits.trim_ascii_start();
        let (&digit, rest) = digits.split_first()?;
        (*place, *digits) = (digit, rest);
    }
    Some(group)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_with_and_without_padding_are_one_stream() {
        // "abcd" with padding, followed by "efghij" in two groups with a line break.
        let mut stream = Stream::base64(b" YWJjZA==ZW\nZnaGlq");
        assert_eq!(stream.take(2).unwrap(), b"ab");
        assert_eq!(stream.take(4).unwrap(), b"cdef");
        assert_eq!(stream.take(4).unwrap(), b"ghij");
        assert!(stream.take(1).is_err());
        assert_eq!(Stream::base64(b"YWJj").take(0).unwrap(), b"");
    }

    #[test]
    fn what_is_not_there_is_not_allocated() {
        assert!(Stream::Raw(b"abc").take(usize::MAX).is_err());
        assert!(Stream::base64(b"YWJj").take(usize::MAX).is_err());
        assert!(Stream::base64(b"YW!j").take(3).unwrap_err().contains("base64"));
    }
}
