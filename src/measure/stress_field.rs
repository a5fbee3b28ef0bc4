//! Von Mises stress as a field over the depth below the surface, continuous in each part of the tissue.
//!
//! At a node the field of a part is the value of a straight line in depth, fitted by least squares to the stresses s_q at
//! the quadrature points of the part's elements around the node, with weights w_q = V_q N². Along the edges of elements
//! it is linear. Stress that is linear in depth is reproduced exactly on any mesh, up to the boundaries of the part; at an
//! interface each part has a value of its own. The field, and the depths read from it, are continuous in the stresses. Where an element is
//! deeper in the middle of some corners than at these (`depth_ridge.rs`) the middle is a vertex, too, with the mean of their values, and an
//! edge leads to it from each of them.

#[cfg(test)]
mod tests;

use super::depth_ridge::{Middle, Ridge};
use crate::mechanics::element::MOST_POINTS;
use crate::mesh::cell::CellKind;
use std::collections::BTreeMap;

/// Most corners of an element.
const MOST_CORNERS: usize = 8;

/// Most ends of the tissue that are distinguished.
pub const MOST_ENDS: usize = 32;

/// Largest error of the field over the scatter of the points that it is fitted to [-].
///
/// With curvature s'' on elements of size h, the value at a node is s''h²/24 too large and that in the middle of an edge
/// by s''h²/8 more. Two Gauss points at (1 ∓ 1/√3) h/2 from the node scatter by s''h²/(8√3) about the line: the ratio is 4/√3.
const ERROR_OVER_SCATTER: f64 = 2.309_401_076_758_503;

/// Smallest variance of the depths around a node, over the square of its distance from their mean, for a slope to be
/// fitted [-]: 1/3 at the boundary of a layer of hexahedra.
const LEAST_SPREAD: f64 = 0.1;

/// An element of the tissue.
pub struct TissueElement {
    /// Its slot.
    pub slot: usize,
    /// Index of its part.
    pub part: usize,
    /// Kind of the cell, which gives nodes and points.
    pub cell: CellKind,
    /// Global numbers of its nodes, in the order of the kind.
    pub nodes: Vec<u32>,
    /// Reference volumes of its quadrature points [m³].
    pub volumes: [f64; MOST_POINTS],
    /// Its depths where they are not linear between its corners, and larger.
    pub ridge: Option<Ridge>,
}

/// A node of a part, or the middle of some of them.
#[derive(Clone, Copy)]
struct Vertex {
    part: u32,
    /// Bit set of the ends of the tissue that it belongs to.
    ends: u32,
    /// Its reference depth [m].
    depth: f64,
    /// Von Mises stress at the vertex [Pa].
    stress: f64,
    /// Bound of its error, from the scatter of the points about the line [Pa].
    error: f64,
}

/// The line through the stresses around a node.
#[derive(Clone, Copy, Default)]
struct Line {
    /// Σ w, Σ w δ, Σ w δ² of the points around it, δ their depths relative to its own.
    moments: [f64; 3],
    /// Σ w s, Σ w s δ, Σ w s² of the current pass.
    sums: [f64; 3],
}

/// Corners and point depths of the element in a slot; no corners in slots of other bodies.
#[derive(Clone, Copy, Default)]
struct Corners {
    cell: CellKind,
    count: usize,
    vertices: [u32; MOST_CORNERS],
    /// Depths of its quadrature points [m].
    depths: [f64; MOST_POINTS],
}

/// Depths between which the stress exceeds a threshold [m].
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Largest depth; 0 if the threshold is exceeded nowhere.
    pub depth: f64,
    /// Extent in depth of the edge on which it is read; 0 if the threshold is exceeded nowhere.
    pub edge: f64,
    /// The same with every value lowered and raised by the bound of its error.
    pub bounds: [f64; 2],
    /// Least and largest depth in each part; [`Region::NOWHERE`] in parts in which it is not exceeded.
    pub layers: Vec<[f64; 2]>,
    /// Largest depth to which the threshold is exceeded on the edges from a vertex at each end of the tissue that is above it; −∞ without such
    /// a vertex.
    pub ends: [f64; MOST_ENDS],
}

impl Region {
    /// Depths of an empty region.
    pub const NOWHERE: [f64; 2] = [f64::INFINITY, 0.0];

    /// Adds what exceeds the threshold [Pa] on an edge; with its value raised at least one of its ends does.
    fn add(&mut self, ends: [&Vertex; 2], threshold: f64) {
        // Most edges exceed it from end to end, with every value lowered.
        let ([a, b], lowered) = (ends.map(|v| v.depth), ends.map(|v| v.stress - v.error));
        let is_whole = lowered[0].min(lowered[1]) > threshold;
        let of = |shift: f64| {
            if is_whole {
                return Some([a.min(b), a.max(b)]);
            }
            above(ends.map(|v| (v.depth, v.stress + shift * v.error)), threshold)
        };
        for (bound, shift) in self.bounds.iter_mut().zip([-1.0, 1.0]) {
            *bound = of(shift).map_or(*bound, |[_, deepest]| bound.max(deepest));
        }
        let Some([from, to]) = of(0.0) else { return };
        let layer = &mut self.layers[ends[0].part as usize];
        *layer = [layer[0].min(from), layer[1].max(to)];
        if to > self.depth {
            (self.depth, self.edge) = (to, (a - b).abs());
        }
        // The region may be deepest between two nodes of an end.
        let above_at = |vertex: &Vertex| if vertex.stress > threshold { vertex.ends } else { 0 };
        let reached = above_at(ends[0]) | above_at(ends[1]);
        if reached != 0 {
            let at = self.ends.iter_mut().enumerate().filter(|(bit, _)| reached >> bit & 1 == 1);
            at.for_each(|(_, depth)| *depth = depth.max(to));
        }
    }
}

/// The field at the latest pass.
pub struct StressField {
    /// Those at nodes, then those at middles.
    vertices: Vec<Vertex>,
    /// The line of each of those at nodes.
    lines: Vec<Line>,
    /// The vertices whose middle is each of the last vertices.
    middles: Vec<Vec<u32>>,
    /// Vertices at the corners of each element, by slot.
    elements: Vec<Corners>,
    /// Edges of elements, and from corners to their middles, each once.
    edges: Vec<[u32; 2]>,
    part_count: usize,
}

impl StressField {
    /// A field without stress, given of each node of the plan the depth [m], unused outside of the tissue, and the bit set of the ends of the
    /// tissue that it belongs to. `part_count` and `slot_count` are the numbers of parts and of slots.
    pub fn new(
        (depths, ends): (&[f64], &[u32]),
        (part_count, slot_count): (usize, usize),
        tissue: impl Iterator<Item = TissueElement>,
    ) -> Self {
        let mut field = Self {
            vertices: Vec::new(),
            lines: Vec::new(),
            middles: Vec::new(),
            elements: vec![Corners::default(); slot_count],
            edges: Vec::new(),
            part_count,
        };
        let mut numbers = vec![u32::MAX; part_count * depths.len()];
        // Depth of the middle of some vertices [m]; elements have them in common.
        let mut middles: BTreeMap<Vec<u32>, f64> = BTreeMap::new();
        for element in tissue {
            let depth_of = |local: usize| depths[element.nodes[local] as usize];
            let number = |local: usize| element.part * depths.len() + element.nodes[local] as usize;
            for local in 0..element.cell.table().corners {
                let known = &mut numbers[number(local)];
                if *known == u32::MAX {
                    *known = field.vertices.len() as u32;
                    let ends = ends[element.nodes[local] as usize];
                    field.vertices.push(Vertex::new(element.part as u32, depth_of(local), ends));
                    field.lines.push(Line::default());
                }
            }
            let vertex = |local: usize| numbers[number(local)];
            field.insert(&element, vertex, depth_of);
            for Middle { corners, depth } in element.ridge.iter().flat_map(|ridge| &ridge.middles) {
                let mut corners: Vec<u32> = corners.iter().map(|corner| vertex(*corner)).collect();
                corners.sort_unstable();
                middles.insert(corners, *depth);
            }
        }
        field.add_middles(middles);
        field.edges.sort_unstable();
        field.edges.dedup();
        field.edges.shrink_to_fit();
        field
    }

    /// Inserts an element, given the vertex of each corner and the depth of each node [m].
    fn insert(
        &mut self,
        element: &TissueElement,
        vertex: impl Fn(usize) -> u32,
        depth: impl Fn(usize) -> f64,
    ) {
        let (kind, table) = (element.cell.element(), element.cell.table());
        let mut corners = Corners { cell: element.cell, count: table.corners, ..Corners::default() };
        for (local, to) in corners.vertices.iter_mut().enumerate().take(table.corners) {
            *to = vertex(local);
        }
        for (q, volume) in element.volumes.iter().enumerate().take(kind.point_count()) {
            let shapes = kind.shapes_at(q);
            corners.depths[q] = match &element.ridge {
                Some(ridge) => ridge.points[q],
                None => shapes.iter().enumerate().map(|(local, N)| N * depth(local)).sum(),
            };
            for (vertex, N) in corners.vertices.iter().zip(shapes).take(corners.count) {
                let delta = corners.depths[q] - self.vertices[*vertex as usize].depth;
                self.lines[*vertex as usize].add_moments(volume * N * N, delta);
            }
        }
        let ends = |[a, b]: &[usize; 2]| {
            let [a, b] = [corners.vertices[*a], corners.vertices[*b]];
            [a.min(b), a.max(b)]
        };
        self.edges.extend(table.edges.iter().map(ends));
        self.elements[element.slot] = corners;
    }

    /// Adds vertices at the middles of others, each with its depth [m], at the ends that all of these are at.
    fn add_middles(&mut self, middles: BTreeMap<Vec<u32>, f64>) {
        for (corners, depth) in middles {
            let at = |corner: &u32| &self.vertices[*corner as usize];
            let part = corners.first().map_or(0, |corner| at(corner).part);
            let ends = corners.iter().map(at).fold(u32::MAX, |ends, vertex| ends & vertex.ends);
            let middle = self.vertices.len() as u32;
            self.vertices.push(Vertex::new(part, depth, ends));
            self.edges.extend(corners.iter().map(|corner| [*corner, middle]));
            self.middles.push(corners);
        }
    }

    /// Largest depth of a node, or of a middle that is deeper [m]; `None` without tissue.
    pub fn deepest(&self) -> Option<f64> {
        self.vertices.iter().map(|vertex| vertex.depth).reduce(f64::max)
    }

    /// Begins a pass over all points. Points that are not added have no stress.
    pub fn begin(&mut self) {
        self.lines.iter_mut().for_each(|line| line.sums = [0.0; 3]);
    }

    /// Adds a stress [Pa] at a quadrature point of the element in a slot, with its reference volume [m³].
    pub fn add(&mut self, slot: usize, q: usize, (stress, volume): (f64, f64)) {
        let Corners { cell, count, vertices, depths } = &self.elements[slot];
        for (vertex, N) in vertices.iter().zip(cell.element().shapes_at(q)).take(*count) {
            let delta = depths[q] - self.vertices[*vertex as usize].depth;
            let weighted = volume * N * N * stress;
            for (sum, x) in self.lines[*vertex as usize].sums.iter_mut().zip([1.0, delta, stress]) {
                *sum += weighted * x;
            }
        }
    }

    /// Ends the pass: fits the lines.
    pub fn end(&mut self) {
        let (nodes, middles) = self.vertices.split_at_mut(self.lines.len());
        for (node, line) in nodes.iter_mut().zip(&self.lines) {
            (node.stress, node.error) = line.fit();
        }
        for (middle, corners) in middles.iter_mut().zip(&self.middles) {
            let mean = |of: fn(&Vertex) -> f64| {
                corners.iter().map(|corner| of(&nodes[*corner as usize])).sum::<f64>() / corners.len() as f64
            };
            (middle.stress, middle.error) = (mean(|vertex| vertex.stress), mean(|vertex| vertex.error));
        }
    }

    /// The region in which the stress exceeds a threshold [Pa].
    pub fn region(&self, threshold: f64) -> Region {
        let mut region = Region {
            depth: 0.0,
            edge: 0.0,
            bounds: [0.0; 2],
            layers: vec![Region::NOWHERE; self.part_count],
            ends: [f64::NEG_INFINITY; MOST_ENDS],
        };
        // Where not even the raised stress exceeds the threshold, nothing does.
        let raised = |vertex: &Vertex| vertex.stress + vertex.error;
        for ends in self.ends_of_edges().filter(|[a, b]| raised(a).max(raised(b)) > threshold) {
            region.add(ends, threshold);
        }
        region
    }

    /// Largest stress at or below a depth [m] [Pa]; 0 if the tissue ends above it.
    pub fn largest_below(&self, depth: f64) -> f64 {
        let on_edge = |[a, b]: [&Vertex; 2]| {
            let [upper, lower] = if a.depth > b.depth { [b, a] } else { [a, b] };
            let at_top = if upper.depth >= depth {
                upper.stress
            } else {
                let fraction = (depth - upper.depth) / (lower.depth - upper.depth);
                upper.stress + fraction * (lower.stress - upper.stress)
            };
            (lower.depth >= depth).then_some(at_top.max(lower.stress))
        };
        self.ends_of_edges().filter_map(on_edge).fold(0.0, f64::max)
    }

    fn ends_of_edges(&self) -> impl Iterator<Item = [&Vertex; 2]> {
        self.edges.iter().map(|ends| ends.map(|end| &self.vertices[end as usize]))
    }
}

impl Vertex {
    fn new(part: u32, depth: f64, ends: u32) -> Self {
        Self { part, depth, ends, stress: 0.0, error: 0.0 }
    }
}

impl Line {
    /// Adds a point with weight w at the relative depth δ [m].
    fn add_moments(&mut self, weight: f64, delta: f64) {
        for (moment, x) in self.moments.iter_mut().zip([1.0, delta, delta * delta]) {
            *moment += weight * x;
        }
    }

    /// Fits s = a + b δ: the value a, and the bound of its error by the residual variance (Σ w s² − a Σ w s − b Σ w s δ) / Σ w [Pa].
    fn fit(&self) -> (f64, f64) {
        let ([m0, m1, m2], [s0, s1, squares]) = (self.moments, self.sums);
        let determinant = m0 * m2 - m1 * m1;
        let [a, b] = if determinant > LEAST_SPREAD * m1 * m1 {
            [(m2 * s0 - m1 * s1) / determinant, (m0 * s1 - m1 * s0) / determinant]
        } else {
            [s0 / m0.max(f64::MIN_POSITIVE), 0.0]
        };
        let variance = (squares - a * s0 - b * s1) / m0.max(f64::MIN_POSITIVE);
        (a, ERROR_OVER_SCATTER * variance.max(0.0).sqrt())
    }
}

/// Depths between which a stress that is linear between two (depth, stress) exceeds a threshold; `None` if nowhere.
fn above([a, b]: [(f64, f64); 2], threshold: f64) -> Option<[f64; 2]> {
    if a.1 < b.1 {
        return above([b, a], threshold);
    }
    if a.1 <= threshold {
        return None;
    }
    let end = if b.1 >= threshold { b.0 } else { a.0 + (b.0 - a.0) * (a.1 - threshold) / (a.1 - b.1) };
    Some([a.0.min(end), a.0.max(end)])
}
