//! A series of `.vtu` files with the `.pvd` file that lists them by time and part.

use super::array::escaped;
use super::block::{Block, Blocks};
use crate::record::RecordError;
use std::fmt::Write as _;

/// Longest name of a body in the name of a file; part and time make it unique.
const LONGEST_NAME: usize = 40;

/// Where the files of a series go.
pub trait Place {
    /// Stores a file of the folder of the series.
    ///
    /// # Errors
    /// If it cannot be written.
    fn put(&mut self, name: &str, content: &[u8]) -> Result<(), RecordError>;
    /// Name of the folder, as the `.pvd` file beside it says it.
    fn folder(&self) -> &str;
    /// Stores the `.pvd` file, the last one.
    ///
    /// # Errors
    /// If it cannot be written.
    fn close(self, pvd: &str) -> Result<(), RecordError>;
    /// Instead of closing: removes what has been stored, where that is possible.
    fn discard(self);
}

/// A series being written: one file in memory at a time.
#[derive(Debug)]
pub struct Series<P> {
    place: P,
    /// Lines of the `.pvd` file.
    list: String,
    /// Latest time [s], and how many there were.
    time_s: Option<f64>,
    times: usize,
}

impl<P: Place> Series<P> {
    /// A series without times, to be written at a place.
    pub fn new(place: P) -> Self {
        Self { place, list: String::new(), time_s: None, times: 0 }
    }

    /// Number of times so far.
    pub fn times(&self) -> usize {
        self.times
    }

    /// Writes the list; without any time there is no series.
    ///
    /// # Errors
    /// If it cannot be written, or there is no time.
    pub fn finish(self) -> Result<(), RecordError> {
        if self.times == 0 {
            self.place.discard();
            return Err(RecordError::NoFields);
        }
        self.place.close(&format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  \
             <Collection>\n{}  </Collection>\n</VTKFile>\n",
            self.list
        ))
    }

    /// Instead of finishing: removes what has been stored, where that is possible.
    pub fn discard(self) {
        self.place.discard();
    }
}

impl<P: Place> Blocks for Series<P> {
    fn block(&mut self, block: &Block) -> Result<(), RecordError> {
        if self.time_s != Some(block.time_s) {
            self.time_s = Some(block.time_s);
            self.times += 1;
        }
        let file = format!("{}_{}_{:04}.vtu", block.part, file_name(&block.name), self.times - 1);
        let mut content = Vec::new();
        block
            .grid
            .write(&mut content)
            .map_err(|source| RecordError::File { path: (&file).into(), source })?;
        self.place.put(&file, &content)?;
        // A time that is written as Rust does is read as the same double.
        let _ = writeln!(
            self.list,
            "    <DataSet timestep=\"{:e}\" group=\"\" part=\"{}\" name=\"{}\" file=\"{}/{file}\"/>",
            block.time_s,
            block.part,
            escaped(&block.name),
            escaped(self.place.folder()),
        );
        Ok(())
    }
}

/// A name that every file system and archive takes.
fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().map(plain).take(LONGEST_NAME).collect()
}
