//! Blocks of compressed bytes. Sizes are checked before anything of that size is allocated.

use super::stream::Stream;

/// Bytes to which the arrays of any file may decompress.
const ALWAYS_ALLOWED: u64 = 64 << 20;
/// Bytes to which they may decompress for each byte of the file: more than meshes do, less than what is made to explode.
const ALLOWED_A_BYTE: u64 = 50;

/// How blocks are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
}

/// Number of bytes to which the arrays of a file of this size may decompress.
pub(super) fn most_decompressed(file: usize) -> u64 {
    ALWAYS_ALLOWED + ALLOWED_A_BYTE * file as u64
}

impl Compressor {
    /// All blocks of an array, decompressed. `header` reads a number of the header; `left` is the number of bytes that may
    /// still be decompressed.
    ///
    /// # Errors
    /// A message when sizes or blocks are wrong.
    pub(super) fn decompress(
        self,
        stream: &mut Stream,
        header: impl Fn(&mut Stream) -> Result<u64, String>,
        left: &mut u64,
    ) -> Result<Vec<u8>, String> {
        let [blocks, size, last] = [header(stream)?, header(stream)?, header(stream)?];
        // The last block is shorter, unless its size is zero.
        let whole = if last == 0 { blocks } else { blocks.saturating_sub(1) };
        let total = whole.saturating_mul(size).saturating_add(last);
        let allowed = left.checked_sub(total).filter(|_| last <= size || blocks == 0);
        *left = allowed.ok_or_else(|| {
            format!("{blocks} blocks of {size} bytes, of which {left} are allowed here: save it without compression")
        })?;
        // As many sizes as the stream has at least: each is read before the next is stored.
        let mut sizes = Vec::new();
        for _ in 0..blocks {
            sizes.push(header(stream)?);
        }
        let mut out = Vec::with_capacity(total as usize);
        for (block, compressed) in (0..).zip(sizes) {
            let expected = if block < whole { size } else { last } as usize;
            let compressed = stream.take(usize::try_from(compressed).unwrap_or(usize::MAX))?;
            let start = out.len();
            out.resize(start + expected, 0);
            let written = self.block(&compressed, &mut out[start..]);
            if written != Some(expected) {
                return Err(format!("block {block} does not decompress to {expected} bytes"));
            }
        }
        Ok(out)
    }

    /// Decompresses one block, and returns the number of bytes written; `None` for an invalid block or one that is longer.
    fn block(self, compressed: &[u8], out: &mut [u8]) -> Option<usize> {
        match self {
            Self::Zlib => {
                use miniz_oxide::inflate::{TINFLStatus, core};
                let flags = core::inflate_flags::TINFL_FLAG_PARSE_ZLIB_HEADER
                    | core::inflate_flags::TINFL_FLAG_USING_NON_WRAPPING_OUTPUT_BUF
                    | core::inflate_flags::TINFL_FLAG_COMPUTE_ADLER32;
                let mut state = Box::<core::DecompressorOxide>::default();
                let (status, _, written) = core::decompress(&mut state, compressed, out, 0, flags);
                (status == TINFLStatus::Done).then_some(written)
            }
            Self::Lz4 => lz4_flex::block::decompress_into(compressed, out).ok(),
        }
    }
}
