//! Initial deformation of a body.

use super::document::{BodyDocument, InitialDeformation};
use crate::mechanics::tensor::{Mat3, Vec3};

impl BodyDocument {
    /// Initial position [m] of a point X [m] of the placed mesh.
    pub fn start_position(&self, X: &Vec3) -> Vec3 {
        self.initial_deformation.as_ref().map_or(*X, |deformation| deformation.position(X))
    }
}

impl InitialDeformation {
    /// Initial position [m] of a point X [m] of the body at rest.
    ///
    /// Inflation: r³ = R³ + A³ (λ³ − 1) along the ray from the centre. Affine: x = c + F (X − c).
    pub fn position(&self, X: &Vec3) -> Vec3 {
        match self {
            Self::SphericalInflation { center_m, inner_radius_m, inner_stretch } => {
                let arm = X - Vec3::from(*center_m);
                let R = arm.norm();
                if R == 0.0 {
                    return *X;
                }
                let grown = inner_radius_m.powi(3) * (inner_stretch.powi(3) - 1.0);
                Vec3::from(*center_m) + arm * ((R.powi(3) + grown).cbrt() / R)
            }
            Self::Affine { center_m, deformation_gradient: rows } => {
                let F = Mat3::from_fn(|i, j| rows[i][j]);
                Vec3::from(*center_m) + F * (X - Vec3::from(*center_m))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inflation_keeps_the_volume_of_the_wall() {
        let inflated = InitialDeformation::SphericalInflation {
            center_m: [1.0, 0.0, 0.0],
            inner_radius_m: 0.01,
            inner_stretch: 1.25,
        };
        let radius = |R: f64| (inflated.position(&Vec3::new(1.0, R, 0.0)) - Vec3::x()).norm();
        assert!((radius(0.01) - 0.0125).abs() < 1e-15);
        let wall = radius(0.015).powi(3) - radius(0.01).powi(3);
        assert!((wall - (0.015_f64.powi(3) - 0.01_f64.powi(3))).abs() < 1e-18);
    }
}
