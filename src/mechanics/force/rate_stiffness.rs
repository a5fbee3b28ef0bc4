//! Tangent stiffness of viscosity and history in implicit steps, to be added to that of the law: the derivative of their forces at the
//! end of a step by the displacement there,
//!
//! ```text
//! A = ∂P/∂F + 1/(θh) ∂P/∂Ḟ        K = Σ_q w ∇Nᵀ ½ (A + Aᵀ) ∇N
//! ```
//!
//! exact by dual numbers, with the history at the beginning of the step held. A itself is not symmetric: by terms of the size of the stress of
//! memory or viscosity, and by what relaxation takes of the volume change from fibres that resist it (`"i4": "full"`), of which only the
//! deviator relaxes. Linear systems are symmetric, and leave the rest to Newton's iteration.

use super::block::ElementBlock;
use super::chunk::Chunk;
use super::first_pass::FirstPass;
use super::memory::{Past, sizes, take_over_step};
use super::packed::{InBlocks, Packed, with_elements};
use super::parameters::BlockParameters;
use super::reduced::OnePointBatch;
use super::rows::{gather_global, load_corners};
use super::shear_viscosity::viscous_stress;
use super::stiffness::{
    CORNER_PAIRS, StiffnessBatch, add_pairs, fixed, fixed_fibres, fixed_tensor, gradients, store_column,
};
use crate::dual::Dual;
use crate::lanes::{BATCH, Lane, Row, dispatch_rare};
use crate::material::{Kinematics, MemorySteps, volume_change};
use crate::real::{Outlined, Real};
use crate::tensor::{Tensor, Vec3};
use pulp::{Simd, WithSimd};

/// The end of an implicit step, and what was before.
#[derive(Clone, Copy, Debug)]
pub struct EndOfStep<'a> {
    /// Displacements at the end [m], nodes × 3.
    pub u: &'a [Vec3],
    /// Velocities at the end [m/s], nodes × 3.
    pub v: &'a [Vec3],
    /// Step size h [s].
    pub h: f64,
    /// ∂v/∂u at the end, 1/(θh) [1/s].
    pub velocity_slope: f64,
    /// History of each chunk of all blocks at the beginning.
    pub history: &'a [Vec<Row>],
}

impl ElementBlock {
    /// Adds the tangent stiffness of viscosity and history of the elements of a batch.
    pub fn add_rate_stiffness(&self, batch: usize, end: &EndOfStep, stiffness: &mut StiffnessBatch) {
        let nodes = self.nodes_of_chunk(batch / Chunk::BATCHES);
        with_elements!(&self.packed, elements => dispatch_rare(RateStiffness {
            block: self,
            elements,
            batch,
            steps: self.parameters.memory.step(end.h),
            velocity_slope: end.velocity_slope,
            history: self.history_of(batch, end.history),
            size: sizes(&elements.batches[batch].volume),
            u: gather_global(&elements.batches[batch].nodes, nodes, end.u),
            v: gather_global(&elements.batches[batch].nodes, nodes, end.v),
            to: stiffness,
        }));
    }

    /// History of the points of a batch; empty without memory.
    fn history_of<'a>(&self, batch: usize, history: &'a [Vec<Row>]) -> &'a [Row] {
        let rows = self.history_rows();
        let first = batch % Chunk::BATCHES * rows;
        let of_chunk = history.get(self.chunk_number(batch / Chunk::BATCHES));
        of_chunk.map_or(&[], |chunk| &chunk[first + self.bulk_rows()..first + rows])
    }
}

/// A batch at the end of an implicit step.
struct RateStiffness<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    block: &'a ElementBlock,
    elements: &'a Packed<E, N, Q>,
    batch: usize,
    steps: MemorySteps,
    velocity_slope: f64,
    history: &'a [Row],
    size: Row,
    u: [[Row; N]; 3],
    v: [[Row; N]; 3],
    to: &'a mut StiffnessBatch,
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for RateStiffness<'_, E, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..BATCH / S::F64_LANES {
            let mut sums = [[Lane::splat(simd, 0.0); 9]; CORNER_PAIRS];
            let first_pass = self.elements.batches[self.batch].first_pass(simd, part, &self.u);
            if self.block.parameters.shear_viscosity > 0.0 {
                self.add_viscosity(simd, part, &first_pass, &mut sums);
            }
            if !self.history.is_empty() {
                self.add_memory(simd, part, &first_pass, &mut sums);
            }
            for (to, sum) in self.to.0.as_flattened_mut().iter_mut().zip(sums.as_flattened()) {
                (Lane::load(simd, to, part) + *sum).store(to, part);
            }
        }
    }
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> RateStiffness<'_, E, N, Q> {
    /// ∇N of the corners [1/m] at a point.
    #[inline(always)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        part: usize,
        q: usize,
        first_pass: &FirstPass<Lane<S>, Q>,
    ) -> [[Lane<S>; 3]; N] {
        let inverse_weight = Lane::load(simd, &self.elements.batches[self.batch].inverse_weight[q], part);
        gradients::<E, _, N, Q>(q, &first_pass.cof_X.0[q].scaled(inverse_weight))
    }

    #[inline(always)]
    fn add_viscosity<S: Simd>(
        &self,
        simd: S,
        part: usize,
        first_pass: &FirstPass<Lane<S>, Q>,
        sums: &mut [[Lane<S>; 9]; CORNER_PAIRS],
    ) {
        let eta = self.block.parameters.shear_viscosity;
        let local_v = E::local_gradients(&load_corners(simd, &self.v, part));
        for q in 0..Q {
            let cof_X = &first_pass.cof_X.0[q];
            let rate = self.elements.batches[self.batch].gradient_at(simd, part, &local_v, (q, cof_X));
            let H = &first_pass.H.0[q];
            let A = rate.0[0][0].outlined(ViscousTangent { eta, H, rate: &rate, slope: self.velocity_slope });
            let g = self.gradients(simd, part, q, first_pass);
            add_pairs(sums, &A, &g, first_pass.w.0[q] * E::SCALE);
        }
    }

    #[inline(always)]
    fn add_memory<S: Simd>(
        &self,
        simd: S,
        part: usize,
        first_pass: &FirstPass<Lane<S>, Q>,
        sums: &mut [[Lane<S>; 9]; CORNER_PAIRS],
    ) {
        let zero = Lane::splat(simd, 0.0);
        let Some(one_point) = self.elements.one_point.get(self.batch) else {
            for q in 0..Q {
                let A = self.memory_tangent(simd, part, q, &first_pass.H.0[q]);
                let g = self.gradients(simd, part, q, first_pass);
                add_pairs(sums, &A, &g, first_pass.w.0[q] * E::SCALE);
            }
            return;
        };
        // At their one point, with the mean gradients.
        let (mut mean, mut volume) = ([[zero; 3]; N], zero);
        for q in 0..Q {
            let (g, w) = (self.gradients(simd, part, q, first_pass), first_pass.w.0[q] * E::SCALE);
            volume += w;
            for (mean, g) in mean.as_flattened_mut().iter_mut().zip(g.as_flattened()) {
                *mean += *g * w;
            }
        }
        // Padding has no volume.
        let inverse = volume.select_positive(volume.constant(1.0) / volume, zero);
        for mean in mean.as_flattened_mut() {
            *mean = *mean * inverse;
        }
        let A = self.memory_tangent(simd, part, 0, &one_point.mean_gradient(simd, part, &self.u));
        add_pairs(sums, &A, &mean, volume);
    }

    /// Symmetric part of ∂P/∂F [Pa] of what the history of a point adds.
    #[inline(always)]
    fn memory_tangent<S: Simd>(
        &self,
        simd: S,
        part: usize,
        q: usize,
        H: &Tensor<Lane<S>>,
    ) -> [[Lane<S>; 9]; 9] {
        let rows = self.block.memory_rows();
        let directions = fixed_fibres(simd, self.block.fibres_of(self.batch), part);
        Lane::splat(simd, 0.0).outlined(MemoryTangent {
            parameters: &self.block.parameters,
            steps: &self.steps,
            H,
            fibres: &directions[..self.block.parameters.material.family_count()],
            size: fixed(Lane::load(simd, &self.size, part)),
            history: Past { simd, part, rows: &self.history[q * rows..(q + 1) * rows] },
        })
    }
}

/// Symmetric part of ∂P/∂F [Pa] of what the history of a point adds.
struct MemoryTangent<'a, S: Simd> {
    parameters: &'a BlockParameters,
    steps: &'a MemorySteps,
    H: &'a Tensor<Lane<S>>,
    fibres: &'a [[Dual<Lane<S>>; 3]],
    size: Dual<Lane<S>>,
    history: Past<'a, S>,
}

impl<S: Simd> Outlined for MemoryTangent<'_, S> {
    type Output = [[Lane<S>; 9]; 9];

    #[inline(always)]
    fn run(mut self) -> [[Lane<S>; 9]; 9] {
        let zero = self.size.value.zero();
        let mut A = [[zero; 9]; 9];
        let mut lifted = fixed_tensor(self.H);
        for column in 0..9 {
            lifted.0[column / 3][column % 3].slope = zero.constant(1.0);
            let k = Kinematics::new(&lifted);
            let (kinematics, of_element) = ((&k, self.fibres), (self.size.zero(), self.size));
            let (_, inelastic) =
                take_over_step(self.parameters, self.steps, kinematics, of_element, &mut self.history);
            store_column(&k.F.dot_sym(&inelastic.S), column, &mut A);
            lifted.0[column / 3][column % 3].slope = zero;
        }
        symmetric(&A)
    }
}

/// Symmetric part of ∂P/∂F + `slope` ∂P/∂Ḟ [Pa] of a viscosity η [Pa s].
struct ViscousTangent<'a, R> {
    eta: f64,
    H: &'a Tensor<R>,
    rate: &'a Tensor<R>,
    slope: f64,
}

impl<R: Real> Outlined for ViscousTangent<'_, R> {
    type Output = [[R; 9]; 9];

    #[inline(always)]
    fn run(self) -> [[R; 9]; 9] {
        let Self { eta, H, rate, slope } = self;
        let zero = H.0[0][0].zero();
        let mut A = [[zero; 9]; 9];
        let (mut H, mut rate) = (fixed_tensor(H), fixed_tensor(rate));
        let identity = Tensor::diagonal(fixed(zero.constant(1.0)));
        for column in 0..9 {
            let (i, j) = (column / 3, column % 3);
            (H.0[i][j].slope, rate.0[i][j].slope) = (zero.constant(1.0), zero.constant(slope));
            let cof_F = H.plus(&identity).cofactor();
            store_column(&viscous_stress(eta, &rate, &cof_F, volume_change(&H)), column, &mut A);
            (H.0[i][j].slope, rate.0[i][j].slope) = (zero, zero);
        }
        symmetric(&A)
    }
}

/// ½ (A + Aᵀ)
#[inline(always)]
fn symmetric<R: Real>(A: &[[R; 9]; 9]) -> [[R; 9]; 9] {
    let mut out = *A;
    for i in 0..9 {
        for j in 0..9 {
            out[i][j] = (A[i][j] + A[j][i]) * 0.5;
        }
    }
    out
}

#[cfg(test)]
mod tests;
