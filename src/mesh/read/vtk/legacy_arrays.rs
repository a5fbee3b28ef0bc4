//! Arrays of points and cells in legacy VTK files, with their attributes.

use super::labels::Owner;
use super::legacy::Reader;
use super::scalar::{Scalar, Values, read_values};
use super::text::unescaped;
use crate::mesh::MeshError;
use crate::mesh::read::cursor::{Numbers, shown};

impl Reader<'_> {
    /// Begins the arrays of the points or cells.
    pub(super) fn begin_data(&mut self, owner: Owner, count: usize, what: &str) -> Result<(), MeshError> {
        let start = self.cursor.offset();
        let found: usize = self.cursor.parsed("a number of values")?;
        if found != count {
            let message = format!("the grid has {count} {what}, its data {found}");
            return Err(self.cursor.error_at(start, message));
        }
        self.owner = Some((owner, count));
        Ok(())
    }

    /// Scalars, with a line for their components and one for a table of colours.
    pub(super) fn scalars(&mut self) -> Result<(), MeshError> {
        let name = self.name();
        let scalar = self.scalar()?;
        let rest = self.cursor.line();
        let components = if rest.is_empty() {
            1
        } else {
            let parsed = std::str::from_utf8(rest).ok().and_then(|rest| rest.parse().ok());
            parsed.ok_or_else(|| {
                self.cursor.error(format!("expected a number of components, found {}", shown(rest)))
            })?
        };
        self.require("LOOKUP_TABLE")?;
        self.cursor.line();
        self.values(&name, components, (scalar, scalar))
    }

    /// Colours, which are bytes; text files have them divided by 255.
    pub(super) fn colour_scalars(&mut self) -> Result<(), MeshError> {
        let name = self.name();
        let components = self.cursor.parsed("the number of colours")?;
        self.cursor.line();
        self.values(&name, components, (Some(Scalar::U8), Some(self.colour())))
    }

    /// The type in which the file has colours.
    fn colour(&self) -> Scalar {
        if self.cursor.numbers == Numbers::Text { Scalar::F32 } else { Scalar::U8 }
    }

    /// Skips a table of colours.
    pub(super) fn lookup_table(&mut self) -> Result<(), MeshError> {
        self.word();
        let count: usize = self.cursor.parsed("the number of colours")?;
        self.cursor.line();
        let colour = self.colour();
        self.read(Some(colour), 4, count).map(|_| ())
    }

    /// An attribute with this number of components: its name, its type, its values.
    pub(super) fn attribute(&mut self, components: u64) -> Result<(), MeshError> {
        let name = self.name();
        self.array(&name, components, None)
    }

    /// Coordinates of a texture: one to three of them.
    pub(super) fn texture_coordinates(&mut self) -> Result<(), MeshError> {
        let name = self.name();
        let components = self.cursor.parsed("the number of texture coordinates")?;
        self.array(&name, components, None)
    }

    /// Arrays of any shape; before the data of points and cells, those of the whole file.
    pub(super) fn field(&mut self) -> Result<(), MeshError> {
        self.word();
        let arrays: u64 = self.cursor.parsed("the number of arrays")?;
        for _ in 0..arrays {
            let mut name = self.name();
            // Metadata may follow an array.
            while name.eq_ignore_ascii_case("METADATA") {
                self.metadata();
                name = self.name();
            }
            let components = self.cursor.parsed("the number of components")?;
            let tuples = self.cursor.parsed("the number of tuples")?;
            self.array(&name, components, Some(tuples))?;
        }
        Ok(())
    }

    /// The type and the values of an array.
    fn array(&mut self, name: &str, components: u64, tuples: Option<usize>) -> Result<(), MeshError> {
        let scalar = self.scalar()?;
        self.cursor.line();
        match (tuples, self.owner) {
            (Some(tuples), Some((_, count))) if tuples != count => {
                let message =
                    format!("the array {} has {tuples} tuples, not {count}", shown(name.as_bytes()));
                Err(self.cursor.error(message))
            }
            (Some(tuples), None) => self.read(scalar, components, tuples).map(|_| ()),
            _ => self.values(name, components, (scalar, scalar)),
        }
    }

    /// The values of an array of the points or cells, by their type and that in which they are written.
    fn values(
        &mut self,
        name: &str,
        components: u64,
        (scalar, written): (Option<Scalar>, Option<Scalar>),
    ) -> Result<(), MeshError> {
        let Some((owner, count)) = self.owner else {
            return Err(self.cursor.error("an array before CELL_DATA or POINT_DATA"));
        };
        let integer = scalar.is_some_and(Scalar::is_integer);
        let wanted = self.grid.wants(owner, name, components, (integer, scalar.is_none()));
        let values = match self.read(written, components, count)? {
            // Bytes that are written as fractions.
            Values::Reals(fractions) if integer => {
                Values::Integers(fractions.iter().map(|x| (255.0 * x).round() as i64).collect())
            }
            values => values,
        };
        if wanted {
            self.grid
                .add_array((owner, components), name, values)
                .map_err(|message| self.cursor.error(message))?;
        }
        Ok(())
    }

    fn read(&mut self, scalar: Option<Scalar>, components: u64, tuples: usize) -> Result<Values, MeshError> {
        let count = (tuples as u64).saturating_mul(components);
        let count = self.cursor.counted(count, 1, 1, "values")?;
        match scalar {
            Some(scalar) => read_values(&mut self.cursor, scalar, count, "values of an array"),
            None => (0..count).map(|_| self.text()).collect::<Result<_, _>>().map(Values::Texts),
        }
    }

    /// One text: a line, or the number of its bytes and these.
    fn text(&mut self) -> Result<String, MeshError> {
        let bytes = if self.cursor.numbers == Numbers::Text {
            self.cursor.line()
        } else {
            // The two highest bits give the number of bytes of the number.
            let first = self.cursor.take(1, "the length of a text")?[0];
            let more = [7, 3, 1, 0][usize::from(first >> 6)];
            let rest = self.cursor.take(more, "the length of a text")?;
            let length = rest.iter().fold(u64::from(first & 0x3f), |sum, &byte| sum << 8 | u64::from(byte));
            self.cursor.take(usize::try_from(length).unwrap_or(usize::MAX), "a text")?
        };
        Ok(unescaped(bytes))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use crate::mesh::read::{MeshFormat, read_mesh};

    const TETRAHEDRON: &str = "# vtk DataFile Version 3.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n\
        POINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n\
        POINT_DATA 4\nCOLOR_SCALARS bottom 1\n0.00392157 0.00392157 0.00392157 0\n";

    #[test]
    fn colours_of_text_files_are_bytes_divided_by_255() {
        let mesh = read_mesh(TETRAHEDRON.as_bytes(), MeshFormat::Vtk).unwrap();
        assert_eq!(mesh.node_sets["bottom"], [0, 1, 2]);
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        let bytes = TETRAHEDRON.replace("0.00392157 0\n", "0.5 0\n");
        let mesh = read_mesh(bytes.as_bytes(), MeshFormat::Vtk).unwrap();
        assert!(
            mesh.node_sets.is_empty() && mesh.notes == ["arrays not used: bottom (1)"],
            "{:?}",
            mesh.notes
        );
    }

    #[test]
    fn a_text_file_without_the_end_of_its_last_line_is_noted() {
        let mesh = read_mesh(TETRAHEDRON.trim_end().as_bytes(), MeshFormat::Vtk).unwrap();
        assert!(
            mesh.notes.iter().any(|note| note.contains("last line of the file has no line break")),
            "{:?}",
            mesh.notes
        );
    }
}
