//! Common part of the first-order methods: steps with finite μ until the error is small. They need only products with
//! W.

use super::measure::At;
use super::options::{Ending, Limits};
use super::scaled::Scaled;
use crate::contact::solution::local::proj_coulomb_cone;
use crate::contact::solution::problem::local;

/// Power iterations for the largest eigenvalue, and the safety factor for their error.
const POWER_STEPS: usize = 30;
const EIGENVALUE_ROOM: f64 = 1.05;

/// Default limit of iterations.
pub(super) const MAX_STEPS: usize = 100_000;

/// Takes steps until the error is within the tolerance; does nothing for infinite μ, for which there is no De Saxcé
/// form. `prepare` computes the data of the steps, usually starting with their length.
pub(super) fn iterate<P: Iterate, S>(
    scaled: &mut P,
    limits: &Limits,
    prepare: impl FnOnce(&mut P) -> S,
    mut step: impl FnMut(&mut P, &mut S),
) -> Ending {
    let mut error = scaled.error();
    if error <= limits.tolerance || scaled.at().mu.iter().any(|mu| mu.is_infinite()) {
        return Ending { iterations: 0, error };
    }
    let mut own = prepare(scaled);
    let mut steps = 0;
    while error > limits.tolerance && steps < limits.iterations && !limits.interrupted() {
        step(scaled, &mut own);
        error = scaled.error();
        steps += 1;
    }
    Ending { iterations: steps, error }
}

/// A dimensionless problem that can be iterated on with products alone.
pub(super) trait Iterate {
    fn at(&self) -> At<'_>;

    /// Replaces the reactions and updates their velocities.
    fn set_reactions(&mut self, r: &[f64]);

    /// Replaces the reactions where their velocities `u = W r + q` are known, but for rounding.
    fn set_known(&mut self, r: &[f64], u: &[f64]);

    /// Product `W x` with a vector.
    fn product(&mut self, x: &[f64]) -> Vec<f64>;

    /// `Proj_K(z − ρ (u + μ ‖u_t‖ n))` of all contacts, u the current velocities; μ finite.
    fn projected_step(&self, z: &[f64], rho: f64) -> Vec<f64> {
        let At { mu, u, .. } = self.at();
        let one = |c: usize| {
            let (z, [n, t1, t2], mu) = (local(z, c), local(u, c), mu[c]);
            let lifted = n + mu * t1.hypot(t2);
            proj_coulomb_cone([z[0] - rho * lifted, z[1] - rho * t1, z[2] - rho * t2], mu)
        };
        (0..mu.len()).flat_map(one).collect()
    }

    /// The ρ for which a simultaneous step of all contacts converges: the inverse of the largest eigenvalue of W, by
    /// power iteration.
    fn safe_step(&mut self) -> f64 {
        let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        // A vector that no symmetry of the contacts makes orthogonal to the eigenvector.
        let mut x: Vec<f64> =
            (0..self.at().r.len()).map(|i| 1.0 + 0.37 * ((i * 7919) % 101) as f64 / 101.0).collect();
        let mut largest = 3.0;
        for _ in 0..POWER_STEPS {
            let y = self.product(&x);
            let (from, to) = (size(&x), size(&y));
            if !(to > 0.0) {
                break;
            }
            largest = to / from;
            x = y.into_iter().map(|y| y / to).collect();
        }
        1.0 / (EIGENVALUE_ROOM * largest)
    }

    /// [`At::error`] of the iterate.
    fn error(&self) -> f64 {
        self.at().error()
    }
}

impl Iterate for Scaled {
    fn at(&self) -> At<'_> {
        Self::at(self)
    }

    fn set_reactions(&mut self, r: &[f64]) {
        Self::set_reactions(self, r);
    }

    fn set_known(&mut self, r: &[f64], u: &[f64]) {
        self.r.copy_from_slice(r);
        self.u.copy_from_slice(u);
    }

    fn product(&mut self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for c in 0..self.contacts {
            self.add_column(c, local(x, c), &mut y);
        }
        y
    }
}
