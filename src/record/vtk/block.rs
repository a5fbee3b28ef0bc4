//! Blocks: what a recording holds of one body, or of the contacts of one pair, at one field time.

use super::grid::Grid;
use crate::mesh::Cells;
use crate::record::RecordError;
use std::borrow::Cow;

/// One body, or the contacts of one pair, at one time.
#[derive(Debug)]
pub struct Block<'a> {
    /// Field time [s].
    pub time_s: f64,
    /// Number among the blocks of a time, the same at all times.
    pub part: usize,
    /// Name of the body, or `contact ` and that of the pair.
    pub name: Cow<'a, str>,
    /// Points, cells and arrays.
    pub grid: Grid<'a>,
    /// Points as numbers: x, y, z of each [m].
    pub positions: &'a [[f32; 3]],
    /// What its surface is made of.
    pub surface: BlockSurface<'a>,
}

/// What the surface of a block is made of.
#[derive(Clone, Copy, Debug)]
pub enum BlockSurface<'a> {
    /// The outer faces of cells, where they are not eroded (1 for each eroded cell; empty if the body cannot erode).
    Cells(&'a Cells, &'a [u8]),
    /// Triangles, by the numbers of their corners.
    Triangles(&'a [u32]),
    /// No faces: the block is drawn as points.
    None,
}

/// A destination of blocks.
pub trait Blocks {
    /// Whether it needs the blocks of a field time [s]; the others are not made.
    fn wants(&mut self, _time_s: f64) -> bool {
        true
    }
    /// Receives the next block: in the order of times, and of parts at each time.
    ///
    /// # Errors
    /// If it cannot be written.
    fn block(&mut self, block: &Block) -> Result<(), RecordError>;
}
