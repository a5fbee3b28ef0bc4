//! The eight-node hexahedron: points, faces, edges, interpolation, names elsewhere.

use super::table::{AbaqusName, CellFace, CellTable, Foreign, Split};
use crate::mechanics::element::ElementKind;
use crate::mechanics::element::GAUSS;
use crate::mechanics::element::HEX8_CORNERS;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Nodes 0–3 counter-clockwise on the bottom seen from the top, 4–7 above them.
pub(super) static TABLE: CellTable = CellTable {
    name: "hex8",
    title: "hexahedron of 8 nodes",
    element: ElementKind::Hex8,
    points: &HEX8_CORNERS,
    corners: 8,
    centre: [0.0; 3],
    half_spaces: &[
        ([-1.0, 0.0, 0.0], 1.0),
        ([1.0, 0.0, 0.0], 1.0),
        ([0.0, -1.0, 0.0], 1.0),
        ([0.0, 1.0, 0.0], 1.0),
        ([0.0, 0.0, -1.0], 1.0),
        ([0.0, 0.0, 1.0], 1.0),
    ],
    edges: &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]],
    faces: &[
        CellFace { corners: &[0, 3, 2, 1], facets: &[[0, 3, 2, 1]] },
        CellFace { corners: &[4, 5, 6, 7], facets: &[[4, 5, 6, 7]] },
        CellFace { corners: &[0, 1, 5, 4], facets: &[[0, 1, 5, 4]] },
        CellFace { corners: &[1, 2, 6, 5], facets: &[[1, 2, 6, 5]] },
        CellFace { corners: &[2, 3, 7, 6], facets: &[[2, 3, 7, 6]] },
        CellFace { corners: &[3, 0, 4, 7], facets: &[[3, 0, 4, 7]] },
    ],
    oblique: None,
    // The 2×2×2 Gauss rule is exact: the determinant is quadratic in each of ξ, η, ζ.
    quadrature: &[
        ([-GAUSS, -GAUSS, -GAUSS], 1.0),
        ([GAUSS, -GAUSS, -GAUSS], 1.0),
        ([GAUSS, GAUSS, -GAUSS], 1.0),
        ([-GAUSS, GAUSS, -GAUSS], 1.0),
        ([-GAUSS, -GAUSS, GAUSS], 1.0),
        ([GAUSS, -GAUSS, GAUSS], 1.0),
        ([GAUSS, GAUSS, GAUSS], 1.0),
        ([-GAUSS, GAUSS, GAUSS], 1.0),
    ],
    place,
    jacobian,
    split: Some(Split {
        middles: &[
            &[0, 1],
            &[1, 2],
            &[2, 3],
            &[3, 0],
            &[4, 5],
            &[5, 6],
            &[6, 7],
            &[7, 4],
            &[0, 4],
            &[1, 5],
            &[2, 6],
            &[3, 7],
            &[0, 3, 2, 1],
            &[4, 5, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
            &[0, 1, 2, 3, 4, 5, 6, 7],
        ],
        children: &[
            &[0, 8, 20, 11, 16, 22, 26, 25],
            &[8, 1, 9, 20, 22, 17, 23, 26],
            &[20, 9, 2, 10, 26, 23, 18, 24],
            &[11, 20, 10, 3, 25, 26, 24, 19],
            &[16, 22, 26, 25, 4, 12, 21, 15],
            &[22, 17, 23, 26, 12, 5, 13, 21],
            &[26, 23, 18, 24, 21, 13, 6, 14],
            &[25, 26, 24, 19, 15, 21, 14, 7],
        ],
    }),
    vtk: Foreign { number: 12, order: &[0, 1, 2, 3, 4, 5, 6, 7] },
    gmsh: Foreign { number: 5, order: &[0, 1, 2, 3, 4, 5, 6, 7] },
    abaqus: AbaqusName { name: "C3D8", suffixes: "RHIS" },
};

/// Position x(ξ) = Σ_a x_a ⅛ (1 + ξ_a ξ)(1 + η_a η)(1 + ζ_a ζ)
fn place(x: &[Vec3], xi: [f64; 3]) -> Vec3 {
    let weight = |c: &[f64; 3]| 0.125 * (0..3).map(|i| 1.0 + c[i] * xi[i]).product::<f64>();
    x.iter().zip(&HEX8_CORNERS).map(|(x, c)| x * weight(c)).sum()
}

fn jacobian(x: &[Vec3], xi: [f64; 3]) -> Mat3 {
    let mut columns = [Vec3::zeros(); 3];
    for (x, c) in x.iter().zip(&HEX8_CORNERS) {
        let f = [1.0 + c[0] * xi[0], 1.0 + c[1] * xi[1], 1.0 + c[2] * xi[2]];
        columns[0] += x * (0.125 * c[0] * f[1] * f[2]);
        columns[1] += x * (0.125 * c[1] * f[0] * f[2]);
        columns[2] += x * (0.125 * c[2] * f[0] * f[1]);
    }
    Mat3::from_columns(&columns)
}
