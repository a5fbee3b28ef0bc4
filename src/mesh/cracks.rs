//! Nodes in the interior of an edge or a face of another element: a file does not say that they hang there, so that its elements would come
//! apart. Those in the middles are recognised as hanging nodes; others cannot be computed with.

use super::surface::{boundary, boundary_nodes};
use super::{ELEMENTS_OF_A_TASK, HangingNodes, Mesh};
use crate::mechanics::tensor::Vec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Largest distance of a node from the middle of an edge or face that it hangs on, over the length of the edge: files round.
const OF_MIDDLE: f64 = 1e-3;

/// Largest distance of a node from a face that it lies on, over the size of the face.
const OF_FACE: f64 = 1e-5;

/// Nodes that lie on elements of their own body without being a corner there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cracks {
    /// Number of such nodes.
    pub count: usize,
    /// One of them, and its position.
    pub example: (u32, Vec3),
}

/// Recognises nodes that hang in the middles of edges and faces of coarser hexahedra, and returns how many there are.
///
/// # Errors
/// Nodes elsewhere on a face or an edge of an element that is connected to theirs, or next to elements of other kinds.
pub fn recognise_hanging(mesh: &mut Mesh) -> Result<usize, Cracks> {
    let faces = boundary(&mesh.cells);
    let between = in_middles(&faces, &mesh.nodes);
    if let (Some(&node), None) = (between.keys().next(), mesh.cells.hexes()) {
        return Err(Cracks { count: between.len(), example: (node, mesh.nodes[node as usize]) });
    }
    let hanging = HangingNodes::new(between);
    let others = on_faces(mesh, &hanging.boundary(faces));
    if let Some(&node) = others.first() {
        return Err(Cracks { count: others.len(), example: (node, mesh.nodes[node as usize]) });
    }
    mesh.hanging = hanging;
    Ok(mesh.hanging.len())
}

/// Nodes in the middle of an edge whose halves are edges, too, and in the middle of a face whose quarters are faces; with the ends or
/// corners.
fn in_middles(faces: &[[u32; 4]], nodes: &[Vec3]) -> BTreeMap<u32, Vec<u32>> {
    let edges_of = |face: &[u32; 4]| {
        let edges = [0, 1, 2, 3].map(|i| [face[i], face[(i + 1) % 4]]);
        edges.into_iter().filter(|[a, b]| a != b)
    };
    let mut ends: Vec<[u32; 2]> =
        faces.iter().flat_map(edges_of).flat_map(|[a, b]| [[a, b], [b, a]]).collect();
    ends.sort_unstable();
    ends.dedup();
    let neighbours = |node: u32| {
        let from = ends.partition_point(|edge| edge[0] < node);
        ends[from..].iter().take_while(move |edge| edge[0] == node).map(|edge| edge[1])
    };
    let are_joined = |a: u32, b: u32| ends.binary_search(&[a, b]).is_ok();
    let is_middle = |node: u32, corners: &[u32]| {
        let x = |node: u32| nodes[node as usize];
        let mean = corners.iter().map(|&corner| x(corner)).sum::<Vec3>() / corners.len() as f64;
        (x(node) - mean).norm() <= OF_MIDDLE * (x(corners[1]) - x(corners[0])).norm()
    };
    let middle_of = |[a, b]: [u32; 2]| neighbours(a).find(|&m| are_joined(m, b) && is_middle(m, &[a, b]));
    let mut between = BTreeMap::new();
    for &[a, b] in ends.iter().filter(|[a, b]| a < b) {
        if let Some(middle) = middle_of([a, b]) {
            between.insert(middle, vec![a, b]);
        }
    }
    if between.is_empty() {
        return between;
    }
    let middles: BTreeMap<[u32; 2], u32> =
        between.iter().map(|(node, ends)| ([ends[0], ends[1]], *node)).collect();
    let mut centres = Vec::new();
    for face in faces {
        let middle = |[a, b]: [u32; 2]| middles.get(&[a.min(b), a.max(b)]).copied();
        let of_edges: Vec<u32> = edges_of(face).filter_map(middle).collect();
        let &[first, second, third, fourth] = &of_edges[..] else { continue };
        let is_centre = |node: &u32| {
            [second, third, fourth].iter().all(|&other| are_joined(*node, other)) && is_middle(*node, face)
        };
        centres.extend(neighbours(first).find(is_centre).map(|node| (node, face.to_vec())));
    }
    between.extend(centres);
    between
}

/// The nodes of a boundary that lie on faces of it, of which they are no corners; ascending. What touches without common nodes is contact.
fn on_faces(mesh: &Mesh, faces: &[[u32; 4]]) -> BTreeSet<u32> {
    let component = components(mesh);
    let at = |node: u32| mesh.nodes[node as usize];
    let mut sorted = boundary_nodes(faces);
    sorted.sort_by(|&a, &b| at(a).x.total_cmp(&at(b).x));
    let on_face = |face: &[u32; 4]| {
        let x = face.map(at);
        let (low, high) = x.iter().fold((x[0], x[0]), |(low, high), x| (low.inf(x), high.sup(x)));
        let margin = OF_FACE * (high - low).norm();
        let (low, high) = (low.add_scalar(-margin), high.add_scalar(margin));
        let from = sorted.partition_point(|&node| at(node).x < low.x);
        let near = sorted[from..].iter().copied().take_while(move |&node| at(node).x <= high.x);
        let is_in = move |y: Vec3| (1..3).all(|k| low[k] <= y[k] && y[k] <= high[k]);
        let triangles: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
        let touches =
            move |y: Vec3| triangles.iter().any(|corners| lies_on(y, corners.map(|i| x[i]), margin));
        let found: Vec<u32> = near
            .filter(|&node| is_in(at(node)) && !face.contains(&node))
            .filter(|&node| component[node as usize] == component[face[0] as usize] && touches(at(node)))
            .collect();
        found
    };
    faces.par_iter().with_min_len(ELEMENTS_OF_A_TASK).flat_map_iter(on_face).collect()
}

/// Whether a point lies on a triangle, farther than a margin from its corners.
fn lies_on(point: Vec3, [a, b, c]: [Vec3; 3], margin: f64) -> bool {
    let normal = (b - a).cross(&(c - a));
    let area = normal.norm();
    if area == 0.0 || (point - a).dot(&normal).abs() > margin * area {
        return false;
    }
    let is_inside = [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let edge = to - from;
        edge.cross(&(point - from)).dot(&normal) >= -margin * edge.norm() * area
    });
    is_inside && [a, b, c].iter().all(|corner| (point - corner).norm() > margin)
}

/// The least node of the group of a node.
fn first(leader: &mut [u32], mut node: u32) -> u32 {
    while leader[node as usize] != node {
        // Halves the way for the next search.
        leader[node as usize] = leader[leader[node as usize] as usize];
        node = leader[node as usize];
    }
    node
}

/// For each node the least node that elements connect it to.
fn components(mesh: &Mesh) -> Vec<u32> {
    let mut leader: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    for cell in mesh.cells.iter() {
        let own = first(&mut leader, cell.nodes[0]);
        for &node in cell.nodes {
            let (a, b) = (first(&mut leader, own), first(&mut leader, node));
            leader[a.max(b) as usize] = a.min(b);
        }
    }
    (0..mesh.nodes.len() as u32).map(|node| first(&mut leader, node)).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::CellKind;
    use super::super::generate::block::Block;
    use super::super::local_refinement::refined_in;
    use super::super::refinement_region::{Place, Region};
    use super::*;

    fn refined(size: f64) -> Mesh {
        let mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(8.0, 8.0, 4.0), [8, 8, 4], "b").generate().unwrap();
        let places = Place::on_all(&mesh, &[Vec3::new(4.0, 3.0, 4.0)]);
        refined_in(&mesh, &[Region { places, within: 1.2, size }], 1_000_000).unwrap().0
    }

    #[test]
    fn hanging_nodes_of_a_refined_mesh_are_those_that_it_was_made_with() {
        for size in [0.5, 0.25] {
            let original = refined(size);
            assert!(original.hanging.len() > 20);
            let mut read = Mesh { hanging: HangingNodes::default(), ..original.clone() };
            // As rounded by a file.
            read.nodes.iter_mut().for_each(|x| *x = x.map(|x| f64::from((0.1 * x) as f32)));
            assert_eq!(recognise_hanging(&mut read), Ok(original.hanging.len()));
            let sorted = |hanging: &HangingNodes| {
                let pair = |(node, on): (u32, &[u32])| (node, on.iter().copied().collect::<BTreeSet<u32>>());
                hanging.each().map(pair).collect::<Vec<_>>()
            };
            assert_eq!(sorted(&read.hanging), sorted(&original.hanging));
        }
    }

    #[test]
    fn meshes_without_hanging_nodes_have_none() {
        let block =
            Block::uniform(Vec3::zeros(), Vec3::new(1.0, 2.0, 0.3), [4, 3, 2], "b").generate().unwrap();
        for kind in CellKind::ALL {
            assert_eq!(recognise_hanging(&mut block.split_to(kind)), Ok(0));
        }
    }

    #[test]
    fn nodes_elsewhere_on_a_face_are_refused() {
        let mut mesh = refined(0.5);
        let (node, on) =
            mesh.hanging.each().find(|(_, on)| on.len() == 4).map(|(node, on)| (node, on.to_vec())).unwrap();
        let corner = mesh.nodes[on[0] as usize];
        mesh.nodes[node as usize] = mesh.nodes[node as usize] * 0.8 + corner * 0.2;
        mesh.hanging = HangingNodes::default();
        let found = recognise_hanging(&mut mesh).unwrap_err();
        assert_eq!((found.count, found.example.0), (1, node));
        // Tetrahedra with hanging nodes.
        let mut split = refined(0.5).split_to_tetrahedra();
        split.hanging = HangingNodes::default();
        assert!(recognise_hanging(&mut split).unwrap_err().count > 5);
    }

    #[test]
    fn what_touches_without_common_nodes_is_contact() {
        let size = Vec3::new(1.0, 1.0, 1.0);
        let mut mesh = Block::uniform(Vec3::zeros(), size, [1, 1, 1], "a").generate().unwrap();
        let other = Block::uniform(Vec3::z(), Vec3::new(1.0, 1.0, 2.0), [2, 2, 1], "a").generate().unwrap();
        let count = mesh.nodes.len() as u32;
        mesh.nodes.extend(&other.nodes);
        mesh.cells.extend(other.cells.map(|node| node + count).iter());
        mesh.part_of.extend(&other.part_of);
        assert_eq!(recognise_hanging(&mut mesh), Ok(0));
    }
}
