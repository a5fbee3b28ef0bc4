//! Arrays of numbers in VTK's XML files: little-endian, compressed with zlib block by block (`vtkZLibDataCompressor`).

use miniz_oxide::deflate::compress_to_vec_zlib;

/// Uncompressed size of a block [bytes]; the last one may be shorter.
const BLOCK: usize = 1 << 18;

/// Compression level of zlib. Fields of an impact are mostly floats that hardly compress: level 6 takes six to nine times
/// as long for 3 to 5 % fewer bytes.
const LEVEL: u8 = 1;

/// Type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberType {
    /// IEEE single precision, as recordings have fields.
    Float32,
    /// IEEE double precision.
    Float64,
    /// Signed 32-bit integers, which VTK requires of the cells.
    Int32,
    /// Unsigned 32-bit integers, such as numbers of elements.
    UInt32,
    /// Unsigned 8-bit integers, such as types of cells.
    UInt8,
}

impl NumberType {
    /// Type with a name of the recording's (`PackedArray.dtype`).
    pub fn of_dtype(dtype: &str) -> Option<Self> {
        match dtype {
            "f32" => Some(Self::Float32),
            "f64" => Some(Self::Float64),
            "u32" => Some(Self::UInt32),
            "u8" => Some(Self::UInt8),
            _ => None,
        }
    }

    /// Name of the type in VTK.
    fn name(self) -> &'static str {
        match self {
            Self::Float32 => "Float32",
            Self::Float64 => "Float64",
            Self::Int32 => "Int32",
            Self::UInt32 => "UInt32",
            Self::UInt8 => "UInt8",
        }
    }

    /// Size of a number [bytes].
    pub fn size(self) -> usize {
        match self {
            Self::Float64 => 8,
            Self::Float32 | Self::Int32 | Self::UInt32 => 4,
            Self::UInt8 => 1,
        }
    }
}

/// A named array, compressed.
#[derive(Clone, Debug)]
pub struct Array {
    name: String,
    number: NumberType,
    components: usize,
    /// Header and blocks, as they stand in a file.
    encoded: Vec<u8>,
}

impl Array {
    /// Compresses the little-endian bytes of an array with so many components an entry.
    pub fn new(name: &str, number: NumberType, components: usize, data: &[u8]) -> Self {
        Self { name: name.to_owned(), number, components, encoded: encode(data) }
    }

    /// Its element in a file whose appended data hold it at `offset`.
    pub(super) fn element(&self, offset: usize) -> String {
        format!(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{offset}\"/>",
            self.number.name(),
            escaped(&self.name),
            self.components
        )
    }

    /// Header and compressed blocks.
    pub(super) fn encoded(&self) -> &[u8] {
        &self.encoded
    }
}

/// Header of u32 (number of blocks, their uncompressed size, that of the last if it is shorter, compressed sizes), then
/// the blocks.
fn encode(data: &[u8]) -> Vec<u8> {
    let blocks: Vec<Vec<u8>> = data.chunks(BLOCK).map(|block| compress_to_vec_zlib(block, LEVEL)).collect();
    let header = [blocks.len(), BLOCK, data.len() % BLOCK];
    let sizes = header.into_iter().chain(blocks.iter().map(Vec::len));
    let mut encoded: Vec<u8> = sizes.flat_map(|size| (size as u32).to_le_bytes()).collect();
    encoded.extend(blocks.iter().flatten());
    encoded
}

/// A text inside an XML attribute. Characters that XML 1.0 does not allow become `_`.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            c if c.is_control() || ['\u{fffe}', '\u{ffff}'].contains(&c) => safe.push('_'),
            c => safe.push(c),
        }
    }
    safe
}
