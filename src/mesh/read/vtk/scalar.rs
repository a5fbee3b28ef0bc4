//! Types of the numbers in VTK files: their names, and the reading of them.

use crate::mechanics::tensor::Vec3;
use crate::mesh::MeshError;
use crate::mesh::read::cursor::{Cursor, Numbers};

/// Type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// The numbers or texts of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
    Texts(Vec<String>),
}

impl Values {
    /// The values as floating-point numbers; `None` for texts.
    pub(super) fn as_reals(&self) -> Option<Vec<f64>> {
        match self {
            Self::Reals(reals) => Some(reals.clone()),
            Self::Integers(integers) => Some(integers.iter().map(|x| *x as f64).collect()),
            Self::Texts(_) => None,
        }
    }

    /// Groups of three numbers as positions.
    ///
    /// # Errors
    /// A message with the first point that has a coordinate that is not finite.
    pub(super) fn into_positions(self) -> Result<Vec<Vec3>, String> {
        let coordinates = match self {
            Self::Reals(reals) => reals,
            Self::Integers(integers) => integers.into_iter().map(|x| x as f64).collect(),
            Self::Texts(_) => return Err("coordinates are numbers".into()),
        };
        let (positions, _) = coordinates.as_chunks::<3>();
        match positions.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
            Some(point) => Err(format!("point {point} has a coordinate that is not finite")),
            None => Ok(positions.iter().map(|x| Vec3::from(*x)).collect()),
        }
    }
}

impl Scalar {
    /// The type with this name in legacy files, which store `vtkIdType` in four bytes.
    pub(super) fn of_legacy(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "signed_char" => Self::I8,
            "unsigned_char" => Self::U8,
            "short" => Self::I16,
            "unsigned_short" => Self::U16,
            "int" | "vtkidtype" => Self::I32,
            "unsigned_int" => Self::U32,
            "long" | "long_long" | "vtktypeint64" => Self::I64,
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => return None,
        })
    }

    /// The type with this name in XML files.
    pub(super) fn of_xml(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Self::I8,
            "UInt8" => Self::U8,
            "Int16" => Self::I16,
            "UInt16" => Self::U16,
            "Int32" => Self::I32,
            "UInt32" => Self::U32,
            "Int64" => Self::I64,
            "UInt64" => Self::U64,
            "Float32" => Self::F32,
            "Float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether the numbers are integers.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The numbers in these bytes; `None` if one exceeds the range of `i64`.
    pub(super) fn decode(self, bytes: &[u8], big_endian: bool) -> Option<Values> {
        Some(match self {
            Self::I8 => integers(bytes, big_endian, i8::from_le_bytes),
            Self::U8 => integers(bytes, big_endian, u8::from_le_bytes),
            Self::I16 => integers(bytes, big_endian, i16::from_le_bytes),
            Self::U16 => integers(bytes, big_endian, u16::from_le_bytes),
            Self::I32 => integers(bytes, big_endian, i32::from_le_bytes),
            Self::U32 => integers(bytes, big_endian, u32::from_le_bytes),
            Self::I64 => integers(bytes, big_endian, i64::from_le_bytes),
            Self::U64 => {
                let numbers = each(bytes, big_endian, u64::from_le_bytes);
                Values::Integers(numbers.map(|number| i64::try_from(number).ok()).collect::<Option<_>>()?)
            }
            Self::F32 => Values::Reals(each(bytes, big_endian, f32::from_le_bytes).map(f64::from).collect()),
            Self::F64 => Values::Reals(each(bytes, big_endian, f64::from_le_bytes).collect()),
        })
    }
}

/// The numbers in these bytes, each from `N` bytes in little-endian order.
fn each<const N: usize, T>(
    bytes: &[u8],
    big_endian: bool,
    number: fn([u8; N]) -> T,
) -> impl Iterator<Item = T> {
    let (chunks, _) = bytes.as_chunks::<N>();
    chunks.iter().map(move |chunk| {
        let mut chunk = *chunk;
        if big_endian {
            chunk.reverse();
        }
        number(chunk)
    })
}

fn integers<const N: usize, T: Into<i64>>(
    bytes: &[u8],
    big_endian: bool,
    number: fn([u8; N]) -> T,
) -> Values {
    Values::Integers(each(bytes, big_endian, number).map(T::into).collect())
}

/// Reads `count` numbers at the cursor: words of text, or bytes.
///
/// # Errors
/// `Malformed` when the file has fewer values, or something else.
pub(super) fn read_values(
    cursor: &mut Cursor,
    scalar: Scalar,
    count: usize,
    what: &str,
) -> Result<Values, MeshError> {
    let count = cursor.counted(count as u64, 1, scalar.size() as u64, what)?;
    let start = cursor.offset();
    match cursor.numbers {
        Numbers::Text if scalar.is_integer() => {
            let numbers = (0..count).map(|_| cursor.parsed::<i64>(what)).collect::<Result<_, _>>()?;
            Ok(Values::Integers(numbers))
        }
        Numbers::Text => {
            let numbers = (0..count).map(|_| cursor.parsed::<f64>(what)).collect::<Result<_, _>>()?;
            Ok(Values::Reals(numbers))
        }
        order => {
            let bytes = cursor.take(count * scalar.size(), what)?;
            let values = scalar.decode(bytes, order == Numbers::BigEndian);
            values.ok_or_else(|| cursor.error_at(start, format!("{what}: a number exceeds 2⁶³ − 1")))
        }
    }
}
