//! The skin of a mesh: its outward quadrilateral faces.

use super::hexahedron::FACES;
use crate::mechanics::tensor::Vec3;
use std::fmt;

/// The faces that belong to one element only, in the order of their elements.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Skin {
    /// Corner nodes of each face, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 4]>,
    /// Element that each face belongs to.
    pub owner: Vec<u32>,
    /// Which face of its owner each is, an index into [`FACES`].
    pub side: Vec<u8>,
}

impl Skin {
    /// The skin of these elements. Faces used more than once are inside; what else may be wrong with them,
    /// [`topology_problems`] says.
    pub fn of(hexes: &[[u32; 8]]) -> Self {
        let mut outer: Vec<(u32, u8)> = face_groups(&sorted_faces(hexes))
            .filter(|group| group.len() == 1)
            .map(|group| (group[0].element, group[0].side))
            .collect();
        outer.sort_unstable();
        Self {
            faces: outer.iter().map(|&(e, side)| face_of(&hexes[e as usize], side)).collect(),
            owner: outer.iter().map(|&(e, _)| e).collect(),
            side: outer.iter().map(|&(_, side)| side).collect(),
        }
    }
}

/// The faces that belong to one element only, counter-clockwise seen from outside, in the order of their elements.
pub fn skin(hexes: &[[u32; 8]]) -> Vec<[u32; 4]> {
    Skin::of(hexes).faces
}

/// The nodes of these faces, sorted and without repetition.
pub fn skin_nodes(faces: &[[u32; 4]]) -> Vec<u32> {
    let mut nodes: Vec<u32> = faces.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The faces all of whose corners are in a node set (sorted, as in [`Mesh::node_sets`]).
///
/// [`Mesh::node_sets`]: crate::mesh::Mesh::node_sets
pub fn faces_within(faces: &[[u32; 4]], node_set: &[u32]) -> Vec<[u32; 4]> {
    faces.iter().filter(|face| face.iter().all(|a| node_set.binary_search(a).is_ok())).copied().collect()
}

/// Area [m²] that each node stands for, one a node of `positions` [m]; zero off the surface.
///
/// A_a = ∫ N_a ‖x,ξ × x,η‖ dξ dη over the faces around the node, by the 2×2 Gauss rule (exact on parallelograms); the
/// sum over the nodes is the area of the surface by the same rule.
pub fn tributary_areas(faces: &[[u32; 4]], positions: &[Vec3]) -> Vec<f64> {
    let mut areas = vec![0.0; positions.len()];
    for face in faces {
        let x = face.map(|a| positions[a as usize]);
        for (xi, eta) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let (xi, eta) = (xi / 3.0_f64.sqrt(), eta / 3.0_f64.sqrt());
            let along_xi = ((x[1] - x[0]) * (1.0 - eta) + (x[2] - x[3]) * (1.0 + eta)) * 0.25;
            let along_eta = ((x[3] - x[0]) * (1.0 - xi) + (x[2] - x[1]) * (1.0 + xi)) * 0.25;
            let area = along_xi.cross(&along_eta).norm();
            let shape = [
                (1.0 - xi) * (1.0 - eta),
                (1.0 + xi) * (1.0 - eta),
                (1.0 + xi) * (1.0 + eta),
                (1.0 - xi) * (1.0 + eta),
            ];
            for (a, n) in face.iter().zip(shape) {
                areas[*a as usize] += 0.25 * n * area;
            }
        }
    }
    areas
}

/// Volume [m³] that a closed surface encloses, by Gauss' theorem; positive when the faces look outwards.
///
/// V = ⅓ ∮ x · n dA over the bilinear faces. The integrand x · (x,ξ × x,η) is quadratic in ξ and in η, so that the 2×2
/// Gauss rule is exact: this equals the sum of the trilinear elements inside.
pub fn enclosed_volume_m3(faces: &[[u32; 4]], positions: &[Vec3]) -> f64 {
    let mut volume = 0.0;
    for face in faces {
        let x = face.map(|a| positions[a as usize]);
        for (xi, eta) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let (xi, eta) = (xi / 3.0_f64.sqrt(), eta / 3.0_f64.sqrt());
            let along_xi = ((x[1] - x[0]) * (1.0 - eta) + (x[2] - x[3]) * (1.0 + eta)) * 0.25;
            let along_eta = ((x[3] - x[0]) * (1.0 - xi) + (x[2] - x[1]) * (1.0 + xi)) * 0.25;
            let low = x[0] * (1.0 - xi) + x[1] * (1.0 + xi);
            let high = x[3] * (1.0 - xi) + x[2] * (1.0 + xi);
            let point = (low * (1.0 - eta) + high * (1.0 + eta)) * 0.25;
            volume += point.dot(&along_xi.cross(&along_eta)) / 3.0;
        }
    }
    volume
}

/// Something that the topology of a mesh cannot be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TopologyProblem {
    /// Two elements with the same eight nodes: the mass would count twice.
    DuplicateElement {
        /// The element first in the list.
        first: u32,
        /// The one that repeats it.
        second: u32,
    },
    /// An element that names a node twice.
    RepeatedNode {
        /// The element.
        element: u32,
        /// The node.
        node: u32,
    },
    /// A face shared by three elements or more.
    FaceSharedByMany {
        /// All of them.
        elements: Vec<u32>,
    },
    /// Two neighbours whose common face looks the same way from both: one of them is inside out, or they overlap.
    SameSideOfFace {
        /// The two elements.
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
        }
    }
}

/// All that is wrong with how the elements hang together, in the order of the elements; empty for a sound mesh.
pub fn topology_problems(hexes: &[[u32; 8]]) -> Vec<TopologyProblem> {
    let mut problems = Vec::new();
    for (e, hex) in hexes.iter().enumerate() {
        if let Some(i) = (1..8).find(|&i| hex[..i].contains(&hex[i])) {
            problems.push(TopologyProblem::RepeatedNode { element: e as u32, node: hex[i] });
        }
    }
    let mut duplicate = vec![false; hexes.len()];
    for (first, second) in duplicate_elements(hexes) {
        duplicate[second as usize] = true;
        problems.push(TopologyProblem::DuplicateElement { first, second });
    }

    // A duplicate shares all its faces: it is reported once above, not six times here.
    let mut shared = Vec::new();
    for group in face_groups(&sorted_faces(hexes)) {
        let group: Vec<&Face> = group.iter().filter(|face| !duplicate[face.element as usize]).collect();
        match group[..] {
            [] | [_] => {}
            [a, b]
                if opposite(
                    face_of(&hexes[a.element as usize], a.side),
                    face_of(&hexes[b.element as usize], b.side),
                ) => {}
            [a, b] => shared.push(TopologyProblem::SameSideOfFace { elements: [a.element, b.element] }),
            _ => shared.push(TopologyProblem::FaceSharedByMany {
                elements: group.iter().map(|face| face.element).collect(),
            }),
        }
    }
    shared.sort_by_key(|problem| match problem {
        TopologyProblem::SameSideOfFace { elements } => elements[0],
        TopologyProblem::FaceSharedByMany { elements } => elements[0],
        _ => u32::MAX,
    });
    problems.extend(shared);
    problems
}

/// One side of one element, under the sorted nodes of that face.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    key: [u32; 4],
    element: u32,
    side: u8,
}

/// All faces of all elements, equal faces next to each other.
fn sorted_faces(hexes: &[[u32; 8]]) -> Vec<Face> {
    let mut faces = Vec::with_capacity(hexes.len() * 6);
    for (e, hex) in hexes.iter().enumerate() {
        for side in 0..6 {
            let mut key = face_of(hex, side);
            key.sort_unstable();
            faces.push(Face { key, element: e as u32, side });
        }
    }
    faces.sort_unstable();
    faces
}

/// The runs of equal faces.
fn face_groups(sorted: &[Face]) -> impl Iterator<Item = &[Face]> {
    sorted.chunk_by(|a, b| a.key == b.key)
}

/// The nodes of one side of an element, counter-clockwise seen from outside.
fn face_of(hex: &[u32; 8], side: u8) -> [u32; 4] {
    FACES[usize::from(side)].map(|i| hex[i])
}

/// Whether two faces of the same four nodes run round in opposite senses.
fn opposite(a: [u32; 4], b: [u32; 4]) -> bool {
    let Some(start) = b.iter().position(|&node| node == a[0]) else { return false };
    (0..4).all(|i| a[i] == b[(start + 4 - i) % 4])
}

/// Pairs (first, repetition) of elements with the same nodes, sorted.
fn duplicate_elements(hexes: &[[u32; 8]]) -> Vec<(u32, u32)> {
    let mut sorted: Vec<([u32; 8], u32)> = hexes
        .iter()
        .enumerate()
        .map(|(e, hex)| {
            let mut key = *hex;
            key.sort_unstable();
            (key, e as u32)
        })
        .collect();
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
    fn skin_of_a_block_is_its_six_sides() {
        let mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(3.0, 2.0, 1.0), [3, 2, 2], "b").generate().unwrap();
        let skin = Skin::of(&mesh.hexes);
        assert_eq!(skin.faces.len(), 2 * (3 * 2 + 3 * 2 + 2 * 2));
        assert!((enclosed_volume_m3(&skin.faces, &mesh.nodes) - 6.0).abs() < 1e-13);
        let areas = tributary_areas(&skin.faces, &mesh.nodes);
        assert!((areas.iter().sum::<f64>() - 22.0).abs() < 1e-13);
        for (face, (&owner, &side)) in skin.faces.iter().zip(skin.owner.iter().zip(&skin.side)) {
            assert_eq!(*face, face_of(&mesh.hexes[owner as usize], side));
        }
        assert_eq!(skin_nodes(&skin.faces).len(), 4 * 3 * 3 - 2, "all but the two nodes inside");
    }

    #[test]
    fn a_shell_has_an_outer_and_an_inner_skin() {
        let ball = HollowBall {
            center: Vec3::new(0.1, -0.2, 0.3),
            outer_radius_m: 0.015,
            inner_radius_m: 0.012,
            elements_around: 4,
            elements_through: 2,
            part: "rubber".into(),
        };
        let mesh = ball.generate().unwrap();
        let faces = skin(&mesh.hexes);
        assert_eq!(faces.len(), 2 * 6 * 16);
        let volume = enclosed_volume_m3(&faces, &mesh.nodes);
        assert!((volume - mesh.volume_m3()).abs() < 1e-12 * volume);
        assert!(topology_problems(&mesh.hexes).is_empty());
    }

    #[test]
    fn each_topology_problem_is_found_once() {
        let a = [0, 1, 2, 3, 4, 5, 6, 7];
        let above = [4, 5, 6, 7, 8, 9, 10, 11];
        let turned = [6, 7, 4, 5, 2, 3, 0, 1];
        assert_eq!(topology_problems(&[a, above]), []);
        assert_eq!(
            topology_problems(&[a, above, turned]),
            [TopologyProblem::DuplicateElement { first: 0, second: 2 }]
        );

        let third = [4, 5, 6, 7, 12, 13, 14, 15];
        let problems = topology_problems(&[a, above, third]);
        assert_eq!(problems, [TopologyProblem::FaceSharedByMany { elements: vec![0, 1, 2] }]);

        let folded_back = [12, 13, 14, 15, 4, 5, 6, 7];
        let problems = topology_problems(&[a, folded_back]);
        assert_eq!(problems, [TopologyProblem::SameSideOfFace { elements: [0, 1] }]);

        let pinched = [4, 5, 6, 7, 8, 9, 10, 10];
        assert!(
            topology_problems(&[pinched]).contains(&TopologyProblem::RepeatedNode { element: 0, node: 10 })
        );
    }
}
