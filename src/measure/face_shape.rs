//! One face of the contact patch: its area vector, and what it gives to its corners.

use crate::mechanics::tensor::Vec3;

/// Least cosine between a face's outward normal and the direction of the contact, for the face to press: 60°.
const TURNED: f64 = 0.5;

/// Corners without the repetition that marks a triangle.
pub(super) fn distinct(face: &[u32; 4]) -> &[u32] {
    if face[2] == face[3] { &face[..3] } else { face }
}

/// Corners of the bilinear quadrilateral.
const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// What one face gives to its corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FaceShape {
    /// Area vector, out of the face [m²].
    normal: Vec3,
    /// Its norm [m²].
    area: f64,
    /// dA at each of the 2×2 Gauss points of a bilinear quadrilateral; a third of the area at each corner of a triangle.
    weights: [f64; 4],
    is_triangle: bool,
}

impl FaceShape {
    /// From its corners (global nodes) and where they are [m].
    pub fn new(face: &[u32; 4], position: &impl Fn(u32) -> Vec3) -> Self {
        let x = face.map(position);
        // Half the cross product of the diagonals is the area vector of a quadrilateral, and of a triangle (c = d).
        let normal = (x[2] - x[0]).cross(&(x[3] - x[1]));
        let is_triangle = face[2] == face[3];
        let weights = if is_triangle {
            [(x[1] - x[0]).cross(&(x[2] - x[0])).norm() / 6.0; 4]
        } else {
            gauss_points().map(|[a, b]| {
                let (mut along_a, mut along_b) = (Vec3::zeros(), Vec3::zeros());
                for (x, s) in x.iter().zip(SIGNS) {
                    along_a += x * (0.25 * s[0] * (1.0 + s[1] * b));
                    along_b += x * (0.25 * s[1] * (1.0 + s[0] * a));
                }
                along_a.cross(&along_b).norm()
            })
        };
        Self { normal, area: normal.norm(), weights, is_triangle }
    }

    /// Whether its outward normal opposes `n` by at least [`TURNED`]. At the rim of a flat end the sides of the body are not
    /// turned to the contact, and press on nothing.
    pub fn is_turned(&self, n: &Vec3) -> bool {
        -n.dot(&self.normal) > TURNED * self.area
    }

    /// ∫ N_a dA for one corner [m²].
    pub fn tributary_share(&self, corner: usize) -> f64 {
        if self.is_triangle {
            return self.weights[corner];
        }
        let s = SIGNS[corner];
        let share = |([a, b], dA): ([f64; 2], f64)| 0.25 * (1.0 + s[0] * a) * (1.0 + s[1] * b) * dA;
        gauss_points().into_iter().zip(self.weights).map(share).sum()
    }
}

/// The 2×2 Gauss points of the unit square −1…1.
fn gauss_points() -> [[f64; 2]; 4] {
    let g = 1.0 / 3f64.sqrt();
    SIGNS.map(|[a, b]| [g * a, g * b])
}
