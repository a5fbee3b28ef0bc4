//! Boundary surface of a mesh: its outward faces, quadrilaterals and triangles.
//!
//! A triangle is a quadrilateral with its last corner repeated. Its bilinear map is the linear one of the triangle, so
//! areas and volumes by the rules for quadrilaterals are exact, and contact recognises it as a triangle.

use super::cell::{CellFace, CellKind};
use super::cells::{Cell, Cells};
use crate::mechanics::tensor::Vec3;
use std::fmt;

/// The boundary surface: faces that belong to one element only, in the order of their elements.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Boundary {
    /// Corner nodes of each face, counter-clockwise seen from outside. A side of a quadratic cell is four triangles here.
    pub faces: Vec<[u32; 4]>,
    /// Element of each face.
    pub owner: Vec<u32>,
    /// Local face number in that element, an index into the faces of its kind.
    pub side: Vec<u8>,
}

impl Boundary {
    /// The boundary surface of these elements. Faces used more than once are inside; what else may be wrong with them,
    /// [`topology_problems`] says.
    pub fn of(cells: &Cells) -> Self {
        let mut outer: Vec<(u32, u8)> = face_groups(&sorted_faces(cells))
            .filter(|group| group.len() == 1)
            .map(|group| (group[0].element, group[0].side))
            .collect();
        outer.sort_unstable();
        let mut boundary = Self::default();
        for (owner, side) in outer {
            let cell = cells.get(owner as usize);
            for facet in side_of(cell.kind, side).facets {
                boundary.faces.push(facet.map(|i| cell.nodes[i]));
                boundary.owner.push(owner);
                boundary.side.push(side);
            }
        }
        boundary
    }
}

/// The faces that belong to one element only, counter-clockwise seen from outside, in the order of their elements.
pub fn boundary(cells: &Cells) -> Vec<[u32; 4]> {
    Boundary::of(cells).faces
}

/// The nodes of these faces, sorted and without repetition.
pub fn boundary_nodes(faces: &[[u32; 4]]) -> Vec<u32> {
    let mut nodes: Vec<u32> = faces.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The faces whose corners are all in a node set (sorted, as in [`Mesh::node_sets`]).
///
/// [`Mesh::node_sets`]: crate::mesh::Mesh::node_sets
pub fn faces_within(faces: &[[u32; 4]], node_set: &[u32]) -> Vec<[u32; 4]> {
    faces.iter().filter(|face| face.iter().all(|a| node_set.binary_search(a).is_ok())).copied().collect()
}

/// 4 N_a [-] of the four nodes of a bilinear face, and x,ξ × x,η [m²], at the points of the 2×2 Gauss rule.
fn gauss_points(face: &[u32; 4], positions: &[Vec3]) -> [([f64; 4], Vec3); 4] {
    let x = face.map(|a| positions[a as usize]);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(xi, eta)| {
        let (xi, eta) = (xi / 3.0_f64.sqrt(), eta / 3.0_f64.sqrt());
        let along_xi = ((x[1] - x[0]) * (1.0 - eta) + (x[2] - x[3]) * (1.0 + eta)) * 0.25;
        let along_eta = ((x[3] - x[0]) * (1.0 - xi) + (x[2] - x[1]) * (1.0 + xi)) * 0.25;
        let shape = [
            (1.0 - xi) * (1.0 - eta),
            (1.0 + xi) * (1.0 - eta),
            (1.0 + xi) * (1.0 + eta),
            (1.0 - xi) * (1.0 + eta),
        ];
        (shape, along_xi.cross(&along_eta))
    })
}

/// Tributary area [m²] of each node of `positions` [m]; zero off the surface.
///
/// A_a = ∫ N_a ‖x,ξ × x,η‖ dξ dη over the faces around the node, by the 2×2 Gauss rule (exact on parallelograms); the
/// sum over the nodes is the area of the surface by the same rule.
pub fn tributary_areas(faces: &[[u32; 4]], positions: &[Vec3]) -> Vec<f64> {
    let mut areas = vec![0.0; positions.len()];
    for face in faces {
        for (shape, normal) in gauss_points(face, positions) {
            let area = normal.norm();
            for (a, n) in face.iter().zip(shape) {
                areas[*a as usize] += 0.25 * n * area;
            }
        }
    }
    areas
}

/// Whether faces run along each edge once in each direction, as on a closed surface.
#[cfg(test)]
pub(super) fn is_closed(faces: &[[u32; 4]]) -> bool {
    let mut edges = std::collections::BTreeMap::<(u32, u32), i32>::new();
    for face in faces {
        for i in 0..4 {
            let (a, b) = (face[i], face[(i + 1) % 4]);
            if a != b {
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
        }
    }
    edges.values().all(|sum| *sum == 0)
}

/// Volume [m³] enclosed by a closed surface, by Gauss' theorem; positive for outward faces.
///
/// V = ⅓ ∮ x · n dA over the bilinear faces. The integrand x · (x,ξ × x,η) is quadratic in ξ and in η, so that the 2×2
/// Gauss rule is exact: this equals the sum of the trilinear elements inside.
#[cfg(test)]
pub(super) fn enclosed_volume_m3(faces: &[[u32; 4]], positions: &[Vec3]) -> f64 {
    let of_face = |face: &[u32; 4]| {
        let of_point = |(shape, normal): ([f64; 4], Vec3)| {
            let point: Vec3 = face.iter().zip(shape).map(|(a, n)| positions[*a as usize] * (0.25 * n)).sum();
            point.dot(&normal) / 3.0
        };
        gauss_points(face, positions).map(of_point).iter().sum::<f64>()
    };
    faces.iter().map(of_face).sum()
}

/// A defect in the topology of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TopologyProblem {
    /// Two elements with the same corners: the mass would count twice.
    DuplicateElement {
        /// The first element in the list.
        first: u32,
        /// The element that repeats it.
        second: u32,
    },
    /// An element that uses a node twice.
    RepeatedNode {
        /// Index of the element in the mesh, from 0.
        element: u32,
        /// Index of the node in the mesh, from 0.
        node: u32,
    },
    /// A face shared by three or more elements.
    FaceSharedByMany {
        /// Indices of the elements.
        elements: Vec<u32>,
    },
    /// Two neighbours on the same side of their common face: one of them is inverted, or they overlap.
    SameSideOfFace {
        /// Indices of the two elements.
        elements: [u32; 2],
    },
    /// Two neighbours that share the corners of a face, but not its mid-side nodes: they separate there.
    NodesBetweenCorners {
        /// Indices of the two elements.
        elements: [u32; 2],
    },
}

impl fmt::Display for TopologyProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DuplicateElement { first, second } => {
                write!(f, "element {second} has the same nodes as element {first}")
            }
            Self::RepeatedNode { element, node } => write!(f, "element {element} names node {node} twice"),
            Self::FaceSharedByMany { elements } => write!(f, "elements {elements:?} share one face"),
            Self::SameSideOfFace { elements: [a, b] } => {
                write!(f, "elements {a} and {b} lie on the same side of their common face")
            }
            Self::NodesBetweenCorners { elements: [a, b] } => {
                write!(f, "elements {a} and {b} share the corners of a face, but not the nodes between them")
            }
        }
    }
}

/// All defects of the mesh topology, in the order of the elements; empty for a valid mesh.
pub fn topology_problems(cells: &Cells) -> Vec<TopologyProblem> {
    let mut problems = Vec::new();
    for (e, Cell { nodes, .. }) in cells.iter().enumerate() {
        if let Some(i) = (1..nodes.len()).find(|&i| nodes[..i].contains(&nodes[i])) {
            problems.push(TopologyProblem::RepeatedNode { element: e as u32, node: nodes[i] });
        }
    }
    let mut duplicate = vec![false; cells.len()];
    for (first, second) in duplicate_elements(cells) {
        duplicate[second as usize] = true;
        problems.push(TopologyProblem::DuplicateElement { first, second });
    }

    // A duplicate shares all its faces: it is reported once above, not for each of them.
    let mut shared: Vec<(u32, TopologyProblem)> = Vec::new();
    for group in face_groups(&sorted_faces(cells)) {
        let group: Vec<&Face> = group.iter().filter(|face| !duplicate[face.element as usize]).collect();
        let problem = match group[..] {
            [] | [_] => None,
            [a, b] => problem_between(cells, [a, b]),
            _ => Some(TopologyProblem::FaceSharedByMany {
                elements: group.iter().map(|face| face.element).collect(),
            }),
        };
        shared.extend(problem.map(|problem| (group[0].element, problem)));
    }
    shared.sort_by_key(|(first, _)| *first);
    problems.extend(shared.into_iter().map(|(_, problem)| problem));
    problems
}

/// Defect of two neighbours at their common face.
fn problem_between(cells: &Cells, faces: [&Face; 2]) -> Option<TopologyProblem> {
    let [(a, of_a), (b, of_b)] = faces.map(|face| {
        let cell = cells.get(face.element as usize);
        (cell.nodes, side_of(cell.kind, face.side))
    });
    let elements = faces.map(|face| face.element);
    if !opposite(chosen(a, of_a.corners), chosen(b, of_b.corners), of_a.corners.len()) {
        return Some(TopologyProblem::SameSideOfFace { elements });
    }
    if of_a.facets.len().max(of_b.facets.len()) == 1 {
        return None;
    }
    let all_nodes = |nodes: &[u32], face: &CellFace| {
        boundary_nodes(&face.facets.iter().map(|facet| facet.map(|i| nodes[i])).collect::<Vec<_>>())
    };
    let differ = all_nodes(a, of_a) != all_nodes(b, of_b);
    differ.then_some(TopologyProblem::NodesBetweenCorners { elements })
}

/// A face of an element, under its sorted corners; for a triangle the last one is not a node.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    key: [u32; 4],
    element: u32,
    side: u8,
}

/// All faces of all elements, equal faces adjacent.
fn sorted_faces(cells: &Cells) -> Vec<Face> {
    let count = cells.counts().iter().map(|(kind, count)| kind.table().faces.len() * count).sum();
    let mut faces = Vec::with_capacity(count);
    for (e, cell) in cells.iter().enumerate() {
        for (side, face) in (0..).zip(cell.kind.table().faces) {
            let mut key = chosen(cell.nodes, face.corners);
            key.sort_unstable();
            faces.push(Face { key, element: e as u32, side });
        }
    }
    faces.sort_unstable();
    faces
}

/// Up to four nodes of a cell, padded with `u32::MAX`.
fn chosen(nodes: &[u32], places: &[usize]) -> [u32; 4] {
    match *places {
        [a, b, c, d] => [nodes[a], nodes[b], nodes[c], nodes[d]],
        [a, b, c] => [nodes[a], nodes[b], nodes[c], u32::MAX],
        _ => [u32::MAX; 4],
    }
}

/// Groups of equal faces.
fn face_groups(sorted: &[Face]) -> impl Iterator<Item = &[Face]> {
    sorted.chunk_by(|a, b| a.key == b.key)
}

/// A face of a kind of cell.
fn side_of(kind: CellKind, side: u8) -> &'static CellFace {
    &kind.table().faces[usize::from(side)]
}

/// Whether two faces with the same `n` corners have opposite orientation.
fn opposite(a: [u32; 4], b: [u32; 4], n: usize) -> bool {
    let Some(start) = b.iter().position(|&node| node == a[0]) else { return false };
    (0..n).all(|i| a[i] == b[(start + n - i) % n])
}

/// Pairs (first, duplicate) of elements with the same corners, sorted.
fn duplicate_elements(cells: &Cells) -> Vec<(u32, u32)> {
    let key = |cell: Cell| {
        let (mut key, corners) = ([u32::MAX; 8], cell.kind.table().corners);
        key[..corners].copy_from_slice(&cell.nodes[..corners]);
        key.sort_unstable();
        key
    };
    let mut sorted: Vec<([u32; 8], u32)> = (0..).zip(cells.iter()).map(|(e, cell)| (key(cell), e)).collect();
    sorted.sort_unstable();
    let mut pairs: Vec<(u32, u32)> = sorted
        .chunk_by(|a, b| a.0 == b.0)
        .flat_map(|run| run[1..].iter().map(|again| (run[0].1, again.1)))
        .collect();
    pairs.sort_unstable();
    pairs
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::super::generate::hollow_ball::HollowBall;
    use super::*;

    #[test]
    fn boundary_of_a_block_is_its_six_sides() {
        let mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(3.0, 2.0, 1.0), [3, 2, 2], "b").generate().unwrap();
        let boundary = Boundary::of(&mesh.cells);
        assert_eq!(boundary.faces.len(), 2 * (3 * 2 + 3 * 2 + 2 * 2));
        assert!((enclosed_volume_m3(&boundary.faces, &mesh.nodes) - 6.0).abs() < 1e-13);
        let areas = tributary_areas(&boundary.faces, &mesh.nodes);
        assert!((areas.iter().sum::<f64>() - 22.0).abs() < 1e-13);
        for (face, (&owner, &side)) in boundary.faces.iter().zip(boundary.owner.iter().zip(&boundary.side)) {
            let cell = mesh.cells.get(owner as usize);
            let [facet] = side_of(cell.kind, side).facets else { panic!("a hexahedron has plain faces") };
            assert_eq!(*face, facet.map(|i| cell.nodes[i]));
        }
        assert_eq!(boundary_nodes(&boundary.faces).len(), 4 * 3 * 3 - 2, "all but the two nodes inside");
    }

    #[test]
    fn a_shell_has_an_outer_and_an_inner_boundary() {
        let ball = HollowBall {
            center_m: [0.1, -0.2, 0.3],
            outer_radius_m: 0.015,
            inner_radius_m: 0.012,
            elements_around: 4,
            elements_through: 2,
        };
        let mesh = ball.generate().unwrap();
        let faces = boundary(&mesh.cells);
        assert_eq!(faces.len(), 2 * 6 * 16);
        let volume = enclosed_volume_m3(&faces, &mesh.nodes);
        assert!((volume - mesh.volume_m3()).abs() < 1e-12 * volume);
        assert!(topology_problems(&mesh.cells).is_empty());
    }

    #[test]
    fn each_topology_problem_is_found_once() {
        let problems = |hexes: &[[u32; 8]]| topology_problems(&Cells::from(hexes.to_vec()));
        let a = [0, 1, 2, 3, 4, 5, 6, 7];
        let above = [4, 5, 6, 7, 8, 9, 10, 11];
        let turned = [6, 7, 4, 5, 2, 3, 0, 1];
        assert_eq!(problems(&[a, above]), []);
        assert_eq!(
            problems(&[a, above, turned]),
            [TopologyProblem::DuplicateElement { first: 0, second: 2 }]
        );

        let third = [4, 5, 6, 7, 12, 13, 14, 15];
        assert_eq!(
            problems(&[a, above, third]),
            [TopologyProblem::FaceSharedByMany { elements: vec![0, 1, 2] }]
        );

        let folded_back = [12, 13, 14, 15, 4, 5, 6, 7];
        assert_eq!(problems(&[a, folded_back]), [TopologyProblem::SameSideOfFace { elements: [0, 1] }]);

        let pinched = [4, 5, 6, 7, 8, 9, 10, 10];
        assert!(problems(&[pinched]).contains(&TopologyProblem::RepeatedNode { element: 0, node: 10 }));
    }
}
