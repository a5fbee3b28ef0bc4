//! Nodes are moved onto the surfaces of the labels, and others after them. A move is made only while the scaled Jacobians of all
//! elements that it changes stay above a limit: as all begin as bricks, the limit holds to the end.

use super::elements::Elements;
use super::surfaces::{Node, Surfaces, meeting};
use crate::mechanics::tensor::Vec3;
use crate::mesh::CellKind;
use std::collections::BTreeMap;

/// Smallest scaled Jacobian of an element of the mesh [-].
pub const LEAST_SCALED_JACOBIAN: f64 = 0.2;

/// Fractions of a move that are tried [-].
const FRACTIONS: [f64; 4] = [1.0, 0.5, 0.25, 0.1];

/// For each corner of a hexahedron, the corners at the other ends of its edges, as a right-handed triad.
const TRIADS: [[usize; 3]; 8] =
    [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]];

/// From this scaled Jacobian at the corners on, that at the points of quadrature is not computed [-].
const SOUND: f64 = 0.6;

/// Shortest edge of an element that a move may leave, relative to that of its leaf or its layer before [-].
const SHORTEST: f64 = 0.3;

/// Shortest edge of an element of the skin that a move may leave, relative to what it was in an earlier pass [-].
const SHORTEST_SKIN: f64 = 0.7;

/// Smallest scaled Jacobian of a hexahedron at its corners and points of quadrature [-], and its shortest edge [m].
pub fn quality(x: &[Vec3; 8]) -> (f64, f64) {
    let (mut least, mut shortest) = (f64::INFINITY, f64::INFINITY);
    for (corner, [a, b, c]) in TRIADS.into_iter().enumerate() {
        let [a, b, c] = [a, b, c].map(|other| x[other] - x[corner]);
        let squares = [a, b, c].map(|edge| edge.norm_squared());
        shortest = squares.into_iter().fold(shortest, f64::min);
        let lengths = squares.into_iter().product::<f64>().sqrt();
        least = least.min(if lengths > 0.0 { a.cross(&b).dot(&c) / lengths } else { 0.0 });
    }
    if least < SOUND {
        let points = CellKind::Hex8.table().quadrature.iter();
        least = points.map(|(xi, _)| CellKind::Hex8.scaled_jacobian(x, *xi)).fold(least, f64::min);
    }
    (least, shortest.sqrt())
}

/// Elements whose nodes are moved.
pub struct Smoothing<'a> {
    /// The elements; their nodes are where they were moved to.
    pub elements: &'a mut Elements,
    /// Where the nodes were [m].
    homes: Vec<Vec3>,
    /// Classes that meet at each node that is moved onto a surface; empty for others.
    pub meeting: Vec<Vec<u8>>,
    /// Classes that meet at each node, hanging nodes included.
    meeting_at: Vec<Vec<u8>>,
    /// Thickness of the skin [m].
    pub thickness: f64,
    /// Nodes at the other ends of the edges of each node.
    neighbours: Vec<Vec<u32>>,
    /// Nodes that hang on each node.
    followers: Vec<Vec<u32>>,
    /// Elements affected by moving each node; empty for hanging nodes.
    changed: Vec<Vec<u32>>,
    /// Longest edge of the elements at each node [m].
    edges: Vec<f64>,
    /// Shortest edge that each element may get [m].
    shortest: Vec<f64>,
    /// Scaled Jacobian of the elements that are below the limit of the mesh, which moves may not make worse; infinite for all others.
    /// Elements of a new layer start below it where the surface underneath has an edge.
    unsound: Vec<f64>,
}

/// Scaled Jacobian of an element below the limit of the mesh; infinite above.
fn unsoundness(x: &[Vec3; 8]) -> f64 {
    let (jacobian, _) = quality(x);
    if jacobian < LEAST_SCALED_JACOBIAN { jacobian } else { f64::INFINITY }
}

impl<'a> Smoothing<'a> {
    /// Prepares the moves of all nodes, with a skin of this thickness [m].
    pub fn new(elements: &'a mut Elements, thickness: f64) -> Self {
        let count = elements.nodes.len();
        // Neighbours along edges, elements and longest edge of each node.
        let (mut neighbours, mut at_node) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        let mut edges = vec![0.0_f64; count];
        for (e, hex) in (0..).zip(&elements.hexes) {
            for &[a, b] in CellKind::Hex8.table().edges {
                neighbours[hex[a] as usize].push(hex[b]);
                neighbours[hex[b] as usize].push(hex[a]);
            }
            for &node in hex {
                at_node[node as usize].push(e);
                edges[node as usize] = edges[node as usize].max(elements.edges[e as usize]);
            }
        }
        // Hanging nodes follow their masters, and change the elements at both.
        let mut followers = vec![Vec::new(); count];
        for (&node, on) in &elements.hanging {
            for master in on {
                followers[*master as usize].push(node);
            }
        }
        let unique = |mut list: Vec<u32>| {
            list.sort_unstable();
            list.dedup();
            list
        };
        let of_node = |node: usize| {
            if elements.hanging.contains_key(&(node as u32)) {
                return Vec::new();
            }
            let also = followers[node].iter().flat_map(|&f: &u32| at_node[f as usize].iter());
            unique(at_node[node].iter().chain(also).copied().collect())
        };
        // Shortest edges that a move may leave: a fraction of the first, which is larger in the skin.
        let first_of_skin = elements.skin.as_ref().map_or(usize::MAX, |skin| skin.first_element);
        let part_of_first = |e: usize| if e < first_of_skin { SHORTEST } else { SHORTEST_SKIN };
        let first_edge = |hex: &[u32; 8]| quality(&hex.map(|node| elements.nodes[node as usize])).1;
        Self {
            unsound: elements
                .hexes
                .iter()
                .map(|hex| unsoundness(&hex.map(|node| elements.nodes[node as usize])))
                .collect(),
            shortest: (0..).zip(&elements.hexes).map(|(e, hex)| part_of_first(e) * first_edge(hex)).collect(),
            homes: elements.nodes.clone(),
            meeting: meeting(elements, false),
            meeting_at: meeting(elements, true),
            thickness,
            changed: (0..count).map(of_node).collect(),
            neighbours: neighbours.into_iter().map(unique).collect(),
            followers,
            edges,
            elements,
        }
    }

    /// From now on, no element of the skin gets much thinner than it is.
    pub fn keep_thickness(&mut self) {
        let Some(skin) = &self.elements.skin else { return };
        for e in skin.first_element..self.elements.hexes.len() {
            let x = self.elements.hexes[e].map(|node| self.elements.nodes[node as usize]);
            let thin = SHORTEST_SKIN * quality(&x).1;
            self.shortest[e] = self.shortest[e].max(thin);
        }
    }

    /// Moves every node once, onto the surfaces or after its neighbours; scaled Jacobians stay above `least`.
    pub fn pass(&mut self, surfaces: &mut Surfaces, least: f64, is_backward: bool) {
        let count = self.homes.len();
        for i in 0..count {
            let node = if is_backward { count - 1 - i } else { i };
            if self.changed[node].is_empty() || self.elements.is_fixed[node] == [true; 3] {
                continue;
            }
            let target = match self.pair(node) {
                Some(pair) => self.in_skin(node, pair, surfaces),
                None if self.meeting[node].is_empty() => self.after_neighbours(node),
                None => self.on_surface(node, surfaces),
            };
            self.try_move(node, target, least);
            // Where an element is not sound, the middle of all neighbours may help.
            if self.changed[node].iter().any(|e| self.unsound[*e as usize].is_finite()) {
                let around = &self.neighbours[node];
                let sum: Vec3 = around.iter().map(|other| self.elements.nodes[*other as usize]).sum();
                self.try_move(node, sum / around.len() as f64, least);
            }
        }
    }

    /// A node inside is displaced as its neighbours are in the mean: bricks stay bricks where nothing moves.
    fn after_neighbours(&self, node: usize) -> Vec3 {
        let around = &self.neighbours[node];
        let moved = |other: &u32| self.elements.nodes[*other as usize] - self.homes[*other as usize];
        self.homes[node] + around.iter().map(moved).sum::<Vec3>() / around.len() as f64
    }

    /// The nodes below and above the skin where `node` is one of them.
    fn pair(&self, node: usize) -> Option<[usize; 2]> {
        let skin = self.elements.skin.as_ref()?;
        if node >= skin.first_node {
            return Some([skin.below[node - skin.first_node] as usize, node]);
        }
        skin.above.get(&(node as u32)).map(|above| [node, *above as usize])
    }

    /// A node above the skin goes half way to the middle of its neighbours there, and back onto the outer surface; one below goes to
    /// where the thickness puts it.
    fn in_skin(&self, node: usize, [below, above]: [usize; 2], surfaces: &mut Surfaces) -> Vec3 {
        let x = &self.elements.nodes;
        let it = Node {
            classes: &self.meeting_at[below],
            is_fixed: self.elements.is_fixed[node],
            edge: self.edges[node],
            home: self.homes[node],
            reach: if node == above { 1.5 * self.thickness } else { 0.0 },
        };
        let mut from = x[above];
        if node == above {
            let first = self.elements.skin.as_ref().map_or(0, |skin| skin.first_node);
            let cuts = |node: usize| self.elements.is_fixed[node];
            let is_on = |other: &&u32| {
                **other as usize >= first
                    && (cuts(node) == cuts(**other as usize) || cuts(node) == [false; 3])
            };
            let on: Vec<u32> = self.neighbours[node].iter().filter(is_on).copied().collect();
            if !on.is_empty() {
                let middle = on.iter().map(|other| x[*other as usize]).sum::<Vec3>() / on.len() as f64;
                from = (from + middle) * 0.5;
            }
        }
        (0..3).filter(|k| it.is_fixed[*k]).for_each(|k| from[k] = it.home[k]);
        let (outer, normal) = surfaces.project_outwards(&it, &from);
        if node == above {
            return it.bounded(outer);
        }
        let inner = x[above] - normal * self.thickness;
        it.bounded(surfaces.project_along(&it, &inner, &normal))
    }

    /// A node between classes goes half way to the middle of its neighbours on the same surface, and back onto it.
    fn on_surface(&self, node: usize, surfaces: &mut Surfaces) -> Vec3 {
        let classes = &self.meeting[node];
        let x = &self.elements.nodes;
        let is_on = |other: &&u32| classes.iter().all(|class| self.meeting[**other as usize].contains(class));
        let on: Vec<u32> = self.neighbours[node].iter().filter(is_on).copied().collect();
        let mut from = x[node];
        if on.len() > 1 {
            let middle = on.iter().map(|other| x[*other as usize]).sum::<Vec3>() / on.len() as f64;
            from = (from + middle) * 0.5;
        }
        let is_fixed = self.elements.is_fixed[node];
        let home = self.homes[node];
        (0..3).filter(|k| is_fixed[*k]).for_each(|k| from[k] = home[k]);
        let it = Node { classes, is_fixed, edge: self.edges[node], home, reach: 0.0 };
        surfaces.project(&it, &from)
    }

    /// Moves a node as far towards `target` as the limit allows; returns whether it did.
    fn try_move(&mut self, node: usize, mut target: Vec3, least: f64) -> bool {
        let from = self.elements.nodes[node];
        let (is_fixed, home) = (self.elements.is_fixed[node], self.homes[node]);
        (0..3).filter(|k| is_fixed[*k]).for_each(|k| target[k] = home[k]);
        if (target - from).norm() < 1e-6 * self.edges[node] {
            return false;
        }
        let before: Vec<f64> = self.changed[node].iter().map(|e| self.unsound[*e as usize]).collect();
        for fraction in FRACTIONS {
            self.place(node, from + (target - from) * fraction);
            let is_sound = |(e, before): (&u32, &f64)| self.is_sound(*e as usize, least.min(*before));
            if self.changed[node].iter().zip(&before).all(is_sound) {
                self.note_better(node, &before);
                return true;
            }
        }
        self.place(node, from);
        false
    }

    /// What the unsound elements at a node have become.
    fn note_better(&mut self, node: usize, before: &[f64]) {
        for i in (0..before.len()).filter(|i| before[*i].is_finite()) {
            let element = self.changed[node][i] as usize;
            let hex = self.elements.hexes[element].map(|node| self.elements.nodes[node as usize]);
            self.unsound[element] = unsoundness(&hex);
        }
    }

    fn place(&mut self, node: usize, x: Vec3) {
        let Elements { nodes, hanging, .. } = &mut *self.elements;
        nodes[node] = x;
        for &follower in &self.followers[node] {
            nodes[follower as usize] = middle(nodes, &hanging[&follower]);
        }
    }

    /// Whether an element has a scaled Jacobian of at least `least`, and no edge that is too short.
    fn is_sound(&self, element: usize, least: f64) -> bool {
        let hex = &self.elements.hexes[element];
        let (jacobian, edge) = quality(&hex.map(|node| self.elements.nodes[node as usize]));
        jacobian >= least && edge >= self.shortest[element]
    }
}

/// The middle of some nodes [m].
fn middle(nodes: &[Vec3], on: &[u32]) -> Vec3 {
    on.iter().map(|node| nodes[*node as usize]).sum::<Vec3>() / on.len() as f64
}

/// Puts hanging nodes into the middle of what they hang on.
pub fn follow(nodes: &mut [Vec3], hanging: &BTreeMap<u32, Vec<u32>>) {
    for (&node, on) in hanging {
        nodes[node as usize] = middle(nodes, on);
    }
}
