//! Plane ellipses in the section of a limb: points, normals, offsets, areas.

use nalgebra::Vector2;
use std::f64::consts::PI;

/// An ellipse about the origin with semi-axes along x and z; its parameter τ starts at +z and grows towards +x.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// Semi-axis along x [m].
    pub(super) x: f64,
    /// Semi-axis along z [m].
    pub(super) z: f64,
}

impl Ellipse {
    /// The point (x, z) [m] at the parameter τ: (a sin τ, b cos τ).
    pub(super) fn point(&self, tau: f64) -> Vector2<f64> {
        Vector2::new(self.x * tau.sin(), self.z * tau.cos())
    }

    /// The outward unit normal (x, z) at the parameter τ.
    pub(super) fn normal(&self, tau: f64) -> Vector2<f64> {
        Vector2::new(tau.sin() / self.x, tau.cos() / self.z).normalize()
    }

    /// The parameter of the point seen from the centre at `angle` [rad] from +z towards +x.
    pub(super) fn parameter_at(&self, angle: f64) -> f64 {
        (self.z * angle.sin()).atan2(self.x * angle.cos())
    }

    /// Distance [m] from the centre to the ellipse along a unit direction.
    pub(super) fn radius_along(&self, direction: &Vector2<f64>) -> f64 {
        (direction.x / self.x).hypot(direction.y / self.z).recip()
    }

    /// Arc length per τ at the parameter τ [m].
    pub(super) fn speed(&self, tau: f64) -> f64 {
        (self.x * tau.cos()).hypot(self.z * tau.sin())
    }

    /// Smallest radius of curvature [m], min(a²/b, b²/a): an inner offset beyond it self-intersects.
    pub(super) fn min_curvature_radius(&self) -> f64 {
        (self.x * self.x / self.z).min(self.z * self.z / self.x)
    }

    /// Perimeter [m], by the trapezoidal rule, which converges exponentially on a closed smooth curve.
    pub(super) fn perimeter(&self) -> f64 {
        const POINTS: u32 = 2048;
        let step = 2.0 * PI / f64::from(POINTS);
        (0..POINTS).map(|i| self.speed(step * f64::from(i))).sum::<f64>() * step
    }

    /// Area [m²] inside the curve at distance `inward` [m] inside the ellipse.
    ///
    /// A(t) = π a b − t L + π t²  (Steiner), for t up to the smallest radius of curvature.
    pub(super) fn offset_area(&self, inward: f64) -> f64 {
        PI * self.x * self.z - inward * self.perimeter() + PI * inward * inward
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perimeter_and_offset_area_of_a_circle() {
        let circle = Ellipse { x: 2.0, z: 2.0 };
        assert!((circle.perimeter() - 4.0 * PI).abs() < 1e-12);
        assert!((circle.offset_area(0.5) - 2.25 * PI).abs() < 1e-12);
    }

    #[test]
    fn perimeter_of_an_ellipse() {
        // 4 a E(e) with a = 2, b = 1: 9.688448220547676.
        assert!((Ellipse { x: 2.0, z: 1.0 }.perimeter() - 9.688_448_220_547_676).abs() < 1e-12);
    }

    #[test]
    fn the_parameter_of_an_angle_lies_in_that_direction() {
        let ellipse = Ellipse { x: 3.0, z: 1.0 };
        for angle in [0.0, 0.4, 2.0, -1.0, 3.0] {
            let p = ellipse.point(ellipse.parameter_at(angle));
            assert!((p.x.atan2(p.y) - angle).abs() < 1e-12);
            let direction = Vector2::new(angle.sin(), angle.cos());
            assert!((ellipse.radius_along(&direction) - p.norm()).abs() < 1e-12);
        }
    }
}
