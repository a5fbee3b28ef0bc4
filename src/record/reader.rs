//! Reading a recording record by record, however damaged it is.
//!
//! A torn or mutated file claims lengths that it does not have. Nothing is allocated by such a claim: the file is read in pieces,
//! and a chunk that says it unpacks to more than `LARGEST_UNPACKED` is the end of what is good.

use super::RecordError;
use ::mcap::records::{Record, op};
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, McapResult, parse_record};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Most that one record or one chunk may unpack to [bytes], unless the file itself is larger. Chunks are closed at
/// a few megabytes; one message of the largest mesh is less than this.
const LARGEST_UNPACKED: usize = 256 << 20;

/// What is read of the file at a time [bytes].
const PIECE: usize = 256 << 10;

/// Hands every whole record of a file to `take`, those inside chunks too; a chunk whose checksum is wrong is not begun.
/// Returns why the file broke off, nothing when it is whole to its end; it also breaks off at a record that `take` refuses as one
/// of no MCAP file.
///
/// # Errors
/// When the file cannot be read, and what else `take` says.
pub fn for_each_record(
    path: &Path,
    take: impl FnMut(Record) -> Result<(), RecordError>,
) -> Result<Option<McapError>, RecordError> {
    let input = File::open(path).map_err(|source| RecordError::File { path: path.to_owned(), source })?;
    for_each_record_of(input, path, take)
}

/// As [`for_each_record`], of what is not a file and called `name` in errors.
///
/// # Errors
/// As [`for_each_record`].
pub fn for_each_record_of(
    mut input: impl Read + Seek,
    name: &Path,
    mut take: impl FnMut(Record) -> Result<(), RecordError>,
) -> Result<Option<McapError>, RecordError> {
    let at = |source| RecordError::File { path: name.to_owned(), source };
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
                    // It contradicts what came before.
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

/// A record of its bytes. The parser slices an attachment by lengths that may overlap: such a one is refused before.
fn parse(opcode: u8, body: &[u8]) -> McapResult<Record<'_>> {
    if opcode == op::ATTACHMENT && !has_room_for_attachment(body) {
        return Err(McapError::UnexpectedEof);
    }
    parse_record(opcode, body)
}

/// Whether the fields of an attachment fit into its record: two times, name and media type with their lengths, the length of
/// the data, and at the end a checksum.
fn has_room_for_attachment(body: &[u8]) -> bool {
    let after_text = |from: usize| {
        let length = body.get(from..from + 4)?.try_into().ok().map(u32::from_le_bytes)?;
        Some(from + 4 + length as usize)
    };
    after_text(16).and_then(after_text).is_some_and(|header| header + 8 + 4 <= body.len())
}
