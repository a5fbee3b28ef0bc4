//! The contact patch: area, axes and pressure of the slave nodes that are pressed.

use crate::mechanics::contact::Surface;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::step::Frame;
use std::collections::BTreeSet;

/// The patch of one pair at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPatch {
    /// Sum of the current tributary areas of the slave nodes with r_n > 0 [m²].
    pub area: f64,
    /// Long and short axis: 4 √(eigenvalue of the area-weighted second moment) [m]. That is the full axis of a uniformly
    /// covered ellipse; a single node has no extent and gives 0.
    pub axes: [f64; 2],
    /// Number of slave nodes with r_n > 0.
    pub nodes: u32,
    /// Nodes across the short axis, about: 1 + extent / mean spacing, rounded [-].
    pub nodes_across: u32,
    /// Largest nodal pressure r_n / (h̄ · tributary area) [Pa].
    pub peak_pressure: f64,
    /// Area-weighted centre [m].
    pub centre: Vec3,
}

impl Default for ContactPatch {
    fn default() -> Self {
        Self {
            area: 0.0,
            axes: [0.0; 2],
            nodes: 0,
            nodes_across: 0,
            peak_pressure: 0.0,
            centre: Vec3::zeros(),
        }
    }
}

/// Which faces of a slave surface each of its nodes belongs to, found once per run.
#[derive(Clone, Debug)]
pub struct PatchGeometry {
    /// The faces, global nodes.
    faces: Vec<[u32; 4]>,
    /// Sorted nodes of the surface.
    nodes: Vec<u32>,
    /// Faces of `nodes[i]`: `incident[start[i]..start[i + 1]]`.
    start: Vec<u32>,
    incident: Vec<u32>,
}

/// One pressed node: position [m], tributary area [m²], force normal to the face [N].
struct Pressed {
    position: Vec3,
    area: f64,
    normal_force: f64,
}

impl PatchGeometry {
    /// Of a slave surface.
    pub fn new(surface: &Surface) -> Self {
        let nodes = surface.nodes.clone();
        let mut lists = vec![Vec::new(); nodes.len()];
        for (face, corners) in surface.faces.iter().enumerate() {
            for corner in distinct(corners) {
                if let Ok(i) = nodes.binary_search(corner) {
                    lists[i].push(face as u32);
                }
            }
        }
        let mut start = vec![0];
        let mut incident = Vec::new();
        for list in lists {
            incident.extend(list);
            start.push(incident.len() as u32);
        }
        Self { faces: surface.faces.clone(), nodes, start, incident }
    }

    /// Faces that a node belongs to; none when the node is not on the surface.
    fn faces_of(&self, node: u32) -> &[u32] {
        match self.nodes.binary_search(&node) {
            Ok(i) => &self.incident[self.start[i] as usize..self.start[i + 1] as usize],
            Err(_) => &[],
        }
    }

    /// Faces of a node that are turned to the contact: their outward normal opposes `n`, the normal out of the master, by
    /// at least [`TURNED`]. At the rim of a flat end the sides of the body are not, and press on nothing.
    fn faces_towards(
        &self,
        node: u32,
        n: &Vec3,
        position: &dyn Fn(u32) -> Vec3,
    ) -> impl Iterator<Item = u32> {
        self.faces_of(node).iter().copied().filter(move |&f| {
            let [a, b, c, d] = self.faces[f as usize].map(position);
            // Half the cross product of the diagonals is the area vector of a quadrilateral, and of a triangle (c = d).
            let normal = (c - a).cross(&(d - b));
            -n.dot(&normal) > TURNED * normal.norm()
        })
    }

    /// Current tributary area of a node [m²]: ∫ N_a dA over its faces that are turned to the contact.
    pub fn tributary_area(&self, node: u32, n: &Vec3, position: &dyn Fn(u32) -> Vec3) -> f64 {
        let faces = self.faces_towards(node, n, position);
        faces.map(|f| tributary_share(&self.faces[f as usize], node, position)).sum()
    }

    /// The patch of pair `pair` in a frame.
    pub fn eval(&self, frame: &Frame, pair: u32) -> ContactPatch {
        let position = |node: u32| frame.position(node);
        let (mut pressed, mut faces) = (Vec::new(), BTreeSet::new());
        let mut last = None;
        // Contacts are sorted by (pair, slave, face): all contacts of a node stand together and count once.
        for (contact, reaction) in frame.contacts.iter().zip(frame.reactions) {
            if contact.pair != pair || reaction.impulse[0] <= 0.0 {
                continue;
            }
            let normal_force = reaction.impulse[0] / frame.mean_step;
            if last == Some(contact.slave) {
                if let Some(Pressed { normal_force: sum, .. }) = pressed.last_mut() {
                    *sum += normal_force;
                }
                continue;
            }
            last = Some(contact.slave);
            let n = &contact.frame[0];
            faces.extend(self.faces_towards(contact.slave, n, &position));
            let area = self.tributary_area(contact.slave, n, &position);
            pressed.push(Pressed { position: position(contact.slave), area, normal_force });
        }
        let face_area: f64 = faces.iter().map(|&f| face_area(&self.faces[f as usize], &position)).sum();
        let spacing = if faces.is_empty() { 0.0 } else { (face_area / faces.len() as f64).sqrt() };
        patch_of(&pressed, spacing)
    }
}

/// Area, axes and pressure of the pressed nodes; `spacing` is the mean edge of their faces [m].
fn patch_of(pressed: &[Pressed], spacing: f64) -> ContactPatch {
    let area: f64 = pressed.iter().map(|p| p.area).sum();
    if area <= 0.0 {
        return ContactPatch { nodes: pressed.len() as u32, ..ContactPatch::default() };
    }
    let centre = pressed.iter().fold(Vec3::zeros(), |sum, p| sum + p.position * p.area) / area;
    let moment = pressed.iter().fold(Mat3::zeros(), |sum, p| {
        let d = p.position - centre;
        sum + d * d.transpose() * (p.area / area)
    });
    // The patch is nearly flat: the smallest of the three eigenvalues is its warp, the other two are its axes.
    let eigen = moment.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axis = |i: usize| 4.0 * eigen.eigenvalues[order[i]].max(0.0).sqrt();
    let short: Vec3 = eigen.eigenvectors.column(order[1]).into();
    let along = pressed.iter().map(|p| (p.position - centre).dot(&short));
    let (low, high) =
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));
    let across = if spacing > 0.0 { 1.0 + (high - low) / spacing } else { 1.0 };
    ContactPatch {
        area,
        axes: [axis(0), axis(1)],
        nodes: pressed.len() as u32,
        nodes_across: rounded(across),
        peak_pressure: pressed
            .iter()
            .fold(0.0, |peak, p| if p.area > 0.0 { f64::max(peak, p.normal_force / p.area) } else { peak }),
        centre,
    }
}

/// To the nearest whole number.
#[allow(clippy::cast_sign_loss)] // never negative
fn rounded(count: f64) -> u32 {
    count.round() as u32
}

/// Least cosine between a face's outward normal and the direction of the contact, for the face to press: 60°.
const TURNED: f64 = 0.5;

/// Corners without the repetition that marks a triangle.
fn distinct(face: &[u32; 4]) -> &[u32] {
    if face[2] == face[3] { &face[..3] } else { face }
}

/// Area of a face [m²].
fn face_area(face: &[u32; 4], position: &dyn Fn(u32) -> Vec3) -> f64 {
    distinct(face).iter().map(|&node| tributary_share(face, node, position)).sum()
}

/// Corners of the bilinear quadrilateral.
const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// ∫ N_a dA over one face for its corner `node` [m²]: 2×2 Gauss points on a bilinear quadrilateral, a third of a triangle.
fn tributary_share(face: &[u32; 4], node: u32, position: &dyn Fn(u32) -> Vec3) -> f64 {
    let Some(corner) = face.iter().position(|&n| n == node) else { return 0.0 };
    let x = face.map(position);
    if face[2] == face[3] {
        return (x[1] - x[0]).cross(&(x[2] - x[0])).norm() / 6.0;
    }
    let g = 1.0 / 3f64.sqrt();
    SIGNS
        .iter()
        .map(|point| {
            let (a, b) = (g * point[0], g * point[1]);
            let (mut along_a, mut along_b) = (Vec3::zeros(), Vec3::zeros());
            for (x, s) in x.iter().zip(SIGNS) {
                along_a += x * (0.25 * s[0] * (1.0 + s[1] * b));
                along_b += x * (0.25 * s[1] * (1.0 + s[0] * a));
            }
            let s = SIGNS[corner];
            0.25 * (1.0 + s[0] * a) * (1.0 + s[1] * b) * along_a.cross(&along_b).norm()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat 10 × 10 grid of unit squares, z = 0.
    fn grid() -> (Surface, impl Fn(u32) -> Vec3) {
        let node = |i: u32, j: u32| j * 11 + i;
        let faces = (0..10)
            .flat_map(|j| {
                (0..10).map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])
            })
            .collect();
        (Surface { nodes: (0..121).collect(), faces }, |n| {
            Vec3::new(f64::from(n % 11), f64::from(n / 11), 0.0)
        })
    }

    #[test]
    fn tributary_areas_of_a_grid_sum_to_its_area() {
        let (surface, position) = grid();
        let geometry = PatchGeometry::new(&surface);
        let area = |n| geometry.tributary_area(n, &-Vec3::z(), &position);
        assert!(
            (area(0) - 0.25).abs() < 1e-14 && (area(5) - 0.5).abs() < 1e-14 && (area(60) - 1.0).abs() < 1e-14
        );
        let total: f64 = (0..121).map(area).sum();
        assert!((total - 100.0).abs() < 1e-12, "{total}");
    }

    #[test]
    fn a_triangle_gives_a_third_to_each_corner() {
        let surface = Surface { nodes: vec![0, 1, 2], faces: vec![[0, 1, 2, 2]] };
        let position =
            |n: u32| [Vec3::zeros(), Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0)][n as usize];
        let geometry = PatchGeometry::new(&surface);
        for n in 0..3 {
            assert!((geometry.tributary_area(n, &-Vec3::z(), &position) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn axes_of_a_uniform_ellipse_are_its_diameters() {
        let (a, b, spacing) = (3.0, 1.5, 0.05);
        let mut pressed = Vec::new();
        for i in -80..=80 {
            for j in -80..=80 {
                let (x, y) = (f64::from(i) * spacing, f64::from(j) * spacing);
                if (x / a).powi(2) + (y / b).powi(2) <= 1.0 {
                    let position = Vec3::new(x * 0.6 - y * 0.8, x * 0.8 + y * 0.6, 1.0);
                    pressed.push(Pressed { position, area: spacing * spacing, normal_force: 2.0 });
                }
            }
        }
        let patch = patch_of(&pressed, spacing);
        assert!(
            (patch.axes[0] / (2.0 * a) - 1.0).abs() < 0.01 && (patch.axes[1] / (2.0 * b) - 1.0).abs() < 0.01
        );
        assert!((patch.area / (std::f64::consts::PI * a * b) - 1.0).abs() < 0.01);
        assert_eq!(patch.nodes_across, 61);
        assert!((patch.peak_pressure - 2.0 / (spacing * spacing)).abs() < 1e-9);
        assert!((patch.centre - Vec3::new(0.0, 0.0, 1.0)).norm() < 1e-12);
    }

    #[test]
    fn one_node_has_no_extent() {
        let patch = patch_of(&[Pressed { position: Vec3::x(), area: 2.0, normal_force: 1.0 }], 1.0);
        assert_eq!((patch.axes, patch.nodes_across, patch.nodes), ([0.0, 0.0], 1, 1));
    }
}
