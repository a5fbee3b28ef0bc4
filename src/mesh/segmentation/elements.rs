//! Hexahedra of the leaves of an octree, their nodes, and the faces between classes.

use super::grid::OUTSIDE;
use super::labelling::{BEYOND, behind};
use super::octree::{Leaf, Octree};
use crate::mechanics::element::HEX8_CORNERS;
use crate::mechanics::tensor::Vec3;
use crate::mesh::CellKind;
use std::collections::{BTreeMap, HashMap};

/// A face of an element behind which another class, the outside or the end of the box begins.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Its nodes, counter-clockwise seen from outside of the element.
    pub nodes: [u32; 4],
    /// The element that it is a face of, an index.
    pub element: u32,
    /// Class behind it, or [`BEYOND`].
    pub behind: u8,
    /// Which side of the element it is: 2 axis + 1 where it is the high one.
    pub side: u8,
}

/// The layer of elements that follow those of the leaves.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Number of nodes of the leaves: that of the first outer node.
    pub first_node: usize,
    /// Number of elements of the leaves: that of the first element of the layer.
    pub first_element: usize,
    /// Node below each outer node.
    pub below: Vec<u32>,
    /// Outer node above each node; only those of the surface have one.
    pub above: BTreeMap<u32, u32>,
    /// Element under each element of the layer.
    pub under: Vec<u32>,
}

/// The hexahedra of all leaves that are not outside.
#[derive(Clone, Debug, Default)]
pub struct Elements {
    /// Corner of the octree at which each node was.
    pub corners: Vec<[u32; 3]>,
    /// Positions of the nodes [m], from the low corner of the box along the axes of the scan.
    pub nodes: Vec<Vec3>,
    /// Classes of the octants around each node that does not hang.
    pub around: Vec<[u8; 8]>,
    /// For each node, the coordinates that are fixed, as it lies on a side of the box.
    pub is_fixed: Vec<[bool; 3]>,
    /// Nodes of each element.
    pub hexes: Vec<[u32; 8]>,
    /// Class of each element.
    pub classes: Vec<u8>,
    /// Longest edge of each element before nodes were moved [m].
    pub edges: Vec<f64>,
    /// For each hanging node, the ends of the edge or the corners of the face whose middle it is.
    pub hanging: BTreeMap<u32, Vec<u32>>,
    /// Faces between classes, of the finer element; all faces behind which nothing is.
    pub faces: Vec<Face>,
    /// The layer on the outer surface, if there is one.
    pub skin: Option<Skin>,
}

/// Side of the box, in the numbers of [`Face::side`], of each face of [`CellKind::Hex8`].
const SIDES: [usize; 6] = [4, 5, 2, 1, 3, 0];

impl Elements {
    /// The elements of the leaves of an octree with these classes.
    pub fn new(tree: &Octree, classes: &[u8]) -> Self {
        let mut out = Self::default();
        let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
        let mut corners: Vec<[u32; 3]> = Vec::new();
        for (leaf, &class) in tree.leaves.iter().zip(classes).filter(|(_, class)| **class != OUTSIDE) {
            let size = tree.size(leaf.level);
            let hex = HEX8_CORNERS.map(|c| {
                let corner = [0, 1, 2].map(|k| leaf.at[k] + if c[k] > 0.0 { size } else { 0 });
                *numbers.entry(corner).or_insert_with(|| {
                    corners.push(corner);
                    (corners.len() - 1) as u32
                })
            });
            out.hexes.push(hex);
            out.classes.push(class);
            out.edges.push(tree.edge(leaf.level));
        }
        for corner in &corners {
            out.nodes.push(tree.position(*corner));
            out.around.push(tree.around(*corner).map(|leaf| leaf.map_or(BEYOND, |leaf| classes[leaf])));
            out.is_fixed.push([0, 1, 2].map(|k| corner[k] == 0 || corner[k] == tree.cells[k]));
        }
        out.hanging = hanging(&corners, &out.hexes);
        out.corners = corners;
        out.find_faces(tree, classes);
        out
    }

    fn find_faces(&mut self, tree: &Octree, classes: &[u8]) {
        let leaves = tree.leaves.iter().zip(classes).filter(|(_, class)| **class != OUTSIDE);
        for (element, (leaf, &class)) in (0..).zip(leaves) {
            for (face, &side) in CellKind::Hex8.table().faces.iter().zip(&SIDES) {
                let found = face_class(tree, *leaf, side, classes);
                if let Some(behind) = found.filter(|behind| *behind != class) {
                    let hex = self.hexes[element as usize];
                    let nodes = std::array::from_fn(|i| hex[face.corners[i]]);
                    self.faces.push(Face { nodes, element, behind, side: side as u8 });
                }
            }
        }
    }
}

/// The nodes at the middle of an edge or a face of one of these elements, with the corners of that; `corners` has the corner of the
/// octree at which each node was.
pub fn hanging(corners: &[[u32; 3]], hexes: &[[u32; 8]]) -> BTreeMap<u32, Vec<u32>> {
    let used = hexes.iter().flatten().map(|&node| (corners[node as usize], node));
    let numbers: HashMap<[u32; 3], u32> = used.collect();
    let table = CellKind::Hex8.table();
    let mut out = BTreeMap::new();
    for hex in hexes {
        let sides = table.edges.iter().map(|e| &e[..]).chain(table.faces.iter().map(|f| f.corners));
        for side in sides {
            let on: Vec<u32> = side.iter().map(|&i| hex[i]).collect();
            let sums = [0, 1, 2].map(|k| on.iter().map(|&node| corners[node as usize][k]).sum::<u32>());
            let count = on.len() as u32;
            if sums.iter().all(|sum| sum % count == 0)
                && let Some(&middle) = numbers.get(&sums.map(|sum| sum / count))
            {
                out.entry(middle).or_insert(on);
            }
        }
    }
    out
}

/// Class behind a face; `None` where finer elements have it. Behind a coarse face with finer leaves that are all outside or all
/// beyond, it is theirs.
fn face_class(tree: &Octree, leaf: Leaf, side: usize, classes: &[u8]) -> Option<u8> {
    let behind = behind(tree, leaf, side);
    let class = |other: &Option<usize>| other.map_or(BEYOND, |other| classes[other]);
    let first = class(behind.first()?);
    let is_outside = behind.iter().all(|other| class(other) == OUTSIDE);
    (behind.len() == 1 || is_outside).then_some(first)
}
