//! Solid elements from their lists of nodes, in which repeated nodes make tetrahedra and wedges of hexahedra (LS-DYNA
//! Keyword User's Manual, Vol. I, `*ELEMENT_SOLID`).

use crate::mesh::CellKind;

/// What a list of nodes describes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Solid {
    /// A cell with its nodes in our order.
    Cell(CellKind, Vec<u64>),
    /// A volume that is none of our kinds.
    Other(&'static str),
}

/// Repetitions in a list of eight nodes: for each node, the first place of the same number. With the kind and, in our order,
/// the places of its nodes.
const DEGENERATE: [([usize; 8], CellKind, &[usize]); 5] = [
    ([0, 1, 2, 3, 4, 5, 6, 7], CellKind::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]),
    ([0, 1, 2, 3, 3, 3, 3, 3], CellKind::Tet4, &[0, 1, 2, 3]),
    ([0, 1, 2, 2, 4, 4, 4, 4], CellKind::Tet4, &[0, 1, 2, 4]),
    // The edges 5–6 and 7–8 are points: triangles 1 2 5 and 4 3 7.
    ([0, 1, 2, 3, 4, 4, 6, 6], CellKind::Wedge6, &[0, 4, 1, 3, 6, 2]),
    // The edges 3–4 and 7–8 are points: triangles 1 2 3 and 5 6 7.
    ([0, 1, 2, 2, 4, 5, 6, 6], CellKind::Wedge6, &[0, 1, 2, 4, 5, 6]),
];

/// The top is a point.
const PYRAMID: [usize; 8] = [0, 1, 2, 3, 4, 4, 4, 4];

impl Solid {
    /// The element of up to ten nodes, in which zeros at the end are no nodes. `None` for another number of nodes.
    pub(super) fn new(nodes: &[u64]) -> Option<Self> {
        let count = nodes.iter().rposition(|&node| node != 0).map_or(0, |last| last + 1);
        match &nodes[..count] {
            ten @ [_, _, _, _, _, _, _, _, _, _] => Some(Self::Cell(CellKind::Tet10, ten.to_vec())),
            four @ [_, _, _, _] => Some(Self::Cell(CellKind::Tet4, four.to_vec())),
            eight @ [_, _, _, _, _, _, _, _] => Some(Self::of_eight(eight)),
            _ => None,
        }
    }

    fn of_eight(nodes: &[u64]) -> Self {
        let first = |node: &u64| nodes.iter().position(|other| other == node).unwrap_or_default();
        let pattern: Vec<usize> = nodes.iter().map(first).collect();
        if let Some((_, kind, order)) = DEGENERATE.iter().find(|(known, ..)| *known == pattern[..]) {
            return Self::Cell(*kind, order.iter().map(|&place| nodes[place]).collect());
        }
        Self::Other(if pattern == PYRAMID { "pyramid of 5 nodes" } else { "hexahedron with repeated nodes" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::tensor::Vec3;

    /// Volume of a hexahedron with corners moved together, as read from its repeated nodes.
    fn volume(nodes: [u64; 8], places: [[f64; 3]; 8]) -> (CellKind, f64) {
        match Solid::new(&nodes) {
            Some(Solid::Cell(kind, ours)) => {
                let x: Vec<Vec3> = ours.iter().map(|&node| places[node as usize - 1].into()).collect();
                (kind, kind.volume_m3(&x))
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn repeated_nodes_make_tetrahedra_and_wedges_that_are_not_inside_out() {
        let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let top = [a, b, c, d].map(|[x, y, _]| [x, y, 1.0]);
        let places = [a, b, c, d, top[0], top[1], top[2], top[3]];
        assert_eq!(volume([1, 2, 3, 4, 5, 6, 7, 8], places).0, CellKind::Hex8);
        // Triangles 1 2 3 and 5 6 7 of the cube.
        let (kind, half) = volume([1, 2, 3, 3, 5, 6, 7, 7], places);
        assert!(kind == CellKind::Wedge6 && (half - 0.5).abs() < 1e-15, "{kind:?} {half}");
        // The ridge 5 7 above the square.
        let mut roof = places;
        (roof[4], roof[6]) = ([0.5, 0.0, 1.0], [0.5, 1.0, 1.0]);
        let (kind, half) = volume([1, 2, 3, 4, 5, 5, 7, 7], roof);
        assert!(kind == CellKind::Wedge6 && (half - 0.5).abs() < 1e-15, "{kind:?} {half}");
        for tet in [[1, 2, 3, 8, 8, 8, 8, 8], [1, 2, 3, 3, 8, 8, 8, 8]] {
            let (kind, sixth) = volume(tet, places);
            assert!(kind == CellKind::Tet4 && (sixth - 1.0 / 6.0).abs() < 1e-15, "{kind:?} {sixth}");
        }
    }

    #[test]
    fn other_lists_are_named() {
        assert_eq!(Solid::new(&[1, 2, 3, 4, 5, 5, 5, 5, 0, 0]), Some(Solid::Other("pyramid of 5 nodes")));
        assert_eq!(
            Solid::new(&[1, 1, 1, 4, 5, 6, 7, 8]),
            Some(Solid::Other("hexahedron with repeated nodes"))
        );
        assert_eq!(Solid::new(&[1, 2, 3, 4, 5, 6, 0, 0]), None);
        assert_eq!(Solid::new(&[0; 10]), None);
        assert_eq!(
            Solid::new(&[1, 2, 3, 4, 0, 0, 0, 0]),
            Some(Solid::Cell(CellKind::Tet4, vec![1, 2, 3, 4]))
        );
    }
}
