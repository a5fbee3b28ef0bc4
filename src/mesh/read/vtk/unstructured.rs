//! XML files of unstructured grids, `.vtu`: arrays as text, in base64, or appended; compressed or not.

use super::compression::{Compressor, most_decompressed};
use super::grid::Grid;
use super::labels::Owner;
use super::scalar::{Scalar, Values, read_values};
use super::stream::Stream;
use crate::mechanics::tensor::Vec3;
use crate::mesh::read::FieldNames;
use crate::mesh::read::cursor::shown;
use crate::mesh::read::xml::Xml;
use crate::mesh::{Mesh, MeshError};
use roxmltree::Node;
use std::borrow::Cow;

/// The element that holds appended arrays: after it, a file may be anything but XML.
const APPENDED: &[u8] = b"<AppendedData";
/// What closes the file when the appended arrays are cut off.
const END: &str = "</VTKFile>";

/// Reads a `.vtu` file.
///
/// # Errors
/// As [`read_mesh`](crate::mesh::read::read_mesh).
pub(super) fn read(bytes: &[u8], fields: &FieldNames) -> Result<Mesh, MeshError> {
    let appended = bytes.windows(APPENDED.len()).position(|window| window == APPENDED);
    let (head, appended) = bytes.split_at(appended.unwrap_or(bytes.len()));
    let mut text = String::from_utf8_lossy(head);
    if !appended.is_empty() {
        text = Cow::Owned(text.into_owned() + END);
    }
    let xml = Xml::new(&text)?;
    let mut reader = Reader::new(&xml, appended, bytes.len())?;
    let grid = reader.grid(fields)?;
    grid.into_mesh(|offset| xml.place(offset))
}

struct Reader<'a> {
    xml: &'a Xml<'a>,
    /// Appended arrays, if there are any.
    appended: Option<Appended<'a>>,
    big_endian: bool,
    /// Type of the numbers of headers.
    header: Scalar,
    compressor: Option<Compressor>,
    /// Bytes that may still be decompressed.
    left: u64,
    /// Memory that values may still take [bytes]: arrays may share their bytes in the file.
    memory: u64,
}

/// What follows the underscore of `<AppendedData>`.
struct Appended<'a> {
    bytes: &'a [u8],
    base64: bool,
}

impl<'a> Reader<'a> {
    /// Reads the attributes of the file.
    fn new(xml: &'a Xml<'a>, appended: &'a [u8], size: usize) -> Result<Self, MeshError> {
        let root = xml.root();
        let refused = |what: String, remedy: &str| MeshError::Unsupported {
            what: format!("{}: {what}", xml.place(root.range().start)),
            remedy: remedy.to_owned(),
        };
        let kind = xml.attribute(root, "type")?;
        if !root.has_tag_name("VTKFile") || kind != "UnstructuredGrid" {
            let what = format!("a VTK data set {}", shown(kind.as_bytes()));
            return Err(refused(what, "save an UnstructuredGrid in one file"));
        }
        let compressor = match root.attribute("compressor") {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
            Some(other) => {
                return Err(refused(
                    format!("the compressor {}", shown(other.as_bytes())),
                    "write it compressed by zlib or not at all, as PyVista does by `mesh.save(\"mesh.vtu\")`",
                ));
            }
        };
        let big_endian = match root.attribute("byte_order") {
            None | Some("LittleEndian") => false,
            Some("BigEndian") => true,
            Some(other) => {
                return Err(xml.error(root, format!("{} is not a byte order", shown(other.as_bytes()))));
            }
        };
        let header = match root.attribute("header_type") {
            None | Some("UInt32") => Scalar::U32,
            Some("UInt64") => Scalar::U64,
            Some(other) => {
                return Err(xml.error(root, format!("{} is not a header type", shown(other.as_bytes()))));
            }
        };
        let appended = Appended::new(appended);
        let most = most_decompressed(size);
        Ok(Self { xml, appended, big_endian, header, compressor, left: most, memory: most })
    }

    /// The grid of the only piece of the file.
    fn grid<'f>(&mut self, fields: &'f FieldNames) -> Result<Grid<'f>, MeshError> {
        let xml = self.xml;
        let piece = self.piece()?;
        let points: usize = xml.number(piece, "NumberOfPoints")?;
        let cells: usize = xml.number(piece, "NumberOfCells")?;
        let mut grid = Grid::new(fields);
        grid.part_names = self.part_names()?;
        grid.points = self.points(piece, points)?;

        // Cells: the last offset is the number of entries of the connectivity.
        let list = xml.child(piece, "Cells")?;
        grid.cells_at = list.range().start;
        grid.types = self.cell_array(list, "types", cells)?;
        grid.ends = self.cell_array(list, "offsets", cells)?;
        let entries = grid.ends.last().copied().unwrap_or(0);
        let entries =
            usize::try_from(entries).map_err(|_| xml.error(list, format!("the last offset is {entries}")))?;
        grid.connectivity = self.cell_array(list, "connectivity", entries)?;

        // Arrays that may name parts and sets.
        for (owner, section, count) in
            [(Owner::Cells, "CellData", cells), (Owner::Points, "PointData", points)]
        {
            let arrays = piece.children().filter(|child| child.has_tag_name(section));
            for array in arrays.flat_map(|data| data.children().filter(Node::is_element)) {
                self.named_array(&mut grid, owner, array, count)?;
            }
        }
        Ok(grid)
    }

    /// The texts `parts` of the field data.
    fn part_names(&mut self) -> Result<Vec<String>, MeshError> {
        let grid = self.xml.child(self.xml.root(), "UnstructuredGrid")?;
        let data = grid.children().filter(|child| child.has_tag_name("FieldData"));
        let mut arrays = data.flat_map(|data| data.children().filter(Node::is_element));
        let is_it = |array: &Node| {
            [array.attribute("Name"), array.attribute("type")] == [Some("parts"), Some("String")]
        };
        let Some(array) = arrays.find(is_it) else { return Ok(Vec::new()) };
        let count: usize = self.xml.number(array, "NumberOfTuples")?;
        match self.values(array, count)? {
            Values::Texts(names) => Ok(names),
            _ => Ok(Vec::new()),
        }
    }

    fn piece(&self) -> Result<Node<'a, 'a>, MeshError> {
        let grid = self.xml.child(self.xml.root(), "UnstructuredGrid")?;
        let piece = self.xml.child(grid, "Piece")?;
        let pieces = grid.children().filter(|child| child.has_tag_name("Piece")).count();
        if pieces > 1 {
            return Err(MeshError::Unsupported {
                what: format!("{pieces} pieces, which do not share their points"),
                remedy: "merge them, and their coincident points, into one".into(),
            });
        }
        Ok(piece)
    }

    fn points(&mut self, piece: Node<'a, 'a>, count: usize) -> Result<Vec<Vec3>, MeshError> {
        let array = self.xml.child(self.xml.child(piece, "Points")?, "DataArray")?;
        let components: u64 = self.xml.number(array, "NumberOfComponents")?;
        if components != 3 {
            return Err(self.xml.error(array, format!("points have 3 coordinates, not {components}")));
        }
        let coordinates = self.values(array, count.saturating_mul(3))?;
        coordinates.into_positions().map_err(|message| self.xml.error(array, message))
    }

    /// An array of integers of `<Cells>`.
    fn cell_array(&mut self, cells: Node<'a, 'a>, name: &str, count: usize) -> Result<Vec<i64>, MeshError> {
        let found = cells.children().find(|child| child.attribute("Name") == Some(name));
        let array = found.ok_or_else(|| self.xml.error(cells, format!("<Cells> has no array {name}")))?;
        match self.values(array, count)? {
            Values::Integers(integers) => Ok(integers),
            _ => Err(self.xml.error(array, format!("the array {name} has integers"))),
        }
    }

    /// Adds an array of points or cells to the grid if it may name parts or sets.
    fn named_array(
        &mut self,
        grid: &mut Grid,
        owner: Owner,
        array: Node<'a, 'a>,
        count: usize,
    ) -> Result<(), MeshError> {
        let name = array.attribute("Name").unwrap_or_default();
        let components = match array.attribute("NumberOfComponents") {
            None => 1,
            Some(_) => self.xml.number(array, "NumberOfComponents")?,
        };
        let scalar = array.attribute("type").and_then(Scalar::of_xml);
        let kind = (scalar.is_some_and(Scalar::is_integer), scalar.is_none());
        if grid.wants(owner, name, components, kind) {
            // Three components at most are wanted.
            let values = self.values(array, count.saturating_mul(components as usize))?;
            let added = grid.add_array((owner, components), name, values);
            added.map_err(|message| self.xml.error(array, message))?;
        }
        Ok(())
    }

    /// The values of an array; `count` of them.
    fn values(&mut self, array: Node<'a, 'a>, count: usize) -> Result<Values, MeshError> {
        let kind = self.xml.attribute(array, "type")?;
        let scalar = match kind {
            "String" => None,
            _ => Some(Scalar::of_xml(kind).ok_or_else(|| {
                self.xml.error(array, format!("{} is not an array type", shown(kind.as_bytes())))
            })?),
        };
        if array.attribute("format").is_none_or(|format| format == "ascii") {
            return self.text(array, scalar, count);
        }
        // Text has a character for each value at least; other arrays may be compressed, or share their bytes.
        let taken = 8_u64.saturating_mul(count as u64);
        self.memory = self.memory.checked_sub(taken).ok_or_else(|| {
            let message = format!(
                "{count} values take {taken} bytes of memory, of which {} are left for a file of this size: omit arrays that a mesh has no \
                 use for",
                self.memory
            );
            self.xml.error(array, message)
        })?;
        let size = scalar.map_or(1, Scalar::size);
        let bytes = self.bytes(array).map_err(|message| self.xml.error(array, message))?;
        match scalar {
            None => texts(&bytes, count).map_err(|message| self.xml.error(array, message)),
            Some(_) if bytes.len() / size != count || bytes.len() % size != 0 => {
                let found = bytes.len();
                Err(self.xml.error(array, format!("{found} bytes are not {count} numbers of {size} bytes")))
            }
            Some(scalar) => scalar
                .decode(&bytes, self.big_endian)
                .ok_or_else(|| self.xml.error(array, "a number exceeds 2⁶³ − 1")),
        }
    }

    /// Values written as text; texts as the numbers of their bytes.
    fn text(&self, array: Node<'a, 'a>, scalar: Option<Scalar>, count: usize) -> Result<Values, MeshError> {
        let mut cursor = self.xml.cursor(array);
        let Some(scalar) = scalar else {
            let mut bytes = Vec::new();
            while !cursor.at_end() {
                bytes.push(cursor.parsed::<u8>("the number of a byte")?);
            }
            return texts(&bytes, count).map_err(|message| self.xml.error(array, message));
        };
        let values = read_values(&mut cursor, scalar, count, "values of an array")?;
        if !cursor.at_end() {
            return Err(cursor.error(format!("an array of {count} numbers has more")));
        }
        Ok(values)
    }

    /// The bytes of an array in base64, or appended.
    fn bytes(&mut self, array: Node<'a, 'a>) -> Result<Vec<u8>, String> {
        let mut stream = match array.attribute("format") {
            Some("binary") => Stream::base64(array.text().unwrap_or_default().as_bytes()),
            Some("appended") => {
                let offset = array.attribute("offset").and_then(|offset| offset.trim().parse().ok());
                let offset: usize = offset.ok_or("an appended array has an offset")?;
                let appended = self.appended.as_ref().ok_or("the file has no appended data")?;
                let from = appended.bytes.get(offset..);
                let from =
                    from.ok_or_else(|| format!("the offset {offset} is behind the end of the file"))?;
                if appended.base64 { Stream::base64(from) } else { Stream::Raw(from) }
            }
            other => {
                let other = shown(other.unwrap_or_default().as_bytes());
                return Err(format!("{other} is not an array format"));
            }
        };
        let (size, big_endian, kind) = (self.header.size(), self.big_endian, self.header);
        let header = |stream: &mut Stream| match kind.decode(&stream.take(size)?, big_endian) {
            Some(Values::Integers(numbers)) => Ok(numbers.first().map_or(0, |number| number.unsigned_abs())),
            _ => Err("a size in the header exceeds 2⁶³ − 1".to_owned()),
        };
        if let Some(compressor) = self.compressor {
            return compressor.decompress(&mut stream, header, &mut self.left);
        }
        let bytes = header(&mut stream)?;
        stream.take(usize::try_from(bytes).unwrap_or(usize::MAX))
    }
}

impl<'a> Appended<'a> {
    /// What follows the underscore; `None` if there is nothing.
    fn new(element: &'a [u8]) -> Option<Self> {
        let end_of_tag = element.iter().position(|&b| b == b'>')?;
        let (tag, content) = element.split_at(end_of_tag);
        let start = content.iter().position(|&b| b == b'_')?;
        let raw = tag.windows(5).any(|window| window == b"\"raw\"" || window == b"'raw'");
        Some(Self { bytes: &content[start + 1..], base64: !raw })
    }
}

/// Texts, each ended by a zero.
fn texts(bytes: &[u8], count: usize) -> Result<Values, String> {
    let mut texts: Vec<String> =
        bytes.split(|&byte| byte == 0).map(|text| String::from_utf8_lossy(text).into_owned()).collect();
    if texts.last().is_some_and(String::is_empty) {
        texts.pop();
    }
    if texts.len() == count {
        Ok(Values::Texts(texts))
    } else {
        Err(format!("{} texts, not {count}", texts.len()))
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::read::{MeshFormat, read_mesh};

    #[test]
    fn arrays_that_share_their_bytes_are_counted_each() {
        const COUNT: usize = 100_000;
        let data = [&u32::try_from(COUNT).unwrap().to_le_bytes()[..], &vec![1_u8; COUNT]].concat();
        let with = |arrays: usize| {
            let marks: Vec<String> = (0..arrays)
                .map(|i| {
                    format!("<DataArray type=\"UInt8\" Name=\"set{i}\" format=\"appended\" offset=\"0\"/>\n")
                })
                .collect();
            let text = format!(
                "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"{COUNT}\" NumberOfCells=\"0\">\
                 <Points><DataArray type=\"UInt8\" NumberOfComponents=\"3\" format=\"appended\" offset=\"{}\"/></Points>\
                 <Cells><DataArray type=\"UInt8\" Name=\"types\"/><DataArray type=\"Int64\" Name=\"offsets\"/>\
                 <DataArray type=\"Int64\" Name=\"connectivity\"/></Cells><PointData>{}</PointData></Piece></UnstructuredGrid>\
                 <AppendedData encoding=\"raw\">_",
                data.len(),
                marks.concat()
            );
            let points =
                [&u32::try_from(3 * COUNT).unwrap().to_le_bytes()[..], &vec![0_u8; 3 * COUNT]].concat();
            read_mesh(&[text.as_bytes(), &data, &points].concat(), MeshFormat::Vtu).unwrap_err().to_string()
        };
        // 24 bytes a point and 8 a mark: 400 MB would be more than what a file of half a megabyte may take.
        let message = with(500);
        assert!(message.contains("omit arrays that a mesh has no use for"), "{message}");
        let message = with(20);
        assert!(!message.contains("omit arrays"), "{message}");
    }
}
