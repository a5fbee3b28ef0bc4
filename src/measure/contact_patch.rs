//! The contact patch: area, axes and pressure of the slave nodes that are pressed.

use super::face_shape::{FaceShape, distinct};
use crate::mechanics::contact::Surface;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::step::Frame;

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

/// Which faces of a slave surface each of its nodes belongs to, found once per run, with the memory of an evaluation.
#[derive(Clone, Debug)]
pub struct PatchGeometry {
    /// The body of the surface.
    body: usize,
    /// How many elements were gone when the faces were listed.
    gone: usize,
    /// The faces, global nodes.
    faces: Vec<[u32; 4]>,
    /// Sorted nodes of the surface.
    nodes: Vec<u32>,
    /// Faces of `nodes[i]`: `incident[start[i]..start[i + 1]]`.
    start: Vec<u32>,
    incident: Vec<u32>,
    /// Shape of each face, and the evaluation that it is of.
    shapes: Vec<(u64, FaceShape)>,
    evaluation: u64,
    pressed: Vec<Pressed>,
    /// Of each node: the evaluation that it was last pressed in, and its place in `pressed`.
    places: Vec<(u64, u32)>,
    pressed_faces: Vec<u32>,
}

/// One pressed node: position [m], tributary area [m²], force normal to the face [N].
#[derive(Clone, Copy, Debug)]
struct Pressed {
    position: Vec3,
    area: f64,
    normal_force: f64,
}

impl PatchGeometry {
    /// Of a slave surface, the skin of a body.
    pub fn new(body: usize, surface: &Surface) -> Self {
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
        Self {
            body,
            gone: 0,
            faces: surface.faces.clone(),
            places: vec![(0, 0); nodes.len()],
            nodes,
            start,
            incident,
            shapes: vec![(0, FaceShape::default()); surface.faces.len()],
            evaluation: 0,
            pressed: Vec::new(),
            pressed_faces: Vec::new(),
        }
    }

    /// Faces that a node belongs to; none when the node is not on the surface.
    fn faces_of(&self, node: u32) -> std::ops::Range<usize> {
        match self.nodes.binary_search(&node) {
            Ok(i) => self.start[i] as usize..self.start[i + 1] as usize,
            Err(_) => 0..0,
        }
    }

    /// Current tributary area of a node [m²]: ∫ N_a dA over its faces that are turned to the contact, with `n` the normal
    /// out of the master; those faces are noted among the pressed ones.
    fn tributary_area(&mut self, node: u32, n: &Vec3, position: &impl Fn(u32) -> Vec3) -> f64 {
        let mut area = 0.0;
        for i in self.faces_of(node) {
            let face = self.incident[i];
            let corners = &self.faces[face as usize];
            let (of, shape) = &mut self.shapes[face as usize];
            if *of != self.evaluation {
                (*of, *shape) = (self.evaluation, FaceShape::new(corners, position));
            }
            if let (true, Some(corner)) = (shape.is_turned(n), corners.iter().position(|&c| c == node)) {
                area += shape.tributary_share(corner);
                self.pressed_faces.push(face);
            }
        }
        area
    }

    /// The patch of pair `pair` in a frame.
    pub fn eval(&mut self, frame: &Frame, pair: u32) -> ContactPatch {
        let (body, gone) = (self.body, frame.erosion.elements().len());
        if gone != self.gone {
            *self = Self { gone, ..Self::new(body, &frame.plan.bodies[body].skin_after(frame.erosion)) };
        }
        let position = |node: u32| frame.position_in(body, node);
        self.evaluation += 1;
        self.pressed.clear();
        self.pressed_faces.clear();
        for (contact, reaction) in frame.contacts.iter().zip(frame.reactions) {
            if contact.pair != pair || reaction.impulse[0] <= 0.0 {
                continue;
            }
            for (node, share) in contact.stencil.slave() {
                self.press(node, &contact.frame[0], share * reaction.impulse[0] / frame.mean_step, &position);
            }
        }
        let spacing = self.spacing();
        patch_of(&self.pressed, spacing)
    }

    /// Adds a force [N] along the normal `n` to a node, which counts once.
    fn press(&mut self, node: u32, n: &Vec3, normal_force: f64, position: &impl Fn(u32) -> Vec3) {
        let place = self.nodes.binary_search(&node).ok();
        if let Some((of, at)) = place.map(|place| self.places[place])
            && of == self.evaluation
        {
            self.pressed[at as usize].normal_force += normal_force;
            return;
        }
        if let Some(place) = place {
            self.places[place] = (self.evaluation, self.pressed.len() as u32);
        }
        let area = self.tributary_area(node, n, position);
        self.pressed.push(Pressed { position: position(node), area, normal_force });
    }

    /// Mean edge of the pressed faces [m].
    fn spacing(&mut self) -> f64 {
        self.pressed_faces.sort_unstable();
        self.pressed_faces.dedup();
        let faces = &self.pressed_faces;
        let area: f64 = faces
            .iter()
            .map(|&f| {
                let count = distinct(&self.faces[f as usize]).len();
                (0..count).map(|corner| self.shapes[f as usize].1.tributary_share(corner)).sum::<f64>()
            })
            .sum();
        if faces.is_empty() { 0.0 } else { (area / faces.len() as f64).sqrt() }
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
        let mut geometry = PatchGeometry::new(0, &surface);
        geometry.evaluation = 1;
        let mut area = |n| geometry.tributary_area(n, &-Vec3::z(), &position);
        assert!(
            (area(0) - 0.25).abs() < 1e-14 && (area(5) - 0.5).abs() < 1e-14 && (area(60) - 1.0).abs() < 1e-14
        );
        let total: f64 = (0..121).map(&mut area).sum();
        assert!((total - 100.0).abs() < 1e-12, "{total}");
    }

    #[test]
    fn a_triangle_gives_a_third_to_each_corner() {
        let surface = Surface { nodes: vec![0, 1, 2], faces: vec![[0, 1, 2, 2]] };
        let position =
            |n: u32| [Vec3::zeros(), Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0)][n as usize];
        let mut geometry = PatchGeometry::new(0, &surface);
        geometry.evaluation = 1;
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
