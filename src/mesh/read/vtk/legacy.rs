//! Legacy VTK files, versions 1 to 5.1, ASCII and binary ("VTK File Formats", kitware).

use super::grid::Grid;
use super::labels::Owner;
use super::scalar::{Scalar, Values, read_values};
use super::text::unescaped;
use crate::mesh::read::FieldNames;
use crate::mesh::read::cursor::{Cursor, Numbers, place_of, shown};
use crate::mesh::{Mesh, MeshError};
use std::borrow::Cow;

/// Reads a legacy file.
///
/// # Errors
/// As [`read_mesh`](crate::mesh::read::read_mesh).
pub(super) fn read(bytes: &[u8], fields: &FieldNames) -> Result<Mesh, MeshError> {
    let mut cursor = Cursor::new(bytes);
    let version = read_version(&mut cursor)?;
    // The title.
    cursor.line();
    let start = cursor.offset();
    match cursor.line().to_ascii_uppercase().as_slice() {
        b"ASCII" => {}
        b"BINARY" => cursor.numbers = Numbers::BigEndian,
        other => {
            return Err(cursor.error_at(start, format!("expected ASCII or BINARY, found {}", shown(other))));
        }
    }
    let mut reader = Reader { cursor, version, grid: Grid::new(fields), owner: None };
    while !reader.cursor.at_end() {
        reader.section()?;
    }
    let numbers = reader.cursor.numbers;
    reader.grid.into_mesh(|offset| place_of(bytes, offset, numbers))
}

/// The major version from the first line.
fn read_version(cursor: &mut Cursor) -> Result<u32, MeshError> {
    let line = cursor.line();
    let text = String::from_utf8_lossy(line);
    let version =
        text.to_ascii_lowercase().strip_prefix("# vtk datafile version").map(|v| v.trim().to_owned());
    let major = version.as_deref().and_then(|v| v.split('.').next()?.parse().ok());
    match major {
        Some(major @ 1..=5) => Ok(major),
        Some(_) => Err(MeshError::Unsupported {
            what: format!("version {} of legacy VTK files", shown(version.unwrap_or_default().as_bytes())),
            remedy: "save it as version 5.1 or earlier, or as .vtu".into(),
        }),
        None => {
            let message = format!("expected `# vtk DataFile Version`, found {}", shown(line));
            Err(cursor.error_at(0, message))
        }
    }
}

pub(super) struct Reader<'a> {
    pub(super) cursor: Cursor<'a>,
    /// Major version; from 5 on cells are written as offsets and connectivity.
    version: u32,
    pub(super) grid: Grid<'a>,
    /// What the arrays belong to, and how many of it there are; `None` before any `CELL_DATA` or `POINT_DATA`.
    pub(super) owner: Option<(Owner, usize)>,
}

impl<'a> Reader<'a> {
    /// Reads one section, beginning with its keyword.
    fn section(&mut self) -> Result<(), MeshError> {
        let (start, keyword) = self.word();
        match keyword.to_ascii_uppercase().as_str() {
            "DATASET" => self.dataset(),
            "POINTS" => self.points(),
            "CELLS" => self.cells(start),
            "CELL_TYPES" => self.cell_types(),
            "CELL_DATA" => self.begin_data(Owner::Cells, self.grid.types.len(), "cells"),
            "POINT_DATA" => self.begin_data(Owner::Points, self.grid.points.len(), "points"),
            "METADATA" => {
                self.metadata();
                Ok(())
            }
            "FIELD" => self.field(),
            "LOOKUP_TABLE" => self.lookup_table(),
            "SCALARS" => self.scalars(),
            "COLOR_SCALARS" => self.colour_scalars(),
            "VECTORS" | "NORMALS" => self.attribute(3),
            "TENSORS" => self.attribute(9),
            "TENSORS6" => self.attribute(6),
            "GLOBAL_IDS" | "PEDIGREE_IDS" => self.attribute(1),
            "TEXTURE_COORDINATES" => self.texture_coordinates(),
            _ => {
                let message = format!("expected a section, found {}", shown(keyword.as_bytes()));
                Err(self.cursor.error_at(start, message))
            }
        }
    }

    /// The next word, and where it begins.
    pub(super) fn word(&mut self) -> (usize, Cow<'a, str>) {
        let (start, word) = self.cursor.placed_word();
        (start, String::from_utf8_lossy(word))
    }

    /// The next word as a name, in which `%20` is a space.
    pub(super) fn name(&mut self) -> String {
        unescaped(self.cursor.word())
    }

    /// Skips metadata, which end with an empty line.
    pub(super) fn metadata(&mut self) {
        self.cursor.line();
        while !self.cursor.line().is_empty() {}
    }

    fn dataset(&mut self) -> Result<(), MeshError> {
        let (_, kind) = self.word();
        if kind.eq_ignore_ascii_case("UNSTRUCTURED_GRID") {
            return Ok(());
        }
        Err(MeshError::Unsupported {
            what: format!("a VTK data set {}", shown(kind.as_bytes())),
            remedy: "save an UNSTRUCTURED_GRID".into(),
        })
    }

    /// The next word as a type of numbers; `None` for texts.
    pub(super) fn scalar(&mut self) -> Result<Option<Scalar>, MeshError> {
        let (start, name) = self.word();
        match (name.to_ascii_lowercase().as_str(), Scalar::of_legacy(&name)) {
            (_, Some(scalar)) => Ok(Some(scalar)),
            ("string" | "utf8_string", _) => Ok(None),
            ("bit", _) => Err(MeshError::Unsupported {
                what: "an array of bits".into(),
                remedy: "save the file without it, or with the type unsigned_char".into(),
            }),
            _ => {
                let message = format!("expected a type of numbers, found {}", shown(name.as_bytes()));
                Err(self.cursor.error_at(start, message))
            }
        }
    }

    fn numbers(&mut self, what: &str) -> Result<Scalar, MeshError> {
        let start = self.cursor.offset();
        self.scalar()?.ok_or_else(|| self.cursor.error_at(start, format!("{what} are numbers")))
    }

    fn points(&mut self) -> Result<(), MeshError> {
        let count: usize = self.cursor.parsed("the number of points")?;
        let scalar = self.numbers("coordinates")?;
        self.cursor.line();
        let each = 3 * scalar.size() as u64;
        self.cursor.counted(count as u64, 3, each, "points")?;
        let coordinates = read_values(&mut self.cursor, scalar, 3 * count, "coordinates")?;
        self.grid.points = coordinates.into_positions().map_err(|message| self.cursor.error(message))?;
        Ok(())
    }

    /// Cells: up to version 4 each with the number of its points before them, since 5 as two arrays.
    fn cells(&mut self, start: usize) -> Result<(), MeshError> {
        self.grid.cells_at = start;
        let count: usize = self.cursor.parsed("the number of cells")?;
        let size: usize = self.cursor.parsed("the size of the list of cells")?;
        self.cursor.line();
        if self.version < 5 {
            let list = self.integers(Scalar::I32, size, "the list of cells")?;
            return self.take_apart(&list, count);
        }
        self.require("OFFSETS")?;
        let scalar = self.numbers("offsets")?;
        self.cursor.line();
        let offsets = self.integers(scalar, count, "offsets")?;
        self.require("CONNECTIVITY")?;
        let scalar = self.numbers("connectivity")?;
        self.cursor.line();
        self.grid.connectivity = self.integers(scalar, size, "connectivity")?;
        match offsets.split_first() {
            Some((0, ends)) => self.grid.ends = ends.to_vec(),
            Some((first, _)) => {
                return Err(self.cursor.error_at(start, format!("the first cell begins at {first}, not 0")));
            }
            None => {}
        }
        Ok(())
    }

    pub(super) fn require(&mut self, keyword: &str) -> Result<(), MeshError> {
        let (start, found) = self.word();
        if found.eq_ignore_ascii_case(keyword) {
            return Ok(());
        }
        let message = format!("expected {keyword}, found {}", shown(found.as_bytes()));
        Err(self.cursor.error_at(start, message))
    }

    fn integers(&mut self, scalar: Scalar, count: usize, what: &str) -> Result<Vec<i64>, MeshError> {
        match read_values(&mut self.cursor, scalar, count, what)? {
            Values::Integers(integers) => Ok(integers),
            _ => Err(self.cursor.error(format!("{what} are integers"))),
        }
    }

    /// Splits a list of cells, each a number of points and these points.
    fn take_apart(&mut self, mut list: &[i64], count: usize) -> Result<(), MeshError> {
        let start = self.grid.cells_at;
        for cell in 0..count {
            let points = list.split_first().and_then(|(points, rest)| {
                let (points, rest) = rest.split_at_checked(usize::try_from(*points).ok()?)?;
                list = rest;
                Some(points)
            });
            let Some(points) = points else {
                let message = format!("cell {cell} of {count} has more points than the list of cells");
                return Err(self.cursor.error_at(start, message));
            };
            self.grid.connectivity.extend(points);
            self.grid.ends.push((self.grid.connectivity.len() as u64).cast_signed());
        }
        if !list.is_empty() {
            let message = format!("the list of {count} cells has {} numbers too many", list.len());
            return Err(self.cursor.error_at(start, message));
        }
        Ok(())
    }

    fn cell_types(&mut self) -> Result<(), MeshError> {
        let count: usize = self.cursor.parsed("the number of cell types")?;
        self.cursor.line();
        self.grid.types = self.integers(Scalar::I32, count, "cell types")?;
        Ok(())
    }
}
