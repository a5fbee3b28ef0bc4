//! Meshes that are their own mirror image in a plane normal to a coordinate axis.

use super::Mesh;
use crate::mechanics::tensor::Vec3;
use std::collections::HashMap;

/// Distance within which a node is the mirror image of another one, relative to the size of the mesh [-].
const COINCIDENT: f64 = 1e-9;
/// Edge of the cells in which nodes are looked up, relative to the size of the mesh [-].
const CELL: f64 = 1e-4;

/// The plane in which the coordinate `axis` is `at` [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// 0, 1 or 2: x, y or z.
    pub axis: usize,
    /// Its coordinate [m].
    pub at: f64,
}

impl MirrorPlane {
    /// Mirror image of a point [m].
    pub fn image(&self, mut x: Vec3) -> Vec3 {
        x[self.axis] = 2.0 * self.at - x[self.axis];
        x
    }
    /// A point, or its mirror image, that is above the plane by `least` at least [m].
    pub fn above(&self, mut x: Vec3, least: f64) -> Vec3 {
        let height = x[self.axis] - self.at;
        if height < least {
            x[self.axis] = self.at + height.abs().max(least);
        }
        x
    }
    /// Mirror image of a direction.
    pub fn reflected(&self, mut direction: Vec3) -> Vec3 {
        direction[self.axis] = -direction[self.axis];
        direction
    }
}

/// Mirror images of the nodes and elements of a mesh in a plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MirrorImages {
    /// Mirror image of each node; its own on the plane.
    pub nodes: Vec<u32>,
    /// Mirror image of each element; no element is its own.
    pub elements: Vec<u32>,
}

impl MirrorImages {
    /// `None` if the mesh is not its own mirror image, or an element extends across the plane.
    pub fn new(mesh: &Mesh, plane: MirrorPlane) -> Option<Self> {
        let [low, high] = mesh.bounding_box()?;
        let size = (high - low).norm();
        let near = COINCIDENT * size;
        if (low[plane.axis] + high[plane.axis] - 2.0 * plane.at).abs() > near {
            return None;
        }
        let lookup = Lookup::new(&mesh.nodes, CELL * size);
        let nodes: Vec<u32> = (0_u32..)
            .zip(&mesh.nodes)
            .map(|(node, x)| {
                let image = plane.image(*x);
                // A node on the plane is its own image, whatever is next to it.
                if (image - x).norm() <= near { Some(node) } else { lookup.find(&mesh.nodes, &image, near) }
            })
            .collect::<Option<_>>()?;
        let is_mirrored_back = (0_u32..).zip(&nodes).all(|(node, image)| nodes[*image as usize] == node);
        let hanging: HashMap<u32, &[u32]> = mesh.hanging.each().collect();
        let hangs_alike = hanging.iter().all(|(node, others)| {
            let image = sorted(others.iter().map(|other| nodes[*other as usize]));
            hanging
                .get(&nodes[*node as usize])
                .is_some_and(|of_image| sorted(of_image.iter().copied()) == image)
        });
        if !(is_mirrored_back && hangs_alike) {
            return None;
        }
        let elements = elements(mesh, plane, &nodes)?;
        Some(Self { nodes, elements })
    }
}

/// Mirror image of each element; `None` if one has none, or is its own.
fn elements(mesh: &Mesh, plane: MirrorPlane, images: &[u32]) -> Option<Vec<u32>> {
    let at_nodes = AtNodes::new(mesh);
    let image_of = |(element, nodes): (usize, &[u32])| {
        let image_nodes = sorted(nodes.iter().map(|node| images[*node as usize]));
        let has_these = |other: &&u32| {
            let others = mesh.cells.nodes(**other as usize);
            let may_have = others.iter().all(|node| image_nodes.contains(node));
            may_have && sorted(others.iter().copied()) == image_nodes
        };
        let image = *at_nodes.of(*image_nodes.first()?).iter().rev().find(has_these)?;
        // It lies on one side: none of its nodes is across the plane from another, and not all are on it.
        let off = nodes.iter().filter(|node| images[**node as usize] != **node);
        let mut above = off.map(|node| mesh.nodes[*node as usize][plane.axis] > plane.at);
        let is_on_one_side = above.next().is_some_and(|first| above.all(|other| other == first));
        let is_alike = mesh.cells.kind(element) == mesh.cells.kind(image as usize);
        (is_on_one_side && is_alike).then_some(image)
    };
    mesh.cells.iter().enumerate().map(|(element, cell)| image_of((element, cell.nodes))).collect()
}

fn sorted(nodes: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut nodes: Vec<u32> = nodes.collect();
    nodes.sort_unstable();
    nodes
}

/// The elements at each node, ascending.
struct AtNodes {
    /// Where those of a node begin, and at last where those of all end.
    first: Vec<usize>,
    elements: Vec<u32>,
}

impl AtNodes {
    fn new(mesh: &Mesh) -> Self {
        let mut first = vec![0; mesh.nodes.len() + 1];
        mesh.cells.connectivity().iter().for_each(|node| first[*node as usize + 1] += 1);
        for node in 0..mesh.nodes.len() {
            first[node + 1] += first[node];
        }
        let (mut next, mut elements) = (first.clone(), vec![0; mesh.cells.connectivity().len()]);
        for (element, cell) in (0_u32..).zip(mesh.cells.iter()) {
            for node in cell.nodes {
                elements[next[*node as usize]] = element;
                next[*node as usize] += 1;
            }
        }
        Self { first, elements }
    }

    fn of(&self, node: u32) -> &[u32] {
        &self.elements[self.first[node as usize]..self.first[node as usize + 1]]
    }
}

/// Nodes by the cell of a grid that they lie in.
struct Lookup {
    edge: f64,
    /// Cell and node, in ascending order.
    cells: Vec<([i64; 3], u32)>,
}

impl Lookup {
    fn new(nodes: &[Vec3], edge: f64) -> Self {
        let mut cells: Vec<_> = nodes.iter().map(|x| Self::cell(x, edge)).zip(0_u32..).collect();
        cells.sort_unstable();
        Self { edge, cells }
    }

    #[allow(clippy::cast_possible_truncation)] // a mesh has some 10⁴ cells along an axis
    fn cell(x: &Vec3, edge: f64) -> [i64; 3] {
        [0, 1, 2].map(|i| (x[i] / edge).floor() as i64)
    }

    /// The node within `near` of a point, a small part of the edge of a cell.
    fn find(&self, nodes: &[Vec3], x: &Vec3, near: f64) -> Option<u32> {
        let (low, high) = (x.add_scalar(-near), x.add_scalar(near));
        let (first, last) = (Self::cell(&low, self.edge), Self::cell(&high, self.edge));
        for i in first[0]..=last[0] {
            for j in first[1]..=last[1] {
                // The cells of a row follow each other.
                let begin = self.cells.partition_point(|(cell, _)| *cell < [i, j, first[2]]);
                let row = self.cells[begin..].iter().take_while(|(cell, _)| *cell <= [i, j, last[2]]);
                let found =
                    row.map(|(_, node)| *node).find(|node| (nodes[*node as usize] - x).norm() <= near);
                if found.is_some() {
                    return found;
                }
            }
        }
        None
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mesh::generate::block::Block;

    const X: MirrorPlane = MirrorPlane { axis: 0, at: 0.5 };

    fn block(elements: [u32; 3]) -> Mesh {
        Block::uniform(Vec3::zeros(), Vec3::repeat(1.0), elements, "all").generate().unwrap()
    }

    #[test]
    fn a_block_of_even_numbers_is_its_own_mirror_image() {
        let mesh = block([4, 3, 2]);
        let images = MirrorImages::new(&mesh, X).unwrap();
        for (node, image) in images.nodes.iter().enumerate() {
            let expected = X.image(mesh.nodes[node]);
            assert!((mesh.nodes[*image as usize] - expected).norm() < 1e-12);
        }
        for (element, image) in images.elements.iter().enumerate() {
            assert_ne!(element as u32, *image);
            assert_eq!(images.elements[*image as usize], element as u32);
        }
    }

    #[test]
    fn elsewhere_or_across_an_element_there_is_no_mirror() {
        assert_eq!(MirrorImages::new(&block([3, 2, 2]), X), None, "an element extends across the plane");
        assert_eq!(MirrorImages::new(&block([4, 2, 2]), MirrorPlane { at: 0.25, ..X }), None);
        let mut mesh = block([4, 2, 2]);
        mesh.nodes[0].y += 1e-4;
        assert_eq!(MirrorImages::new(&mesh, X), None, "one node is elsewhere");
    }
}
