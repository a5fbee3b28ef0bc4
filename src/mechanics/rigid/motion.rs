//! Rotation of a free body: an implicit midpoint rule whose rotation is an exponential, which conserves energy and
//! angular momentum.

use super::pose::Rotation;
use crate::tensor::{Mat3, Vec3};

/// Limit of Newton steps; from the initial guess two or three reach rounding for any reasonable step.
const ITERATIONS: usize = 20;
/// Correction, as a fraction of the angular velocity, after which the next one is below rounding: Newton's method
/// squares it.
const LAST: f64 = 1e-11;
/// Half angle [rad] below which tan x / x is evaluated by its series.
const SMALL: f64 = 1e-4;

/// Orientation and angular velocity [rad/s] of a torque-free body after a time `h` [s], the latter in the body axes
/// at that time; `omega` [rad/s] in the initial body axes, principal moments `inertia` [kg m²].
///
/// With ω_m = ½ (ω + ω⁺) the body rotates by Q = exp(h [ω_m]ₓ), and ω⁺ is such that the angular momentum in space is
/// conserved, I ω⁺ = Qᵀ I ω. Since exp(h [ω_m]ₓ) is the Cayley transform of h' ω_m, that is the implicit midpoint
/// rule for Euler's equations with a step h' slightly longer than h,
///
/// I (ω⁺ − ω) = −h' ω_m × I ω_m,   h' = tan(½ h |ω_m|) / (½ |ω_m|),
///
/// which also conserves `½ ω·Iω`, for any h' (after Simo & Wong 1991, who use a Cayley transform of h ω_m). A spin
/// about a principal axis keeps its bits and rotates by the exact angle. `None` where Newton's iteration does not
/// converge: for rotations by radians in h.
pub fn turn_freely(orientation: &Rotation, omega: &Vec3, inertia: &Vec3, h: f64) -> Option<(Rotation, Vec3)> {
    let mut change = Vec3::zeros();
    for _ in 0..ITERATIONS {
        let mean = omega + change * 0.5;
        let moment = inertia.component_mul(&mean);
        let couple = mean.cross(&moment);
        let (longer, growth) = cayley_step(mean.norm(), h)?;
        let residual = inertia.component_mul(&change) + couple * longer;
        let mut correction = Vec3::zeros();
        if residual != Vec3::zeros() {
            // d(h' ω × Iω) = h' (dω × Iω + ω × I dω) + (ω × Iω) (dh'/d|ω|²) 2 ω·dω, dω half of the change
            let slope = mean.cross_matrix() * Mat3::from_diagonal(inertia) - moment.cross_matrix();
            let tangent =
                Mat3::from_diagonal(inertia) + slope * (0.5 * longer) + couple * mean.transpose() * growth;
            correction = tangent.lu().solve(&residual)?;
        }
        change -= correction;
        if correction.norm() <= LAST * omega.norm() {
            let end = rotated(orientation, &(omega + change * 0.5), h);
            return Some((end, omega + change));
        }
    }
    None
}

/// The step h' [s] whose Cayley transform rotates by `speed` [rad/s] times `h` [s], and its derivative by the square
/// of the speed; `None` from half a turn on.
fn cayley_step(speed: f64, h: f64) -> Option<(f64, f64)> {
    let x = 0.5 * h * speed;
    if x < SMALL {
        return Some((h * (1.0 + x * x / 3.0), h * h * h / 12.0));
    }
    let quotient = x.tan() / x;
    let derivative = (1.0 + x.tan().powi(2) - quotient) / (2.0 * x * x);
    (x < std::f64::consts::FRAC_PI_2).then_some((h * quotient, 0.25 * h * h * h * derivative))
}

/// The orientation after a rotation with `omega` (axes of the body) [rad/s] for a time `h` [s]: `R exp(h [ω]ₓ)`.
///
/// ω in the axes of the body is the same at both ends, so in space, too, it is the angular velocity of the whole
/// step.
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

    /// Kinetic energy, and angular momentum in space.
    fn invariants(omega: &Vec3, orientation: &Rotation) -> (f64, Vec3) {
        let moment = Vec3::from(INERTIA).component_mul(omega);
        (0.5 * omega.dot(&moment), orientation * moment)
    }

    /// Integrates a free body, and shows each state to `see`.
    fn fly(omega: Vec3, h: f64, steps: usize, mut see: impl FnMut(&Vec3, &Rotation)) {
        let mut now = (Rotation::from_euler_angles(0.3, -0.2, 0.9), omega);
        for _ in 0..steps {
            see(&now.1, &now.0);
            now = turn_freely(&now.0, &now.1, &Vec3::from(INERTIA), h).unwrap();
        }
        see(&now.1, &now.0);
    }

    /// Largest relative changes of the energy and of the momentum vector, and whether the body has turned over.
    fn worst(start: Vec3, h: f64, steps: usize) -> (f64, f64, bool) {
        let (mut first, mut worst) = (None, (0.0_f64, 0.0_f64, false));
        fly(start, h, steps, |omega, orientation| {
            let (energy, momentum) = invariants(omega, orientation);
            let (energy_0, momentum_0) = *first.get_or_insert((energy, momentum));
            worst.0 = worst.0.max((energy / energy_0 - 1.0).abs());
            worst.1 = worst.1.max((momentum - momentum_0).norm() / momentum_0.norm());
            worst.2 |= omega.y < -0.9 * start.y;
        });
        worst
    }

    #[test]
    fn energy_and_the_momentum_vector_are_kept_to_rounding_also_about_the_middle_axis() {
        let (energy, momentum, flipped) = worst(Vec3::new(0.01, 7.0, 0.02), 1e-3, 50_000);
        assert!(energy < 1e-11 && momentum < 1e-11, "{energy:e} {momentum:e}");
        assert!(flipped, "a spin about the middle axis turns over");
    }

    #[test]
    fn a_step_of_a_radian_keeps_them_too() {
        let start = Vec3::new(3.0, 5.0, -4.0);
        for angle in [0.3, 1.0, 1.5] {
            let (energy, momentum, _) = worst(start, angle / start.norm(), 20_000);
            assert!(energy < 1e-11 && momentum < 1e-11, "{angle} rad: {energy:e} {momentum:e}");
        }
        assert_eq!(
            turn_freely(&Rotation::identity(), &start, &Vec3::from(INERTIA), 7.0 / start.norm()),
            None
        );
    }

    #[test]
    fn the_motion_is_of_second_order() {
        let end = |h: f64| {
            let mut last = Rotation::identity();
            fly(Vec3::new(3.0, 5.0, -4.0), h, (1.0 / h).round() as usize, |_, orientation| {
                last = *orientation;
            });
            last
        };
        let exact = end(1e-4);
        let [coarse, fine] = [end(8e-3), end(4e-3)].map(|r| r.angle_to(&exact));
        assert!(coarse < 5e-3 && (coarse / fine - 4.0).abs() < 0.1, "{coarse:e} {fine:e}");
    }

    #[test]
    fn a_spin_about_a_principal_axis_keeps_its_bits_and_turns_by_the_exact_angle() {
        let (omega, start) = (Vec3::new(0.0, 0.0, 123.456), Rotation::identity());
        let turned = turn_freely(&start, &omega, &Vec3::from(INERTIA), 5e-3);
        assert_eq!(turned, Some((rotated(&start, &omega, 5e-3), omega)));
    }
}
