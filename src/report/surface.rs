//! The surfaces of the bodies at one field time, deformed, as triangles.

use super::ReadError;
use super::fields::{field_times, for_each_block};
pub use super::surface_file::{write_ply, write_stl};
use crate::mechanics::contact::Surface;
use crate::mesh::{Cells, surface};
use crate::record::RecordError;
use crate::record::scene_update::triangles;
use crate::record::vtk::{Block, BlockSurface, Blocks};
use std::io::{Read, Seek};
use std::path::Path;

/// Surfaces of bodies at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surfaces {
    /// Field time [s].
    pub time_s: f64,
    /// Surfaces of the deformable bodies.
    pub bodies: Vec<BodySurface>,
}

/// Surface of one body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodySurface {
    /// Name of the body.
    pub name: String,
    /// Positions of the corners [m].
    pub positions: Vec<[f32; 3]>,
    /// Corners of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Surfaces of the bodies at the field time nearest to `time_s`, or at the last one.
///
/// # Errors
/// As [`for_each_block`], and if the recording has no fields or none around that time.
pub fn surfaces_at(
    mut input: impl Read + Seek,
    name: &Path,
    time_s: Option<f64>,
) -> Result<Surfaces, ReadError> {
    let times = field_times(&mut input, name)?;
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return Err(ReadError::Fields(RecordError::NoFields));
    };
    let requested = time_s.unwrap_or(last);
    // What is read as milliseconds and printed in seconds may differ in the last digit.
    let slack = 1e-9 * last.abs();
    if !(first - slack..=last + slack).contains(&requested) {
        return Err(ReadError::NoSuchTime { path: name.to_owned(), requested, first, last });
    }
    let nearest = times.into_iter().min_by(|a, b| (a - requested).abs().total_cmp(&(b - requested).abs()));
    let mut surfaces = Surfaces { time_s: nearest.unwrap_or(last), bodies: Vec::new() };
    for_each_block(input, name, &mut surfaces)?;
    Ok(surfaces)
}

impl Blocks for Surfaces {
    fn wants(&mut self, time_s: f64) -> bool {
        time_s.to_bits() == self.time_s.to_bits()
    }

    fn block(&mut self, block: &Block) -> Result<(), RecordError> {
        let (positions, triangles) = match block.surface {
            BlockSurface::Cells(cells, eroded) => skin(cells, eroded, block.positions),
            BlockSurface::Triangles(corners) => (block.positions.to_vec(), corners.to_vec()),
            BlockSurface::None => return Ok(()),
        };
        let triangles = triangles.as_chunks().0.to_vec();
        self.bodies.push(BodySurface { name: block.name.to_string(), positions, triangles });
        Ok(())
    }
}

/// Corners and triangles of the boundary surface of the cells that are not eroded.
fn skin(cells: &Cells, eroded: &[u8], positions: &[[f32; 3]]) -> (Vec<[f32; 3]>, Vec<u32>) {
    let is_intact = |cell: usize| eroded.get(cell).is_none_or(|&gone| gone == 0);
    let intact: Cells =
        cells.iter().enumerate().filter(|(i, _)| is_intact(*i)).map(|(_, cell)| cell).collect();
    let faces = surface::boundary(&intact);
    let surface = Surface::new(surface::boundary_nodes(&faces), faces);
    let corners = surface.nodes.iter().map(|&node| positions[node as usize]).collect();
    (corners, triangles(&surface))
}
