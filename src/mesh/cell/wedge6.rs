//! The six-node wedge: points, faces, edges, interpolation, names elsewhere.

use super::table::{
    AbaqusName, CellFace, CellTable, Foreign, Oblique, Split, interpolated, interpolated_jacobian,
};
use crate::mechanics::element::ElementKind;
use crate::mechanics::element::GAUSS;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Nodes 0–2 counter-clockwise on the bottom seen from the top, 3–5 above them.
pub(super) static TABLE: CellTable = CellTable {
    name: "wedge6",
    title: "prism of 6 nodes",
    element: ElementKind::Wedge6,
    points: &POINTS,
    corners: 6,
    centre: [1.0 / 3.0, 1.0 / 3.0, 0.0],
    half_spaces: &[
        ([-1.0, 0.0, 0.0], 0.0),
        ([0.0, -1.0, 0.0], 0.0),
        ([1.0, 1.0, 0.0], 1.0),
        ([0.0, 0.0, -1.0], 1.0),
        ([0.0, 0.0, 1.0], 1.0),
    ],
    edges: &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
    faces: &[
        CellFace { corners: &[0, 2, 1], facets: &[[0, 2, 1, 1]] },
        CellFace { corners: &[3, 4, 5], facets: &[[3, 4, 5, 5]] },
        CellFace { corners: &[0, 1, 4, 3], facets: &[[0, 1, 4, 3]] },
        CellFace { corners: &[1, 2, 5, 4], facets: &[[1, 2, 5, 4]] },
        CellFace { corners: &[2, 0, 3, 5], facets: &[[2, 0, 3, 5]] },
    ],
    oblique: Some(Oblique {
        frame: [[1.0, 0.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, 1.0]],
        neighbours: &[[1, 2, 3], [2, 0, 4], [0, 1, 5], [4, 5, 0], [5, 3, 1], [3, 4, 2]],
        // √3/2: an equilateral triangle with edges perpendicular to it.
        corner: 0.866_025_403_784_438_6,
    }),
    // Three points in the triangle, exact to second degree, times two along the line.
    quadrature: &[
        ([1.0 / 6.0, 1.0 / 6.0, -GAUSS], 1.0 / 6.0),
        ([2.0 / 3.0, 1.0 / 6.0, -GAUSS], 1.0 / 6.0),
        ([1.0 / 6.0, 2.0 / 3.0, -GAUSS], 1.0 / 6.0),
        ([1.0 / 6.0, 1.0 / 6.0, GAUSS], 1.0 / 6.0),
        ([2.0 / 3.0, 1.0 / 6.0, GAUSS], 1.0 / 6.0),
        ([1.0 / 6.0, 2.0 / 3.0, GAUSS], 1.0 / 6.0),
    ],
    place,
    jacobian,
    // Each triangle into four, each of the three edges between them into two.
    split: Some(Split {
        middles: &[
            &[0, 1],
            &[1, 2],
            &[2, 0],
            &[3, 4],
            &[4, 5],
            &[5, 3],
            &[0, 3],
            &[1, 4],
            &[2, 5],
            &[0, 1, 4, 3],
            &[1, 2, 5, 4],
            &[2, 0, 3, 5],
        ],
        children: &[
            &[0, 6, 8, 12, 15, 17],
            &[6, 1, 7, 15, 13, 16],
            &[8, 7, 2, 17, 16, 14],
            &[6, 7, 8, 15, 16, 17],
            &[12, 15, 17, 3, 9, 11],
            &[15, 13, 16, 9, 4, 10],
            &[17, 16, 14, 11, 10, 5],
            &[15, 16, 17, 9, 10, 11],
        ],
    }),
    // In VTK, the triangle 0–2 faces outwards.
    vtk: Foreign { number: 13, order: &[0, 1, 2, 3, 4, 5] },
    gmsh: Foreign { number: 6, order: &[0, 1, 2, 3, 4, 5] },
    abaqus: AbaqusName { name: "C3D6", suffixes: "H" },
};

/// Reference cell: ξ, η ≥ 0 with ξ + η ≤ 1, and ζ within ±1.
const POINTS: [[f64; 3]; 6] =
    [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

/// Derivatives of the barycentric coordinates of the triangle with respect to ξ and η.
const TRIANGLE_GRADIENTS: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];

/// Position with shape functions L_i(ξ, η) ½ (1 ± ζ).
fn place(x: &[Vec3], xi: [f64; 3]) -> Vec3 {
    let l = triangle(xi);
    interpolated(x, |a| l[a % 3] * 0.5 * (1.0 + POINTS[a][2] * xi[2]))
}

fn jacobian(x: &[Vec3], xi: [f64; 3]) -> Mat3 {
    let l = triangle(xi);
    interpolated_jacobian(x, |a| {
        let (side, [g, h]) = (POINTS[a][2], TRIANGLE_GRADIENTS[a % 3]);
        let along = 0.5 * (1.0 + side * xi[2]);
        [g * along, h * along, 0.5 * side * l[a % 3]]
    })
}

fn triangle(xi: [f64; 3]) -> [f64; 3] {
    [1.0 - xi[0] - xi[1], xi[0], xi[1]]
}
