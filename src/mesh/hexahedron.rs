//! The eight-node hexahedron as a shape: its faces, edges, volume and Jacobians.

pub use crate::mechanics::element::HEX8_CORNERS as CORNERS;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Corners of the six faces, counter-clockwise seen from outside; face `i` is Abaqus' `S{i+1}`.
pub const FACES: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// End corners of the twelve edges.
pub const EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// Jacobian ∂x/∂ξ [m] of the trilinear map at the natural point `xi`; column `j` is ∂x/∂ξ_j.
///
/// x(ξ) = Σ_a x_a ⅛ (1 + ξ_a ξ)(1 + η_a η)(1 + ζ_a ζ)
pub fn jacobian(corners: &[Vec3; 8], xi: [f64; 3]) -> Mat3 {
    let mut columns = [Vec3::zeros(); 3];
    for (x, c) in corners.iter().zip(&CORNERS) {
        let f = [1.0 + c[0] * xi[0], 1.0 + c[1] * xi[1], 1.0 + c[2] * xi[2]];
        columns[0] += x * (0.125 * c[0] * f[1] * f[2]);
        columns[1] += x * (0.125 * c[1] * f[0] * f[2]);
        columns[2] += x * (0.125 * c[2] * f[0] * f[1]);
    }
    Mat3::from_columns(&columns)
}

/// The eight points of the 2×2×2 Gauss rule, ξ = ±1/√3; all weights are one.
pub fn gauss_points() -> [[f64; 3]; 8] {
    CORNERS.map(|c| c.map(|s| s / 3.0_f64.sqrt()))
}

/// Volume [m³] of the trilinear hexahedron; negative when it is inside out.
///
/// V = Σ det ∂x/∂ξ over the 2×2×2 Gauss points: exact, since the determinant is quadratic in each of ξ, η, ζ.
pub fn volume_m3(corners: &[Vec3; 8]) -> f64 {
    gauss_points().iter().map(|&xi| jacobian(corners, xi).determinant()).sum()
}

/// Determinant over the product of the lengths of the columns, in [−1, 1]; 1 where the edges are square to each other,
/// 0 where a column vanishes.
pub fn scaled_determinant(jacobian: &Mat3) -> f64 {
    let lengths: f64 = jacobian.column_iter().map(|c| c.norm()).product();
    if lengths > 0.0 { jacobian.determinant() / lengths } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheared_box_has_its_exact_volume_and_outward_faces() {
        let map = Mat3::new(2.0, 0.5, 0.1, 0.0, 3.0, 0.7, 0.0, 0.0, 4.0);
        let corners = CORNERS.map(|c| map * Vec3::from(c));
        assert!((volume_m3(&corners) - 8.0 * 24.0).abs() < 1e-12);
        for face in FACES {
            let [a, b, c, d] = face.map(|i| corners[i]);
            let normal = (c - a).cross(&(d - b));
            assert!(
                normal.dot(&(a + b + c + d)) > 0.0,
                "{face:?} points outwards from the centre at the origin"
            );
        }
    }

    #[test]
    fn edges_join_corners_that_differ_in_one_coordinate() {
        for [a, b] in EDGES {
            let differing = (0..3).filter(|&i| CORNERS[a][i] * CORNERS[b][i] < 0.0).count();
            assert_eq!(differing, 1);
        }
    }
}
