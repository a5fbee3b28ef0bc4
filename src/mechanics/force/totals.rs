//! Energies and extremes of an evaluation.

use super::pressure::stable_step;
use crate::lanes::{BATCH, Lane, Row};
use crate::real::Real;
use crate::registers::Registers;

/// Sums and extremes of one batch, lane by lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BatchTotals {
    /// Strain energy of each element, that of its stabilisation included [J].
    pub strain: Row,
    /// Strain energy in the stabilisation [J]; 0 in formulations without one.
    pub hourglass: Row,
    /// Energy that bulk viscosity and damage dissipated in the last step [J].
    pub viscous: Row,
    /// Energy stored with the stress of history: in the branches of Prony series, by internal variables [J].
    pub branches: Row,
    /// Mean damage of a material that softens [-].
    pub damage: Row,
    /// Largest critical time step [s].
    pub stable_step: Row,
    /// Reduction by damping: half of the largest viscous eigenvalue, of bulk and shear viscosity [1/s].
    pub damping: Row,
    /// Smallest J − 1 over the points [-]; ≤ −1 means inverted.
    pub smallest_j: Row,
    /// Largest fibre exponent k2 E² over points and families [-]; 0 without fibres.
    pub fibre_exponent: Row,
}

impl BatchTotals {
    /// Stores the critical time step and the damping in it of the elements of a register, from ω² [1/s²] and the viscous eigenvalue [1/s].
    #[inline(always)]
    pub(super) fn store_step<S: Registers>(&mut self, omega_squared: Lane<S>, viscous: Lane<S>, part: usize) {
        (viscous * 0.5).store(&mut self.damping, part);
        stable_step(omega_squared, viscous).store(&mut self.stable_step, part);
    }

    /// Adds to the ω² [1/s²] and to half of the viscous eigenvalue [1/s] behind the critical time step at hand: `(2/h − a)² = ω² + a²`.
    #[inline(always)]
    pub(super) fn shorten_step<S: Registers>(
        &mut self,
        simd: S,
        omega_squared: Lane<S>,
        half: Lane<S>,
        part: usize,
    ) {
        let a = Lane::load(simd, &self.damping, part);
        let twice_rate = a.constant(2.0) / Lane::load(simd, &self.stable_step, part);
        let known = (twice_rate * (twice_rate - a * 2.0)).max(a.zero());
        self.store_step(known + omega_squared, (a + half) * 2.0, part);
    }
}

/// The totals of many elements as one: sums in slot order, extremes with their slot in the block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockTotals {
    /// Strain energy, that of the stabilisation included [J].
    pub strain: f64,
    /// Strain energy in the stabilisation [J].
    pub hourglass: f64,
    /// Energy that bulk viscosity and damage dissipated in the last step [J].
    pub viscous: f64,
    /// Energy stored with the stress of history: in the branches of Prony series, by internal variables [J].
    pub branches: f64,
    /// Smallest critical time step [s] and its slot.
    pub stable_step: (f64, usize),
    /// Smallest J − 1 [-] and its slot.
    pub smallest_j: (f64, usize),
    /// Largest fibre exponent [-] and its slot.
    pub fibre_exponent: (f64, usize),
}

impl BlockTotals {
    /// Totals of no element: zero sums, and extremes that any element replaces.
    pub const NONE: Self = Self {
        strain: 0.0,
        hourglass: 0.0,
        viscous: 0.0,
        branches: 0.0,
        stable_step: (f64::INFINITY, 0),
        smallest_j: (f64::INFINITY, 0),
        fibre_exponent: (0.0, 0),
    };

    /// Sums over batches in order, the first of which begins at slot `first`.
    pub(super) fn of_batches(first: usize, batches: &[BatchTotals]) -> Self {
        let mut sum = Self::NONE;
        for (b, batch) in batches.iter().enumerate() {
            for lane in 0..BATCH {
                let slot = first + b * BATCH + lane;
                sum.add(&Self {
                    strain: batch.strain.0[lane],
                    hourglass: batch.hourglass.0[lane],
                    viscous: batch.viscous.0[lane],
                    branches: batch.branches.0[lane],
                    stable_step: (batch.stable_step.0[lane], slot),
                    smallest_j: (batch.smallest_j.0[lane], slot),
                    fibre_exponent: (batch.fibre_exponent.0[lane], slot),
                });
            }
        }
        sum
    }

    /// Adds the totals of the slots that follow.
    pub(super) fn add(&mut self, next: &Self) {
        self.strain += next.strain;
        self.hourglass += next.hourglass;
        self.viscous += next.viscous;
        self.branches += next.branches;
        // Written so that a NaN wins and stays: it must be seen, not skipped.
        if !(next.stable_step.0 >= self.stable_step.0 || self.stable_step.0.is_nan()) {
            self.stable_step = next.stable_step;
        }
        if !(next.smallest_j.0 >= self.smallest_j.0 || self.smallest_j.0.is_nan()) {
            self.smallest_j = next.smallest_j;
        }
        if next.fibre_exponent.0 > self.fibre_exponent.0 {
            self.fibre_exponent = next.fibre_exponent;
        }
    }
}
