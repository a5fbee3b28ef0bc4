//! The octree of a grid: how large its leaves are.

use super::classes::{Classes, refused};
use super::grid::ClassGrid;
use super::labelling;
use super::octree::{Leaf, MOST_CELLS, MOST_HALVINGS, Octree};
use super::options::Options;
use super::volume::Frame;
use crate::mechanics::tensor::Vec3;
use crate::mesh::MeshError;

/// Edge of an element per distance from where it is to be small [-].
const GROWTH: f64 = 0.4;

/// A layer is thin where no ball of this diameter, in edges of the element, lies in it [-].
const THIN: f64 = 2.0;

/// Fraction of the volume of a leaf from which a label counts there [-].
const COUNTS: f64 = 0.02;

/// Refuses more elements than are allowed.
///
/// # Errors
/// `Unsupported`.
pub fn within(elements: u64, options: &Options) -> Result<(), MeshError> {
    if elements <= options.max_elements {
        return Ok(());
    }
    let what = format!("{elements} elements or more, of which at most {} are allowed", options.max_elements);
    Err(refused(what, "enlarge the sizes, or crop the scan around the impact"))
}

/// The octree, fine where that is requested and at thin layers, and which of the requested places make no leaf of a part smaller.
///
/// # Errors
/// `Unsupported` for too many elements, as soon as there will be.
pub fn octree(
    grid: &ClassGrid,
    frame: &Frame,
    classes: &Classes,
    options: &Options,
) -> Result<(Octree, Vec<bool>), MeshError> {
    let lengths = grid.lengths();
    // Base grid of the largest size, refused before it is allocated: none is larger, or those of half the size that a point asks for would
    // be halved once more.
    let counts = lengths.map(|length| (length / options.size_m - 1e-6).ceil().max(1.0));
    let most = 8 * options.max_elements;
    if !(counts.product() <= most as f64) {
        within(counts.product().min(1e18) as u64, options)?;
    }
    let base = [0, 1, 2].map(|k| counts[k] as u32);
    let edge = (0..3).map(|k| lengths[k] / counts[k]).fold(0.0, f64::max);
    // Requested places in the axes of the grid, and the halvings that the finest of them needs.
    let corner = Vec3::from_fn(|k, _| grid.first[k] as f64 * grid.spacing[k]);
    let places: Vec<(Vec3, f64, f64)> = options
        .near
        .iter()
        .map(|near| (frame.local(&near.point) - corner, near.size_m, near.within_m))
        .collect();
    let finest = places.iter().fold(options.size_m, |least, (_, size, _)| least.min(*size));
    let thin = options.thin_size_m.unwrap_or(finest);
    let halvings = (edge / finest.min(thin) - 1e-6).log2().ceil().clamp(0.0, f64::from(MOST_HALVINGS));
    if base.iter().any(|n| u64::from(*n) << (halvings as u32) >= u64::from(MOST_CELLS)) {
        return Err(refused(
            "more than a million elements along an axis",
            "enlarge the sizes, or crop the scan",
        ));
    }
    // Halve what is coarser than requested at its distance, or than a thin layer in it.
    let mut tree = Octree::new(base, &lengths, halvings as u8);
    let (mut fractions, mut found) = (Vec::new(), Vec::new());
    let mut are_idle = vec![true; places.len()];
    let mut elements = 0;
    let mut asks = |tree: &Octree, leaf: Leaf| {
        let [low, high] = tree.bounds(leaf);
        labelling::fractions(grid, [low, high], &mut fractions);
        // Holes have no elements, but are to be resolved.
        let of_parts: f64 =
            (0..grid.count).filter(|class| classes.is_part[*class]).map(|class| fractions[class]).sum();
        let edge = tree.edge(leaf.level);
        let is_coarse = |(point, size, within): &(Vec3, f64, f64)| {
            let distance = (point - point.sup(&low).inf(&high)).norm();
            edge > (size + GROWTH * (distance - within).max(0.0)).min(options.size_m) * (1.0 + 1e-6)
        };
        found.clear();
        found.extend((1..grid.count).filter(|class| fractions[*class] > COUNTS).map(|class| class as u8));
        let mut is_requested = false;
        for (_, is_idle) in
            places.iter().zip(&mut are_idle).filter(|(place, _)| of_parts > 0.0 && is_coarse(place))
        {
            (is_requested, *is_idle) = (true, false);
        }
        let is_split = is_requested
            || edge > thin * (1.0 + 1e-6)
                && found.iter().any(|class| is_thin(grid, [low, high], *class, edge));
        // What is nothing but parts has an element in each of its leaves, however far they are still halved.
        if is_split && of_parts > 1.0 - 1e-6 {
            elements += if leaf.level == 0 { 8 } else { 7 };
        }
        if elements > options.max_elements { Err(elements) } else { Ok(is_split) }
    };
    match tree.refine(most, &mut asks) {
        Ok(()) => Ok((tree, are_idle)),
        Err(elements) => Err(within(elements, options).err().unwrap_or(MeshError::Empty)),
    }
}

/// Whether no ball of a diameter of [`THIN`] edges around a point near a leaf is all of one class.
fn is_thin(grid: &ClassGrid, [low, high]: [Vec3; 2], class: u8, edge: f64) -> bool {
    const POINTS: usize = 7;
    let radius = 0.5 * THIN * edge;
    let lengths = grid.lengths();
    let is_solid = |centre: &Vec3| {
        let steps = [-1.0, 0.0, 1.0];
        let at = |x: f64, y: f64, z: f64| {
            let away = Vec3::new(x, y, z);
            let length = away.norm();
            let p = centre + if length > 0.0 { away * (radius / length) } else { away };
            // Beyond the box, the body goes on.
            grid.class_at(&p.sup(&Vec3::zeros()).inf(&lengths)) == class
        };
        grid.class_at(centre) == class
            && steps.iter().all(|x| steps.iter().all(|y| steps.iter().all(|z| at(*x, *y, *z))))
    };
    let (low, size) = (low.add_scalar(-radius), (high - low).add_scalar(2.0 * radius));
    let place = |n: usize| n as f64 / (POINTS - 1) as f64;
    !(0..POINTS).any(|i| {
        (0..POINTS).any(|j| {
            (0..POINTS)
                .any(|k| is_solid(&(low + size.component_mul(&Vec3::new(place(i), place(j), place(k))))))
        })
    })
}
