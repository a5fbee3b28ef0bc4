//! Points in the unit cube: Latin hypercubes and the Sobol sequence, reproducible on every machine for the same seed.

use super::document::SampleMethod;

/// Dimensions covered by the table of direction numbers.
pub const MOST_SOBOL_DIMENSIONS: usize = 21;

/// Bits per coordinate of the Sobol sequence.
const BITS: u32 = 32;

/// Primitive polynomials and initial direction numbers of the dimensions from the second on: degree s, coefficients a, m_1 …
/// m_s (Joe & Kuo 2008, SIAM J. Sci. Comput. 30, table `new-joe-kuo-6`).
const DIRECTIONS: [(u32, u32, &[u32]); MOST_SOBOL_DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
    (7, 4, &[1, 3, 7, 13, 13, 15, 69]),
];

/// SplitMix64 (Steele, Lea & Flood 2014): a stream of 64-bit numbers from a seed.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream for a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }
    /// Next 64-bit number of the stream.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// Uniform in 0…1, ends excluded.
    pub fn unit(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }
    /// Uniform among 0 … count − 1.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.bits()) * count as u128) >> 64) as usize
    }
}

/// `count` points of `dimensions` coordinates in 0 … 1, ends excluded.
pub fn points(method: SampleMethod, count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    match method {
        SampleMethod::Sobol => sobol(count, dimensions, seed),
        SampleMethod::LatinHypercube => latin_hypercube(count, dimensions, seed),
    }
}

/// One point in every slice 1/count of every coordinate (McKay, Beckman & Conover 1979).
fn latin_hypercube(count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Random::new(seed);
    let mut points = vec![vec![0.0; dimensions]; count];
    for dimension in 0..dimensions {
        let mut slices: Vec<usize> = (0..count).collect();
        // Fisher–Yates shuffle.
        for last in (1..count).rev() {
            slices.swap(last, random.below(last + 1));
        }
        for (point, slice) in points.iter_mut().zip(slices) {
            point[dimension] = (slice as f64 + random.unit()) / count as f64;
        }
    }
    points
}

/// Sobol sequence in Gray code order (Antonov & Saleev 1979), each coordinate shifted digit by digit by a random number
/// (Cranley–Patterson in base 2), which preserves uniformity and removes the origin.
fn sobol(count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Random::new(seed);
    let shifts: Vec<u32> = (0..dimensions).map(|_| (random.bits() >> 32) as u32).collect();
    let unit = |bits: u32| (f64::from(bits) + 0.5) / (1_u64 << BITS) as f64;
    sobol_bits(count, dimensions)
        .into_iter()
        .map(|point| point.iter().zip(&shifts).map(|(bits, shift)| unit(bits ^ shift)).collect())
        .collect()
}

/// The unshifted sequence, as binary fractions.
fn sobol_bits(count: usize, dimensions: usize) -> Vec<Vec<u32>> {
    let directions: Vec<Vec<u32>> = (0..dimensions).map(direction_numbers).collect();
    let mut point = vec![0_u32; dimensions];
    (0..count)
        .map(|index| {
            let now = point.clone();
            let digit = (index as u32).trailing_ones() as usize;
            point.iter_mut().zip(&directions).for_each(|(x, v)| *x ^= v[digit.min(v.len() - 1)]);
            now
        })
        .collect()
}

/// Direction numbers v_1 … v_32 of a dimension, scaled to integers.
fn direction_numbers(dimension: usize) -> Vec<u32> {
    let mut v: Vec<u32> = Vec::with_capacity(BITS as usize);
    let Some((degree, coefficients, m)) = dimension.checked_sub(1).and_then(|row| DIRECTIONS.get(row)) else {
        return (0..BITS).map(|i| 1 << (BITS - 1 - i)).collect();
    };
    let degree = *degree as usize;
    for i in 0..BITS as usize {
        let next = if i < degree {
            m[i] << (BITS as usize - 1 - i)
        } else {
            let bit = |k: usize| coefficients >> (degree - 1 - k) & 1;
            (1..degree)
                .filter(|k| bit(*k) == 1)
                .fold(v[i - degree] ^ (v[i - degree] >> degree), |x, k| x ^ v[i - k])
        };
        v.push(next);
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_that_of_other_codes() {
        // scipy.stats.qmc.Sobol(d=21, scramble=False).random(8), in eighths: three coordinates, and all of the last point.
        let points = sobol_bits(8, 21);
        let eighths = |point: &[u32]| point.iter().map(|x| x >> 29).collect::<Vec<_>>();
        let first: Vec<Vec<u32>> = points.iter().map(|point| eighths(&point[..3])).collect();
        let known = [[0, 0, 0], [4, 4, 4], [6, 2, 2], [2, 6, 6], [3, 3, 5], [7, 7, 1], [5, 1, 7], [1, 5, 3]];
        assert_eq!(first, known);
        let last = [1, 5, 3, 1, 1, 3, 5, 5, 5, 7, 5, 1, 5, 3, 1, 1, 1, 1, 5, 7, 7];
        assert_eq!(eighths(&points[7]), last);
    }

    #[test]
    fn every_power_of_two_of_points_is_even_in_every_coordinate() {
        let points = sobol_bits(64, MOST_SOBOL_DIMENSIONS);
        for dimension in 0..MOST_SOBOL_DIMENSIONS {
            let mut slices: Vec<u32> = points.iter().map(|point| point[dimension] >> 26).collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..64).collect::<Vec<_>>(), "dimension {dimension}");
        }
    }

    #[test]
    fn hypercubes_have_a_point_in_every_slice_and_depend_on_the_seed_alone() {
        let points = latin_hypercube(50, 3, 7);
        for dimension in 0..3 {
            let mut slices: Vec<usize> = points.iter().map(|p| (50.0 * p[dimension]) as usize).collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..50).collect::<Vec<_>>());
        }
        assert_eq!(points, latin_hypercube(50, 3, 7));
        assert_ne!(points, latin_hypercube(50, 3, 8));
    }
}
