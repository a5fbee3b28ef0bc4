//! An archive of a series in the format of `tar` (POSIX.1-1988 ustar), for a stream: it needs no length in advance.

use super::series::Place;
use crate::record::RecordError;
use std::io::{self, Write};

/// Size of a block of the archive [bytes].
const BLOCK: usize = 512;
/// Longest name of a series.
const LONGEST_SERIES: usize = 32;
/// Longest path of a file [bytes].
const LONGEST_NAME: usize = 100;
/// Largest file, of eleven octal digits [bytes].
const LARGEST_FILE: usize = 0o777_7777_7777;

/// An archive with a series called `name`: `name.pvd` and the files in `name_vtu/`.
#[derive(Debug)]
pub struct Archive<W> {
    out: W,
    name: String,
    folder: String,
}

impl<W: Write> Archive<W> {
    /// An archive written to `out`. Of a longer name the beginning is used, so that the paths fit.
    pub fn new(out: W, name: &str) -> Self {
        let name: String = name.chars().take(LONGEST_SERIES).collect();
        Self { out, folder: super::folder_name(&name), name }
    }

    fn entry(&mut self, path: &str, content: &[u8]) -> Result<(), RecordError> {
        let written = header(path, content.len()).and_then(|header| {
            self.out.write_all(&header)?;
            self.out.write_all(content)?;
            self.out.write_all(&[0; BLOCK][..content.len().next_multiple_of(BLOCK) - content.len()])
        });
        written.map_err(|source| RecordError::File { path: path.into(), source })
    }
}

impl<W: Write> Place for Archive<W> {
    fn put(&mut self, name: &str, content: &[u8]) -> Result<(), RecordError> {
        self.entry(&format!("{}/{name}", self.folder), content)
    }

    fn folder(&self) -> &str {
        &self.folder
    }

    fn close(mut self, pvd: &str) -> Result<(), RecordError> {
        let path = format!("{}.pvd", self.name);
        self.entry(&path, pvd.as_bytes())?;
        // Two empty blocks end an archive.
        let ended = self.out.write_all(&[0; 2 * BLOCK]).and_then(|()| self.out.flush());
        ended.map_err(|source| RecordError::File { path: path.into(), source })
    }

    /// What is in a stream stays there; without its end it is no archive.
    fn discard(self) {}
}

/// Header of a file. Its time is 0, so that equal recordings give equal archives.
fn header(path: &str, size: usize) -> io::Result<[u8; BLOCK]> {
    if path.len() > LONGEST_NAME || size > LARGEST_FILE {
        return Err(io::Error::other(format!("{path} of {size} bytes exceeds what an archive can hold")));
    }
    let mut header = [0; BLOCK];
    let mut put = |at: usize, text: &str| header[at..at + text.len()].copy_from_slice(text.as_bytes());
    put(0, path);
    put(100, "0000644\0");
    put(108, "0000000\0");
    put(116, "0000000\0");
    put(124, &format!("{size:011o}\0"));
    put(136, "00000000000\0");
    // The checksum counts as spaces in itself.
    put(148, "        ");
    put(156, "0");
    put(257, "ustar\x0000");
    let sum: u32 = header.iter().map(|&byte| u32::from(byte)).sum();
    header[148..156].copy_from_slice(format!("{sum:06o}\0 ").as_bytes());
    Ok(header)
}
