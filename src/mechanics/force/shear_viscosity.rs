//! Shear viscosity of a part (Kelvin–Voigt): stress at a point, and forces of the elements of a register, of any law and formulation.
//!
//! ```text
//! l = Ḟ F⁻¹        σ_v = η dev(l + lᵀ) = (η/J) dev(s + sᵀ)        s = Ḟ cof Fᵀ = J l        P_v = σ_v cof F
//! ```
//!
//! with Ḟ of the half step before t_n in explicit steps, and at its end in implicit ones. Everything is taken at the points of the element, of
//! one-point hexahedra at 2×2×2 too: their hourglass modes are damped like any other motion. There and in crushed elements J may come near zero or below, so that 1/J is capped: the
//! stress stays objective and dissipates, whatever J.

use super::block::ElementBlock;
use super::chunk::ChunkForces;
use super::first_pass::FirstPass;
use super::packed::Batch;
use super::rows::{load_corners, store_corners};
use super::totals::BatchTotals;
use crate::element::Element;
use crate::lanes::{Aligned, Lane, Row};
use crate::material::bound_largest;
use crate::real::{Outlined, Real};
use crate::registers::Registers;
use crate::tensor::{Sym, Tensor, Vec3};

/// J below which 1/J grows no further [-].
const LEAST_J: f64 = 0.2;

/// Viscous Cauchy stress over the viscosity, `σ_v/η = dev(s + sᵀ)/J` [1/s], of the rate Ḟ [1/s] at `j = J − 1`.
#[inline(always)]
pub(super) fn stress_over_viscosity<R: Real>(rate: &Tensor<R>, cof_F: &Tensor<R>, j: R) -> Sym<R> {
    let s = rate.dot_transposed(cof_F);
    // Loops, not closures: those would be compiled without the instruction set of the lanes.
    let mut twice = Sym([j; 6]);
    for (sum, (a, b)) in twice.0.iter_mut().zip(Sym::<R>::INDICES) {
        *sum = s.0[a][b] + s.0[b][a];
    }
    twice.deviator().scaled(inverse_J(j))
}

/// First Piola–Kirchhoff stress P_v [Pa] of a viscosity η [Pa s] at the rate Ḟ [1/s] and `j = J − 1`.
#[inline(always)]
pub(super) fn viscous_stress<R: Real>(eta: f64, rate: &Tensor<R>, cof_F: &Tensor<R>, j: R) -> Tensor<R> {
    let zero = j.zero();
    let sigma = stress_over_viscosity(rate, cof_F, j).scaled(zero.constant(eta));
    let mut P = Tensor([[zero; 3]; 3]);
    for a in 0..3 {
        for b in 0..3 {
            for c in 0..3 {
                P.0[a][b] = sigma.at(a, c).mul_add(cof_F.0[c][b], P.0[a][b]);
            }
        }
    }
    P
}

/// 1/J, capped where an element is nearly crushed [-].
#[inline(always)]
fn inverse_J<R: Real>(j: R) -> R {
    j.constant(1.0) / (j + 1.0).max(j.constant(LEAST_J))
}

impl ChunkForces {
    /// Takes the velocities [m/s] of its nodes, and sets the forces of viscosity and memory to zero.
    pub(super) fn begin_viscous(&mut self, block: &ElementBlock, v: &[Vec3]) {
        self.viscous.fill(Vec3::zeros());
        for (of_chunk, node) in self.v.iter_mut().zip(block.nodes_of_chunk(self.chunk as usize)) {
            *of_chunk = v[*node as usize];
        }
    }
}

/// Shear viscosity of the elements of a register, within the pass of the internal forces: one copy for all laws.
pub(super) struct ShearViscosity<'a, S: Registers, E: Element<N, Q>, const N: usize, const Q: usize> {
    pub simd: S,
    pub batch: &'a Batch<E, N, Q>,
    pub part: usize,
    /// Viscosity η [Pa s].
    pub eta: f64,
    pub first: &'a FirstPass<Lane<S>, Q>,
    /// Velocities on entry [m/s], viscous forces on return [N]: `[component][node]`.
    pub rates: &'a mut [[Row; N]; 3],
    pub totals: &'a mut BatchTotals,
}

impl<S: Registers, E: Element<N, Q>, const N: usize, const Q: usize> Outlined
    for ShearViscosity<'_, S, E, N, Q>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { simd, batch, part, eta, first, rates, totals } = self;
        batch.viscous_forces::<S>(simd, part, eta, first, rates, totals);
    }
}

impl<E: Element<N, Q>, const N: usize, const Q: usize> Batch<E, N, Q> {
    /// Replaces the velocities [m/s] of the elements of a register by their viscous forces [N].
    #[inline(always)]
    pub(super) fn viscous_forces<S: Registers>(
        &self,
        simd: S,
        part: usize,
        eta: f64,
        first: &FirstPass<Lane<S>, Q>,
        rates: &mut [[Row; N]; 3],
        totals: &mut BatchTotals,
    ) {
        let zero = Lane::splat(simd, 0.0);
        let identity = Tensor::diagonal(zero.constant(1.0));
        let local_v = Aligned(E::local_gradients(&load_corners(simd, rates, part)));
        let mut sums = Aligned(E::no_stress(zero));
        let mut largest = zero;
        for q in 0..Q {
            let (cof_X, j) = (&first.cof_X.0[q], first.j.0[q]);
            let rate = self.gradient_at(simd, part, &local_v.0, (q, cof_X));
            let cof_F = first.H.0[q].plus(&identity).cofactor();

            let P = viscous_stress(eta, &rate, &cof_F, j);
            E::add_local_stress(&mut sums.0, q, &P, cof_X);

            // |P_v| ≤ 2 η/J |cof F|² |Ḟ|, by the largest eigenvalue of cof Fᵀ cof F.
            let mut square = Sym([zero; 6]);
            for (sum, (a, b)) in square.0.iter_mut().zip(Sym::<Lane<S>>::INDICES) {
                for c in 0..3 {
                    *sum = cof_F.0[c][a].mul_add(cof_F.0[c][b], *sum);
                }
            }
            let norm = bound_largest(square.trace() * (1.0 / 3.0), square.deviator().norm_squared());
            largest = largest.max(norm * inverse_J(j) * (2.0 * eta));
        }
        store_corners(&E::nodal_forces(&sums.0), rates, part);

        let half = Lane::load(simd, &self.frequency_bound, part) * largest * 0.5;
        totals.shorten_step(simd, zero, half, part);
    }
}
