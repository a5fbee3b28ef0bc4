//! Checked access to the packed arrays of messages, whose declared sizes a damaged file may contradict.

use super::array::{Array, NumberType};
use crate::record::proto::contuse::PackedArray;
use std::borrow::Cow;

/// Reason why a message cannot be used.
pub(super) type Reason = String;

/// The data of a packed array of this type, once its length is what it declares.
pub(super) fn checked<'a>(
    array: Option<&'a PackedArray>,
    name: &str,
    (dtype, components): (&str, u32),
) -> Result<&'a [u8], Reason> {
    let array = array.ok_or_else(|| format!("{name} is missing"))?;
    if array.dtype != dtype || array.components != components {
        return Err(format!("{name} is {} × {}, not {dtype} × {components}", array.dtype, array.components));
    }
    with_entries(array, array.count as usize)
}

/// The data of a packed array, once it has this number of entries.
fn with_entries(array: &PackedArray, entries: usize) -> Result<&[u8], Reason> {
    let number = number_type(array)?;
    let size = (array.components as usize).saturating_mul(number.size()).saturating_mul(entries);
    if array.count as usize == entries && array.data.len() == size {
        return Ok(&array.data);
    }
    Err(format!("{} has {} entries in {} bytes, not {entries}", array.name, array.count, array.data.len()))
}

fn number_type(array: &PackedArray) -> Result<NumberType, Reason> {
    NumberType::of_dtype(&array.dtype)
        .ok_or_else(|| format!("{} has the unknown type {}", array.name, array.dtype))
}

/// The arrays of a message for VTK, under their names, once each has this number of entries.
pub(super) fn arrays<'a>(
    packed: impl IntoIterator<Item = &'a PackedArray>,
    entries: usize,
) -> Result<Vec<Array>, Reason> {
    packed.into_iter().map(|array| array_of(array, entries, None)).collect()
}

/// One array for VTK, once it has this number of entries; where `kept` is given, only these.
pub(super) fn array_of(array: &PackedArray, entries: usize, kept: Option<&[u32]>) -> Result<Array, Reason> {
    let (data, number) = (with_entries(array, entries)?, number_type(array)?);
    let components = array.components as usize;
    let data = rows(data, components * number.size(), kept);
    Ok(Array::new(&array.name, number, components, &data))
}

/// The entries of an array of entries of `size` bytes that are kept: all if `kept` is not given.
pub(super) fn rows<'a>(data: &'a [u8], size: usize, kept: Option<&[u32]>) -> Cow<'a, [u8]> {
    let Some(kept) = kept else { return Cow::Borrowed(data) };
    kept.iter().flat_map(|&row| &data[row as usize * size..(row as usize + 1) * size]).copied().collect()
}

/// Unsigned 32-bit integers of packed little-endian bytes; an incomplete last one is omitted.
pub(super) fn u32s(data: &[u8]) -> impl Iterator<Item = u32> {
    data.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes))
}

/// Little-endian f32 in threes.
pub(super) fn triples(data: &[u8]) -> Vec<[f32; 3]> {
    let number = |bytes: &[u8; 4]| f32::from_le_bytes(*bytes);
    data.as_chunks::<12>()
        .0
        .iter()
        .map(|entry| {
            let [x, y, z] = entry.as_chunks().0 else { return [0.0; 3] };
            [number(x), number(y), number(z)]
        })
        .collect()
}
