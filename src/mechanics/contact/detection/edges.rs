//! Contacts of two edges, between their ends, at least one of which is sharp.
//!
//! The difference of a point on each edge, `x_A(a) − x_B(b)`, spans a bilinear patch, and the edges meet where it is
//! zero: so the closest points of two edges are given by the point of that patch closest to the origin, and their
//! first impact is that of the fixed origin with the moving patch ([`super::time_of_impact`]).
//!
//! Edges touch along their common normal, where it points out of each body: into the arc between the normals of the
//! two faces at an edge (the arcs of the Gauss map cross), or nearly along their mean, since edges of surfaces that
//! bulge towards each other cross with a normal just outside the arc. Elsewhere a node touches a face.
//!
//! An edge is sharp where the body is convex by more than [`SHARP`], or by [`BENT`] more than at the start of the
//! run: crushed soft bodies form new edges. Two edges that were sharp from the start do not enter each other at all.
//! All others are held as nodes of the master are: they may enter by [`ALLOWED`] and no deeper, so that this
//! constrains nothing where nodes hold already; what is deeper when it is found stays so ([`BULGE`]).

use super::boundary::{Across, Boundary, corner_count};
use super::closest_point::Patch;
use super::detector::Motion;
use super::frame::local_frame;
use super::narrow_phase::NEAR;
use super::node_to_face::NodeToFace;
use super::surfaces::PairSurfaces;
use super::sweep::Sweep;
use super::time_of_impact::Search;
use crate::contact::ALLOWED;
use crate::contact::kind::{Gap, Identity, Kind, SLOW};
use crate::contact::stencil::Stencil;
use crate::contact::{Contact, ContactLaw, ContactPair, Master};
use crate::tensor::Vec3;
use std::f64::consts::PI;

/// Angle between the normals of two faces above which their common edge is sharp, for edges sharp at the start [rad].
const SHARP: f64 = PI / 6.0;
/// Growth of the angle by which a smooth edge becomes sharp [rad].
pub(super) const BENT: f64 = PI / 18.0;
/// Sine of the angle between two edges below which they are parallel, and a node of one touches instead.
const PARALLEL: f64 = 0.05;
/// Sine of the angle by which the common normal is inside the arcs: at their ends a node or a face touches.
const INSIDE: f64 = 0.05;
/// Cosine of the angle between the common normal and the mean normal at an edge above which the edge is met from
/// outside.
const OUTSIDE: f64 = 0.8;
/// Fraction of a smooth edge next to its ends where a node touches.
const AT_END: f64 = 0.05;
/// Penetration, as a fraction of their mean length, beyond which crossed edges cannot be distinguished from edges
/// that cross behind the bodies.
const DEPTH: f64 = 0.25;

/// Two edges, which may keep what linearisation leaves, up to twice the allowed penetration of a node: from step to step they
/// cross elsewhere and along another normal, and pushing them out each time would do work without end.
const CROSSING: Kind = Kind {
    gap: Gap::ConstantWeights,
    kept: 2.0 * ALLOWED,
    pace: SLOW,
    identity: Identity::Nodes,
    ..Kind::NODE
};
/// Two edges one of which was formed by deformation: held where they are found, but not moved apart. Surfaces that bulge
/// towards each other cross before anything detects it; moving them apart would do work.
const BULGE: Kind = Kind { gap: Gap::NotMeasured, ..CROSSING };

/// An edge between two faces.
#[derive(Clone, Copy, Debug)]
struct Edge {
    nodes: [u32; 2],
    faces: [u32; 2],
    /// Angle between the normals of the faces at the start of the run [rad], negative in a notch.
    start: f64,
    /// Whether it is sharp in the present step; updated only in [`EdgeFinder::near`].
    is_sharp: bool,
}

/// Finds the contacts of edges in the pairs of meshes.
pub(super) struct EdgeFinder {
    /// Edges of each surface that is in a pair.
    edges: Vec<Vec<Edge>>,
    /// Box around each of these surfaces over the step [m].
    boxes: Vec<[Vec3; 2]>,
    /// Growth of the angle by which an edge becomes sharp [rad].
    bent: f64,
    /// Edges of each side of the present pair that come near the other side in a step, the sharp ones first.
    near: [Vec<Edge>; 2],
    sweep: Sweep,
    search: Search,
}

/// Positions of all nodes at both ends of a step [m].
type Ends<'a> = (&'a [Vec3], &'a [Vec3]);

impl EdgeFinder {
    /// Edges of the surfaces of pairs, with the positions `x` [m] of all nodes at the start of the
    /// run; an edge whose angle grows by `bent` [rad] is sharp.
    pub fn new(PairSurfaces { boundaries, pairs }: &PairSurfaces, x: &[Vec3], bent: f64) -> Self {
        let mut edges = vec![Vec::new(); boundaries.len()];
        let master = |pair: &ContactPair| if let Master::Surface(m) = pair.master { m } else { pair.slave };
        let listed = pairs.listed().flat_map(|(_, pair)| [pair.slave, master(pair)]);
        for surface in listed.chain(pairs.every_two().surfaces()) {
            if edges[surface].is_empty() {
                edges[surface] = edges_of(&boundaries[surface], x);
            }
        }
        let most = edges.iter().map(Vec::len).max().unwrap_or(0);
        let near = [0, 1].map(|_| Vec::with_capacity(most));
        let boxes = vec![[Vec3::zeros(); 2]; edges.len()];
        Self { edges, boxes, bent, near, sweep: Sweep::with_capacity(most), search: Search::default() }
    }

    /// Appends the contacts of a step, of the pairs that the `detector`, with slave and master exchanged, has found near;
    /// `number` gives the number of each.
    pub fn detect(
        &mut self,
        detector: &NodeToFace,
        number: impl Fn(u32) -> u32,
        motion: &Motion,
        contacts: &mut Vec<Contact>,
    ) {
        let (all, ends) = (&detector.surfaces().boundaries, (motion.x, motion.x_end));
        let Self { edges, boxes, bent, near, sweep, search } = self;
        for (surface, of_it) in
            boxes.iter_mut().enumerate().filter(|(surface, _)| !edges[*surface].is_empty())
        {
            *of_it = box_of(&all[surface], ends);
        }
        for (pair, [master, slave]) in detector.pairs_of_two() {
            let surfaces = [slave, master];
            // The part of space that both surfaces come near to.
            let boundaries = surfaces.map(|surface| &all[surface]);
            let [a, b] = surfaces.map(|surface| boxes[surface]);
            let common = [a[0].sup(&b[0]), a[1].inf(&b[1])];
            // The search distance is at most a twentieth of an edge, and no edge is longer than its surface.
            let near_size = NEAR * (a[1] - a[0]).norm().max((b[1] - b[0]).norm());
            if (0..3).any(|i| common[0][i] > common[1][i] + near_size) {
                continue;
            }
            // The edges of each side in there, sharp ones first.
            for (side, near) in near.iter_mut().enumerate() {
                near.clear();
                near.extend(near_box(&edges[surfaces[side]], &common, ends).map(|edge| {
                    let most = if edge.start > SHARP { SHARP } else { edge.start.max(0.0) + *bent };
                    Edge { is_sharp: angle(edge, boundaries[side], ends.0) > most, ..*edge }
                }));
                near.sort_unstable_by_key(|edge| (!edge.is_sharp, edge.nodes));
            }
            let sharp = near[1].partition_point(|edge| edge.is_sharp);
            sweep.sort(near[1].iter().map(|edge| reach_of(edge, ends)));
            for a in &near[0] {
                // At least one of the two is sharp.
                let others = if a.is_sharp { near[1].len() } else { sharp };
                for b in sweep.met_by(&reach_of(a, ends), others) {
                    if let Some(found) = contact_of([a, &near[1][*b as usize]], boundaries, ends, search) {
                        contacts.push(Contact { pair: number(pair), ..found });
                    }
                }
            }
        }
    }
}

/// The edges between two faces of a surface.
fn edges_of(boundary: &Boundary, x: &[Vec3]) -> Vec<Edge> {
    let mut edges = Vec::new();
    for (i, face) in boundary.faces.iter().enumerate() {
        let n = corner_count(face);
        for k in 0..n {
            let Across::Face(other) = boundary.across(i as u32, k) else { continue };
            if (other as usize) < i {
                continue;
            }
            let nodes = [face[k], face[(k + 1) % n]];
            let edge = Edge { nodes, faces: [i as u32, other], start: 0.0, is_sharp: false };
            edges.push(Edge { start: angle(&edge, boundary, x), ..edge });
        }
    }
    edges
}

/// Angle between the normals of the faces of an edge, negative in a notch: there the second lies before the first.
fn angle(edge: &Edge, boundary: &Boundary, x: &[Vec3]) -> f64 {
    let [a, b] = normals(edge, boundary, (x, x), 0.0);
    // A degenerate face has no normal.
    if a.norm_squared().min(b.norm_squared()) == 0.0 {
        return 0.0;
    }
    // The vector from the middle of the edge to that of its face lies along the face, however warped that is.
    let middle = Patch::new(&boundary.faces[edge.faces[1] as usize], x).point(&[0.25; 4]);
    let of_edge = (x[edge.nodes[0] as usize] + x[edge.nodes[1] as usize]) * 0.5;
    let is_notch = a.dot(&(middle - of_edge)) > 0.0;
    let angle = a.dot(&b).clamp(-1.0, 1.0).acos();
    if is_notch { -angle } else { angle }
}

fn joined([low, high]: [Vec3; 2], [l, h]: [Vec3; 2]) -> [Vec3; 2] {
    [low.inf(&l), high.sup(&h)]
}

/// The box around a surface over the step.
fn box_of(boundary: &Boundary, (x, x_end): Ends) -> [Vec3; 2] {
    let ends = boundary.nodes.iter().flat_map(|&node| [x[node as usize], x_end[node as usize]]);
    ends.map(|x| [x, x]).reduce(joined).unwrap_or([Vec3::zeros(); 2])
}

/// The edges that come near a box.
fn near_box<'a>(edges: &'a [Edge], place: &'a [Vec3; 2], ends: Ends<'a>) -> impl Iterator<Item = &'a Edge> {
    edges.iter().filter(move |edge| meet(&swept(edge, ends), place, NEAR * length(edge, ends.0)))
}

/// Normals of the faces at an edge, at the fraction `tau` of the step.
fn normals(edge: &Edge, boundary: &Boundary, (x, x_end): Ends, tau: f64) -> [Vec3; 2] {
    edge.faces.map(|face| Patch::between(&boundary.faces[face as usize], x, x_end, tau).normal(&[0.25; 4]))
}

fn length(edge: &Edge, x: &[Vec3]) -> f64 {
    (x[edge.nodes[1] as usize] - x[edge.nodes[0] as usize]).norm()
}

/// The ends of an edge, at the fraction `tau` of the step.
fn ends_of(edge: &Edge, (x, x_end): Ends, tau: f64) -> [Vec3; 2] {
    edge.nodes.map(|node| x[node as usize].lerp(&x_end[node as usize], tau))
}

/// The box around an edge over the step.
fn swept(edge: &Edge, (x, x_end): Ends) -> [Vec3; 2] {
    let [a, b] = edge.nodes.map(|node| node as usize);
    let points = [x[b], x_end[a], x_end[b]];
    points.iter().fold([x[a]; 2], |[low, high], p| [low.inf(p), high.sup(p)])
}

/// The box around an edge over the step, with its half of the distance within which two edges are near each other, and a little for rounding.
fn reach_of(edge: &Edge, ends: Ends) -> [Vec3; 2] {
    let ([low, high], half) = (swept(edge, ends), 0.501 * NEAR * length(edge, ends.0));
    [low.add_scalar(-half), high.add_scalar(half)]
}

fn meet(a: &[Vec3; 2], b: &[Vec3; 2], near: f64) -> bool {
    (0..3).all(|i| a[0][i] <= b[1][i] + near && b[0][i] <= a[1][i] + near)
}

/// The differences `x_A(a) − x_B(b)` of the points of two edges, at the fraction `tau` of the step.
fn difference(edges: [&Edge; 2], ends: Ends, tau: f64) -> Patch {
    let [[a0, a1], [b0, b1]] = edges.map(|edge| ends_of(edge, ends, tau));
    Patch { corners: [a0 - b0, a1 - b0, a1 - b1, a0 - b1], triangle: false }
}

/// Where the lines of two edges are closest, as fractions of their lengths, if that is between their ends.
fn closest_places(difference: &Patch) -> Option<(f64, f64)> {
    let [origin, along_a, _, along_b] = difference.corners;
    let (a, b) = (along_a - origin, along_b - origin);
    let (aa, ab, bb) = (a.norm_squared(), a.dot(&b), b.norm_squared());
    let (oa, ob) = (origin.dot(&a), origin.dot(&b));
    let determinant = aa * bb - ab * ab;
    let places = ((ab * ob - bb * oa) / determinant, (ab * oa - aa * ob) / determinant);
    let is_between = |place: f64| place > 0.0 && place < 1.0;
    (is_between(places.0) && is_between(places.1)).then_some(places)
}

/// Unit normal of the contact, out of the second edge, that of the master; `None` if it is not in both arcs.
fn common_normal(edges: [&Edge; 2], boundaries: [&Boundary; 2], ends: Ends, tau: f64) -> Option<Vec3> {
    let [a, b] = edges.map(|edge| {
        let [from, to] = ends_of(edge, ends, tau);
        to - from
    });
    let across = a.cross(&b);
    let sine = across.norm();
    if !(sine > PARALLEL * a.norm() * b.norm()) {
        return None;
    }
    let [of_a, of_b] = [0, 1].map(|side| normals(edges[side], boundaries[side], ends, tau));
    let outwards = of_b[0] + of_b[1] - of_a[0] - of_a[1];
    let n = across * (across.dot(&outwards).signum() / sine);
    let within = |n: &Vec3, is_sharp: bool, [first, second]: &[Vec3; 2], along: &Vec3| {
        let (along, mean) = (along.normalize(), first + second);
        let (to, from) = (first.cross(n).dot(&along), n.cross(second).dot(&along));
        let is_between = to.abs().min(from.abs()) > INSIDE && to * from > 0.0;
        let outwards = n.dot(&mean);
        outwards > OUTSIDE * mean.norm() || (is_sharp && is_between && outwards > 0.0)
    };
    (within(&n, edges[1].is_sharp, &of_b, &b) && within(&-n, edges[0].is_sharp, &of_a, &a)).then_some(n)
}

/// Whether both edges were sharp at the start of the run, and are.
fn are_sharp(edges: [&Edge; 2]) -> bool {
    edges.iter().all(|edge| edge.is_sharp && edge.start > SHARP)
}

/// The contact of two edges; the pair number is set by the caller.
fn contact_of(
    edges: [&Edge; 2],
    boundaries: [&Boundary; 2],
    ends: Ends,
    search: &mut Search,
) -> Option<Contact> {
    let (x, _) = ends;
    let size = 0.5 * (length(edges[0], x) + length(edges[1], x));
    let near = NEAR * size;
    let allowed = if are_sharp(edges) { 0.0 } else { ALLOWED * size };
    let [a, b] = edges.map(|edge| swept(edge, ends));
    if !meet(&a, &b, near) {
        return None;
    }
    let (start, end) = (difference(edges, ends, 0.0), difference(edges, ends, 1.0));
    // Near each other at the start of the step: the closest points.
    if let Some((a, b)) = closest_places(&start)
        && let weights = start.weights(a, b)
        && let point = start.point(&weights)
        && point.norm_squared() <= (DEPTH * size).powi(2)
        && let Some(n) = common_normal(edges, boundaries, ends, 0.0)
    {
        let gap = n.dot(&point);
        let after = gap + n.dot(&(end.point(&weights) - point));
        let is_held = allowed == 0.0 || gap.min(after) + allowed <= 0.0;
        if is_held && gap <= near && gap >= -DEPTH * size {
            return new_contact(edges, &n, &weights, gap + allowed, x);
        }
    }
    let moved = start.corners.iter().zip(&end.corners).map(|(p, q)| (q - p).norm()).fold(0.0, f64::max);
    if moved <= near {
        return None;
    }
    // Otherwise the first time of impact, of the side on which the patch is met.
    let turned = |patch: &Patch, is_turned: bool| {
        let [p, q, r, s] = patch.corners;
        Patch { corners: if is_turned { [q, p, s, r] } else { patch.corners }, triangle: false }
    };
    for is_turned in [false, true] {
        let (from, to) = (turned(&start, is_turned), turned(&end, is_turned));
        let origin = Vec3::zeros();
        let Some(hit) = search.first_impact(&from, &to, &origin, &origin, f64::INFINITY) else { continue };
        let a = if is_turned { 1.0 - hit.a } else { hit.a };
        let weights = start.weights(a, hit.b);
        let Some(n) = common_normal(edges, boundaries, ends, hit.tau) else { continue };
        let change = end.point(&weights) - start.point(&weights);
        if n.dot(&change) < 0.0 {
            return new_contact(edges, &n, &weights, n.dot(&start.point(&weights)) + allowed, x);
        }
    }
    None
}

/// Contact of two edges, with the `weights` of the corners of [`difference`].
fn new_contact(edges: [&Edge; 2], n: &Vec3, weights: &[f64; 4], gap: f64, x: &[Vec3]) -> Option<Contact> {
    let (a, b) = (weights[1] + weights[2], weights[2] + weights[3]);
    let is_at_end = |edge: &Edge, fraction: f64| !edge.is_sharp && fraction.min(1.0 - fraction) < AT_END;
    if is_at_end(edges[0], a) || is_at_end(edges[1], b) {
        return None;
    }
    let [of_slave, of_master] = edges.map(|edge| edge.nodes);
    let place = |[p, q]: [u32; 2], fraction: f64| x[p as usize] * (1.0 - fraction) + x[q as usize] * fraction;
    let along = x[of_slave[1] as usize] - x[of_slave[0] as usize];
    let is_made = edges.iter().any(|edge| edge.is_sharp && edge.start <= SHARP);
    Some(Contact {
        pair: 0,
        kind: if is_made { BULGE } else { CROSSING },
        slave: of_slave[usize::from(a > 0.5)],
        face: edges[1].faces[0],
        stencil: Stencil::new(
            [(of_slave[0], 1.0 - a), (of_slave[1], a)],
            [(of_master[0], 1.0 - b), (of_master[1], b)],
        )?,
        frame: local_frame(n, &along),
        gap,
        point: place(of_slave, a),
        drift: Vec3::zeros(),
        law: ContactLaw::Frictionless,
    })
}
