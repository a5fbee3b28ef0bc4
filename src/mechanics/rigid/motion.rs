//! Rotation of a free body: Euler's equations by the implicit midpoint, the orientation by the exponential.

use super::Rotation;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Newton steps; from the start value two or three reach rounding at any sensible step.
const ITERATIONS: usize = 20;
/// A correction below this share of the angular velocity is rounding.
const ROUNDING: f64 = 1e-15;

/// Angular velocity of a torque-free body after a time, in the axes of the body [rad/s].
///
/// `omega` before [rad/s], principal moments `inertia` [kg m²], `h` [s]. Implicit midpoint of Euler's equations,
///
/// I (ω⁺ − ω) = −h ω_m × I ω_m,   ω_m = ½ (ω + ω⁺),
///
/// which keeps `½ ω·Iω` and `|I ω|` to rounding, since both are quadratic invariants. A body that spins about a principal
/// axis keeps its bits. `None` where Newton's iteration does not close: a body that turns by more than about a radian in h.
pub fn turn_freely(omega: &Vec3, inertia: &Vec3, h: f64) -> Option<Vec3> {
    let couple = |w: &Vec3| w.cross(&inertia.component_mul(w));
    let mut change = Vec3::zeros();
    for _ in 0..ITERATIONS {
        let mean = omega + change * 0.5;
        let residual = inertia.component_mul(&change) + couple(&mean) * h;
        if residual == Vec3::zeros() {
            return Some(omega + change);
        }
        // d(ω × Iω) = dω × Iω + ω × I dω
        let moment = inertia.component_mul(&mean);
        let slope = mean.cross_matrix() * Mat3::from_diagonal(inertia) - moment.cross_matrix();
        let tangent = Mat3::from_diagonal(inertia) + slope * (0.5 * h);
        let correction = tangent.lu().solve(&residual)?;
        change -= correction;
        if correction.norm() <= ROUNDING * omega.norm() {
            return Some(omega + change);
        }
    }
    None
}

/// The orientation after turning with `omega` (axes of the body) [rad/s] for a time `h` [s]: `R exp(h [ω]ₓ)`.
///
/// ω in the axes of the body is the same at both ends, so it is the angular velocity of the whole step also in space.
pub fn rotated(orientation: &Rotation, omega: &Vec3, h: f64) -> Rotation {
    if *omega == Vec3::zeros() {
        return *orientation;
    }
    let mut next = orientation * Rotation::from_scaled_axis(omega * h);
    next.renormalize();
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    const INERTIA: [f64; 3] = [2.0, 3.0, 4.5];

    /// Energy and angular momentum in space.
    fn invariants(omega: &Vec3, orientation: &Rotation) -> (f64, Vec3) {
        let moment = Vec3::from(INERTIA).component_mul(omega);
        (0.5 * omega.dot(&moment), orientation * moment)
    }

    /// A free body from its start, seen at half steps as the integrator does.
    fn fly(mut omega: Vec3, h: f64, steps: usize, mut see: impl FnMut(&Vec3, &Rotation)) {
        let mut orientation = Rotation::from_euler_angles(0.3, -0.2, 0.9);
        for _ in 0..steps {
            orientation = rotated(&orientation, &omega, 0.5 * h);
            see(&omega, &orientation);
            orientation = rotated(&orientation, &omega, 0.5 * h);
            omega = turn_freely(&omega, &Vec3::from(INERTIA), h).unwrap();
        }
    }

    #[test]
    fn energy_and_size_of_the_momentum_are_kept_to_rounding_also_about_the_middle_axis() {
        let start = Vec3::new(0.01, 7.0, 0.02);
        let mut flipped = false;
        let mut first = None;
        fly(start, 1e-3, 50_000, |omega, orientation| {
            let (energy, momentum) = invariants(omega, orientation);
            let (energy_0, momentum_0) = *first.get_or_insert((energy, momentum));
            assert!((energy / energy_0 - 1.0).abs() < 1e-11, "{energy} {energy_0}");
            assert!((momentum.norm() / momentum_0.norm() - 1.0).abs() < 1e-11);
            flipped |= omega.y < -6.9;
        });
        assert!(flipped, "a spin about the middle axis turns over");
    }

    #[test]
    fn the_direction_of_the_momentum_is_kept_to_second_order() {
        let drift = |h: f64| {
            let (mut first, mut worst) = (None, 0.0_f64);
            fly(Vec3::new(3.0, 5.0, -4.0), h, (2.0 / h).round() as usize, |omega, orientation| {
                let (_, momentum) = invariants(omega, orientation);
                let start = *first.get_or_insert(momentum);
                worst = worst.max((momentum - start).norm() / start.norm());
            });
            worst
        };
        let [coarse, fine] = [drift(2e-3), drift(1e-3)];
        assert!(coarse < 1e-4 && (coarse / fine - 4.0).abs() < 0.4, "{coarse:e} {fine:e}");
    }

    #[test]
    fn a_spin_about_a_principal_axis_keeps_its_bits() {
        let omega = Vec3::new(0.0, 0.0, 123.456);
        assert_eq!(turn_freely(&omega, &Vec3::from(INERTIA), 1e-3), Some(omega));
    }
}
