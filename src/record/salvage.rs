//! Makes a readable file from an unfinished recording: after a crash, or during the run.
//!
//! Chunks are written only when complete, so everything up to the last complete record is valid. It is copied to a new
//! file with its own index and summary section, marked as incomplete.

use super::RecordError;
use super::metadata::{ENDING_METADATA, ending_metadata};
use super::reader::for_each_record;
use super::writer::{partial_path, seal, write_options};
use ::mcap::records::Record;
use ::mcap::{Attachment, McapError, Writer};
use std::borrow::Cow;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Contents of a salvaged recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Salvaged {
    /// Number of messages in the file.
    pub messages: u64,
    /// Simulated time of the last message [s].
    pub time_s: f64,
}

/// After a crash: creates `path` from `<path>.partial`, marked as incomplete, and removes the partial file.
///
/// # Errors
/// If the partial file is missing or is no MCAP file, or the new one cannot be written.
pub fn reindex_incomplete(path: &Path) -> Result<Salvaged, RecordError> {
    let partial = partial_path(path);
    // The copy has a partial name of its own until complete, so that a crash here can be followed by another attempt.
    let copy = path.with_extension("salvaged");
    let why = "the process that wrote it was killed";
    let salvaged = copy_whole_records(&partial, &copy, "worker_lost", why)?;
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| RecordError::File { path, source }
    };
    std::fs::rename(&copy, path).map_err(at(path))?;
    std::fs::remove_file(&partial).map_err(at(&partial))?;
    Ok(salvaged)
}

/// During a run: writes the contents so far of its recording `path` to `target`, as a complete file.
///
/// # Errors
/// If the run has no partial file (not begun, or finished), or the snapshot cannot be written.
pub fn snapshot(path: &Path, target: &Path) -> Result<Salvaged, RecordError> {
    copy_whole_records(&partial_path(path), target, "running", "a snapshot of a run in progress")
}

/// Copies every complete record of `source` to `target`; leaves no file behind on failure.
fn copy_whole_records(
    source: &Path,
    target: &Path,
    ending: &str,
    why: &str,
) -> Result<Salvaged, RecordError> {
    copy_records(source, target, ending, why).inspect_err(|_| {
        // It may not even have been created; the first error is reported.
        let _ = std::fs::remove_file(partial_path(target));
    })
}

fn copy_records(source: &Path, target: &Path, ending: &str, why: &str) -> Result<Salvaged, RecordError> {
    let partial = partial_path(target);
    let output =
        BufWriter::new(File::create(&partial).map_err(|source| RecordError::File { path: partial, source })?);
    let mut copy = Copy { writer: write_options().create(output)?, salvaged: Salvaged::default() };
    // The valid part ends where reading stops; a file without the header of a recording has none.
    let mut has_begun = false;
    let broken_off = for_each_record(source, |record| {
        has_begun = true;
        copy.take(record)
    })?;
    if let Some(McapError::BadMagic) = broken_off
        && !has_begun
    {
        return Err(McapError::BadMagic.into());
    }
    let Salvaged { time_s, .. } = copy.salvaged;
    let metadata = ending_metadata(false, ending, why, time_s, 0);
    copy.writer.write_metadata(&::mcap::records::Metadata { name: ENDING_METADATA.into(), metadata })?;
    copy.writer.finish()?;
    seal(copy.writer.into_inner(), target)?;
    Ok(copy.salvaged)
}

struct Copy {
    writer: Writer<BufWriter<File>>,
    salvaged: Salvaged,
}

impl Copy {
    /// Copies one record, except those of the old file's index.
    fn take(&mut self, record: Record) -> Result<(), RecordError> {
        match record {
            Record::Schema { header, data } => {
                self.writer.add_schema_with_id(header.id, &header.name, &header.encoding, &data)?;
            }
            Record::Channel(c) => {
                self.writer.add_channel_with_id(
                    c.id,
                    c.schema_id,
                    &c.topic,
                    &c.message_encoding,
                    &c.metadata,
                )?;
            }
            Record::Message { header, data } => {
                self.writer.write_to_known_channel(&header, &data)?;
                self.salvaged.messages += 1;
                self.salvaged.time_s = header.publish_time as f64 * 1e-9;
            }
            Record::Attachment { header, data, .. } => self.writer.attach(&Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data: Cow::Borrowed(&data),
            })?,
            // A run killed after its final record has one already; another would contradict it.
            Record::Metadata(metadata) if metadata.name != ENDING_METADATA => {
                self.writer.write_metadata(&metadata)?;
            }
            _ => {}
        }
        Ok(())
    }
}
