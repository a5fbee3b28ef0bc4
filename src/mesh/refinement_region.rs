//! Places around which local refinement is requested, and which elements it concerns.

use super::surface::{boundary, boundary_nodes};
use super::{CellKind, Mesh};
use crate::mechanics::element::HEX8_CORNERS;
use crate::mechanics::tensor::Vec3;

/// Relative tolerance for edges of exactly the required length [-].
pub(super) const ROUNDING: f64 = 1e-9;

/// Largest number of levels: from a metre to less than a micrometre.
pub(super) const MOST_HALVINGS: u8 = 20;

/// A place at which elements are to be small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position of the point [m].
    pub point: Vec3,
    /// Outward unit normal of the nearest boundary surface; zero where elements are to be small along all directions.
    pub normal: Vec3,
}

impl Place {
    /// Points [m] with the normal of the mesh's boundary at the nearest node.
    pub fn on_all(mesh: &Mesh, points: &[Vec3]) -> Vec<Self> {
        let faces = mesh.hanging.boundary(boundary(&mesh.cells));
        let nodes = boundary_nodes(&faces);
        let mut normals = vec![Vec3::zeros(); mesh.nodes.len()];
        for face in &faces {
            let [a, b, c, d] = face.map(|node| mesh.nodes[node as usize]);
            let area = (c - a).cross(&(d - b));
            for node in face {
                normals[*node as usize] += area;
            }
        }
        let on = |point: &Vec3| {
            let far = |node: &u32| (mesh.nodes[*node as usize] - point).norm_squared();
            let nearest = nodes.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            let normal = nearest.and_then(|node| normals[*node as usize].try_normalize(0.0));
            Self { point: *point, normal: normal.unwrap_or_else(Vec3::zeros) }
        };
        points.iter().map(on).collect()
    }
}

/// A region with a required element size.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Elements near any of these are refined.
    pub places: Vec<Place>,
    /// Largest distance between a place and the bounding box of an element (along x, y, z) [m].
    pub within: f64,
    /// Largest edge length along the surface [m]: in the two natural directions that are least aligned with the normal.
    pub size: f64,
}

impl Region {
    /// Whether an element with these corners [m] is to be split.
    pub(super) fn splits(&self, corners: &[Vec3; 8]) -> bool {
        let most = self.size * (1.0 + ROUNDING);
        // Distances take longest where there are many places.
        longest_along_surface(corners, &Vec3::zeros()) > most
            && self.size_of(corners).is_some_and(|size| size > most)
    }

    /// Longest edge along the surface [m] of an element with these corners [m]; `None` beyond the region.
    fn size_of(&self, corners: &[Vec3; 8]) -> Option<f64> {
        let low = corners.iter().fold(corners[0], |low, x| low.inf(x));
        let high = corners.iter().fold(corners[0], |high, x| high.sup(x));
        let within = self.within + ROUNDING * (high - low).norm();
        let (distance, place) = self.nearest(&[low, high])?;
        (distance <= within).then(|| longest_along_surface(corners, &place.normal))
    }

    /// The place nearest to a box [m], and its distance [m].
    fn nearest(&self, [low, high]: &[Vec3; 2]) -> Option<(f64, &Place)> {
        let distance = |place: &Place| (place.point - place.point.sup(low).inf(high)).norm();
        let near = self.places.iter().map(|place| (distance(place), place));
        near.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Whether any hexahedron of a mesh is to be split.
    pub fn splits_any(&self, mesh: &Mesh) -> bool {
        hexahedra(mesh).any(|corners| self.splits(&corners))
    }

    /// Least and largest size [m], as in [`Self::size`], of the hexahedra of a mesh in the region; `None` if there are none.
    pub fn sizes_in(&self, mesh: &Mesh) -> Option<[f64; 2]> {
        let sizes = hexahedra(mesh).filter_map(|corners| self.size_of(&corners));
        sizes.map(|size| [size; 2]).reduce(|[least, most], [size, _]| [least.min(size), most.max(size)])
    }

    /// Distance [m] between the places and the nearest hexahedron of a mesh; infinite without either.
    pub fn distance(&self, mesh: &Mesh) -> f64 {
        let of_element = |corners: [Vec3; 8]| {
            let low = corners.iter().fold(corners[0], |low, x| low.inf(x));
            let high = corners.iter().fold(corners[0], |high, x| high.sup(x));
            Some(self.nearest(&[low, high])?.0)
        };
        hexahedra(mesh).filter_map(of_element).fold(f64::INFINITY, f64::min)
    }
}

/// Corners [m] of the hexahedra of a mesh.
fn hexahedra(mesh: &Mesh) -> impl Iterator<Item = [Vec3; 8]> {
    let hexahedra = mesh.cells.iter().filter(|cell| cell.kind == CellKind::Hex8);
    hexahedra.filter_map(move |cell| <[Vec3; 8]>::try_from(&*cell.points(&mesh.nodes)).ok())
}

/// Longest edge of an element [m] in the two natural directions least aligned with a normal; in all three if it is zero.
fn longest_along_surface(corners: &[Vec3; 8], normal: &Vec3) -> f64 {
    let (mut longest, mut mean) = ([0.0_f64; 3], [Vec3::zeros(); 3]);
    for &[a, b] in CellKind::Hex8.table().edges {
        // The two corners differ in one natural coordinate.
        let axis = (0..3).find(|&k| HEX8_CORNERS[a][k] * HEX8_CORNERS[b][k] < 0.0).unwrap_or(0);
        let edge = (corners[b] - corners[a]) * HEX8_CORNERS[b][axis];
        longest[axis] = longest[axis].max(edge.norm());
        mean[axis] += edge;
    }
    if *normal != Vec3::zeros() {
        let along = mean.map(|edge| edge.normalize().dot(normal).abs());
        let through = (0..3).max_by(|&a, &b| along[a].total_cmp(&along[b])).unwrap_or(0);
        longest[through] = 0.0;
    }
    longest.into_iter().fold(0.0, f64::max)
}
