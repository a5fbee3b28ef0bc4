//! The internal force evaluation of one-point elements.

use super::internal::{BatchLanes, ElementForcePass, ElementKernel};
use super::packed::InBlocks;
use super::pressure::{Pressure, pressure_at, tangent_bound, viscous_pressure};
use super::reduced::{NoOnePoint, ReducedBatch};
use super::rows::{load_corners, load_fibres, store_corners};
use super::totals::BatchTotals;
use crate::element::{Hex8, Modes};
use crate::lanes::{Aligned, Lane};
use crate::material::{Invariants, Kinematics, Law};
use crate::real::Real;
use crate::registers::Registers;

/// The formulation with one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnePoint;

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> ElementKernel<E, N, Q> for OnePoint
where
    E::OnePoint: OnePointEvaluation<E, N, Q>,
{
    const HAS_POINTS: bool = false;

    #[inline(always)]
    fn evaluate<S: Registers, L: Law>(
        self,
        element: &ElementForcePass<L, E, N, Q>,
        simd: S,
        part: usize,
        lanes: &mut BatchLanes<S, N, Q>,
        totals: &mut BatchTotals,
    ) {
        if let Some(batch) = element.one_point {
            batch.evaluate(element, simd, part, lanes, totals);
        }
    }
}

/// What it does to the elements of a batch that fit into a register, see [`ElementKernel::evaluate`].
pub(super) trait OnePointEvaluation<E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    fn evaluate<S: Registers, L: Law>(
        &self,
        element: &ElementForcePass<L, E, N, Q>,
        simd: S,
        part: usize,
        lanes: &mut BatchLanes<S, N, Q>,
        totals: &mut BatchTotals,
    );
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> OnePointEvaluation<E, N, Q> for NoOnePoint {
    fn evaluate<S: Registers, L: Law>(
        &self,
        _: &ElementForcePass<L, E, N, Q>,
        _: S,
        _: usize,
        _: &mut BatchLanes<S, N, Q>,
        _: &mut BatchTotals,
    ) {
        match *self {}
    }
}

impl OnePointEvaluation<Hex8, 8, 8> for ReducedBatch {
    #[inline(always)]
    fn evaluate<S: Registers, L: Law>(
        &self,
        element: &ElementForcePass<L, Hex8, 8, 8>,
        simd: S,
        part: usize,
        lanes: &mut BatchLanes<S, 8, 8>,
        totals: &mut BatchTotals,
    ) {
        // A macro, not a closure: that would be compiled without the instruction set of this function.
        macro_rules! load {
            ($x:expr) => {
                Lane::load(simd, $x, part)
            };
        }
        let law = &element.law;
        let zero = Lane::splat(simd, 0.0);
        let modes = Aligned(Modes::new(&load_corners(simd, &lanes.nodal, part)));
        let (A, B) = self.gradient_vectors(simd, part);
        let H = modes.0.mean_gradient(&A, &B);

        // The law at the one point.
        let k = Kinematics::new(&H);
        let volume = load!(&self.volume);
        let viscous = viscous_pressure(
            element.parameters,
            element.inverse_step,
            load!(&self.length),
            k.j,
            load!(&lanes.before[0]),
        );
        let fibres = &load_fibres(simd, element.fibres, part)[..element.fibres.len()];
        let invariants = Invariants::new(&k);
        let point = law.eval_with_bounds(&k, &invariants, fibres);
        let response = point.response;
        let (mut psi, mut pressure) = (response.psi, Pressure { p: -viscous.0, stiffness: zero });
        if let Some(U) = law.volumetric() {
            psi += U.energy(k.j);
            pressure = pressure_at(U, k.j, viscous.0);
        }
        let tangent = tangent_bound(point.stiffness_bound, &invariants, &pressure);

        // The stabilisation, and the forces of both.
        let one_point = Aligned(self.one_point(simd, part, A, B));
        let hourglass = one_point.0.hourglass(&modes.0, &H);
        let mut forces = one_point.0.nodal_forces(&response.first_piola(&k, pressure.p), &hourglass);
        let (mut stabilisation, mut corner_frequency) = (hourglass.energy, zero);
        if one_point.0.corners_may_fold(k.j, &hourglass, part) {
            let energy;
            (energy, corner_frequency) =
                element.batch.add_corner_penalty((simd, part), &lanes.nodal, &mut forces);
            stabilisation += energy;
        }
        store_corners(&forces, &mut lanes.nodal, part);
        volume.mul_add(psi, stabilisation).store(&mut totals.strain, part);
        stabilisation.store(&mut totals.hourglass, part);
        lanes.store_history(k.j, viscous.0, part);
        lanes.dissipated(simd, volume, part).store(&mut totals.viscous, part);
        let bound = load!(&self.frequency_bound);
        let tangent = tangent.max(hourglass.stiffening * self.tangent_at_rest);
        let base = load!(&self.base_bound) * hourglass.base_stiffness;
        let omega_squared = bound.mul_add(tangent, base + corner_frequency);
        totals.store_step(omega_squared, bound * invariants.I2 * viscous.1, part);
        k.j.store(&mut totals.smallest_j, part);
        point.fibre_exponent.store(&mut totals.fibre_exponent, part);
    }
}
