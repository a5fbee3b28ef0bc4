//! Arrays of numbers packed as little-endian bytes.
//!
//! `bytes` encode several times faster than `repeated double`, and readers access them as one block.

use super::proto::contuse::PackedArray;
use crate::mechanics::tensor::Vec3;

/// Rounds a number to 13 significant bits, to within 0.013 %: less than what a nodal average of a field is worth, and the
/// other half of its bits compress to nothing.
pub fn rounded(value: f64) -> f64 {
    const DROPPED: u32 = 11;
    let bits = (value as f32).to_bits();
    f64::from(f32::from_bits(bits.wrapping_add(1 << (DROPPED - 1)) & !((1 << DROPPED) - 1)))
}

/// Packs scalars as f32.
pub fn scalars(name: &str, unit: &str, values: impl IntoIterator<Item = f64>) -> PackedArray {
    f32s(name, unit, values.into_iter().map(|v| [v]))
}

/// Packs vectors as f32 × 3.
pub fn vectors(name: &str, unit: &str, values: impl IntoIterator<Item = Vec3>) -> PackedArray {
    f32s(name, unit, values.into_iter().map(|v| [v.x, v.y, v.z]))
}

/// Packs entries of N numbers as f32, with the 7 digits needed for display; sums and energies are stored as doubles.
pub fn f32s<const N: usize>(
    name: &str,
    unit: &str,
    entries: impl IntoIterator<Item = [f64; N]>,
) -> PackedArray {
    pack(name, unit, "f32", entries, |v, data| data.extend((v as f32).to_le_bytes()))
}

/// Packs entries of N numbers as f64.
pub fn f64s<const N: usize>(
    name: &str,
    unit: &str,
    entries: impl IntoIterator<Item = [f64; N]>,
) -> PackedArray {
    pack(name, unit, "f64", entries, |v, data| data.extend(v.to_le_bytes()))
}

/// Packs entries of N numbers as u32.
pub fn u32s<const N: usize>(name: &str, entries: impl IntoIterator<Item = [u32; N]>) -> PackedArray {
    pack(name, "", "u32", entries, |v, data| data.extend(v.to_le_bytes()))
}

/// Packs numbers as u8.
pub fn u8s(name: &str, values: impl IntoIterator<Item = u8>) -> PackedArray {
    pack(name, "", "u8", values.into_iter().map(|v| [v]), |v, data| data.push(v))
}

fn pack<T, const N: usize>(
    name: &str,
    unit: &str,
    dtype: &str,
    entries: impl IntoIterator<Item = [T; N]>,
    put: impl Fn(T, &mut Vec<u8>),
) -> PackedArray {
    let (mut data, mut count) = (Vec::new(), 0);
    for entry in entries {
        count += 1;
        for value in entry {
            put(value, &mut data);
        }
    }
    PackedArray {
        name: name.into(),
        dtype: dtype.into(),
        count,
        components: N as u32,
        unit: unit.into(),
        data,
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // rounding twice changes nothing
mod tests {
    use super::*;

    #[test]
    fn rounded_numbers_are_near_and_have_short_mantissas() {
        for value in [0.0, 1.0, -1.0, 0.1, -12_345.678, 9.87e7, 3e-12] {
            let near = rounded(value);
            assert!((near - value).abs() <= value.abs() * 0.5_f64.powi(13), "{value}: {near}");
            assert_eq!((near as f32).to_bits() % (1 << 11), 0, "{value}: {near}");
            assert_eq!(rounded(near), near);
        }
    }

    #[test]
    fn bytes_are_little_endian_and_counted() {
        let array = vectors("u", "m", [Vec3::new(1.0, 2.0, -0.5), Vec3::zeros()]);
        assert_eq!((array.count, array.components, array.data.len()), (2, 3, 24));
        assert_eq!(array.data[..4], 1f32.to_le_bytes());
        assert_eq!(array.data[8..12], (-0.5f32).to_le_bytes());
        assert_eq!(u32s("n", [[258]]).data, [2, 1, 0, 0]);
    }
}
