//! Closed surfaces → a label volume: voxels whose centres lie inside.
//!
//! A slice of voxel centres cuts a closed surface in closed polygons, and a row of them cuts these polygons. What a row has passed
//! through, each time with the sign of the way, is the winding number there: inside is where it is not zero. Every comparison is
//! half-open, and a point on an edge is computed from the ends of the edge in one order, so that both triangles of the edge see the
//! same point: no ray slips through, whatever it meets exactly.

use super::classes::refused;
use super::enclosed::enclosed_m3;
use super::options::Crop;
use super::volume::LabelVolume;
use crate::mechanics::tensor::Vec3;
use crate::mesh::MeshError;
use crate::mesh::read::stl::ClosedSurface;
use std::collections::BTreeMap;

/// Largest number of steps over slices and rows that the triangles of a surface may take: far more than those of a body take.
const MOST_CUTS: u64 = 1_000_000_000;

/// Largest coordinate of a surface [m].
const FARTHEST: f64 = 1e3;

/// Part of a voxel by which an end of the grid is rounded down [-].
const ROUNDING: f64 = 1e-6;

/// What is filled, and with which voxels.
#[derive(Clone, Debug)]
pub struct Filling<'a> {
    /// Surfaces in metres, those inside others after them: a voxel belongs to the last that it is in.
    pub surfaces: &'a [ClosedSurface],
    /// Largest edge of the voxels [m]; they divide the bounding box of all surfaces.
    pub voxel_m: f64,
    /// The box that is filled; `None`: that of all surfaces.
    pub crop: Option<&'a Crop>,
    /// Largest number of voxels.
    pub most_voxels: u64,
}

/// The labels of surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// Label n is the n-th surface, from 1; 0 is outside of all.
    pub volume: LabelVolume,
    /// Volume of each label that the surfaces enclose in the box [m³]: what is in a surface, without what later ones take of it.
    pub volumes_m3: Vec<(i64, f64)>,
}

/// Why surfaces are not filled, and the number of the one that is the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Unfilled {
    /// Number of the surface, from 0; `None` for all.
    pub surface: Option<usize>,
    /// The reason.
    pub error: MeshError,
}

impl Filling<'_> {
    /// The label volume of the surfaces, along x, y, z, with a layer of voxels outside of them.
    ///
    /// # Errors
    /// `Unsupported` for too many voxels, a surface that encloses nothing or no voxel, or of which later ones leave none, and a crop
    /// outside of all.
    pub fn labels(&self) -> Result<Filled, Unfilled> {
        let of_all = |error| Unfilled { surface: None, error };
        let grid = self.grid().map_err(of_all)?;
        let mut labels = vec![0_u16; grid.voxels()];
        let mut fills = Vec::with_capacity(self.surfaces.len());
        for (i, surface) in self.surfaces.iter().enumerate() {
            let fill = grid.fill(surface, i as u16 + 1, &mut labels);
            fills.push(fill.map_err(|error| Unfilled { surface: Some(i), error })?);
        }
        self.check(&fills, &labels)?;
        let [a, b, c] = grid.dims;
        let millimetres = grid.spacing.map(|x| format!("{:.3}", 1e3 * x));
        let of_grid =
            format!("{a} × {b} × {c} voxels of {} mm in the surfaces", millimetres.as_slice().join(" × "));
        let volume = LabelVolume {
            dims: grid.dims,
            labels,
            values: (0..=self.surfaces.len() as i64).collect(),
            names: BTreeMap::new(),
            origin: grid.low + grid.spacing * 0.5,
            steps: [0, 1, 2].map(|k| Vec3::ith(k, grid.spacing[k])),
            notes: vec![of_grid],
        };
        Ok(Filled { volume, volumes_m3: self.volumes_m3(&grid, &fills) })
    }

    /// Volumes of the labels: of each surface its own, less that of later ones in the proportion of the voxels that they take of it,
    /// which is all or nothing where surfaces do not cross each other.
    fn volumes_m3(&self, grid: &Grid, fills: &[Fill]) -> Vec<(i64, f64)> {
        let voxel_m3 = grid.spacing.product();
        let mut volumes = vec![0.0; 1 + fills.len()];
        for (i, (fill, surface)) in fills.iter().zip(self.surfaces).enumerate() {
            if fill.count == 0 {
                continue;
            }
            // Of one voxel. Shells that overlap count twice in what is enclosed, and in the winding numbers, but not here.
            let enclosed = enclosed_m3(surface, &grid.bounds());
            let of_voxel = if fill.winding > 0 { enclosed / fill.winding as f64 } else { voxel_m3 };
            volumes[i + 1] += fill.count as f64 * of_voxel;
            for (volume, taken) in volumes.iter_mut().zip(&fill.taken) {
                *volume -= *taken as f64 * of_voxel;
            }
        }
        (0..).zip(volumes).skip(1).collect()
    }

    /// The voxels of the box of all surfaces with a layer around it, or of the crop, rounded outwards.
    fn grid(&self) -> Result<Grid, MeshError> {
        let points = || self.surfaces.iter().flat_map(|surface| &surface.points);
        let corner = |fold: fn(&Vec3, &Vec3) -> Vec3| points().copied().reduce(|a, b| fold(&a, &b));
        let (Some(low), Some(high)) = (corner(Vec3::inf), corner(Vec3::sup)) else {
            return Err(refused("no surface", "name one, \"surfaces\": [{\"name\": …, \"part\": …}]"));
        };
        let farthest = low.abs().max().max(high.abs().max());
        if !(farthest <= FARTHEST) {
            let what = format!(
                "a surface with a coordinate of {farthest:e} m, of which at most {FARTHEST} m are allowed"
            );
            return Err(refused(what, "check \"scale\" of the surfaces: 0.001 for millimetres"));
        }
        let lengths = high - low;
        let counts = lengths.map(|length| (length / self.voxel_m - ROUNDING).ceil().max(1.0));
        let spacing = lengths.component_div(&counts);
        let mut ends = [0, 1, 2].map(|k| [-1.0, counts[k] + 1.0]);
        if let Some(crop) = self.crop {
            for (k, [first, end]) in ends.iter_mut().enumerate() {
                let at = |side: f64| (crop.center[k] + 0.5 * side * crop.size_m[k] - low[k]) / spacing[k];
                *first = first.max((at(-1.0) + ROUNDING).floor());
                *end = end.min((at(1.0) - ROUNDING).ceil());
                if !(*first < *end) {
                    return Err(refused(
                        "a crop outside of the surfaces",
                        "move its centre into the outer surface",
                    ));
                }
            }
        }
        let voxels: f64 = ends.iter().map(|[first, end]| end - first).product();
        if !(voxels <= self.most_voxels as f64) {
            let size = lengths.map(|x| format!("{x:.3}")).as_slice().join(" × ");
            let what = format!(
                "{voxels:.3e} voxels of {} m in surfaces of {size} m, of which at most {} are allowed",
                self.voxel_m, self.most_voxels
            );
            let remedy = "check \"scale\" of the surfaces (0.001 for millimetres), give a larger voxel_size_m, or crop them around the impact";
            return Err(refused(what, remedy));
        }
        let first = Vec3::from_fn(|k, _| ends[k][0]);
        Ok(Grid {
            low: low + first.component_mul(&spacing),
            spacing,
            dims: ends.map(|[first, end]| (end - first) as usize),
        })
    }

    /// Refuses surfaces without voxels: `fills` are those in each, `labels` what later ones left of them.
    fn check(&self, fills: &[Fill], labels: &[u16]) -> Result<(), Unfilled> {
        let mut left = vec![0_u64; 1 + fills.len()];
        for label in labels {
            left[usize::from(*label)] += 1;
        }
        for (i, (fill, left)) in fills.iter().zip(&left[1..]).enumerate() {
            let error = match (fill.count, left) {
                (0, _) if self.crop.is_none() => refused(
                    format!("a surface of {:.3e} m³ with no voxel in it", self.surfaces[i].volume()),
                    "give a smaller voxel_size_m, or omit the surface",
                ),
                (1.., 0) => refused(
                    "a surface of which those after it leave nothing",
                    "list the surfaces from the outside to the inside: a voxel belongs to the last that it is in",
                ),
                _ => continue,
            };
            return Err(Unfilled { surface: Some(i), error });
        }
        Ok(())
    }
}

/// The voxels in a surface.
struct Fill {
    /// Their number.
    count: u64,
    /// The sum of their winding numbers: `count`, where no shells of the surface overlap.
    winding: i64,
    /// Number of them that had each of the earlier labels, from 0.
    taken: Vec<u64>,
}

/// Voxels along x, y, z.
struct Grid {
    /// Low corner [m].
    low: Vec3,
    /// Edges of a voxel [m].
    spacing: Vec3,
    /// Number of voxels along each axis.
    dims: [usize; 3],
}

impl Grid {
    fn voxels(&self) -> usize {
        self.dims.iter().product()
    }

    /// A position in units of voxels, in which the centre of a voxel is at its indices.
    fn local(&self, x: &Vec3) -> Vec3 {
        (x - self.low).component_div(&self.spacing).add_scalar(-0.5)
    }

    /// Lower and upper corner [m].
    fn bounds(&self) -> [Vec3; 2] {
        [self.low, self.low + self.spacing.component_mul(&Vec3::from(self.dims.map(|n| n as f64)))]
    }

    /// Gives a label to the voxels in a surface, all labels of which are smaller.
    fn fill(&self, surface: &ClosedSurface, label: u16, labels: &mut [u16]) -> Result<Fill, MeshError> {
        if !(surface.volume() > 0.0) {
            return Err(refused("a surface that encloses no volume", "export it again, as a closed surface"));
        }
        let [nx, ny, nz] = self.dims;
        let points: Vec<Vec3> = surface.points.iter().map(|x| self.local(x)).collect();
        let corners = |triangle: u32| surface.triangles[triangle as usize].map(|node| points[node as usize]);
        // Triangles by the first slice that they cross, and those that cross the current one.
        let mut beginning: Vec<Vec<u32>> = vec![Vec::new(); nz];
        for triangle in 0..surface.triangles.len() as u32 {
            let [low, high] = range(corners(triangle).map(|x| x.z), nz);
            if low < high {
                beginning[low].push(triangle);
            }
        }
        let mut active: Vec<u32> = Vec::new();
        let mut changes = vec![0_i32; nx * ny];
        let mut cuts = 0_u64;
        let mut fill = Fill { count: 0, winding: 0, taken: vec![0; usize::from(label)] };
        for (k, (slice, beginning)) in labels.chunks_exact_mut(nx * ny).zip(&beginning).enumerate() {
            active.retain(|triangle| range(corners(*triangle).map(|x| x.z), nz)[1] > k);
            active.extend(beginning);
            for triangle in &active {
                cuts += 1 + cut(&corners(*triangle), k as f64, [nx, ny], &mut changes);
            }
            if cuts > MOST_CUTS {
                let what =
                    format!("a surface whose triangles cross the rows of voxels over {MOST_CUTS} times");
                return Err(refused(
                    what,
                    "reduce the surface, as `decimate` of PyVista does, or give a larger voxel_size_m",
                ));
            }
            for (row, changes) in slice.chunks_exact_mut(nx).zip(changes.chunks_exact_mut(nx)) {
                let mut winding = 0;
                for (voxel, change) in row.iter_mut().zip(changes) {
                    winding += std::mem::take(change);
                    if winding != 0 {
                        fill.taken[usize::from(*voxel)] += 1;
                        fill.winding += i64::from(winding);
                        fill.count += 1;
                        *voxel = label;
                    }
                }
            }
        }
        Ok(fill)
    }
}

/// The indices, below `count`, that lie between the least and the largest of three numbers; the largest itself does not count.
fn range(numbers: [f64; 3], count: usize) -> [usize; 2] {
    let least = numbers.into_iter().fold(f64::INFINITY, f64::min);
    let most = numbers.into_iter().fold(f64::NEG_INFINITY, f64::max);
    [least, most].map(|x| index_from(x, count))
}

/// The first index from a number on, at most `count`.
fn index_from(x: f64, count: usize) -> usize {
    x.ceil().clamp(0.0, count as f64) as usize
}

/// Adds ±1 to the changes of the winding number in the slice at z, at the first voxel of each row behind a triangle. Returns the number
/// of rows that the triangle crosses.
fn cut(corners: &[Vec3; 3], z: f64, [nx, ny]: [usize; 2], changes: &mut [i32]) -> u64 {
    // The segment of the triangle in the slice, from the edge that is passed upwards to the one that is passed downwards.
    let mut ends = [None; 2];
    for (i, a) in corners.iter().enumerate() {
        let b = &corners[(i + 1) % 3];
        match (a.z <= z, b.z <= z) {
            (true, false) => ends[0] = Some(between(a, b, (z - a.z) / (b.z - a.z))),
            (false, true) => ends[1] = Some(between(b, a, (z - b.z) / (a.z - b.z))),
            _ => {}
        }
    }
    let [Some(from), Some(to)] = ends else { return 0 };
    // A row towards +x comes in where the segment goes towards +y.
    let (low, high, sign) = if from.y <= to.y { (from, to, 1) } else { (to, from, -1) };
    let rows = index_from(low.y, ny)..index_from(high.y, ny);
    for j in rows.clone() {
        let x = low.x + (high.x - low.x) * ((j as f64 - low.y) / (high.y - low.y));
        let i = index_from(x, nx);
        if i < nx {
            changes[j * nx + i] += sign;
        }
    }
    rows.len() as u64
}

/// The point at a fraction of the way from a to b.
fn between(a: &Vec3, b: &Vec3, fraction: f64) -> Vec3 {
    a + (b - a) * fraction
}

#[cfg(test)]
mod tests;
