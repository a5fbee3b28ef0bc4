//! Streams of gzip (RFC 1952) and zlib (RFC 1950), decompressed into as many bytes as are expected.

use super::error::malformed;
use crate::mesh::MeshError;
use miniz_oxide::inflate::{TINFLStatus, core};

/// Largest ratio of bytes after and before that deflate can have: 258 bytes for two bits, and some.
const LARGEST_RATIO: u64 = 1032;

/// Whether a file is a gzip stream.
pub(super) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b, 8])
}

/// Compressed bytes in a file.
#[derive(Clone, Copy)]
pub(super) struct Compressed<'a> {
    file: &'a [u8],
    /// Place of the deflate stream in the file.
    offset: usize,
    /// Whether it has the header of zlib; otherwise it is that of gzip, which is skipped already.
    is_zlib: bool,
}

impl<'a> Compressed<'a> {
    /// A zlib stream that begins at a byte of a file.
    pub(super) fn zlib(file: &'a [u8], offset: usize) -> Self {
        Self { file, offset, is_zlib: true }
    }

    /// A gzip stream that begins at a byte of a file.
    ///
    /// # Errors
    /// `Malformed` where its header is not one, or is cut short.
    pub(super) fn gzip(file: &'a [u8], offset: usize) -> Result<Self, MeshError> {
        let bytes = file.get(offset..).unwrap_or_default();
        let short = |at: usize| malformed(offset + at, "the gzip header is cut short");
        let header = bytes.get(..10).ok_or_else(|| short(bytes.len()))?;
        if !begins(bytes) {
            return Err(malformed(offset, "expected a gzip stream"));
        }
        let flags = header[3];
        if flags & 0xe0 != 0 {
            return Err(malformed(offset + 3, format!("the gzip header has the unknown flags {flags:#04x}")));
        }
        let mut at = 10;
        if flags & 4 != 0 {
            let size = bytes.get(at..at + 2).ok_or_else(|| short(at))?;
            at += 2 + usize::from(u16::from_le_bytes([size[0], size[1]]));
        }
        // The name of the file and a comment end with a zero.
        for flag in [8, 16] {
            if flags & flag != 0 {
                let rest = bytes.get(at..).ok_or_else(|| short(bytes.len()))?;
                at += 1 + rest.iter().position(|byte| *byte == 0).ok_or_else(|| short(bytes.len()))?;
            }
        }
        if flags & 2 != 0 {
            at += 2;
        }
        if at > bytes.len() {
            return Err(short(bytes.len()));
        }
        Ok(Self { file, offset: offset + at, is_zlib: false })
    }

    /// The deflate stream, and what follows it.
    fn deflate(&self) -> &'a [u8] {
        self.file.get(self.offset..).unwrap_or_default()
    }

    /// The first bytes, at most `most`; fewer where the content ends.
    ///
    /// # Errors
    /// `Malformed` where a stream is damaged.
    pub(super) fn first(&self, most: usize) -> Result<Vec<u8>, MeshError> {
        let mut out = vec![0; most];
        let (written, _) = self.fill(&mut out)?;
        out.truncate(written);
        Ok(out)
    }

    /// All bytes, of which there are `expected`.
    ///
    /// # Errors
    /// `Malformed` where a stream is damaged, for more or fewer bytes, and for anything but zeros after them; nothing is allocated for more
    /// than deflate can give.
    pub(super) fn all(&self, expected: u64) -> Result<Vec<u8>, MeshError> {
        let most = (self.deflate().len() as u64).saturating_mul(LARGEST_RATIO);
        let short = |found: u64| {
            malformed(
                self.offset,
                format!("the data are {expected} bytes, but decompress to {found} at most"),
            )
        };
        if expected > most {
            return Err(short(most));
        }
        // One byte more shows content beyond the end.
        let size = usize::try_from(expected).ok().and_then(|size| size.checked_add(1));
        let mut out = vec![0; size.ok_or_else(|| short(most))?];
        let (written, end) = self.fill(&mut out)?;
        if (written as u64) < expected {
            return Err(short(written as u64));
        }
        let Some(end) = end.filter(|_| written as u64 == expected) else {
            let message = format!(
                "the data are {expected} bytes, but decompress to more: the sizes or the type in the header are wrong"
            );
            return Err(malformed(self.offset, message));
        };
        let rest = self.file.get(end..).unwrap_or_default();
        if let Some(at) = rest.iter().position(|byte| *byte != 0) {
            let message = format!("{} bytes follow the compressed data: remove them", rest.len());
            return Err(malformed(end + at, message));
        }
        out.truncate(written);
        Ok(out)
    }

    /// Fills `out` with the content of this stream and of the members of gzip after it: the bytes written, and where the last stream ends in
    /// the file, if it was read to its end.
    fn fill(&self, out: &mut [u8]) -> Result<(usize, Option<usize>), MeshError> {
        let (mut part, mut filled) = (*self, 0);
        loop {
            let (status, read, written) = part.decompress(&mut out[filled..])?;
            let content = &out[filled..filled + written];
            filled += written;
            if status != TINFLStatus::Done {
                return Ok((filled, None));
            }
            if part.is_zlib {
                return Ok((filled, Some(part.offset + read)));
            }
            part.check_sum(content, read)?;
            // The check sum, and the number of bytes.
            let end = part.offset + read + 8;
            if filled == out.len() || !begins(self.file.get(end..).unwrap_or_default()) {
                return Ok((filled, Some(end)));
            }
            part = Self::gzip(self.file, end)?;
        }
    }

    /// Decompresses until `out` is full or the stream ends: how it went, bytes read and written.
    fn decompress(&self, out: &mut [u8]) -> Result<(TINFLStatus, usize, usize), MeshError> {
        let zlib = core::inflate_flags::TINFL_FLAG_PARSE_ZLIB_HEADER
            | core::inflate_flags::TINFL_FLAG_COMPUTE_ADLER32;
        let flags = core::inflate_flags::TINFL_FLAG_USING_NON_WRAPPING_OUTPUT_BUF
            | if self.is_zlib { zlib } else { 0 };
        let mut state = Box::<core::DecompressorOxide>::default();
        let (status, read, written) = core::decompress(&mut state, self.deflate(), out, 0, flags);
        match status {
            TINFLStatus::Done | TINFLStatus::HasMoreOutput => Ok((status, read, written)),
            TINFLStatus::FailedCannotMakeProgress | TINFLStatus::NeedsMoreInput => Err(malformed(
                self.offset + read,
                format!("the compressed data end here, after {written} bytes of content"),
            )),
            _ => Err(malformed(
                self.offset + read,
                format!("the compressed data are damaged, after {written} bytes of content"),
            )),
        }
    }

    /// Compares the content with the check sum after a gzip stream.
    fn check_sum(&self, content: &[u8], at: usize) -> Result<(), MeshError> {
        let place = self.offset + at;
        let Some(&[a, b, c, d]) = self.deflate().get(at..at + 4) else {
            return Err(malformed(place, "the gzip stream ends before its check sum"));
        };
        let [written, found] = [u32::from_le_bytes([a, b, c, d]), crc32(content)];
        if written == found {
            return Ok(());
        }
        Err(malformed(place, format!("the check sum of the content is {found:08x}, not {written:08x}")))
    }
}

/// CRC-32 of RFC 1952, section 8.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0_u32; 256];
        let mut i = 0;
        while i < 256 {
            let (mut c, mut bit) = (i as u32, 0);
            while bit < 8 {
                c = if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
                bit += 1;
            }
            table[i] = c;
            i += 1;
        }
        table
    };
    !bytes.iter().fold(!0, |c, byte| TABLE[usize::from(c as u8 ^ byte)] ^ (c >> 8))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    #[test]
    fn the_check_sum_is_that_of_the_standard() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn optional_fields_of_the_header_are_skipped() {
        let content = b"a content that is repeated: a content that is repeated";
        let mut file = vec![0x1f, 0x8b, 8, 4 | 8 | 16 | 2, 0, 0, 0, 0, 0, 3, 3, 0, 1, 2, 3];
        file.extend(b"name\0comment\0\x01\x02");
        file.extend(miniz_oxide::deflate::compress_to_vec(content, 6));
        file.extend(crc32(content).to_le_bytes());
        file.extend((content.len() as u32).to_le_bytes());
        let stream = Compressed::gzip(&file, 0).unwrap();
        assert_eq!(stream.first(9).unwrap(), b"a content");
        assert_eq!(stream.all(content.len() as u64).unwrap(), content);
        for end in 0..file.len() - 4 {
            let cut = Compressed::gzip(&file[..end], 0).and_then(|s| s.all(content.len() as u64));
            assert!(cut.is_err(), "{end}");
        }
        // Members one after another are one content, and zeros may follow.
        let twice = [&file[..], &file, &[0; 9]].concat();
        let whole = [&content[..], content].concat();
        assert_eq!(Compressed::gzip(&twice, 0).unwrap().all(2 * content.len() as u64).unwrap(), whole);
        assert_eq!(Compressed::gzip(&twice, 0).unwrap().first(60).unwrap(), whole[..60]);
        for (file, size, what) in [
            (&twice[..], content.len(), "decompress to more"),
            (&twice, 3 * content.len(), "decompress to 108 at most"),
            (&[&file[..], b"rest"].concat(), content.len(), "4 bytes follow"),
        ] {
            let error = Compressed::gzip(file, 0).and_then(|s| s.all(size as u64)).unwrap_err();
            assert!(error.to_string().contains(what), "{error}");
        }
        let last = file.len() - 5;
        file[last] ^= 1;
        let error = Compressed::gzip(&file, 0).and_then(|s| s.all(content.len() as u64)).unwrap_err();
        assert!(error.to_string().contains("check sum"), "{error}");
    }
}
