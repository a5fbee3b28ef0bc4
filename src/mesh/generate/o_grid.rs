//! The O-grid: a core of squares or cubes inside a round shape, blended into rings around it.

use crate::mechanics::tensor::Vec3;

/// How far the core is rounded: 0 is a square core (elements outside its corners are pressed flat), 1 a round one (the
/// elements inside its corners are). Half way balances the two.
const ROUNDING: f64 = 0.5;

/// Half side of the square part of the core against the radius of its round part.
const SQUARE: f64 = 0.8;

/// Size of the core against the whole radius that makes elements of core and rings about equally thick.
///
/// A core of `n` elements across is 2c wide, the rings 1 − c thick in `m` layers: 2c/n = (1 − c)/m. Held between 0.3 and
/// 0.7, lest the core be crushed or its corners come near the surface.
pub(super) fn core_fraction(n: u32, m: u32) -> f64 {
    (f64::from(n) / (f64::from(n) + 2.0 * f64::from(m))).clamp(0.3, 0.7)
}

/// Where the point `u` of the square [−1, 1]² (third coordinate zero) or cube [−1, 1]³ lies in the core, for a core of
/// size one.
pub(super) fn core_point(u: &Vec3) -> Vec3 {
    let norm = u.norm();
    if norm == 0.0 {
        return Vec3::zeros();
    }
    // u · ‖u‖∞/‖u‖ maps the square to the disc, the cube to the ball.
    u * ((1.0 - ROUNDING) * SQUARE + ROUNDING * u.amax() / norm)
}

/// The point at `fraction` (0 at the core, 1 on the round surface of radius one) along the ring line that starts at the
/// point `u` of the core's boundary.
pub(super) fn ring_point(u: &Vec3, core_fraction: f64, fraction: f64) -> Vec3 {
    core_point(u) * (core_fraction * (1.0 - fraction)) + u.normalize() * fraction
}
