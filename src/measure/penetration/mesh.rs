//! A deformable body in its current configuration, and what is found in it.

use crate::mechanics::contact::Surface;
use crate::mechanics::contact::detection::closest_point::Patch;
use crate::mechanics::contact::detection::winding::nodes_inside;
use crate::mechanics::force::Erosion;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Cells;
use crate::mesh::locate::{Locator, elements_near};
use crate::plan::PlanBody;
use std::borrow::Cow;
use std::cell::OnceCell;

/// Cosine between the normals of a node and of a face of its own body below which the face belongs to another part of
/// the boundary, through which the node entered: at the bottom of a self-intersecting crease the sides stand at right
/// angles to its normal.
const ALONGSIDE: f64 = 0.5;
/// Slightly more than 1 [-], for comparisons of squares that rounding must not decide.
const FAR: f64 = 1.0 + 1e-9;
/// Number of faces that are skipped together where their bounding box is far.
const RUN: usize = 16;

/// A deformable body in its current configuration, without eroded elements.
pub(super) struct Mesh<'a> {
    pub cells: Cow<'a, Cells>,
    pub surface: Cow<'a, Surface>,
    pub x: &'a [Vec3],
    pub bounds: [Vec3; 2],
    /// Number of images of this part that the whole consists of.
    pub images: f64,
    /// Where the faces are, run by run.
    runs: OnceCell<Vec<Run>>,
}

/// Consecutive faces, and their bounding box [m].
struct Run {
    low: Vec3,
    high: Vec3,
    places: Vec<Place>,
}

impl Run {
    fn new(faces: &[[u32; 4]], x: &[Vec3]) -> Self {
        let nodes = || faces.iter().flatten().map(|&node| &x[node as usize]);
        let infinite = Vec3::repeat(f64::INFINITY);
        Self {
            low: nodes().fold(infinite, |low, x| low.inf(x)),
            high: nodes().fold(-infinite, |high, x| high.sup(x)),
            places: faces.iter().map(|face| Place::new(face, x)).collect(),
        }
    }

    /// Squared distance of a point from the box [m²]: no face is nearer.
    fn square_to(&self, point: &Vec3) -> f64 {
        (self.low - point).sup(&(point - self.high)).sup(&Vec3::zeros()).norm_squared()
    }
}

/// Where a face is: its first corner [m], and the largest distance of another from it [m].
struct Place {
    corner: Vec3,
    width: f64,
}

impl Place {
    fn new(face: &[u32; 4], x: &[Vec3]) -> Self {
        let corners = Patch::new(face, x).corners;
        let square = corners.iter().map(|c| (c - corners[0]).norm_squared()).fold(0.0, f64::max);
        Self { corner: corners[0], width: square.sqrt() }
    }
}

/// Result for one pair: depth with its fraction of a face, and volume.
#[derive(Clone, Copy, Default)]
pub(super) struct Found {
    pub depth: f64,
    pub fraction: f64,
    /// The fraction that contact leaves to nodes.
    pub left_to_nodes: f64,
    pub volume: f64,
}

impl Found {
    pub fn deepen(&mut self, depth: f64, size: f64) {
        if depth > self.fraction * size {
            (self.depth, self.fraction) = (depth, depth / size);
        }
    }
}

impl<'a> Mesh<'a> {
    pub fn new(body: &'a PlanBody, erosion: &Erosion, x: &'a [Vec3]) -> Self {
        let surface = body.boundary_after(erosion);
        let cells = match &surface {
            Cow::Borrowed(_) => Cow::Borrowed(&body.cells),
            Cow::Owned(_) => Cow::Owned(body.intact(erosion).collect()),
        };
        let nodes = surface.nodes.iter().map(|&node| x[node as usize]);
        let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        let bounds = nodes.fold(nothing, |[low, high], x| [low.inf(&x), high.sup(&x)]);
        Self { cells, surface, x, bounds, images: 1.0, runs: OnceCell::new() }
    }

    /// As a part of which the whole consists of so many images.
    #[must_use]
    pub fn in_images(self, images: f64) -> Self {
        Self { images, ..self }
    }

    /// Volume [m³], or the sum over its first elements as soon as that reaches `enough`: elements that have not inverted
    /// only add to it.
    pub fn volume_up_to(&self, enough: f64) -> f64 {
        let mut volume = 0.0;
        for cell in self.cells.iter() {
            volume += self.images * cell.kind.volume_m3(&cell.points(self.x));
            if volume >= enough {
                break;
            }
        }
        volume
    }

    /// Distance [m] to the nearest accepted face, and the size of that face [m].
    pub fn depth_below_surface(&self, point: &Vec3, takes: impl Fn(&[u32; 4]) -> bool) -> Option<(f64, f64)> {
        let run = |faces: &[[u32; 4]]| Run::new(faces, self.x);
        let runs = self.runs.get_or_init(|| self.surface.faces.chunks(RUN).map(run).collect());
        let runs = || self.surface.faces.chunks(RUN).zip(runs);
        let square_to = |place: &Place| (point - place.corner).norm_squared();
        // The nearest corner bounds the distance; most faces are farther, as squares show.
        let mut bound = f64::INFINITY;
        for (faces, run) in runs() {
            if run.square_to(point) >= bound {
                continue;
            }
            for (face, place) in faces.iter().zip(&run.places) {
                let square = square_to(place);
                if square < bound && takes(face) {
                    bound = square;
                }
            }
        }
        bound = bound.sqrt();
        let mut best: Option<(f64, f64)> = None;
        for (faces, run) in runs() {
            let least = best.map_or(bound, |(depth, _)| depth.min(bound));
            if run.square_to(point) > FAR * least * least {
                continue;
            }
            for (face, place) in faces.iter().zip(&run.places) {
                let (square, width) = (square_to(place), place.width);
                let reach = best.map_or(bound, |(depth, _)| depth.min(bound)) + width;
                if square > FAR * reach * reach || !takes(face) {
                    continue;
                }
                let least = square.sqrt() - width;
                if best.is_none_or(|(depth, _)| least < depth) {
                    let patch = Patch::new(face, self.x);
                    let depth = (patch.closest(point).point - point).norm();
                    if best.is_none_or(|(least, _)| depth < least) {
                        best = Some((depth, patch.area().sqrt()));
                    }
                }
            }
        }
        best
    }

    /// Calls `take` for some elements with their quadrature points, and the volumes of these [m³].
    pub fn for_each_volume_point(
        &self,
        elements: impl Iterator<Item = usize>,
        mut take: impl FnMut(usize, &Vec3, &dyn Fn() -> f64),
    ) {
        for element in elements {
            let cell = self.cells.get(element);
            let corners = cell.points(self.x);
            let table = cell.kind.table();
            for &(xi, weight) in table.quadrature {
                let point = (table.place)(&corners, xi);
                take(element, &point, &|| (table.jacobian)(&corners, xi).determinant() * weight);
            }
        }
    }

    /// Boundary nodes inside the body and inside elements not adjacent to their own, with the distance to the nearest
    /// face that does not continue their own; the volume only if there are such nodes. Both criteria must hold: a
    /// crumpled boundary alone, or folded elements alone, are no penetration.
    pub fn look_at_itself(&self) -> Found {
        let mut found = Found::default();
        let is_apart = |around: &[u32], other: &[u32]| !other.iter().any(|node| around.contains(node));
        let cells = &self.cells;
        let mut around = Vec::new();
        let elements = OnceCell::new();
        let locator = || elements.get_or_init(|| Locator::within(&self.bounds, cells, self.x));
        // Depth of the boundary nodes inside the body.
        for (node, normal) in nodes_inside(&self.surface, self.x) {
            around.clear();
            let with_node = cells.iter().filter(|cell| cell.nodes.contains(&node));
            around.extend(with_node.flat_map(|cell| cell.nodes));
            let apart = |e: usize| is_apart(&around, cells.nodes(e));
            if locator().element_at(&self.x[node as usize], apart).is_none() {
                continue;
            }
            let point = &self.x[node as usize];
            let is_another_part = |face: &[u32; 4]| {
                !face.contains(&node) && Patch::new(face, self.x).normal(&[0.25; 4]).dot(&normal) < ALONGSIDE
            };
            if let Some((depth, size)) = self.depth_below_surface(point, is_another_part) {
                found.deepen(depth, size);
            }
        }
        // Overlapping volume, only if a node is inside.
        if found.depth > 0.0 {
            let [low, high] = self.bounds;
            let near = elements_near(&self.bounds, cells, self.x);
            self.for_each_volume_point(near.iter().map(|e| *e as usize), |element, point, weight| {
                if !(*point >= low && *point <= high) {
                    return;
                }
                if locator().element_at(point, |e| is_apart(cells.nodes(element), cells.nodes(e))).is_some() {
                    // Each of the two elements counts the shared volume.
                    found.volume += 0.5 * weight();
                }
            });
        }
        found
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mesh::generate::block::Block;
    use crate::mesh::surface;

    /// The nearest face by the distances from all.
    fn nearest(mesh: &Mesh, point: &Vec3, takes: impl Fn(&[u32; 4]) -> bool) -> Option<(f64, f64)> {
        let patches =
            mesh.surface.faces.iter().filter(|face| takes(face)).map(|face| Patch::new(face, mesh.x));
        let far = patches.map(|patch| ((patch.closest(point).point - point).norm(), patch.area().sqrt()));
        far.min_by(|(a, _), (b, _)| a.total_cmp(b))
    }

    #[test]
    fn the_nearest_face_is_found_among_those_that_are_not_skipped() {
        let block =
            Block::uniform(Vec3::zeros(), Vec3::new(3.0, 2.0, 1.0), [9, 7, 5], "b").generate().unwrap();
        let bent = |p: &Vec3| Vec3::new(p.x + 0.2 * p.y * p.z, p.y - 0.1 * p.x * p.x, p.z + 0.3 * p.x);
        let x: Vec<Vec3> = block.nodes.iter().map(bent).collect();
        let faces = surface::boundary(&block.cells);
        assert!(faces.len() > 4 * RUN);
        let mesh = Mesh {
            cells: Cow::Borrowed(&block.cells),
            surface: Cow::Owned(Surface::new(surface::boundary_nodes(&faces), faces)),
            x: &x,
            bounds: [Vec3::repeat(-10.0), Vec3::repeat(10.0)],
            images: 1.0,
            runs: OnceCell::new(),
        };
        for k in 0..200 {
            let t = f64::from(k);
            let [a, b, c] = [0.618_034, 0.754_878, 0.569_840].map(|step| (t * step).fract());
            let point = bent(&Vec3::new(3.0 * a, 2.0 * b, c));
            let takes = |face: &[u32; 4]| k % 3 > 0 || face[0].is_multiple_of(2);
            let (found, expected) = (mesh.depth_below_surface(&point, takes), nearest(&mesh, &point, takes));
            assert_eq!(found, expected, "{point:?}");
        }
    }
}
