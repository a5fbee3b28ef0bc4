//! Element types of Gmsh: numbers, nodes and their order.

use crate::mesh::CellKind;

/// An element type of Gmsh, as its reader needs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ElementKind {
    /// Number of the type in Gmsh.
    number: i32,
    /// The corresponding kind of cell; `None` for points, lines and surfaces, and for unsupported volumes.
    pub(super) cell: Option<CellKind>,
    /// Dimension of the shape, 0 to 3.
    pub(super) dimension: u8,
    /// Number of nodes of the element.
    pub(super) nodes: u8,
    /// Name of the type in messages.
    pub(super) name: &'static str,
}

/// Types besides our cells: up to second order, and the most common ones of higher order (reference manual, "MSH file
/// format").
const OTHERS: [ElementKind; 30] = [
    kind(1, 1, 2, "line of 2 nodes"),
    kind(2, 2, 3, "triangle of 3 nodes"),
    kind(3, 2, 4, "quadrangle of 4 nodes"),
    kind(7, 3, 5, "pyramid of 5 nodes"),
    kind(8, 1, 3, "line of 3 nodes"),
    kind(9, 2, 6, "triangle of 6 nodes"),
    kind(10, 2, 9, "quadrangle of 9 nodes"),
    kind(12, 3, 27, "hexahedron of 27 nodes"),
    kind(13, 3, 18, "prism of 18 nodes"),
    kind(14, 3, 14, "pyramid of 14 nodes"),
    kind(15, 0, 1, "point"),
    kind(16, 2, 8, "quadrangle of 8 nodes"),
    kind(17, 3, 20, "hexahedron of 20 nodes"),
    kind(18, 3, 15, "prism of 15 nodes"),
    kind(19, 3, 13, "pyramid of 13 nodes"),
    kind(20, 2, 9, "triangle of 9 nodes"),
    kind(21, 2, 10, "triangle of 10 nodes"),
    kind(22, 2, 12, "triangle of 12 nodes"),
    kind(23, 2, 15, "triangle of 15 nodes"),
    kind(24, 2, 15, "triangle of 15 nodes"),
    kind(25, 2, 21, "triangle of 21 nodes"),
    kind(26, 1, 4, "line of 4 nodes"),
    kind(27, 1, 5, "line of 5 nodes"),
    kind(28, 1, 6, "line of 6 nodes"),
    kind(29, 3, 20, "tetrahedron of 20 nodes"),
    kind(30, 3, 35, "tetrahedron of 35 nodes"),
    kind(31, 3, 56, "tetrahedron of 56 nodes"),
    kind(36, 2, 16, "quadrangle of 16 nodes"),
    kind(92, 3, 64, "hexahedron of 64 nodes"),
    kind(93, 3, 125, "hexahedron of 125 nodes"),
];

const fn kind(number: i32, dimension: u8, nodes: u8, name: &'static str) -> ElementKind {
    ElementKind { number, cell: None, dimension, nodes, name }
}

impl ElementKind {
    /// The type with this number, if it is known.
    pub(super) fn of(number: i32) -> Option<Self> {
        CellKind::of_gmsh(number)
            .map(|cell| {
                let (nodes, name) = (cell.node_count() as u8, cell.table().title);
                Self { number, cell: Some(cell), dimension: 3, nodes, name }
            })
            .or_else(|| OTHERS.iter().find(|kind| kind.number == number).copied())
    }
}
