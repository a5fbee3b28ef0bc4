//! Between nodes, rows of lanes and registers.

use crate::lanes::{BATCH, Lane, Row};
use crate::material::MAX_FAMILIES;
use crate::registers::Registers;
use crate::tensor::Vec3;

/// Nodal vectors of a batch, transposed into lanes: `[component][corner]`.
#[inline(always)]
pub(super) fn gather<const N: usize>(nodes: &[[u16; BATCH]; N], from: &[Vec3], to: &mut [[Row; N]; 3]) {
    for (corner, nodes) in nodes.iter().enumerate() {
        for (lane, node) in nodes.iter().enumerate() {
            let value = &from[*node as usize];
            to[0][corner].0[lane] = value.x;
            to[1][corner].0[lane] = value.y;
            to[2][corner].0[lane] = value.z;
        }
    }
}

/// [`gather`] from the vectors of all nodes, `of_chunk` the global nodes of the chunk that the batch is in.
pub(super) fn gather_global<const N: usize>(
    nodes: &[[u16; BATCH]; N],
    of_chunk: &[u32],
    from: &[Vec3],
) -> [[Row; N]; 3] {
    let mut to = [[Row::default(); N]; 3];
    for (corner, nodes) in nodes.iter().enumerate() {
        for (lane, node) in nodes.iter().enumerate() {
            let value = &from[of_chunk[*node as usize] as usize];
            for i in 0..3 {
                to[i][corner].0[lane] = value[i];
            }
        }
    }
    to
}

/// Adds the reverse of [`gather`], corner by corner, lane by lane.
#[inline(always)]
pub(super) fn add<const N: usize>(from: &[[Row; N]; 3], nodes: &[[u16; BATCH]; N], to: &mut [Vec3]) {
    for (corner, nodes) in nodes.iter().enumerate() {
        for (lane, node) in nodes.iter().enumerate() {
            let force = &mut to[*node as usize];
            force.x += from[0][corner].0[lane];
            force.y += from[1][corner].0[lane];
            force.z += from[2][corner].0[lane];
        }
    }
}

/// [`gather`] in the precision of `S`, with the elements of the lanes `still` at rest.
#[inline(always)]
pub(super) fn gather_in<S: Registers, const N: usize>(
    nodes: &[[u16; BATCH]; N],
    from: &[Vec3],
    still: u8,
    to: &mut [[Row; N]; 3],
) {
    gather(nodes, from, to);
    keep_still(still, to);
    if S::IS_SINGLE {
        subtract_first(to);
    }
}

/// [`add`] of forces in the precision of `S`.
#[inline(always)]
pub(super) fn add_in<S: Registers, const N: usize>(
    from: &mut [[Row; N]; 3],
    nodes: &[[u16; BATCH]; N],
    to: &mut [Vec3],
) {
    if S::IS_SINGLE {
        balance(from);
    }
    add(from, nodes, to);
}

/// Differences of displacements [m] or velocities [m/s] of the nodes of an element that are taken for zero in single precision. What runs
/// ahead of a wave is smaller by orders of magnitude at each element, and products of three such strains would be subnormal numbers, with
/// which some processors are many times slower.
const NEGLIGIBLE: f64 = 1e-15;

/// Displacements relative to that of the first node, on which the digits of a lower precision are not spent.
#[inline(always)]
fn subtract_first<const N: usize>(nodal: &mut [[Row; N]; 3]) {
    for rows in nodal {
        let first = rows[0];
        for row in rows {
            row.0.iter_mut().zip(&first.0).for_each(|(x, first)| {
                let difference = *x - first;
                *x = if difference.abs() < NEGLIGIBLE { 0.0 } else { difference };
            });
        }
    }
}

/// Makes nodal forces of rounded numbers balance to all digits, so that no momentum is made.
#[inline(always)]
fn balance<const N: usize>(nodal: &mut [[Row; N]; 3]) {
    for rows in nodal {
        let mut sum = Row::default();
        for row in &rows[..N - 1] {
            sum.0.iter_mut().zip(&row.0).for_each(|(sum, x)| *sum += x);
        }
        rows[N - 1] = Row(sum.0.map(|sum| -sum));
    }
}

/// Sets the lanes of a mask to zero, a bit each.
#[inline]
pub(super) fn clear(mask: u8, row: &mut Row) {
    for (lane, value) in row.0.iter_mut().enumerate() {
        if mask >> lane & 1 == 1 {
            *value = 0.0;
        }
    }
}

/// Takes the elements of these lanes for what nothing has moved.
#[inline(always)]
pub(super) fn keep_still<const N: usize>(mask: u8, nodal: &mut [[Row; N]; 3]) {
    if mask != 0 {
        nodal.as_flattened_mut().iter_mut().for_each(|row| clear(mask, row));
    }
}

/// Nodal values of the elements of a register.
#[inline(always)]
pub(super) fn load_corners<S: Registers, const N: usize>(
    simd: S,
    rows: &[[Row; N]; 3],
    part: usize,
) -> [[Lane<S>; N]; 3] {
    let mut lanes = [[Lane::splat(simd, 0.0); N]; 3];
    for i in 0..3 {
        for corner in 0..N {
            lanes[i][corner] = Lane::load(simd, &rows[i][corner], part);
        }
    }
    lanes
}

/// The reverse of [`load_corners`].
#[inline(always)]
pub(super) fn store_corners<S: Registers, const N: usize>(
    lanes: &[[Lane<S>; N]; 3],
    rows: &mut [[Row; N]; 3],
    part: usize,
) {
    for i in 0..3 {
        for corner in 0..N {
            lanes[i][corner].store(&mut rows[i][corner], part);
        }
    }
}

/// Fibre directions of the elements of a register; zero beyond the families of the law.
#[inline(always)]
pub(super) fn load_fibres<S: Registers>(
    simd: S,
    rows: &[[Row; 3]],
    part: usize,
) -> [[Lane<S>; 3]; MAX_FAMILIES] {
    let mut fibres = [[Lane::splat(simd, 0.0); 3]; MAX_FAMILIES];
    for (a, rows) in fibres.iter_mut().zip(rows) {
        for i in 0..3 {
            a[i] = Lane::load(simd, &rows[i], part);
        }
    }
    fibres
}
