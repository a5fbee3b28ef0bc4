//! Reads a recording record by record, however damaged it is.
//!
//! A truncated or corrupted file declares lengths that it does not have. Nothing is allocated on such a declaration:
//! the file is read in pieces, and a chunk that declares more than `LARGEST_UNPACKED` ends the readable part.

use super::RecordError;
use ::mcap::records::{Record, op};
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, McapResult, parse_record};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Maximum unpacked size of a record or chunk [bytes], unless the file itself is larger. Chunks are closed at a few
/// megabytes; one message of the largest mesh is smaller than this.
const LARGEST_UNPACKED: usize = 256 << 20;

/// Bytes read from the file at a time.
const PIECE: usize = 256 << 10;

/// Passes every complete record of a file to `take`, including those inside chunks, but none of a chunk with a wrong
/// checksum. Returns why reading stopped early, or nothing if the file is complete; it also stops at a record that `take`
/// rejects as invalid MCAP.
///
/// # Errors
/// If the file cannot be read, and other errors of `take`.
pub fn for_each_record(
    path: &Path,
    take: impl FnMut(Record) -> Result<(), RecordError>,
) -> Result<Option<McapError>, RecordError> {
    let input = File::open(path).map_err(|source| RecordError::File { path: path.to_owned(), source })?;
    for_each_record_of(input, path, take)
}

/// As [`for_each_record`], for a source other than a file, called `name` in errors.
///
/// # Errors
/// As [`for_each_record`].
pub fn for_each_record_of(
    mut input: impl Read + Seek,
    name: &Path,
    mut take: impl FnMut(Record) -> Result<(), RecordError>,
) -> Result<Option<McapError>, RecordError> {
    let at = |source| RecordError::File { path: name.to_owned(), source };
    // The length of the file bounds every declared length.
    let length = input.seek(SeekFrom::End(0)).map_err(at)?;
    input.rewind().map_err(at)?;
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(length.max(LARGEST_UNPACKED));
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(size)) => {
                let read = input.read(reader.insert(size.min(PIECE))).map_err(at)?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => match parse(opcode, data) {
                Ok(record) => match take(record) {
                    Ok(()) => {}
                    // The record contradicts earlier ones.
                    Err(RecordError::Mcap(error)) if !matches!(error, McapError::Io(_)) => {
                        return Ok(Some(error));
                    }
                    Err(error) => return Err(error),
                },
                Err(error) => return Ok(Some(error)),
            },
            Err(error) => return Ok(Some(error)),
        }
    }
    Ok(None)
}

/// Parses a record. The parser slices an attachment by lengths that may overlap, so these are checked before.
fn parse(opcode: u8, body: &[u8]) -> McapResult<Record<'_>> {
    if opcode == op::ATTACHMENT && !has_room_for_attachment(body) {
        return Err(McapError::UnexpectedEof);
    }
    parse_record(opcode, body)
}

/// Whether the fields of an attachment fit into its record: two times, name and media type with their lengths, the
/// length of the data, and a final checksum.
fn has_room_for_attachment(body: &[u8]) -> bool {
    let after_text = |from: usize| {
        let length = body.get(from..from + 4)?.try_into().ok().map(u32::from_le_bytes)?;
        Some(from + 4 + length as usize)
    };
    after_text(16).and_then(after_text).is_some_and(|header| header + 8 + 4 <= body.len())
}
