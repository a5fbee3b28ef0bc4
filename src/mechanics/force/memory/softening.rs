//! Damage of the elements of a register: what it removes from forces and strain energy, and adds to dissipation.
//!
//! Unlike relaxing stress, which is an addition with a separate work, damage degrades the stress of the elastic law, so
//! that the ledger compares the work of what is left with (1 − d) ψ and the energy that damage dissipates.

use crate::force::block::ElementBlock;
use crate::force::first_pass::FirstPass;
use crate::force::packed::{Batch, InBlocks};
use crate::force::parameters::Formulation;
use crate::force::rows::store_corners;
use crate::force::totals::BatchTotals;
use crate::lanes::{Aligned, Lane, Row};
use crate::material::{ElasticPoint, Inelastic, Kinematics, Volumetric};
use crate::real::Real;
use crate::tensor::Tensor;
use pulp::Simd;

/// U(J) of a material that softens, where J > 1.
pub(in crate::force) struct Tension<R> {
    /// `None` for a material that does not soften.
    U: Option<Volumetric>,
    /// Whether J is the mean of the element.
    is_mean: bool,
    /// J̄ − 1 [-].
    mean: R,
}

impl<R: Real> Tension<R> {
    /// Tension of elements with a mean dilatation J̄ − 1 [-].
    #[inline(always)]
    pub fn new(block: &ElementBlock, mean: R) -> Self {
        let U = block.parameters.material.volumetric().filter(|_| block.parameters.memory.softens());
        Self { U, is_mean: block.parameters.formulation == Formulation::MeanDilatation, mean }
    }
    /// J − 1 where positive, else 0 [-].
    #[inline(always)]
    fn dilatation(&self, k: &Kinematics<R>) -> R {
        (if self.is_mean { self.mean } else { k.j }).max(k.j.zero())
    }
    /// Volumetric energy U(J) of a split law; 0 for others [J/m³].
    #[inline(always)]
    pub fn energy(&self, k: &Kinematics<R>) -> R {
        match self.U {
            Some(U) => U.energy(self.dilatation(k)),
            None => k.j.zero(),
        }
    }
    /// Volumetric response U′(J) of a split law; 0 for others [Pa].
    #[inline(always)]
    pub fn pressure(&self, k: &Kinematics<R>) -> R {
        match self.U {
            Some(U) => U.pressure(self.dilatation(k)),
            None => k.j.zero(),
        }
    }
}

/// Stress and energy removed at a point by full damage, and its damage.
#[derive(Clone, Copy)]
pub(super) struct Lost<R> {
    /// Isochoric part of the first Piola–Kirchhoff stress, F S_iso [Pa].
    P: Tensor<R>,
    /// U′ cof F [Pa].
    of_pressure: Tensor<R>,
    /// ψ and U [J/m³].
    energy: [R; 2],
    /// Damage d of the point [-].
    damage: R,
    /// Energy that damage dissipated in the step [J/m³].
    dissipated: R,
}

impl<R: Real> Lost<R> {
    /// An undamaged point loses nothing.
    #[inline(always)]
    pub fn none(zero: R) -> Self {
        let P = Tensor::diagonal(zero);
        Self { P, of_pressure: P, energy: [zero; 2], damage: zero, dissipated: zero }
    }
    /// Degradable stress of a point with the pressure U′ [Pa].
    #[inline(always)]
    pub fn new(elastic: &ElasticPoint<R>, point: &Inelastic<R>, pressure: R) -> Self {
        Self {
            P: elastic.k.F.dot_sym(&elastic.S_iso),
            of_pressure: elastic.k.cof.scaled(pressure),
            energy: [elastic.psi, elastic.tension],
            damage: point.damage,
            dissipated: point.dissipated,
        }
    }
}

/// Stress and energy removed by damage at all points of the elements of a register.
pub(super) struct LostAtPoints<'a, R, const Q: usize> {
    pub points: &'a [Lost<R>; Q],
    /// Whether the first stands for all.
    pub is_one_point: bool,
    /// Whether the pressure is that of a mean dilatation.
    pub has_mean_dilatation: bool,
}

impl<R, const Q: usize> LostAtPoints<'_, R, Q> {
    #[inline(always)]
    fn at(&self, q: usize) -> &Lost<R> {
        &self.points[if self.is_one_point { 0 } else { q }]
    }
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> Batch<E, N, Q> {
    /// Forces [N] that elements lose; corrects their strain energy and dissipation.
    #[inline(always)]
    pub(super) fn soften<S: Simd>(
        &self,
        (simd, part): (S, usize),
        first: &FirstPass<Lane<S>, Q>,
        lost: &LostAtPoints<Lane<S>, Q>,
        forces: &mut [[Row; N]; 3],
        totals: &mut BatchTotals,
    ) {
        let zero = Lane::splat(simd, 0.0);
        let (w, cof_X) = (&first.w.0, &first.cof_X.0);
        // A pressure of the whole element is lost with the mean of the damage.
        let mut mean = zero;
        for q in 0..Q {
            mean = w[q].mul_add(lost.at(q).damage, mean);
        }
        mean = mean * Lane::load(simd, &self.scaled_inverse_volume, part);

        mean.store(&mut totals.damage, part);

        let mut sums = Aligned(E::no_stress(zero));
        let (mut energy, mut dissipated) = (zero, zero);
        for q in 0..Q {
            let point = lost.at(q);
            let of_pressure = if lost.has_mean_dilatation { mean } else { point.damage };
            let P = point.P.scaled(-point.damage).plus_scaled(-of_pressure, &point.of_pressure);
            E::add_local_stress(&mut sums.0, q, &P, &cof_X[q]);
            let density = point.damage.mul_add(point.energy[0], of_pressure * point.energy[1]);
            energy = w[q].mul_add(density, energy);
            dissipated = w[q].mul_add(point.dissipated, dissipated);
        }
        store_corners(&E::nodal_forces(&sums.0), forces, part);
        (Lane::load(simd, &totals.strain, part) - energy * E::SCALE).store(&mut totals.strain, part);
        (Lane::load(simd, &totals.viscous, part) + dissipated * E::SCALE).store(&mut totals.viscous, part);
    }
}
