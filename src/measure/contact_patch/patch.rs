//! A contact patch: area, axes and pressure of its nodes.
//!
//! A round or square patch has one principal second moment in its plane, and its principal axes are arbitrary: what is measured along them
//! depends on rounding. Widths are therefore those of the narrowest rectangle around the nodes, which lies along an edge of their hull.

use super::super::face_shape::Shadow;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Relative difference below which two widths are the same [-].
const SAME: f64 = 1e-9;

/// The contact patch of one pair at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPatch {
    /// Sum of the current tributary areas of the slave nodes in contact, as far as a rigid master covers them [m²]. A
    /// contact between nodes counts as one node in total, by its weights. At most the area of the master's faces around
    /// the participating nodes.
    pub area: f64,
    /// Long and short axis: 4 √(eigenvalue of the area-weighted second moment) [m]. This is the full axis of a
    /// uniformly covered ellipse; for a ring or a rectangle it would exceed the width, to which it is limited: that of the narrowest
    /// rectangle around the nodes and half a spacing beyond them, and of a rigid master. A single node has no extent and gives 0.
    pub axes: [f64; 2],
    /// Number of slave nodes with r_n > 0 at this instant.
    pub nodes: u32,
    /// Number of nodes across the patch where it is narrowest: 1 + least width / mean spacing, rounded [-].
    pub nodes_across: u32,
    /// Largest nodal pressure r_n / (h̄ · full tributary area) at this instant, covered or not [Pa].
    pub peak_pressure: f64,
    /// Area-weighted centre of the patch [m].
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

impl ContactPatch {
    /// The smaller of the slave patch and the master patch.
    #[must_use]
    pub fn within(self, master: &Self) -> Self {
        if self.area <= master.area || master.area == 0.0 {
            return self;
        }
        Self { area: master.area, axes: master.axes, centre: master.centre, ..self }
    }
}

/// A node in contact, with its area.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pressed {
    pub(super) position: Vec3,
    /// Tributary area covered by a rigid master, and in full [m²].
    pub(super) tributary: [f64; 2],
    /// Sum of the weights of its latest contacts, and the largest such sum of late.
    pub(super) weights: [f64; 2],
    /// Force normal to the face at this instant [N].
    pub(super) normal_force: f64,
}

impl Pressed {
    /// Part of the tributary area in contact [m²].
    pub(super) fn area(&self) -> f64 {
        self.tributary[0] * self.weights[1].clamp(0.0, 1.0)
    }
    /// Pressure on the full tributary area, covered or not [Pa].
    pub(super) fn pressure(&self) -> f64 {
        let area = self.tributary[1] * self.weights[0].clamp(0.0, 1.0);
        if area > 0.0 { self.normal_force / area } else { 0.0 }
    }
}

/// Area, axes and pressure of the pressed nodes; `spacing` is the mean edge length of their faces [m], `shadow` the projection of a rigid
/// master.
pub(super) fn patch_of(pressed: &[Pressed], spacing: f64, shadow: Option<&Shadow>) -> ContactPatch {
    let area: f64 = pressed.iter().map(Pressed::area).sum();
    let nodes = pressed.iter().filter(|p| p.normal_force > 0.0).count() as u32;
    if area <= 0.0 {
        return ContactPatch { nodes, ..ContactPatch::default() };
    }
    // Second moment of area about the centre.
    let centre = pressed.iter().fold(Vec3::zeros(), |sum, p| sum + p.position * p.area()) / area;
    let moment = pressed.iter().fold(Mat3::zeros(), |sum, p| {
        let d = p.position - centre;
        sum + d * d.transpose() * (p.area() / area)
    });
    // The patch is nearly flat: the smallest of the three eigenvalues measures its warping, the other two its axes.
    let eigen = moment.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let plane = [0, 1].map(|i: usize| Vec3::from(eigen.eigenvectors.column(order[i])));
    let places = pressed.iter().map(|p| plane.map(|axis| (p.position - centre).dot(&axis)));
    // Its sides limit the axes of the equivalent ellipse.
    let around = Rectangle::narrowest(places.collect());
    let side = |i: usize| {
        let [x, y] = around.directions[i];
        let direction = plane[0] * x + plane[1] * y;
        let of_master = shadow.map_or(f64::INFINITY, |shadow| shadow.extent_along(&direction));
        (around.sides[i] + spacing).min(of_master)
    };
    let axis = |i: usize| (4.0 * eigen.eigenvalues[order[i]].max(0.0).sqrt()).min(side(i));
    // A rigid master may cover less along the long side than along the short one.
    let (a, b) = (axis(0), axis(1));
    let across = if spacing > 0.0 { 1.0 + around.sides[1] / spacing } else { 1.0 };
    ContactPatch {
        area,
        axes: [a.max(b), a.min(b)],
        nodes,
        nodes_across: rounded(across),
        peak_pressure: pressed.iter().map(Pressed::pressure).fold(0.0, f64::max),
        centre,
    }
}

/// Rounds to the nearest integer.
#[allow(clippy::cast_sign_loss)] // never negative
fn rounded(count: f64) -> u32 {
    count.round() as u32
}

/// A rectangle in a plane.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    /// Its sides, the long one first [m].
    sides: [f64; 2],
    /// Their unit directions.
    directions: [[f64; 2]; 2],
}

impl Rectangle {
    /// The narrowest around some places [m]; of several the shortest.
    fn narrowest(places: Vec<[f64; 2]>) -> Self {
        let hull = hull_of(places);
        let extent = |[x, y]: [f64; 2]| {
            let along = hull.iter().map(|p| p[0] * x + p[1] * y);
            let ends =
                along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| [low.min(s), high.max(s)]);
            (ends[1] - ends[0]).max(0.0)
        };
        // The width between two parallel lines is least where one of them is along an edge of the hull.
        let along_edge = |i: usize| {
            let [a, b] = [hull[i], hull[(i + 1) % hull.len()]];
            let (x, y) = (b[0] - a[0], b[1] - a[1]);
            let length = x.hypot(y);
            (length > 0.0).then(|| {
                let directions = [[x / length, y / length], [-y / length, x / length]];
                Self { sides: directions.map(extent), directions }
            })
        };
        let all: Vec<Self> = (0..hull.len()).filter_map(along_edge).collect();
        let least = all.iter().map(|of| of.sides[1]).fold(f64::INFINITY, f64::min);
        let as_narrow = all.into_iter().filter(|of| of.sides[1] <= least + SAME * of.sides[0]);
        let point = Self { sides: [0.0; 2], directions: [[1.0, 0.0], [0.0, 1.0]] };
        as_narrow.min_by(|a, b| a.sides[0].total_cmp(&b.sides[0])).unwrap_or(point)
    }
}

/// Corners of the convex hull of some places, counter-clockwise (A. M. Andrew, Inf. Process. Lett. 9 (1979) 216–219): its lower and
/// its upper chain.
fn hull_of(mut places: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let is_left = |[a, b]: [&[f64; 2]; 2], c: &[f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
    };
    let chain = |places: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for place in places {
            while let [.., a, b] = &chain[..]
                && !is_left([a, b], &place)
            {
                chain.pop();
            }
            chain.push(place);
        }
        // Its last place is the first of the other chain.
        if chain.len() > 1 {
            chain.pop();
        }
        chain
    };
    let mut hull = chain(&mut places.iter().copied());
    hull.extend(chain(&mut places.iter().rev().copied()));
    hull
}
