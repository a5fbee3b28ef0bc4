//! The fields of a recording, block by block, with one block in memory at a time.

use super::ReadError;
use crate::record::RecordError;
use crate::record::reader::for_each_record_of;
use crate::record::vtk::{Assembler, Block, Blocks, Place, Series};
use ::mcap::records::Record;
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::Path;

/// Passes the blocks of a recording to `to`; `name` is the name of the recording in errors.
///
/// # Errors
/// If the recording cannot be read to its end, contradicts itself, or a block cannot be written.
pub fn for_each_block(input: impl Read + Seek, name: &Path, to: &mut dyn Blocks) -> Result<(), ReadError> {
    let (mut assembler, mut topics) = (Assembler::default(), BTreeMap::new());
    let broken_off = for_each_record_of(input, name, |record| {
        match record {
            Record::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                if let Some(topic) = topics.get(&header.channel_id) {
                    assembler.take(topic, &data, to)?;
                }
            }
            _ => {}
        }
        Ok(())
    });
    match broken_off.map_err(ReadError::Fields)? {
        Some(source) => Err(ReadError::Mcap { path: name.to_owned(), source }),
        None => assembler.finish(to).map_err(ReadError::Fields),
    }
}

/// Writes the fields of a recording as a series of VTK files; returns the number of field times.
///
/// # Errors
/// As [`for_each_block`], and if the recording has no fields.
pub fn write_series(input: impl Read + Seek, name: &Path, place: impl Place) -> Result<usize, ReadError> {
    let mut series = Series::new(place);
    if let Err(error) = for_each_block(input, name, &mut series) {
        series.discard();
        return Err(error);
    }
    let times = series.times();
    series.finish().map_err(ReadError::Fields)?;
    Ok(times)
}

/// The field times of a recording [s].
///
/// # Errors
/// As [`for_each_block`].
pub fn field_times(input: impl Read + Seek, name: &Path) -> Result<Vec<f64>, ReadError> {
    let mut times = Times::default();
    for_each_block(input, name, &mut times)?;
    Ok(times.0)
}

/// Notes the field times, and needs no block.
#[derive(Default)]
struct Times(Vec<f64>);

impl Blocks for Times {
    fn wants(&mut self, time_s: f64) -> bool {
        if self.0.last() != Some(&time_s) {
            self.0.push(time_s);
        }
        false
    }

    fn block(&mut self, _: &Block) -> Result<(), RecordError> {
        Ok(())
    }
}
