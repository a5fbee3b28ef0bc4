//! Faces of a mesh against a rigid body, between their nodes, which have contacts of their own
//! ([`super::rigid_detection`]).
//!
//! A shape may penetrate a face by `RIGID_ALLOWED` of the face's size at rest and no deeper, a round one besides by its bow between the
//! nodes, up to `MOST_BOW` of that size: where nodes are close together they keep it out by themselves, and this constrains nothing. Two
//! flat-sided bodies touch with a corner in a face, a face on a corner, or two edges; faces of a mesh also warp:
//!
//! - *Feet* of the shape (its corners, the ends of its axis, its centre: [`Shape::feet`]) in a face, along the normal
//!   of the face, hence to the side of the mesh, at any depth.
//! - *Edges* of the face between their ends, where the distance to the shape is least: the distance to a convex shape
//!   is convex along a straight edge. It is measured to a *core*, smaller than the shape by twice the allowed depth,
//!   so that the normal is unique at edges and corners of the shape, too. Where the shape lies flat on an edge both
//!   ends of that stretch are held.
//! - Corners of a box below an *edge or node* of the mesh where adjacent faces rise are left to the detection over
//!   the whole surface.
//! - The *bulge* of a warped face, where its inside is nearer to the core than its edges. Nowhere on the face being nearer, the normal there is
//!   that of the face: a sharp edge of the shape has others on both sides of the place, along which it would slide into the face.
//!
//! A face that moves far within a step is followed along its path by steps of its distance, as nodes are: nothing
//! tunnels.

use super::closest_point::{Feature, Patch};
use super::narrow_phase::NEAR;
use super::time_of_impact::first_meeting;
use crate::rigid::Shape;
use crate::tensor::Vec3;

/// Allowed depth of a shape in a face, as a fraction of the face's size at rest.
pub(super) const RIGID_ALLOWED: f64 = 0.0025;
/// Upper bound of the bow of a round shape that a face leaves to its nodes, as a fraction of the face's size at rest: a penetration of a
/// tenth is an error.
pub const MOST_BOW: f64 = 0.075;
/// Upper bound of the allowed depth, as a fraction of the shape's thickness.
const MOST: f64 = 0.015;
/// Depth beyond which a foot is not in the face, as a fraction of the face's size.
const DEEPEST: f64 = 0.5;
/// Distance at which a face has met the shape, as a fraction of the allowed depth.
const MET: f64 = 1e-3;
/// Distance up to which a place is examined, as a multiple of the motion of the face.
const REACH: f64 = 2.0;
/// Growth of the distance along an edge below which it lies flat on the shape.
const FLAT: f64 = 1e-3;
/// Distance, as a fraction of the edge, below which the ends of such a stretch coincide; also the largest one below which a place
/// coincides with a node.
const MERGED: f64 = 1e-2;
/// Resolution of a place on an edge, and of the growth of the distance there relative to its range [-].
const ROUNDING: f64 = 1e-9;
/// Evaluations in which secants that alternate with halvings reach it, even at a jump.
const MOST_EVALUATIONS: usize = 60;
/// Largest difference of shape functions between a bulge and a foot that is above it.
const BESIDE: f64 = 0.1;
/// Resolution of the place of a bulge, as a fraction of the face.
const LOCATED: f64 = 1e-3;

/// Where a face comes too close to a body, in the axes of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceTouch {
    /// Fraction of the step at which the face is taken: 0, or that of the impact.
    pub fraction: f64,
    /// Shape functions of the place on the face.
    pub weights: [f64; 4],
    /// Unit normal out of the body.
    pub normal: Vec3,
    /// Gap at the start of the step along the normal [m].
    pub gap: f64,
    /// Position on the face at the start of the step, or at that fraction where it moves far [m].
    pub point: Vec3,
}

/// Depth up to which a mesh may be in a round shape between its nodes, whatever their distance [m]; 0 for other shapes.
pub fn left_to_nodes(shape: &Shape) -> f64 {
    if matches!(shape, Shape::Ball { .. } | Shape::Capsule { .. }) { MOST * shape.size() } else { 0.0 }
}

/// Allowed depth of a shape in a face of a size at rest, of which all corners are within `radius` of its middle [m].
///
/// Nodes that lie on a round shape have its bow between them. Faces and edges that kept it out would lift the nodes off it, which makes the
/// patch too small and the contact too stiff, and would constrain every node several times, which sweeps resolve slowly.
pub(super) fn allowed(shape: &Shape, size: f64, radius: f64) -> f64 {
    let bow = match shape {
        Shape::Ball { radius: r } | Shape::Capsule { radius: r, .. } => {
            let radius = radius.min(*r);
            r - (r * r - radius * radius).sqrt()
        }
        // Others have edges, which may lie between the nodes.
        _ => 0.0,
    };
    (RIGID_ALLOWED * size + bow.min(MOST_BOW * size)).min(MOST * shape.size())
}

/// Calls `take` with the places at which a face of a size at rest [m] comes too close to a shape while it moves from
/// `start` to `end`, both in the axes of the body [m]; only on the edges that it `owns`, so that each edge of the
/// mesh is examined once. `places`: a buffer.
pub(super) fn touches_of(
    (shape, places): (&Shape, &mut Vec<Place>),
    size: f64,
    [start, end]: [&Patch; 2],
    owns: [bool; 4],
    mut take: impl FnMut(FaceTouch),
) {
    let moved = start.corners.iter().zip(&end.corners).map(|(p, q)| (q - p).norm()).fold(0.0, f64::max);
    let reach = REACH * moved;
    // The distance to a convex shape is convex: nowhere on the face is it below its tangent plane.
    let middle = start.point(&[0.25; 4]);
    let (distance, normal) = shape.eval_distance(&middle);
    let lowest =
        start.corners.iter().map(|c| distance + normal.dot(&(c - middle))).fold(f64::INFINITY, f64::min);
    let around = start.corners.iter().map(|c| (c - middle).norm()).fold(0.0, f64::max);
    let obstacle = Obstacle { owns, ..Obstacle::new(shape, size, around) };
    if lowest + obstacle.allowed > reach {
        return;
    }
    places.clear();
    obstacle.for_each_place(start, reach, |place| places.push(place));
    let left = places.iter().map(|place| place.gap).fold(f64::INFINITY, f64::min);
    if left > reach {
        return;
    }
    // The face at the start, or at its first impact if it is far and moves far.
    let between = |fraction: f64| Patch {
        corners: std::array::from_fn(|k| start.corners[k].lerp(&end.corners[k], fraction)),
        triangle: start.triangle,
    };
    let met = MET * obstacle.allowed;
    let near = NEAR * size;
    let mut fraction = 0.0;
    if left > met && moved > near {
        let distance = |fraction: f64| obstacle.distance(&between(fraction), moved);
        let Some(meeting) = first_meeting(distance, moved, met) else { return };
        fraction = meeting;
        places.clear();
        obstacle.for_each_place(&between(fraction), reach.min(near), |place| places.push(place));
    }
    // Normals are accurate only near the shape.
    for &Place { weights, normal, gap, point, .. } in
        places.iter().filter(|place| place.holds && place.gap <= reach.min(near))
    {
        let place = start.point(&weights);
        let way = end.point(&weights) - place;
        // At the start both sides have the same moment arm about any axis: angular momentum is conserved.
        let point = if moved <= near { place } else { point };
        take(FaceTouch { fraction, weights, normal, gap: gap - normal.dot(&way) * fraction, point });
    }
}

/// A shape as an obstacle to a face of some size.
struct Obstacle {
    /// Allowed depth in the face [m].
    allowed: f64,
    /// The core, and the distance [m] that the face keeps from it.
    core: (Core, f64),
    /// The shape whose feet stand on the face, and their distance [m].
    feet: (Shape, f64),
    deepest: f64,
    /// Edges of the face that are checked: each edge of the mesh belongs to one face.
    owns: [bool; 4],
}

/// What a shape is reduced to, such that normals at its edges are unique outside of it.
enum Core {
    /// A smaller shape of the same kind, the centre of a ball, or the axis of a capsule.
    Smaller(Shape),
    /// A polyhedron whose planes are further inwards by that [m].
    Shrunk(Shape, f64),
}

impl Core {
    /// Signed distance [m] and outward normal of the core at a point, as [`Shape::eval_distance`].
    fn eval_distance(&self, p: &Vec3) -> (f64, Vec3) {
        match self {
            Self::Shrunk(Shape::Polyhedron(hull), less) => hull.eval_core_distance(p, *less),
            Self::Smaller(shape) | Self::Shrunk(shape, _) => shape.eval_distance(p),
        }
    }

    /// Whether it is the centre of a ball.
    fn is_point(&self) -> bool {
        matches!(self, Self::Smaller(Shape::Ball { .. }))
    }
}

/// A place of a face near the shape.
#[derive(Clone, Debug)]
pub(super) struct Place {
    weights: [f64; 4],
    point: Vec3,
    normal: Vec3,
    /// Distance plus the allowed depth [m].
    gap: f64,
    /// Whether this place holds: it is no node, and the shape is in front of the face.
    holds: bool,
}

impl Obstacle {
    fn new(shape: &Shape, size: f64, radius: f64) -> Self {
        let allowed = allowed(shape, size, radius);
        let less = 2.0 * allowed;
        let flat = |core: Shape| ((Core::Smaller(core), allowed), (shape.clone(), 0.0));
        let round =
            |axis: Shape, radius: f64| ((Core::Smaller(axis.clone()), radius - allowed), (axis, radius));
        let (core, feet) = match *shape {
            Shape::Ball { radius } => round(Shape::Ball { radius: 0.0 }, radius),
            Shape::Capsule { radius, half_length } => {
                round(Shape::Capsule { radius: 0.0, half_length }, radius)
            }
            Shape::Box { half } => flat(Shape::Box { half: half.add_scalar(-less) }),
            Shape::Cylinder { radius, half_length } => {
                flat(Shape::Cylinder { radius: radius - less, half_length: half_length - less })
            }
            Shape::Polyhedron(_) => ((Core::Shrunk(shape.clone(), less), allowed), (shape.clone(), 0.0)),
        };
        Self { allowed, core, feet, deepest: DEEPEST * size, owns: [true; 4] }
    }

    /// Distance of the face, nodes included, if at most `reach` [m].
    fn distance(&self, face: &Patch, reach: f64) -> f64 {
        let mut least = f64::INFINITY;
        self.for_each_place(face, reach, |place| least = least.min(place.gap));
        least
    }

    fn for_each_place(&self, face: &Patch, reach: f64, mut take: impl FnMut(Place)) {
        let mut lowest: Option<(f64, [f64; 4])> = None;
        self.for_each_foot(face, reach, &mut |place| {
            if lowest.is_none_or(|(gap, _)| place.gap < gap) {
                lowest = Some((place.gap, place.weights));
            }
            take(place);
        });
        for k in 0..face.corner_count() {
            self.for_each_end(face, k, reach, &mut take);
        }
        self.for_the_bulge(face, lowest.map(|(_, weights)| weights), reach, &mut take);
    }

    /// Feet above or in the face.
    fn for_each_foot(&self, face: &Patch, reach: f64, take: &mut impl FnMut(Place)) {
        // Skip feet that are far from the face.
        let middle = [0.25; 4];
        let (centre, upwards) = (face.point(&middle), face.normal(&middle));
        let around = face.corners.iter().map(|c| (c - centre).norm()).fold(0.0, f64::max);
        let (shape, radius) = &self.feet;
        for foot in shape.feet(&-upwards).points() {
            if (foot - centre).norm() > around + radius + reach {
                continue;
            }
            let on_face = face.closest(foot);
            let normal = face.normal(&on_face.weights);
            let height = normal.dot(&(foot - on_face.point));
            let aside = (foot - on_face.point - normal * height).norm();
            let is_over = match on_face.feature {
                Feature::Interior => true,
                // Exactly over an edge, as in scenes with perfect symmetry.
                Feature::Edge(k) => self.owns[k] && aside <= MET * self.allowed,
                Feature::Corner(_) => false,
            };
            if !is_over {
                continue;
            }
            // The centre of a body behind the face is there, too.
            let is_in_front = height >= 0.0 || (height > -self.deepest && normal.dot(&on_face.point) < 0.0);
            let height = if is_in_front { height } else { -height };
            take(Place {
                weights: on_face.weights,
                point: on_face.point,
                normal: -normal,
                gap: height - radius + self.allowed,
                holds: is_in_front,
            });
        }
    }

    /// The place inside a warped face that is nearest to the core: between straight edges that pass a corner or a
    /// rim, a face bulges into the shape; `foot`: position of the lowest foot.
    fn for_the_bulge(&self, face: &Patch, foot: Option<[f64; 4]>, reach: f64, take: &mut impl FnMut(Place)) {
        let [a, b, c, d] = face.corners;
        let (core, round) = &self.core;
        let warp = 0.25 * (a - b + c - d).norm();
        let (distance, _) = core.eval_distance(&face.point(&[0.25; 4]));
        let around = face.corners.iter().map(|x| (x - face.point(&[0.25; 4])).norm()).fold(0.0, f64::max);
        // A ball touches at its foot.
        if core.is_point() || face.triangle || warp <= self.allowed || distance - around - round > reach {
            return;
        }
        let (distance, [xi, eta]) = nearest_inside(core, face, MET * self.allowed);
        let weights = face.weights(xi, eta);
        let is_inside = |fraction: f64| (MERGED..=1.0 - MERGED).contains(&fraction);
        let is_under_foot = foot.is_some_and(|foot| (0..4).all(|k| (foot[k] - weights[k]).abs() < BESIDE));
        if is_inside(xi) && is_inside(eta) && !is_under_foot {
            let (point, normal) = (face.point(&weights), -face.normal(&weights));
            // A shape behind the face is no obstacle to it.
            let is_in_front = distance <= 0.0 || core.eval_distance(&point).1.dot(&normal) > 0.0;
            let holds = is_in_front && normal != Vec3::zeros();
            take(Place { weights, point, normal, gap: distance - round, holds });
        }
    }

    /// The ends of the stretch of edge k that is nearest to the core.
    fn for_each_end(&self, face: &Patch, k: usize, reach: f64, take: &mut impl FnMut(Place)) {
        let next = (k + 1) % face.corner_count();
        let (from, way) = (face.corners[k], face.corners[next] - face.corners[k]);
        let (core, round) = &self.core;
        let (distance, normal) = core.eval_distance(&(from + way * 0.5));
        if distance - 0.5 * normal.dot(&way).abs() - round > reach {
            return;
        }
        let (first, last) = nearest_stretch(core, &from, &way);
        let ends = if last - first > MERGED {
            [Some(first), Some(last)]
        } else {
            [Some(middle_of((first, last))), None]
        };
        for fraction in ends.into_iter().flatten() {
            let mut weights = [0.0; 4];
            (weights[k], weights[next]) = (1.0 - fraction, fraction);
            // A node keeps out what is nearer to it than the allowed depth, since the distance changes no faster than the place. A sharp
            // edge of the shape farther from it, across this one, is kept out here alone.
            let merged = MERGED.min(self.allowed / way.norm());
            let is_node = !(merged..=1.0 - merged).contains(&fraction);
            self.keep_out(face, weights, self.owns[k] && !is_node, take);
        }
    }

    /// Passes a place of the face to `take`, with its distance from the core.
    fn keep_out(&self, face: &Patch, weights: [f64; 4], holds: bool, take: &mut impl FnMut(Place)) {
        let (core, round) = &self.core;
        let point = face.point(&weights);
        let (distance, outwards) = core.eval_distance(&point);
        // Inside the core only the side of the mesh determines the normal.
        let normal = if distance > MET * self.allowed { outwards } else { -face.normal(&weights) };
        take(Place {
            weights,
            point,
            normal,
            gap: distance - round,
            holds: holds && normal != Vec3::zeros(),
        });
    }
}

/// The distance [m] and the place of a quadrilateral, as its two coordinates from 0 to 1, where it is nearest to a shape, up to
/// `tolerance` [m]. Lines along its first coordinate are straight: the nearest place of each is found whatever edges of the shape it
/// crosses, and of the lines the nearest in steps of a quarter down to [`LOCATED`].
fn nearest_inside(core: &Core, face: &Patch, tolerance: f64) -> (f64, [f64; 2]) {
    let on_line = |eta: f64| {
        let [from, to] = [0.0, 1.0].map(|xi| face.point(&face.weights(xi, eta)));
        let (distance, xi) = nearest_on_line(core, &from, &(to - from), tolerance);
        (distance, [xi, eta])
    };
    let (mut nearest, mut step) = (on_line(0.5), 0.25);
    while step > LOCATED {
        let [before, after] = [-step, step].map(|step| on_line((nearest.1[1] + step).clamp(0.0, 1.0)));
        let next = if before.0 < after.0 { before } else { after };
        if next.0 < nearest.0 - tolerance {
            nearest = next;
        } else {
            step *= 0.5;
        }
    }
    nearest
}

/// The least distance of a line from a shape [m], up to `tolerance` [m], and its place as a fraction of `way`: the distance is nowhere below
/// the tangents on both sides of the place, which is next looked for where they meet.
fn nearest_on_line(core: &Core, from: &Vec3, way: &Vec3, tolerance: f64) -> (f64, f64) {
    let at = |fraction: f64| {
        let (distance, normal) = core.eval_distance(&(from + way * fraction));
        (distance, normal.dot(way), fraction)
    };
    let (mut low, mut high) = (at(0.0), at(1.0));
    if low.1 >= 0.0 || high.1 <= 0.0 {
        let (distance, _, fraction) = if low.1 >= 0.0 { low } else { high };
        return (distance, fraction);
    }
    for _ in 0..MOST_EVALUATIONS {
        let rise = high.0 - high.1 * high.2 - (low.0 - low.1 * low.2);
        let fraction = rise / (low.1 - high.1);
        let least = low.0 + low.1 * (fraction - low.2);
        if low.0.min(high.0) - least <= tolerance {
            break;
        }
        let next = at(fraction);
        if next.1 > 0.0 {
            high = next;
        } else {
            low = next;
        }
    }
    let (distance, _, fraction) = if low.0 < high.0 { low } else { high };
    (distance, fraction)
}

fn middle_of((first, last): (f64, f64)) -> f64 {
    0.5 * (first + last)
}

/// The stretch of a line, as fractions of `way`, between the end of the decrease and the start of the increase of the
/// distance to a convex shape.
fn nearest_stretch(core: &Core, from: &Vec3, way: &Vec3) -> (f64, f64) {
    // The core of a ball is its centre.
    if core.is_point() {
        let fraction = (-from.dot(way) / way.norm_squared()).clamp(0.0, 1.0);
        return (fraction, fraction);
    }
    let flat = FLAT * way.norm();
    let grows = |fraction: f64| core.eval_distance(&(from + way * fraction)).1.dot(way);
    let ends = [grows(0.0), grows(1.0)];
    let first = first_above(&grows, -flat, (0.0, 1.0), ends);
    // The distance is convex: its slope at the first end is that of the second or less.
    let last =
        if ends[0] > flat { first } else { first_above(&grows, flat, (first, 1.0), [grows(first), ends[1]]) };
    (first, last)
}

/// The first place between `low` and `high` at which a slope that nowhere decreases exceeds `flat` [m], found by secants that
/// alternate with halvings: it may jump. `ends`: the slopes there.
fn first_above(
    slope: &impl Fn(f64) -> f64,
    flat: f64,
    (mut low, mut high): (f64, f64),
    ends: [f64; 2],
) -> f64 {
    let [mut below, mut above] = ends.map(|end| end - flat);
    if below > 0.0 {
        return low;
    }
    if above <= 0.0 {
        return high;
    }
    let rounding = ROUNDING * (above - below);
    for k in 0..MOST_EVALUATIONS {
        let is_secant = k % 2 == 0;
        let at = if is_secant { low - below * (high - low) / (above - below) } else { 0.5 * (low + high) };
        let value = slope(at) - flat;
        if value.abs() <= rounding {
            return at;
        }
        if value > 0.0 {
            (high, above) = (at, value);
        } else {
            (low, below) = (at, value);
        }
        if high - low <= ROUNDING {
            break;
        }
    }
    high
}

#[cfg(test)]
mod tests;
