//! Uniform refinement: splits each cell into eight of its kind.

use super::cell::MOST_NODES;
use super::cells::{Cell, Cells};
use super::surface::{boundary, boundary_nodes};
use super::{HangingNodes, Mesh, MeshError};
use crate::mechanics::tensor::Vec3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Splits each element into eight at the middle of its edges, quadrilateral faces and volume.
///
/// New nodes lie on the interpolation of the element, so the volume and the facets of a curved surface are unchanged
/// (generators with `refined` follow the true shape instead). Old nodes keep their numbers. Parts and material axes are
/// inherited. A new node belongs to a node set if all corners of its edge, face or element do; if a set lies wholly on the
/// boundary, the new node must lie there too, so that an edge through a plate one element thick does not join a set on both
/// its sides. Where a quadrilateral face lies on two triangles, its middle is that of the diagonal between them, so that the
/// children share their nodes as their parents do.
///
/// # Errors
/// `Unrefinable` if the mesh has a kind of cell that cannot be split; `Unsupported` where elements of a layer meet in halves of faces.
pub fn refined(mesh: &Mesh) -> Result<Mesh, MeshError> {
    if mesh.hanging.halves_faces(&boundary(&mesh.cells)) {
        return Err(MeshError::Unsupported {
            what: "splitting of a skin of one element that covers coarse and fine elements".into(),
            remedy: "make the mesh of the scan with smaller elements".into(),
        });
    }
    let mut split = Split::new(mesh);
    split.join_diagonals(&mesh.cells);
    let mut cells = Cells::default();
    for cell in mesh.cells.iter() {
        split.add_children(cell, &mut cells)?;
    }
    let each_eight_times = |e: usize| e / 8;
    // Splitting a mesh without hanging nodes creates none.
    let hanging = if mesh.hanging.is_empty() { HangingNodes::default() } else { split.hanging(&cells) };
    let fine_boundary = boundary_nodes(&hanging.boundary(boundary(&cells)));
    let coarse_boundary = boundary_nodes(&mesh.hanging.boundary(boundary(&mesh.cells)));
    let node_sets = split.refined_sets(mesh, &coarse_boundary, &fine_boundary);
    Ok(Mesh {
        part_of: (0..cells.len()).filter_map(|e| mesh.part_of.get(each_eight_times(e)).copied()).collect(),
        axes: (0..cells.len()).filter_map(|e| mesh.axes.get(each_eight_times(e)).copied()).collect(),
        fields: mesh.fields.of_elements(&(0..cells.len()).map(each_eight_times)),
        nodes: split.nodes,
        cells,
        parts: mesh.parts.clone(),
        node_sets,
        hanging,
        notes: mesh.notes.clone(),
    })
}

/// Largest number of nodes of a cell being split, including new ones.
const MOST_SPLIT_NODES: usize = 27;

/// Nodes of a mesh being split.
pub(super) struct Split {
    pub nodes: Vec<Vec3>,
    /// Midpoint of an edge, face or element, by its sorted corners (padded with `u32::MAX`).
    middles: HashMap<[u32; 8], u32>,
    /// Corners that define each new node, in the order of the new nodes.
    parents: Vec<Vec<u32>>,
}

impl Split {
    /// Starts with a mesh, whose hanging nodes are midpoints already.
    pub fn new(mesh: &Mesh) -> Self {
        let middles = mesh.hanging.each().map(|(node, corners)| (key(corners), node)).collect();
        Self { nodes: mesh.nodes.clone(), middles, parents: Vec::new() }
    }

    /// Makes the middle of each quadrilateral face that of a diagonal of it which is the edge of another cell.
    fn join_diagonals(&mut self, cells: &Cells) {
        if cells.counts().len() < 2 {
            return;
        }
        let edges_of = |cell: Cell<'_>| {
            let nodes = cell.nodes.to_vec();
            cell.kind.table().edges.iter().map(move |edge| key(&edge.map(|i| nodes[i])))
        };
        let edges: HashSet<[u32; 8]> = cells.iter().flat_map(edges_of).collect();
        for face in cells.iter().flat_map(edges_and_faces) {
            let &[a, b, c, d] = &face[..] else { continue };
            for diagonal in [key(&[a, c]), key(&[b, d])] {
                if edges.contains(&diagonal) {
                    let middle = self.middle(&face);
                    self.middles.insert(diagonal, middle);
                }
            }
        }
    }

    /// Hanging nodes: midpoints of an edge or face that one of these elements has unsplit.
    pub fn hanging(&self, cells: &Cells) -> HangingNodes {
        let mut between = BTreeMap::new();
        for cell in cells.iter() {
            for corners in edges_and_faces(cell) {
                if let Some(node) = self.made_middle(&corners) {
                    between.entry(node).or_insert(corners);
                }
            }
        }
        HangingNodes::new(between)
    }

    /// Midpoint of these corners, if it exists.
    pub fn made_middle(&self, corners: &[u32]) -> Option<u32> {
        self.middles.get(&key(corners)).copied()
    }

    /// Midpoint of these corners; created on first use.
    fn middle(&mut self, corners: &[u32]) -> u32 {
        let key = key(corners);
        *self.middles.entry(key).or_insert_with(|| {
            let sum: Vec3 = key.iter().take(corners.len()).map(|&a| self.nodes[a as usize]).sum();
            let middle = sum / corners.len() as f64;
            self.nodes.push(middle);
            self.parents.push(corners.to_vec());
            (self.nodes.len() - 1) as u32
        })
    }

    /// Adds the eight children of a cell.
    pub fn add_children(&mut self, cell: Cell, out: &mut Cells) -> Result<(), MeshError> {
        let table = cell.kind.table();
        let unrefinable = || MeshError::Unrefinable { kind: table.title };
        let split = table.split.as_ref().ok_or_else(unrefinable)?;

        // The nodes of the cell, followed by the new ones.
        let mut nodes = [0; MOST_SPLIT_NODES];
        let own = cell.nodes.len();
        nodes[..own].copy_from_slice(cell.nodes);
        for (i, corners) in split.middles.iter().enumerate() {
            nodes[own + i] = {
                let corners: Vec<u32> = corners.iter().map(|&corner| cell.nodes[corner]).collect();
                self.middle(&corners)
            };
        }
        for child in split.children {
            let mut list = [0; MOST_NODES];
            for (node, &i) in list.iter_mut().zip(*child) {
                *node = nodes[i];
            }
            out.push(cell.kind, &list[..own]);
        }
        Ok(())
    }

    /// Node sets of the mesh with the new nodes that belong to them; given the boundary nodes before and after.
    pub fn refined_sets(
        &self,
        mesh: &Mesh,
        coarse_boundary: &[u32],
        fine_boundary: &[u32],
    ) -> BTreeMap<String, Vec<u32>> {
        let refined = |(name, set): (&String, &Vec<u32>)| {
            (name.clone(), self.refined_set(set, coarse_boundary, fine_boundary))
        };
        mesh.node_sets.iter().map(refined).collect()
    }

    /// A node set with the new nodes that belong to it; these are in ascending order, after the corners that they are between.
    fn refined_set(&self, set: &[u32], coarse_boundary: &[u32], fine_boundary: &[u32]) -> Vec<u32> {
        let on_boundary = set.iter().all(|a| coarse_boundary.binary_search(a).is_ok());
        let first_new = self.nodes.len() - self.parents.len();
        let mut out = set.to_vec();
        for (i, parents) in self.parents.iter().enumerate() {
            let node = (first_new + i) as u32;
            let inherits = parents.iter().all(|a| out.binary_search(a).is_ok());
            if inherits && (!on_boundary || fine_boundary.binary_search(&node).is_ok()) {
                out.push(node);
            }
        }
        out
    }
}

/// End nodes of each edge of a cell, and corners of each face.
pub(super) fn edges_and_faces(cell: Cell<'_>) -> impl Iterator<Item = Vec<u32>> {
    let table = cell.kind.table();
    let sides = table.edges.iter().map(|edge| &edge[..]).chain(table.faces.iter().map(|face| face.corners));
    sides.map(move |corners| corners.iter().map(|&i| cell.nodes[i]).collect())
}

/// Sorted corners, as a key.
fn key(corners: &[u32]) -> [u32; 8] {
    let mut key = [u32::MAX; 8];
    key[..corners.len()].copy_from_slice(corners);
    key.sort_unstable();
    key
}

#[cfg(test)]
#[allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::CellKind;
    use super::super::generate::Generator;
    use super::super::generate::block::Block;
    use super::super::generate::limb_segment::LimbSegment;
    use super::super::quality::quality;
    use super::super::surface::topology_problems;
    use super::*;

    #[test]
    fn a_split_block_is_the_block_with_twice_the_counts() {
        let coarse = Block::uniform(Vec3::zeros(), Vec3::new(3.0, 2.0, 1.0), [3, 2, 1], "b");
        let split = refined(&coarse.generate().unwrap()).unwrap();
        let fine = Generator::Block(coarse).refined(2).generate().unwrap();
        assert_eq!((split.nodes.len(), split.cells.len()), (fine.nodes.len(), fine.cells.len()));
        for (name, set) in &fine.node_sets {
            let positions = |mesh: &Mesh, set: &[u32]| {
                let mut x: Vec<[i64; 3]> = set
                    .iter()
                    .map(|&a| mesh.nodes[a as usize].map(|c| (c * 1e6).round() as i64).into())
                    .collect();
                x.sort_unstable();
                x
            };
            assert_eq!(positions(&split, &split.node_sets[name]), positions(&fine, set), "{name}");
            assert!(split.node_sets[name].is_sorted());
        }
        let quality = quality(&split).unwrap();
        assert!((quality.min_scaled_jacobian - 1.0).abs() < 1e-12);
        assert!((quality.volume_m3 - 6.0).abs() < 1e-12);
    }

    /// One hexahedron among tetrahedra: each of its inner faces lies on two triangles.
    #[test]
    fn cells_of_different_kinds_share_their_new_nodes_as_they_share_the_old_ones() {
        let block =
            Block::uniform(Vec3::zeros(), Vec3::new(2.0, 2.0, 2.0), [2, 2, 2], "b").generate().unwrap();
        let tetrahedra = block.split_to_tetrahedra();
        let mut mixed = Mesh { cells: Cells::default(), part_of: Vec::new(), ..block.clone() };
        // The first hexahedron stays, in place of its six tetrahedra.
        mixed.cells.push(CellKind::Hex8, block.cells.get(0).nodes);
        tetrahedra.cells.iter().skip(6).for_each(|cell| mixed.cells.push(cell.kind, cell.nodes));
        mixed.part_of = vec![0; mixed.cells.len()];
        let mut fine = mixed;
        for n in [5, 9] {
            fine = refined(&fine).unwrap();
            // A node at every point of the grid of half the size, and no two at one point.
            assert_eq!(fine.nodes.len(), n * n * n);
            assert!((fine.volume_m3() - 8.0).abs() < 1e-12);
        }
    }

    #[test]
    fn an_edge_through_a_thin_plate_does_not_join_the_set_of_its_sides() {
        let mut plate =
            Block::uniform(Vec3::zeros(), Vec3::new(3.0, 3.0, 1.0), [3, 3, 1], "b").generate().unwrap();
        let mut both = plate.node_sets["z_min"].clone();
        both.extend(&plate.node_sets["z_max"]);
        both.sort_unstable();
        plate.node_sets.insert("both".into(), both);
        let fine = refined(&plate).unwrap();
        let half_way = fine.node_sets["both"]
            .iter()
            .map(|&a| fine.nodes[a as usize])
            .filter(|x| x.z == 0.5 && x.x > 0.1 && x.x < 2.9 && x.y > 0.1 && x.y < 2.9);
        assert_eq!(half_way.count(), 0);
    }

    #[test]
    fn a_split_limb_keeps_volume_parts_and_axes() {
        let limb = LimbSegment { elements_around: 12, elements_along: 3, ..LimbSegment::default() };
        let coarse = limb.generate().unwrap();
        let fine = refined(&coarse).unwrap();
        assert_eq!(fine.axes.len(), fine.cells.len());
        assert!(topology_problems(&fine.cells).is_empty());
        for part in &coarse.parts {
            let (a, b) = (coarse.part_volume_m3(part), fine.part_volume_m3(part));
            assert!((a - b).abs() < 1e-12 * a, "{part}: {a} {b}");
        }
        assert_eq!(fine.node_sets["bone"].len(), 24 * 7);
    }
}
