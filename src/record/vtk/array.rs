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
    /// 32-bit floating-point numbers.
    Float32,
    /// 64-bit floating-point numbers.
    Float64,
    /// Signed 32-bit integers, which VTK requires of the cells.
    Int32,
    /// Unsigned 32-bit integers.
    UInt32,
    /// Bytes.
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
    blocks.iter().for_each(|block| encoded.extend_from_slice(block));
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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use miniz_oxide::inflate::decompress_to_vec_zlib;

    fn u32_at(bytes: &[u8], index: usize) -> usize {
        u32::from_le_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap()) as usize
    }

    /// The data of an encoded array, read by the rules of VTK's file formats.
    pub(in crate::record::vtk) fn decode(encoded: &[u8]) -> Vec<u8> {
        let count = u32_at(encoded, 0);
        let (mut at, mut data) = (4 * (3 + count), Vec::new());
        for block in 0..count {
            let size = u32_at(encoded, 3 + block);
            let plain = decompress_to_vec_zlib(&encoded[at..at + size]).unwrap();
            let last = u32_at(encoded, 2);
            let whole = block + 1 < count || last == 0;
            assert_eq!(plain.len(), if whole { u32_at(encoded, 1) } else { last });
            data.extend(plain);
            at += size;
        }
        data
    }

    #[test]
    fn blocks_return_the_bytes() {
        for length in [0, 1, 5, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK, 2 * BLOCK + 7] {
            let data: Vec<u8> = (0..length).map(|i| (i * i % 251) as u8).collect();
            assert_eq!(decode(&encode(&data)), data, "{length}");
        }
        assert_eq!(u32_at(&encode(&[]), 0), 0);
    }

    #[test]
    fn an_element_names_type_and_place() {
        let array = Array::new("a<\"b\"\n", NumberType::Float32, 3, &[0; 12]);
        let expected = "<DataArray type=\"Float32\" Name=\"a&lt;&quot;b&quot;_\" NumberOfComponents=\"3\" format=\"appended\" offset=\"7\"/>";
        assert_eq!(array.element(7), expected);
    }
}
