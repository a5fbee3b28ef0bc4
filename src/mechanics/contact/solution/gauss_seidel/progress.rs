//! How far sweeps over some contacts have come, and when they are done.

use super::super::problem::squared_motion;
use super::super::solvers::largest_of_motion;
use super::rows::Sums;

/// Residuals below this multiple of the rounding of the velocities that they come from cannot be reduced.
const ROUNDINGS: f64 = 16.0;

/// Stopping criteria of the sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Largest scaled residual [-] of a converged solution.
    pub tolerance: f64,
    /// Largest number of sweeps over all contacts, or over each group that goes on by itself.
    pub max_sweeps: usize,
    /// Scaled residual [-] at which sweeps that make no progress stop.
    pub acceptable: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_sweeps: 1000, acceptable: 0.0 }
    }
}

/// Outcome of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// Sweeps over all contacts, those without friction included, and then over the group that took most.
    pub sweeps: usize,
    /// Scaled natural-map residual [-]: `‖D^½ F‖ / max(‖D^½ p‖, ‖D^−½ q‖)`, with `D = tr W_cc / 3` per contact, F at
    /// `ρ = 1/D`, and q the free relative velocities of the closing contacts.
    pub residual: f64,
    /// The same relative to the motion [-], the free velocities or what impulses change, `(pᵀ W p)^½`, so that growing impulses cannot
    /// hide a contact that nothing can stop.
    pub residual_of_motion: f64,
    /// The same relative to the free velocities alone, `‖D^½ F‖ / ‖D^−½ q‖` [-]: what a heavy body on a light one keeps of its approach.
    pub residual_of_free: f64,
    /// The residual is within the tolerance, or at the rounding of the velocities.
    pub converged: bool,
}

/// What residuals are relative to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// `Σ D⁻¹ |q|²` of the closing contacts.
    pub closing: f64,
    /// The larger of that and of the squared norm of the impulses, and the squared motion, if they are given; otherwise those of the
    /// impulses found.
    pub sizes: Option<[f64; 2]>,
}

impl Scale {
    /// That of the impulses found.
    pub fn found(&self, sums: &Sums) -> Self {
        let motion = squared_motion(self.closing, sums.motion, sums.impulse);
        Self { sizes: Some([self.closing.max(sums.impulse), motion]), ..*self }
    }

    /// A share of it.
    pub fn share(&self, share: f64) -> Self {
        Self { closing: share * self.closing, sizes: self.sizes.map(|sizes| sizes.map(|size| share * size)) }
    }

    /// The report on sums of the natural map after so many sweeps.
    pub fn report(&self, sweeps: usize, sums: &Sums, tolerance: f64) -> SolveReport {
        let [size, motion] = self.sizes.or(self.found(sums).sizes).unwrap_or([self.closing; 2]);
        let [residual, residual_of_motion, residual_of_free] =
            [size, motion, self.closing].map(|size| (sums.change / size).sqrt());
        let rounding = ROUNDINGS * f64::EPSILON * sums.rounding.sqrt();
        // Growing impulses must not hide a contact that they do not stop.
        let is_small = residual <= tolerance && residual_of_motion <= largest_of_motion(tolerance);
        SolveReport {
            sweeps,
            residual,
            residual_of_motion,
            residual_of_free,
            converged: is_small || sums.change.sqrt() <= rounding,
        }
    }
}

/// How far sweeps have come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweeps<'a> {
    pub options: &'a Options,
    /// Number of sweeps without friction, and of those with it.
    pub done: usize,
    pub with_friction: usize,
    /// Factor on the steps of frictional contacts.
    pub damping: f64,
    /// Change of a sweep at the last check of progress [√J], and the least squared change since [J].
    pub last_look: f64,
    pub least: f64,
    /// Squared change of the last sweep [J].
    pub last_change: f64,
    /// Half of the relative change at the last look [-].
    pub half: f64,
}

impl<'a> Sweeps<'a> {
    /// Before the first of them.
    pub fn beginning(options: &'a Options) -> Self {
        let never = f64::INFINITY;
        Self {
            options,
            done: 0,
            with_friction: 0,
            damping: 1.0,
            last_look: never,
            least: never,
            last_change: never,
            half: never,
        }
    }
}
