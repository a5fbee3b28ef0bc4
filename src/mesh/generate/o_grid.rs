//! The O-grid: a core of squares or cubes inside a round shape, and rings around it.

use crate::mechanics::tensor::Vec3;

/// Roundness of the core [-]: 0 is a square core (elements outside its corners are flattened), 1 a round one (those inside
/// its corners are flattened). Half way balances the two.
const ROUNDING: f64 = 0.5;

/// Half side of the square part of the core, relative to the radius of its round part [-].
const SQUARE: f64 = 0.8;

/// Size of the core relative to the whole radius that makes elements of core and rings about equally thick [-].
///
/// A core of `n` elements across is 2c wide, the rings 1 − c thick in `m` layers: 2c/n = (1 − c)/m. Limited to 0.3 … 0.7,
/// so that the core is not crushed and its corners stay away from the surface.
pub(super) fn core_fraction(n: u32, m: u32) -> f64 {
    (f64::from(n) / (f64::from(n) + 2.0 * f64::from(m))).clamp(0.3, 0.7)
}

/// Position in a core of unit size of the point `u` of the square [−1, 1]² (third coordinate zero) or cube [−1, 1]³.
pub(super) fn core_point(u: &Vec3) -> Vec3 {
    let norm = u.norm();
    if norm == 0.0 {
        return Vec3::zeros();
    }
    // u · ‖u‖∞/‖u‖ maps the square to the disc, the cube to the ball.
    u * ((1.0 - ROUNDING) * SQUARE + ROUNDING * u.amax() / norm)
}

/// The point at `fraction` (0 at the core, 1 on the round surface of unit radius) along the ring line from the point `u` of
/// the core's boundary.
pub(super) fn ring_point(u: &Vec3, core_fraction: f64, fraction: f64) -> Vec3 {
    core_point(u) * (core_fraction * (1.0 - fraction)) + u.normalize() * fraction
}
