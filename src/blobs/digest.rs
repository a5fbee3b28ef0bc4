//! Incremental SHA-256 of bytes.

use sha2::{Digest, Sha256};
use std::io::{self, Read};

/// Number of bytes read at a time.
const PIECE: usize = 1 << 20;

/// Size and digest of a sequence of bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlobDigest {
    /// Length of the sequence [bytes].
    pub bytes: u64,
    /// SHA-256 in lower-case hexadecimal.
    pub sha256: String,
}

impl BlobDigest {
    /// Size and digest of everything that can be read from `input`.
    ///
    /// # Errors
    /// When reading fails.
    pub fn of(input: impl Read) -> io::Result<Self> {
        let mut digester = Digester::default();
        pieces(input, |piece| {
            digester.update(piece);
            Ok::<_, io::Error>(())
        })?;
        Ok(digester.digest())
    }
}

/// Reads `input` to its end and passes it to `take` piece by piece.
pub(super) fn pieces<E: From<io::Error>>(
    mut input: impl Read,
    mut take: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let mut buffer = vec![0_u8; PIECE];
    loop {
        match input.read(&mut buffer)? {
            0 => return Ok(()),
            n => take(&buffer[..n])?,
        }
    }
}

/// Counts and digests bytes.
#[derive(Clone, Debug, Default)]
pub struct Digester {
    sha: Sha256,
    bytes: u64,
}

impl Digester {
    /// Appends bytes to the sequence.
    pub fn update(&mut self, bytes: &[u8]) {
        self.sha.update(bytes);
        self.bytes += bytes.len() as u64;
    }

    /// Number of bytes so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Size and digest of the bytes so far.
    pub fn digest(&self) -> BlobDigest {
        BlobDigest { bytes: self.bytes, sha256: hexadecimal(&self.sha.clone().finalize()) }
    }
}

/// Lower-case hexadecimal digits of bytes.
pub fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_that_of_the_bytes() {
        let digest = BlobDigest::of(&b"abc"[..]).unwrap();
        assert_eq!(digest.bytes, 3);
        // SHA-256 of "abc", FIPS 180-2, appendix B.1.
        assert_eq!(digest.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
