//! One `.vtu` file: points, cells and arrays of an unstructured grid, appended raw.

use super::array::{Array, NumberType, escaped};
use std::fmt::Write as _;
use std::io::{self, Write};

/// Cells of a grid: nodes, the end of each cell in them, VTK's types.
#[derive(Clone, Debug)]
pub struct CellArrays {
    /// Number of cells, of any type.
    pub count: usize,
    arrays: [Array; 3],
}

impl CellArrays {
    /// Cells by their VTK types and nodes, the latter in VTK's order and below 2³¹.
    pub fn new(cells: impl Iterator<Item = (u8, impl IntoIterator<Item = u32>)>) -> Self {
        let (mut nodes, mut ends, mut types) = (Vec::new(), Vec::new(), Vec::new());
        for (kind, of_cell) in cells {
            nodes.extend(of_cell.into_iter().flat_map(u32::to_le_bytes));
            ends.extend((nodes.len() as u32 / 4).to_le_bytes());
            types.push(kind);
        }
        Self {
            count: types.len(),
            arrays: [
                Array::new("connectivity", NumberType::Int32, 1, &nodes),
                Array::new("offsets", NumberType::Int32, 1, &ends),
                Array::new("types", NumberType::UInt8, 1, &types),
            ],
        }
    }
}

/// A value that belongs to the whole grid.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValue {
    /// The components of one tuple of numbers.
    Numbers(Vec<f64>),
    /// Texts, one an entry.
    Texts(Vec<String>),
}

/// A grid to be written.
#[derive(Debug)]
pub struct Grid<'a> {
    /// Number of points, used by a cell or not.
    pub point_count: usize,
    /// Positions of the points [m], three components.
    pub points: &'a Array,
    /// Cells, by the numbers of these points.
    pub cells: &'a CellArrays,
    /// Arrays with an entry a point.
    pub point_data: Vec<&'a Array>,
    /// Arrays with an entry a cell.
    pub cell_data: Vec<&'a Array>,
    /// Values of the whole, by name.
    pub field_data: Vec<(&'a str, FieldValue)>,
}

impl Grid<'_> {
    /// Writes the file.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut appended: Vec<&Array> = Vec::new();
        let xml = self.xml(&mut appended);
        out.write_all(xml.as_bytes())?;
        for array in appended {
            out.write_all(array.encoded())?;
        }
        out.write_all(b"\n  </AppendedData>\n</VTKFile>\n")
    }

    /// The text before the appended data, and the arrays that these hold in order.
    fn xml<'s>(&'s self, appended: &mut Vec<&'s Array>) -> String {
        let mut offset = 0;
        let mut section = |name: &str, arrays: &[&'s Array]| {
            let mut text = format!("      <{name}>\n");
            for array in arrays {
                let _ = writeln!(text, "        {}", array.element(offset));
                offset += array.encoded().len();
                appended.push(array);
            }
            text + &format!("      </{name}>\n")
        };
        let pieces = [
            section("PointData", &self.point_data),
            section("CellData", &self.cell_data),
            section("Points", &[self.points]),
            section("Cells", &self.cells.arrays.each_ref()),
        ];
        let fields: String = self.field_data.iter().map(|(name, value)| field_element(name, value)).collect();
        format!(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\" compressor=\"vtkZLibDataCompressor\">\n  \
             <UnstructuredGrid>\n    <FieldData>\n{fields}    </FieldData>\n    \
             <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n{}    </Piece>\n  </UnstructuredGrid>\n  \
             <AppendedData encoding=\"raw\">\n_",
            self.point_count,
            self.cells.count,
            pieces.concat(),
        )
    }
}

/// The element of a value of the whole; texts are the codes of their UTF-8 bytes, each text ended by a zero.
fn field_element(name: &str, value: &FieldValue) -> String {
    let name = escaped(name);
    let list = |numbers: &mut dyn Iterator<Item = String>| numbers.collect::<Vec<_>>().join(" ");
    match value {
        FieldValue::Numbers(numbers) => format!(
            "      <DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n",
            numbers.len(),
            list(&mut numbers.iter().map(|number| format!("{number:e}"))),
        ),
        FieldValue::Texts(texts) => format!(
            "      <Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"{}\" format=\"ascii\">{}</Array>\n",
            texts.len(),
            list(&mut texts.iter().flat_map(|text| text.bytes().chain([0])).map(|byte| byte.to_string())),
        ),
    }
}
