//! The ten-node tetrahedron, whose edges and faces may be curved.

use super::table::{AbaqusName, CellFace, CellTable, Foreign, interpolated, interpolated_jacobian};
use super::tet4::{BARYCENTRIC_GRADIENTS, EDGES, HALF_SPACES, OBLIQUE, POINTS as CORNERS, barycentric};
use crate::mechanics::element::ElementKind;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Corners as in the linear tetrahedron, followed by the middles of its edges in order.
pub(super) static TABLE: CellTable = CellTable {
    name: "tet10",
    title: "tetrahedron of 10 nodes",
    element: ElementKind::Tet10,
    points: &[
        CORNERS[0],
        CORNERS[1],
        CORNERS[2],
        CORNERS[3],
        [0.5, 0.0, 0.0],
        [0.5, 0.5, 0.0],
        [0.0, 0.5, 0.0],
        [0.0, 0.0, 0.5],
        [0.5, 0.0, 0.5],
        [0.0, 0.5, 0.5],
    ],
    corners: 4,
    centre: [0.25; 3],
    half_spaces: &HALF_SPACES,
    edges: &EDGES,
    faces: &[
        CellFace { corners: &[0, 2, 1], facets: &four_triangles([0, 2, 1], [6, 5, 4]) },
        CellFace { corners: &[0, 1, 3], facets: &four_triangles([0, 1, 3], [4, 8, 7]) },
        CellFace { corners: &[1, 2, 3], facets: &four_triangles([1, 2, 3], [5, 9, 8]) },
        CellFace { corners: &[0, 3, 2], facets: &four_triangles([0, 3, 2], [7, 9, 6]) },
    ],
    oblique: Some(OBLIQUE),
    // Five points, exact to third degree, that of the determinant; the weight of the centre is negative (Keast 1986).
    quadrature: &[
        ([0.25; 3], -2.0 / 15.0),
        ([1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0], 3.0 / 40.0),
        ([0.5, 1.0 / 6.0, 1.0 / 6.0], 3.0 / 40.0),
        ([1.0 / 6.0, 0.5, 1.0 / 6.0], 3.0 / 40.0),
        ([1.0 / 6.0, 1.0 / 6.0, 0.5], 3.0 / 40.0),
    ],
    place,
    jacobian,
    split: None,
    vtk: Foreign { number: 24, order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9] },
    gmsh: Foreign { number: 11, order: &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8] },
    abaqus: AbaqusName { name: "C3D10", suffixes: "HIMS" },
};

/// The four triangles of a face, from its corners and the middles of the edges that begin there.
const fn four_triangles([a, b, c]: [usize; 3], [ab, bc, ca]: [usize; 3]) -> [[usize; 4]; 4] {
    [[a, ab, ca, ca], [ab, b, bc, bc], [ca, bc, c, c], [ab, bc, ca, ca]]
}

/// Shape functions: L (2 L − 1) at a corner, 4 L L' between two.
fn place(x: &[Vec3], xi: [f64; 3]) -> Vec3 {
    let l = barycentric(xi);
    interpolated(x, |a| match a.checked_sub(4) {
        None => l[a] * (2.0 * l[a] - 1.0),
        Some(edge) => EDGES[edge].map(|end| l[end]).iter().product::<f64>() * 4.0,
    })
}

fn jacobian(x: &[Vec3], xi: [f64; 3]) -> Mat3 {
    let l = barycentric(xi);
    interpolated_jacobian(x, |a| match a.checked_sub(4) {
        None => BARYCENTRIC_GRADIENTS[a].map(|g| g * (4.0 * l[a] - 1.0)),
        Some(edge) => {
            let [a, b] = EDGES[edge];
            let (of_a, of_b) = (BARYCENTRIC_GRADIENTS[a], BARYCENTRIC_GRADIENTS[b]);
            std::array::from_fn(|k| 4.0 * (l[a] * of_b[k] + l[b] * of_a[k]))
        }
    })
}
