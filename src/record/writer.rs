//! The underlying file of a recording: `.partial` until complete, chunks, times, metadata and attachments.

use super::RecordError;
use super::partial_file::open_exclusively;
use super::proto::schema_of;
use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::{Attachment, Compression, WriteOptions, Writer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Target size of a chunk before compression [bytes].
const CHUNK_SIZE: u64 = 4 * 1024 * 1024;

/// Compression level of zstd: the fastest that encodes bytes by how frequent they are, which is what rounded numbers gain from.
const COMPRESSION_LEVEL: u32 = 1;

/// Name of a recording while it is written: `run.mcap` is `run.mcap.partial`.
pub fn partial_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".partial");
    PathBuf::from(name)
}

/// Scale from simulated time to playback time: `log_time = time × 10ⁿ`, such that the run lasts 1 to 10 s.
///
/// Players cannot play a run of a millisecond: their slowest speed is a hundredth and they read ahead by a tenth of a
/// second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeScale {
    /// Factor 10ⁿ from simulated to log time.
    pub factor: f64,
}

impl TimeScale {
    /// Scale for a run of `end_time` [s].
    pub fn for_run(end_time: f64) -> Self {
        if !(end_time > 0.0 && end_time.is_finite()) {
            return Self { factor: 1.0 };
        }
        // log10 may have a rounding error at powers of ten.
        let mut exponent = -end_time.log10().floor() as i32;
        if end_time * 10f64.powi(exponent) < 1.0 - 1e-9 {
            exponent += 1;
        } else if end_time * 10f64.powi(exponent) >= 10.0 - 1e-9 {
            exponent -= 1;
        }
        Self { factor: 10f64.powi(exponent) }
    }

    /// Log time of a simulated time [s], in nanoseconds.
    pub fn log_time(&self, time: f64) -> u64 {
        nanoseconds(time * self.factor)
    }
}

/// Nanoseconds of a time [s], rounded; 0 before the start.
#[allow(clippy::cast_sign_loss)] // never negative
fn nanoseconds(time: f64) -> u64 {
    (time.max(0.0) * 1e9).round() as u64
}

/// Write options of every recording.
pub(super) fn write_options() -> WriteOptions {
    WriteOptions::new()
        .library(concat!("contuse ", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        .compression_level(COMPRESSION_LEVEL)
        // The threads of the job are reserved for the job; the bytes do not depend on it.
        .compression_threads(0)
        .chunk_size(Some(CHUNK_SIZE))
        // Chunks are written when complete, never with a length to be filled in later, so that the file of a killed
        // process is readable up to its last chunk.
        .disable_seeking(true)
}

/// A recording being written.
pub(super) struct RecordingWriter {
    writer: Writer<BufWriter<File>>,
    path: PathBuf,
    scale: TimeScale,
    /// Registered schemas by name.
    schemas: BTreeMap<String, u16>,
    sequences: BTreeMap<u16, u32>,
    last_log_time: Option<u64>,
    pending_bytes: usize,
}

impl RecordingWriter {
    /// Creates `<path>.partial`, locked for exclusive access.
    pub fn create(path: &Path, scale: TimeScale) -> Result<Self, RecordError> {
        let file = open_exclusively(&partial_path(path))?;
        let writer = write_options().create(BufWriter::new(file))?;
        Ok(Self {
            writer,
            path: path.to_owned(),
            scale,
            schemas: BTreeMap::new(),
            sequences: BTreeMap::new(),
            last_log_time: None,
            pending_bytes: 0,
        })
    }

    /// Adds a channel for protobuf messages.
    pub fn add_channel(&mut self, topic: &str, schema: &str) -> Result<u16, RecordError> {
        let schema = if let Some(id) = self.schemas.get(schema) {
            *id
        } else {
            let id = self.writer.add_schema(schema, "protobuf", &schema_of(schema)?)?;
            self.schemas.insert(schema.to_owned(), id);
            id
        };
        Ok(self.writer.add_channel(schema, topic, "protobuf", &BTreeMap::new())?)
    }

    /// Writes a message at a simulated time [s]. Log times of a file are strictly increasing: messages of one step
    /// follow each other by a nanosecond.
    pub fn write(
        &mut self,
        channel: u16,
        time: f64,
        message: &impl prost::Message,
    ) -> Result<(), RecordError> {
        let data = message.encode_to_vec();
        let earliest = self.last_log_time.map_or(0, |last| last + 1);
        let log_time = self.scale.log_time(time).max(earliest);
        self.last_log_time = Some(log_time);
        let sequence = self.sequences.entry(channel).or_insert(0);
        let publish_time = nanoseconds(time);
        let header = MessageHeader { channel_id: channel, sequence: *sequence, log_time, publish_time };
        *sequence += 1;
        self.pending_bytes += data.len();
        self.writer.write_to_known_channel(&header, &data)?;
        Ok(())
    }

    /// Closes the chunk and flushes to the operating system if at least `bytes` are pending.
    pub fn flush_if(&mut self, bytes: usize) -> Result<(), RecordError> {
        if self.pending_bytes >= bytes {
            self.pending_bytes = 0;
            self.writer.flush()?;
        }
        Ok(())
    }

    /// Writes a metadata record.
    pub fn write_metadata(
        &mut self,
        name: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<(), RecordError> {
        Ok(self.writer.write_metadata(&Metadata { name: name.into(), metadata })?)
    }

    /// Attaches a JSON document. Its times are simulated, not wall-clock times, so that equal runs give equal files.
    pub fn attach(&mut self, name: &str, json: &[u8]) -> Result<(), RecordError> {
        Ok(self.writer.attach(&Attachment {
            log_time: self.last_log_time.unwrap_or(0),
            create_time: 0,
            name: name.into(),
            media_type: "application/json".into(),
            data: Cow::Borrowed(json),
        })?)
    }

    /// Writes the summary section, makes the file durable and renames it to its final name.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.writer.finish()?;
        seal(self.writer.into_inner(), &self.path)
    }

    /// Removes the partial file; a finished recording of the same name stays.
    pub fn discard(self) {
        let partial = partial_path(&self.path);
        drop(self.writer);
        if let Err(error) = std::fs::remove_file(&partial) {
            tracing::warn!(path = %partial.display(), %error, "a discarded recording could not be removed");
        }
    }
}

/// Makes a finished `<path>.partial` durable and renames it to `path`.
pub(super) fn seal(file: BufWriter<File>, path: &Path) -> Result<(), RecordError> {
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| RecordError::File { path, source }
    };
    let partial = partial_path(path);
    let file = file.into_inner().map_err(|e| at(&partial)(e.into_error()))?;
    file.sync_all().map_err(at(&partial))?;
    std::fs::rename(&partial, path).map_err(at(path))?;
    // The rename is durable once the folder is synchronised.
    #[cfg(unix)]
    {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        File::open(folder).and_then(|f| f.sync_all()).map_err(at(folder))?;
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;

    #[test]
    fn runs_last_one_to_ten_seconds() {
        for (end, factor) in [
            (1e-4, 1e4),
            (5e-3, 1e3),
            (9.99e-5, 1e5),
            (1.0, 1.0),
            (10.0, 0.1),
            (2.5, 1.0),
            (1e-6, 1e6),
            (0.001, 1e3),
        ] {
            let scale = TimeScale::for_run(end);
            assert!((scale.factor / factor - 1.0).abs() < 1e-12, "{end}: {}", scale.factor);
            let played = end * scale.factor;
            assert!((1.0 - 1e-9..10.0).contains(&played), "{end}: {played}");
        }
        assert_eq!(TimeScale::for_run(0.0).factor, 1.0);
    }

    #[test]
    fn a_partial_file_stands_beside_the_recording() {
        assert_eq!(partial_path(Path::new("a/run.mcap")), Path::new("a/run.mcap.partial"));
    }
}
