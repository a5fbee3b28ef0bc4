//! The mean force of a step whose work is exactly the strain energy that the step stores.
//!
//! A force in the middle, `f_m = D⁻¹ f(ũ)`, conserves both momenta, where `F̃ = D F_m` with one symmetric D a body, and F_m of
//! `u_m = ½ (u + u⁺)`. But its work misses the change of the strain energy Ψ by what is of third order in the step. A chunk of elements
//! makes up for it along the change of its strains,
//!
//! ```text
//! f̄ = f_m + α g          g = Σ_q w F_m ΔE ∇N          ΔE = ½ (F⁺ᵀ F⁺ − Fᵀ F)
//! α = [Ψ⁺ − Ψ − f_m · (u⁺ − u)] / Σ_q w ΔE:ΔE
//! ```
//!
//! since `g · (u⁺ − u) = Σ_q w ΔE:ΔE`. Neither force resultant nor moment comes of it: `F_m ΔE F_mᵀ` is symmetric. That is the
//! discrete gradient of Gonzalez (2000) with one multiplier a chunk in place of one a point, so that it serves every law and
//! formulation by its energy and its forces alone.

use super::block::ElementBlock;
use super::chunk::{Chunk, ChunkForces};
use super::packed::{Batch, InBlocks, Packed, with_elements};
use super::rows::{add, gather, load_corners, store_corners};
use super::{ElementForces, Threads};
use crate::element::Element;
use crate::lanes::{BATCH, Lane, Row, dispatch_rare};
use crate::real::Real;
use crate::tensor::{Mat3, Sym, Tensor, Vec3};
use pulp::{Simd, WithSimd};

/// An energy below this fraction of what it is the difference of is rounding.
const ROUNDING: f64 = 1e-14;

impl ElementForces {
    /// Strain energy of each chunk as of the last evaluation [J].
    pub fn chunk_energies(&self, energies: &mut Vec<f64>) {
        energies.clear();
        energies.extend(self.chunks.iter().map(|chunk| chunk.totals.strain));
    }

    /// Makes the forces of an evaluation in the middle between two displacements [m], nodes × 3, conserve, with D⁻¹ of each body; `energies`
    /// are those of the chunks [J] at either end.
    pub fn conserve(
        &mut self,
        threads: &Threads,
        blocks: &[ElementBlock],
        (ends, narrowing): ([&[Vec3]; 2], &[Mat3]),
        energies: [&[f64]; 2],
    ) {
        let mut energies: Vec<_> = energies[0].iter().copied().zip(energies[1].iter().copied()).collect();
        threads.for_each_run(1, (&mut self.chunks[..], &mut energies[..]), |_, chunk, energies| {
            for (chunk, energies) in chunk.iter_mut().zip(energies) {
                let block = &blocks[chunk.block as usize];
                chunk.force.iter_mut().for_each(|f| *f = narrowing[block.body] * *f);
                block.conserve(ends, *energies, chunk);
            }
        });
    }
}

impl ElementBlock {
    fn conserve(&self, [before, after]: [&[Vec3]; 2], energies: (f64, f64), forces: &mut ChunkForces) {
        let nodes = self.nodes_of_chunk(forces.chunk as usize);
        let moved = nodes.iter().map(|node| after[*node as usize] - before[*node as usize]);
        let (mut work, mut size) = (0.0, energies.0.abs() + energies.1.abs());
        for (du, f) in moved.zip(&forces.force) {
            work += du.dot(f);
            size += du.dot(f).abs();
        }
        let lacking = energies.1 - energies.0 - work;
        if lacking.abs() <= ROUNDING * size {
            return;
        }
        let [before, after] = [before, after].map(|u| nodes.iter().map(|node| u[*node as usize]).collect());
        let mut g = vec![Vec3::zeros(); nodes.len()];
        let chunk = &self.chunks[forces.chunk as usize];
        let (ends, to) = (&[before, after], &mut g[..]);
        let square = with_elements!(&self.packed, elements => {
            dispatch_rare(ChangeOfStrain { elements, chunk, ends, g: to })
        });
        if square > 0.0 {
            for (force, g) in forces.force.iter_mut().zip(&g) {
                *force += g * (lacking / square);
            }
        }
    }
}

/// The sum Σ_q w ΔE:ΔE [m³] over a chunk, and its g [m²].
struct ChangeOfStrain<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    elements: &'a Packed<E, N, Q>,
    chunk: &'a Chunk,
    /// Displacements of the nodes of the chunk before and after the step [m].
    ends: &'a [Vec<Vec3>; 2],
    g: &'a mut [Vec3],
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for ChangeOfStrain<'_, E, N, Q> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { elements, chunk, ends: [before, after], g } = self;
        let (mut u, mut forces) = ([[Row::default(); N]; 3], [[Row::default(); N]; 3]);
        let (mut squares, mut sum) = (Row::default(), 0.0);
        let range = &chunk.batches;
        for batch in &elements.batches[range.start as usize..range.end as usize] {
            gather(&batch.nodes, before, &mut u);
            gather(&batch.nodes, after, &mut forces);
            for part in 0..BATCH / S::F64_LANES {
                batch.change_of_strain(simd, part, &u, &mut forces).store(&mut squares, part);
            }
            sum += squares.0.iter().sum::<f64>();
            add(&forces, &batch.nodes, g);
        }
        sum
    }
}

impl<E: Element<N, Q>, const N: usize, const Q: usize> Batch<E, N, Q> {
    /// Replaces the displacements after the step [m] by g [m²], and gives Σ_q w ΔE:ΔE [m³], of the elements of a register with the
    /// displacements `before` [m].
    #[inline(always)]
    fn change_of_strain<S: Simd>(
        &self,
        simd: S,
        part: usize,
        before: &[[Row; N]; 3],
        after: &mut [[Row; N]; 3],
    ) -> Lane<S> {
        let zero = Lane::splat(simd, 0.0);
        let identity = Tensor::diagonal(zero + 1.0);
        let first = self.first_pass(simd, part, before);
        let local_after = E::local_gradients(&load_corners(simd, after, part));
        let mut sums = E::no_stress(zero);
        let mut square = zero;
        for q in 0..Q {
            let (H, cof_X) = (&first.H.0[q], &first.cof_X.0[q]);
            let change = self.gradient_at(simd, part, &local_after, (q, cof_X)).plus_scaled(zero - 1.0, H);
            let F = H.plus(&identity).plus_scaled(zero + 0.5, &change);
            // ½ (F⁺ᵀ F⁺ − Fᵀ F) = sym(F_mᵀ ΔF); no closures, which would be compiled without the instruction set of the lanes.
            let mut dE = Sym([zero; 6]);
            for (sum, (a, b)) in dE.0.iter_mut().zip(Sym::<Lane<S>>::INDICES) {
                let (mut ab, mut ba) = (zero, zero);
                for c in 0..3 {
                    ab = F.0[c][a].mul_add(change.0[c][b], ab);
                    ba = F.0[c][b].mul_add(change.0[c][a], ba);
                }
                *sum = (ab + ba) * 0.5;
            }
            square = (first.w.0[q] * E::SCALE).mul_add(dE.norm_squared(), square);
            E::add_local_stress(&mut sums, q, &F.dot_sym(&dE), cof_X);
        }
        store_corners(&E::nodal_forces(&sums), after, part);
        square
    }
}

#[cfg(test)]
mod tests;
