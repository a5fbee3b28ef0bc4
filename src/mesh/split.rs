//! Meshes of other kinds of cells from meshes of hexahedra: tetrahedra, wedges, and tetrahedra of ten nodes.

use super::cell::CellFace;
use super::{Cell, CellKind, Cells, Mesh};
use std::collections::BTreeMap;

impl Mesh {
    /// Each hexahedron as cells of a kind, cut by the functions below; other cells as they are.
    #[must_use]
    pub fn split_to(&self, kind: CellKind) -> Mesh {
        match kind {
            CellKind::Hex8 => self.clone(),
            CellKind::Wedge6 => self.split_to_wedges(),
            CellKind::Tet4 => self.split_to_tetrahedra(),
            CellKind::Tet10 => self.split_to_tetrahedra().to_quadratic_tetrahedra(),
        }
    }

    /// Each hexahedron as six tetrahedra with the same nodes; other cells as they are.
    ///
    /// The tetrahedra join the corner of the lowest number with the faces opposite to it, and each face is cut at its corner of the lowest
    /// number: neighbours cut their common face alike.
    #[must_use]
    pub fn split_to_tetrahedra(&self) -> Mesh {
        self.split(CellKind::Tet4, |hex| {
            let first = lowest(hex);
            let opposite = CellKind::Hex8.table().faces.iter().filter(|face| !face.corners.contains(&first));
            let of_face = |face: &CellFace| {
                let face: Vec<u32> = face.corners.iter().map(|corner| hex[*corner]).collect();
                let [a, b, c, d] = std::array::from_fn(|i| face[(lowest(&face) + i) % 4]);
                // Seen from inside, faces are clockwise.
                [vec![a, b, c, hex[first]], vec![a, c, d, hex[first]]].map(|mut tet| {
                    tet.swap(1, 2);
                    tet
                })
            };
            opposite.flat_map(of_face).collect()
        })
    }

    /// Each hexahedron as two wedges along its third local axis, with the same nodes; other cells as they are. Only where that axis runs
    /// through the whole mesh, as in a block, do neighbours fit.
    #[must_use]
    pub fn split_to_wedges(&self) -> Mesh {
        self.split(CellKind::Wedge6, |hex| {
            [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
                .map(|wedge| wedge.map(|corner| hex[corner]).to_vec())
                .into()
        })
    }

    /// Replaces the hexahedra by cells of a kind on their nodes.
    fn split(&self, kind: CellKind, children: impl Fn(&[u32]) -> Vec<Vec<u32>>) -> Mesh {
        let mut out = Mesh { cells: Cells::default(), part_of: Vec::new(), axes: Vec::new(), ..self.clone() };
        let mut origins = Vec::new();
        for (element, Cell { kind: own, nodes }) in self.cells.iter().enumerate() {
            let (kind, children) =
                if own == CellKind::Hex8 { (kind, children(nodes)) } else { (own, vec![nodes.to_vec()]) };
            for child in children {
                out.cells.push(kind, &child);
                out.part_of.push(self.part_of[element]);
                out.axes.extend(self.axes.get(element));
                origins.push(element);
            }
        }
        out.fields = self.fields.of_elements(&origins.iter().copied());
        out
    }

    /// Each tetrahedron of four nodes as one of ten, with straight edges; other cells as they are. A node between two of a set belongs to
    /// it, too.
    #[must_use]
    pub fn to_quadratic_tetrahedra(&self) -> Mesh {
        let mut out = Mesh { cells: Cells::default(), ..self.clone() };
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for Cell { kind, nodes } in self.cells.iter() {
            if kind != CellKind::Tet4 {
                out.cells.push(kind, nodes);
                continue;
            }
            let mut all = nodes.to_vec();
            for &[a, b] in kind.table().edges {
                let ends = [nodes[a].min(nodes[b]), nodes[a].max(nodes[b])];
                all.push(*middles.entry(ends).or_insert_with(|| {
                    out.nodes.push((out.nodes[ends[0] as usize] + out.nodes[ends[1] as usize]) * 0.5);
                    out.nodes.len() as u32 - 1
                }));
            }
            out.cells.push(CellKind::Tet10, &all);
        }
        for set in out.node_sets.values_mut() {
            let is_in = |node: &u32| set.binary_search(node).is_ok();
            let between = middles.iter().filter(|(ends, _)| ends.iter().all(is_in));
            let mut between: Vec<u32> = between.map(|(_, middle)| *middle).collect();
            between.sort_unstable();
            // Later numbers than those of any corner.
            set.extend(between);
        }
        out
    }
}

/// Place of the lowest number.
fn lowest(nodes: &[u32]) -> usize {
    (0..nodes.len()).min_by_key(|i| nodes[*i]).unwrap_or(0)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mechanics::tensor::Vec3;
    use crate::mesh::generate::block::Block;
    use crate::mesh::generate::solid_ball::SolidBall;
    use crate::mesh::surface::{boundary, enclosed_volume_m3, topology_problems};

    fn check(mesh: &Mesh, volume: f64) {
        assert_eq!(topology_problems(&mesh.cells), []);
        assert_eq!(mesh.part_of.len(), mesh.cells.len());
        assert!((0..mesh.cells.len()).all(|e| mesh.element_volume_m3(e) > 0.0));
        let enclosed = enclosed_volume_m3(&boundary(&mesh.cells), &mesh.nodes);
        for found in [mesh.volume_m3(), enclosed] {
            assert!((found / volume - 1.0).abs() < 1e-12, "{found} for {volume}");
        }
    }

    #[test]
    fn children_fill_their_hexahedra_and_fit() {
        let block =
            Block::uniform(Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0), [2, 3, 4], "b").generate().unwrap();
        let tetrahedra = block.split_to_tetrahedra();
        assert_eq!(tetrahedra.cells.counts(), [(CellKind::Tet4, 6 * 24)]);
        check(&tetrahedra, 6.0);
        let wedges = block.split_to_wedges();
        assert_eq!(wedges.cells.counts(), [(CellKind::Wedge6, 2 * 24)]);
        check(&wedges, 6.0);
        let quadratic = tetrahedra.to_quadratic_tetrahedra();
        assert_eq!(quadratic.cells.counts(), [(CellKind::Tet10, 6 * 24)]);
        check(&quadratic, 6.0);
        // A side of 3 × 4 elements, cut by diagonals: corners and all nodes between.
        assert_eq!(quadratic.node_sets["x_min"].len(), 7 * 9);
        assert!(quadratic.node_sets["x_min"].is_sorted());
    }

    #[test]
    fn neighbours_of_any_orientation_cut_their_face_alike() {
        let ball = SolidBall {
            center_m: [0.0; 3],
            radius_m: 1.0,
            elements_around: 4,
            elements_through: 2,
            grading: 1.0,
            is_quarter: false,
        };
        let tetrahedra = ball.generate().unwrap().split_to_tetrahedra();
        check(&tetrahedra, tetrahedra.volume_m3());
        check(&tetrahedra.to_quadratic_tetrahedra(), tetrahedra.volume_m3());
    }
}
