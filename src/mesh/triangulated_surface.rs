//! A boundary surface as triangles: intersection with rays, and normals.

use crate::mechanics::tensor::Vec3;

/// Cosine of the angle between two triangles above which their common edge is sharp: 60°.
const SHARP: f64 = 0.5;

/// A surface of quadrilateral faces, each split into two triangles, with the neighbour across each edge.
#[derive(Clone, Debug)]
pub struct TriangulatedSurface {
    /// Positions of the nodes [m].
    positions: Vec<Vec3>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    triangles: Vec<[u32; 3]>,
    /// Triangle across each edge; edge k runs from corner k to the next. `None` at a border.
    neighbours: Vec<[Option<usize>; 3]>,
}

/// A point of a boundary surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is [m].
    pub place: Vec3,
    /// Outward unit normal of the smooth surface that the facets approximate; continuous across triangles except at sharp
    /// edges.
    pub normal: Vec3,
}

impl TriangulatedSurface {
    /// Triangulates `faces`, counter-clockwise seen from outside, whose nodes are at `positions` [m].
    pub fn new(faces: &[[u32; 4]], positions: Vec<Vec3>) -> Self {
        let halves = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangles: Vec<[u32; 3]> = halves.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        Self { neighbours: neighbours(&triangles), triangles, positions }
    }

    /// Where a ray first enters the body: the distance as a multiple of `direction` (any length), and the point. `None` if
    /// it does not.
    ///
    /// The signs of d · (b × c) determine on which side of an edge the ray passes. From the two sides of an edge they are exactly
    /// opposite, so that no ray slips through between two triangles.
    pub fn entry(&self, from: &Vec3, direction: &Vec3) -> Option<(f64, SurfacePoint)> {
        let mut first: Option<(f64, usize, Vec3)> = None;
        for index in 0..self.triangles.len() {
            let [a, b, c] = self.corners(index).map(|x| x - from);
            let passes = |a: &Vec3, b: &Vec3| direction.dot(&a.cross(b));
            let weights = [passes(&b, &c), passes(&c, &a), passes(&a, &b)];
            let sum: f64 = weights.iter().sum();
            if weights.iter().any(|weight| *weight > 0.0) || sum.is_nan() || sum >= 0.0 {
                continue;
            }
            let arm = (a * weights[0] + b * weights[1] + c * weights[2]) / sum;
            let multiple = arm.dot(direction) / direction.norm_squared();
            if multiple >= 0.0 && first.is_none_or(|(nearest, ..)| multiple < nearest) {
                first = Some((multiple, index, from + arm));
            }
        }
        first.map(|(multiple, index, place)| (multiple, self.point(index, place)))
    }

    /// Number of triangles, two for each quadrilateral.
    pub(super) fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Node indices of a triangle.
    pub(super) fn nodes(&self, triangle: usize) -> [usize; 3] {
        self.triangles[triangle].map(|node| node as usize)
    }

    /// Positions of the corners of a triangle [m].
    pub(super) fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.nodes(triangle).map(|node| self.positions[node])
    }

    /// The triangle across an edge; `None` at a border.
    pub(super) fn across(&self, triangle: usize, edge: usize) -> Option<usize> {
        self.neighbours[triangle][edge]
    }

    /// Cosine of the angle between two triangles, if their common edge is sharp.
    pub(super) fn sharp_turn(&self, triangle: usize, other: usize) -> Option<f64> {
        let [a, b] = [triangle, other].map(|t| self.area_vector(t).try_normalize(0.0));
        a.zip(b).map(|(a, b)| a.dot(&b)).filter(|cosine| *cosine < SHARP)
    }

    /// The surface point at a position in a triangle.
    ///
    /// Its normal is interpolated between the corners.
    pub(super) fn point(&self, triangle: usize, place: Vec3) -> SurfacePoint {
        let [a, b, c] = self.corners(triangle).map(|x| x - place);
        let area = self.area_vector(triangle);
        let weights = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|part| part.dot(&area));
        let sum: Vec3 = (0..3).map(|corner| self.corner_normal(triangle, corner) * weights[corner]).sum();
        let flat = || area.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        SurfacePoint { place, normal: sum.try_normalize(0.0).unwrap_or_else(flat) }
    }

    /// Unit normal of the smooth surface at a corner of a triangle: over all triangles around that node that can be reached
    /// without crossing a sharp edge, each weighted with e₁ × e₂ / (|e₁|² |e₂|²). Exact where the nodes lie on a sphere, or
    /// regularly on a round cylinder, however uneven the triangles are (Max 1999, Weights for computing vertex normals from
    /// facet normals).
    fn corner_normal(&self, triangle: usize, corner: usize) -> Vec3 {
        let node = self.triangles[triangle][corner];
        let mut sum = self.weighted_normal(triangle, corner);
        // The edges at a corner k are k and k + 2: first around one way, then the rest the other way.
        for side in [0, 2] {
            let (mut here, mut at) = (triangle, corner);
            while let Some(next) = self.across(here, (at + side) % 3) {
                if next == triangle {
                    return normalized(sum);
                }
                let Some(place) = self.triangles[next].iter().position(|n| *n == node) else { break };
                if self.sharp_turn(here, next).is_some() {
                    break;
                }
                (here, at) = (next, place);
                sum += self.weighted_normal(here, at);
            }
        }
        normalized(sum)
    }

    fn weighted_normal(&self, triangle: usize, corner: usize) -> Vec3 {
        let corners = self.corners(triangle);
        let [next, last] = [1, 2].map(|step| corners[(corner + step) % 3] - corners[corner]);
        let squares = next.norm_squared() * last.norm_squared();
        if squares > 0.0 { next.cross(&last) / squares } else { Vec3::zeros() }
    }

    /// Outward normal times twice the area [m²].
    fn area_vector(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a))
    }
}

fn normalized(sum: Vec3) -> Vec3 {
    sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

/// The triangle across each edge. An edge of more than two triangles counts as a border.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[Option<usize>; 3]> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (index, triangle) in triangles.iter().enumerate() {
        for edge in 0..3 {
            let (a, b) = (triangle[edge], triangle[(edge + 1) % 3]);
            edges.push((a.min(b), a.max(b), index, edge));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[None; 3]; triangles.len()];
    for run in edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)) {
        if let [(_, _, i, k), (_, _, j, l)] = *run {
            neighbours[i][k] = Some(j);
            neighbours[j][l] = Some(i);
        }
    }
    neighbours
}
