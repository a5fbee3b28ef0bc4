//! Segments of a slave face: its overlaps with faces of the master, cut along their edges.
//!
//! Everything is in the plane normal to the slave face, onto which both sides are projected (Puso & Laursen 2004).

use super::boundary::{Across, Boundary};
use super::closest_point::Patch;
use super::frame::local_frame;
use crate::tensor::Vec3;

/// Largest number of master faces visited for a slave face.
const MOST_FACES: usize = 48;
/// Distance from the first face, in edges, up to which faces are visited whether they overlap or not.
const RING: u8 = 2;
/// Largest number of corners of a segment: four edges cut by four.
const MOST_CORNERS: usize = 8;
/// Largest cosine between the normals of a slave face and an opposed master face.
pub(super) const OPPOSED: f64 = -0.5;
/// Quadrature of second degree on a triangle, in barycentric coordinates; each point has a third of the area.
const POINTS: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];

type Point = [f64; 2];

/// A convex polygon, corners counter-clockwise.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [Point; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    fn corners(&self) -> &[Point] {
        &self.corners[..self.count]
    }

    /// The part on the inner side of the line from `a` to `b`. A surplus corner, due to rounding, is dropped.
    fn cut(&self, a: Point, b: Point) -> Self {
        let height = |p: &Point| cross(from(a, b), from(a, *p));
        let mut left = Self { corners: [[0.0; 2]; MOST_CORNERS], count: 0 };
        for (i, p) in self.corners().iter().enumerate() {
            let q = &self.corners[(i + 1) % self.count];
            let (h_p, h_q) = (height(p), height(q));
            if h_p >= 0.0 {
                left.push(*p);
            }
            if (h_p > 0.0 && h_q < 0.0) || (h_p < 0.0 && h_q > 0.0) {
                let fraction = h_p / (h_p - h_q);
                left.push([p[0] + fraction * (q[0] - p[0]), p[1] + fraction * (q[1] - p[1])]);
            }
        }
        left
    }

    fn push(&mut self, p: Point) {
        if self.count < MOST_CORNERS {
            self.corners[self.count] = p;
            self.count += 1;
        }
    }

    /// Calls `visit` with quadrature points and their areas.
    fn for_each_point(&self, mut visit: impl FnMut(Point, f64)) {
        for i in 2..self.count {
            let [a, b, c] = [self.corners[0], self.corners[i - 1], self.corners[i]];
            let area = 0.5 * cross(from(a, b), from(a, c));
            for w in POINTS {
                let at = |k: usize| w[0] * a[k] + w[1] * b[k] + w[2] * c[k];
                visit([at(0), at(1)], area / 3.0);
            }
        }
    }

    fn area(&self) -> f64 {
        let [first, ..] = self.corners;
        self.corners().windows(2).map(|w| 0.5 * cross(from(first, w[0]), from(first, w[1]))).sum()
    }
}

fn from(a: Point, b: Point) -> Point {
    [b[0] - a[0], b[1] - a[1]]
}

fn cross(u: Point, v: Point) -> f64 {
    u[0] * v[1] - u[1] * v[0]
}

/// A quadrature point of a segment: its position in the plane of the slave face [m], its area [m²], the master face
/// below it.
pub(super) struct SegmentPoint {
    pub place: Vec3,
    pub area: f64,
    pub face: u32,
}

/// Calls `visit` at the points of all segments of a slave face with unit normal `n` at the positions `x` [m]; `start`
/// is a face of the master near it. Returns the area of the face in its plane [m²]; `None` where too many faces of
/// the master are below it.
pub(super) fn for_each_segment_point(
    slave: &Patch,
    n: &Vec3,
    master: &Boundary,
    start: u32,
    x: &[Vec3],
    mut visit: impl FnMut(&SegmentPoint) -> Option<()>,
) -> Option<f64> {
    let origin = slave.point(&[0.25; 4]);
    let [_, t1, t2] = local_frame(n, &Vec3::zeros());
    let flat = |p: &Vec3| [t1.dot(&(p - origin)), t2.dot(&(p - origin))];
    let polygon = |patch: &Patch, turned: bool| {
        let mut polygon = Polygon { corners: [[0.0; 2]; MOST_CORNERS], count: 0 };
        let n = patch.corner_count();
        (0..n).for_each(|k| polygon.push(flat(&patch.corners[if turned { n - 1 - k } else { k }])));
        polygon
    };
    // Breadth-first search over the master's faces, from `start`.
    let own = polygon(slave, false);
    let area = own.area();
    let (mut seen, mut count) = ([(start, 0_u8); MOST_FACES], 1);
    let mut next = 0;
    while next < count {
        let (face, ring) = seen[next];
        next += 1;
        let patch = Patch::new(&master.faces[face as usize], x);
        if patch.normal(&[0.25; 4]).dot(n) > OPPOSED {
            continue;
        }
        // The overlap: the slave face cut along the edges of the master face.
        let below = polygon(&patch, true);
        let edges = below.corners().iter().zip(below.corners().iter().cycle().skip(1));
        let segment = edges.fold(own, |left, (a, b)| left.cut(*a, *b));
        let overlaps = segment.count > 2 && segment.area() > 1e-12 * area;
        if overlaps {
            let mut is_good = true;
            segment.for_each_point(|p, area| {
                let place = origin + t1 * p[0] + t2 * p[1];
                is_good &= visit(&SegmentPoint { place, area, face }).is_some();
            });
            is_good.then_some(())?;
        }
        // Continue across the edges.
        if overlaps || ring < RING {
            for k in 0..patch.corner_count() {
                let Across::Face(across) = master.across(face, k) else { continue };
                if seen[..count].iter().all(|(f, _)| *f != across) {
                    *seen.get_mut(count)? = (across, ring.saturating_add(1));
                    count += 1;
                }
            }
        }
    }
    Some(area)
}
