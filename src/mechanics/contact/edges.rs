//! Edges against edges, between their ends, where one of them is sharp.
//!
//! The difference of a point on one edge and one on the other, `x_A(a) − x_B(b)`, runs over a bilinear patch, and the edges meet
//! where it is zero: so the closest points of two edges are the point of that patch closest to the origin, and their first
//! impact is that of the resting origin with the moving patch ([`super::time_of_impact`]).
//!
//! Edges touch along the common normal of both, where it points out of each body: into the arc between the normals of the two
//! faces at an edge (the arcs of the Gauss map cross). Elsewhere a node touches a face. An edge is sharp if the normals of its
//! faces are more than [`SHARP`] apart at the start of the run, so two smooth skins have none and cost nothing. Against the other
//! edges of a skin, across which a sharp one may lie where they bulge, it is held as nodes of the master are: by [`ALLOWED`] and no
//! deeper, so that where nodes hold already this constrains nothing.

use super::closest_point::{Feature, Patch};
use super::detection::Detector;
use super::finder::local_frame;
use super::guard::ALLOWED;
use super::narrow_phase::NEAR;
use super::skin::{NONE, Skin, corner_count};
use super::stencil::Stencil;
use super::time_of_impact::Search;
use super::{Contact, Kind};
use crate::mechanics::tensor::Vec3;

/// Cosine of the angle between the normals of two faces above which the edge between them is smooth.
const SHARP: f64 = 0.866;
/// Sine of the angle between two edges below which they are parallel: then a node of one touches.
const PARALLEL: f64 = 0.05;
/// Sine of the angle by which the common normal must be inside the arcs: on their ends a node or a face touches.
const INSIDE: f64 = 0.05;
/// Cosine of the angle between the common normal and that of a smooth edge above which the edge is met from outside.
const OUTSIDE: f64 = 0.8;
/// Share of a smooth edge next to its ends where a node touches.
const AT_END: f64 = 0.05;
/// Edges that have crossed by more than this share of their length are not told apart from others that cross behind.
const DEPTH: f64 = 0.25;

/// An edge between two faces.
#[derive(Clone, Copy, Debug)]
struct Edge {
    nodes: [u32; 2],
    faces: [u32; 2],
    is_sharp: bool,
}

/// The edges of the pairs in which one is sharp, those of the slave first.
pub(super) struct EdgeFinder {
    /// Number of the pair, its place in the detector, edges of both, the sharp ones first.
    pairs: Vec<(u32, usize, [Vec<Edge>; 2])>,
    near: [Vec<u32>; 2],
    search: Search,
}

/// Places of all nodes at both ends of a step [m].
type Ends<'a> = (&'a [Vec3], &'a [Vec3]);

impl EdgeFinder {
    /// Of the pairs of a detector that has slave and master exchanged, with their `numbers`.
    pub fn new(reversed: &Detector, numbers: &[u32], x: &[Vec3]) -> Self {
        let mut pairs = Vec::new();
        for (place, ((master, slave), number)) in reversed.sides().zip(numbers).enumerate() {
            let Some(slave) = slave else { continue };
            let edges = [slave, master].map(|surface| edges_of(reversed.skin(surface), x));
            if edges.iter().flatten().any(|edge| edge.is_sharp) {
                pairs.push((*number, place, edges));
            }
        }
        let most = |side: usize| pairs.iter().map(|(.., edges)| edges[side].len()).max().unwrap_or(0);
        let near = [0, 1].map(|side| Vec::with_capacity(most(side)));
        Self { pairs, near, search: Search::default() }
    }

    /// Appends the contacts of a step.
    pub fn detect(&mut self, reversed: &Detector, ends: Ends, drifts: &[Vec3], contacts: &mut Vec<Contact>) {
        let Self { pairs, near, search } = self;
        for (number, place, edges) in pairs.iter() {
            near.iter_mut().for_each(Vec::clear);
            let sharp = [0, 1].map(|side| edges[side].partition_point(|edge| edge.is_sharp));
            // Sharp edges of one side near all of the other, and what of the other is near those.
            for (side, count) in sharp.into_iter().enumerate() {
                collect_near(&edges[side][..count], 0, box_of(&edges[1 - side], ends), ends, &mut near[side]);
            }
            let of_sharp = [0, 1]
                .map(|side| near[side].iter().map(|&i| swept(&edges[side][i as usize], ends)).reduce(joined));
            for (side, count) in sharp.into_iter().enumerate() {
                collect_near(&edges[side][count..], count, of_sharp[1 - side], ends, &mut near[side]);
            }
            let Some((slave, master)) = reversed.exchanged_skins(*place) else { continue };
            for &i in &near[0] {
                for &j in &near[1] {
                    let pair = [&edges[0][i as usize], &edges[1][j as usize]];
                    if pair.iter().any(|edge| edge.is_sharp)
                        && let Some(found) = contact_of(pair, [slave, master], ends, search)
                    {
                        contacts.push(Contact { pair: *number, drift: drifts[*number as usize], ..found });
                    }
                }
            }
        }
    }
}

/// The edges of a skin, the sharp ones first.
fn edges_of(skin: &Skin, x: &[Vec3]) -> Vec<Edge> {
    let mut edges = Vec::new();
    for (i, (face, across)) in skin.faces.iter().zip(&skin.neighbours).enumerate() {
        let n = corner_count(face);
        for k in 0..n {
            let other = across[k];
            if other == NONE || (other as usize) < i {
                continue;
            }
            let edge =
                Edge { nodes: [face[k], face[(k + 1) % n]], faces: [i as u32, other], is_sharp: false };
            let [a, b] = normals(&edge, skin, (x, x), 0.0);
            // Convex: the neighbour lies behind the face.
            let middle = |face: u32| Patch::new(&skin.faces[face as usize], x).point(&[0.25; 4]);
            let is_convex = a.dot(&(middle(other) - x[edge.nodes[0] as usize])) < 0.0;
            edges.push(Edge { is_sharp: a.dot(&b) < SHARP && is_convex, ..edge });
        }
    }
    edges.sort_by_key(|edge| !edge.is_sharp);
    edges
}

fn joined([low, high]: [Vec3; 2], [l, h]: [Vec3; 2]) -> [Vec3; 2] {
    [low.inf(&l), high.sup(&h)]
}

/// The box around edges over the step.
fn box_of(edges: &[Edge], ends: Ends) -> Option<[Vec3; 2]> {
    edges.iter().map(|edge| swept(edge, ends)).reduce(joined)
}

/// Appends the numbers, from `first` on, of the edges that come near a box.
fn collect_near(edges: &[Edge], first: usize, other: Option<[Vec3; 2]>, ends: Ends, near: &mut Vec<u32>) {
    let Some(other) = other else { return };
    let meets = |(_, edge): &(usize, &Edge)| meet(&swept(edge, ends), &other, NEAR * length(edge, ends.0));
    near.extend(edges.iter().enumerate().filter(meets).map(|(i, _)| (first + i) as u32));
}

/// Normals of the faces at an edge, at a share of the step.
fn normals(edge: &Edge, skin: &Skin, (x, x_end): Ends, tau: f64) -> [Vec3; 2] {
    edge.faces.map(|face| Patch::between(&skin.faces[face as usize], x, x_end, tau).normal(&[0.25; 4]))
}

fn length(edge: &Edge, x: &[Vec3]) -> f64 {
    (x[edge.nodes[1] as usize] - x[edge.nodes[0] as usize]).norm()
}

/// The box around an edge over the step.
fn swept(edge: &Edge, (x, x_end): Ends) -> [Vec3; 2] {
    let [a, b] = edge.nodes.map(|node| node as usize);
    let points = [x[b], x_end[a], x_end[b]];
    points.iter().fold([x[a]; 2], |[low, high], p| [low.inf(p), high.sup(p)])
}

fn meet(a: &[Vec3; 2], b: &[Vec3; 2], near: f64) -> bool {
    (0..3).all(|i| a[0][i] <= b[1][i] + near && b[0][i] <= a[1][i] + near)
}

/// The differences `x_A(a) − x_B(b)` of the points of two edges, at a share of the step.
fn difference([a, b]: [&Edge; 2], (x, x_end): Ends, tau: f64) -> Patch {
    let at = |node: u32| x[node as usize] + (x_end[node as usize] - x[node as usize]) * tau;
    let ([a0, a1], [b0, b1]) = (a.nodes.map(at), b.nodes.map(at));
    Patch { corners: [a0 - b0, a1 - b0, a1 - b1, a0 - b1], triangle: false }
}

/// Unit normal of the contact out of the second edge, the master's, if it is in both arcs.
fn common_normal(edges: [&Edge; 2], skins: [&Skin; 2], ends: Ends, tau: f64) -> Option<Vec3> {
    let along = |edge: &Edge| {
        let at = |node: u32| ends.0[node as usize] + (ends.1[node as usize] - ends.0[node as usize]) * tau;
        at(edge.nodes[1]) - at(edge.nodes[0])
    };
    let (a, b) = (along(edges[0]), along(edges[1]));
    let across = a.cross(&b);
    let sine = across.norm();
    if !(sine > PARALLEL * a.norm() * b.norm()) {
        return None;
    }
    let [of_a, of_b] = [0, 1].map(|side| normals(edges[side], skins[side], ends, tau));
    let outwards = of_b[0] + of_b[1] - of_a[0] - of_a[1];
    let n = across * (across.dot(&outwards).signum() / sine);
    let within = |n: &Vec3, is_sharp: bool, [first, second]: &[Vec3; 2], along: &Vec3| {
        let (along, mean) = (along.normalize(), first + second);
        let (to, from) = (first.cross(n).dot(&along), n.cross(second).dot(&along));
        let is_between = to.abs().min(from.abs()) > INSIDE && to * from > 0.0;
        n.dot(&mean) > if is_sharp { 0.0 } else { OUTSIDE * mean.norm() } && (is_between || !is_sharp)
    };
    (within(&n, edges[1].is_sharp, &of_b, &b) && within(&-n, edges[0].is_sharp, &of_a, &a)).then_some(n)
}

fn contact_of(edges: [&Edge; 2], skins: [&Skin; 2], ends: Ends, search: &mut Search) -> Option<Contact> {
    let (x, _) = ends;
    let size = 0.5 * (length(edges[0], x) + length(edges[1], x));
    let near = NEAR * size;
    let allowed = if edges.iter().all(|edge| edge.is_sharp) { 0.0 } else { ALLOWED * size };
    let [a, b] = edges.map(|edge| swept(edge, ends));
    if !meet(&a, &b, near) {
        return None;
    }
    let (start, end) = (difference(edges, ends, 0.0), difference(edges, ends, 1.0));
    let closest = start.closest(&Vec3::zeros());
    if closest.feature == Feature::Interior
        && let Some(n) = common_normal(edges, skins, ends, 0.0)
    {
        let gap = n.dot(&closest.point);
        if gap <= near && gap >= -DEPTH * size {
            return new_contact(edges, &n, &closest.weights, gap + allowed, x);
        }
    }
    let moved = start.corners.iter().zip(&end.corners).map(|(p, q)| (q - p).norm()).fold(0.0, f64::max);
    if moved <= near {
        return None;
    }
    // The side on which the patch is met: that of the edges as they are.
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
        let Some(n) = common_normal(edges, skins, ends, hit.tau) else { continue };
        let change = end.point(&weights) - start.point(&weights);
        if n.dot(&change) < 0.0 {
            return new_contact(edges, &n, &weights, n.dot(&start.point(&weights)) + allowed, x);
        }
    }
    None
}

/// `weights` of the corners of [`difference`]; the numbers of pair and drift are still to come.
fn new_contact(edges: [&Edge; 2], n: &Vec3, weights: &[f64; 4], gap: f64, x: &[Vec3]) -> Option<Contact> {
    let (a, b) = (weights[1] + weights[2], weights[2] + weights[3]);
    let is_at_end = |edge: &Edge, share: f64| !edge.is_sharp && share.min(1.0 - share) < AT_END;
    if is_at_end(edges[0], a) || is_at_end(edges[1], b) {
        return None;
    }
    let [of_slave, of_master] = edges.map(|edge| edge.nodes);
    let place = |[p, q]: [u32; 2], share: f64| x[p as usize] * (1.0 - share) + x[q as usize] * share;
    let along = x[of_slave[1] as usize] - x[of_slave[0] as usize];
    Some(Contact {
        pair: 0,
        kind: Kind::Fixed,
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
    })
}
