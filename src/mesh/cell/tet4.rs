//! The four-node tetrahedron: points, faces, edges, interpolation, names elsewhere.

use super::table::{
    AbaqusName, CellFace, CellTable, Foreign, Oblique, Split, interpolated, interpolated_jacobian,
};
use crate::mechanics::element::ElementKind;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Nodes 0–2 counter-clockwise seen from node 3.
pub(super) static TABLE: CellTable = CellTable {
    name: "tet4",
    title: "tetrahedron of 4 nodes",
    element: ElementKind::Tet4,
    points: &POINTS,
    corners: 4,
    centre: [0.25; 3],
    half_spaces: &HALF_SPACES,
    edges: &EDGES,
    faces: &[
        CellFace { corners: &[0, 2, 1], facets: &[[0, 2, 1, 1]] },
        CellFace { corners: &[0, 1, 3], facets: &[[0, 1, 3, 3]] },
        CellFace { corners: &[1, 2, 3], facets: &[[1, 2, 3, 3]] },
        CellFace { corners: &[0, 3, 2], facets: &[[0, 3, 2, 2]] },
    ],
    oblique: Some(OBLIQUE),
    quadrature: &[([0.25; 3], 1.0 / 6.0)],
    place,
    jacobian,
    // Bey (1995, Computing 55), "Tetrahedral grid refinement": four children at the corners, four in the octahedron between
    // them, around its diagonal 6–8; the order of nodes limits all descendants to three shapes. Children that his order
    // would invert have their first and third node exchanged, which keeps the diagonal.
    split: Some(Split {
        middles: &[&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]],
        children: &[
            &[0, 4, 6, 7],
            &[4, 1, 5, 8],
            &[6, 5, 2, 9],
            &[7, 8, 9, 3],
            &[4, 6, 7, 8],
            &[5, 6, 4, 8],
            &[6, 7, 8, 9],
            &[8, 5, 6, 9],
        ],
    }),
    vtk: Foreign { number: 10, order: &[0, 1, 2, 3] },
    gmsh: Foreign { number: 4, order: &[0, 1, 2, 3] },
    abaqus: AbaqusName { name: "C3D4", suffixes: "H" },
};

/// Natural coordinates of the corners.
pub(super) const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Half-spaces ξ, η, ζ ≥ 0 and ξ + η + ζ ≤ 1.
pub(super) const HALF_SPACES: [([f64; 3], f64); 4] =
    [([-1.0, 0.0, 0.0], 0.0), ([0.0, -1.0, 0.0], 0.0), ([0.0, 0.0, -1.0], 0.0), ([1.0; 3], 1.0)];

/// End corners of the edges.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Orthogonal directions of the regular tetrahedron: an edge, the height of a face on it, and the height on that face; any
/// other corner is a neighbour.
pub(super) const OBLIQUE: Oblique = Oblique {
    frame: [[1.0, 0.0, 0.0], [-1.0, 2.0, 0.0], [-1.0, -1.0, 3.0]],
    neighbours: &[[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]],
    corner: std::f64::consts::FRAC_1_SQRT_2,
};

/// Barycentric coordinates: L₀ = 1 − ξ − η − ζ, ξ, η, ζ.
pub(super) fn barycentric(xi: [f64; 3]) -> [f64; 4] {
    [1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]]
}

/// Derivatives of the barycentric coordinates with respect to ξ, η, ζ.
pub(super) const BARYCENTRIC_GRADIENTS: [[f64; 3]; 4] =
    [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn place(x: &[Vec3], xi: [f64; 3]) -> Vec3 {
    let shape = barycentric(xi);
    interpolated(x, |a| shape[a])
}

fn jacobian(x: &[Vec3], _xi: [f64; 3]) -> Mat3 {
    interpolated_jacobian(x, |a| BARYCENTRIC_GRADIENTS[a])
}
