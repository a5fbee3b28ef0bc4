//! The mean force of a step whose work is exactly the strain energy that the step stores.
//!
//! The force in the middle, `f(u_m)` with `u_m = ½ (u + u⁺)`, conserves both momenta, but its work misses the change of the
//! strain energy Ψ by what is of third order in the step. A chunk of elements makes up for it along the change of its strains,
//!
//! ```text
//! f̄ = f(u_m) + α g          g = Σ_q w F_m ΔE ∇N          ΔE = ½ (F⁺ᵀ F⁺ − Fᵀ F)
//! α = [Ψ⁺ − Ψ − f(u_m) · (u⁺ − u)] / Σ_q w ΔE:ΔE
//! ```
//!
//! since `g · (u⁺ − u) = Σ_q w ΔE:ΔE`. Neither force resultant nor moment comes of it: `F_m ΔE F_mᵀ` is symmetric. That is the
//! discrete gradient of Gonzalez (2000) with one multiplier a chunk in place of one a point, so that it serves every law and
//! formulation by its energy and its forces alone.

use super::block::{CORNER_SCALE, ElementBlock};
use super::chunk::ChunkForces;
use super::{BATCH, ElementForces, Threads};
use crate::mechanics::element::{Hex8, POINTS};
use crate::mechanics::tensor::{Mat3, Vec3};

/// An energy below this share of what it is the difference of is rounding.
const ROUNDING: f64 = 1e-14;

impl ElementForces {
    /// Strain energy of each chunk as of the last sweep [J].
    pub fn chunk_energies(&self, energies: &mut Vec<f64>) {
        energies.clear();
        energies.extend(self.chunks.iter().map(|chunk| chunk.totals.strain));
    }

    /// Makes the forces of a sweep in the middle between two displacements [m], nodes × 3, conserve; `energies` are those of the
    /// chunks [J] at either end.
    pub fn conserve(
        &mut self,
        threads: &Threads,
        blocks: &[ElementBlock],
        [before, after]: [&[Vec3]; 2],
        energies: [&[f64]; 2],
    ) {
        let mut energies: Vec<_> = energies[0].iter().copied().zip(energies[1].iter().copied()).collect();
        threads.for_each_run(1, (&mut self.chunks[..], &mut energies[..]), |_, chunk, energies| {
            for (chunk, energies) in chunk.iter_mut().zip(energies) {
                blocks[chunk.block as usize].conserve([before, after], *energies, chunk);
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
        let (mut g, mut square) = (vec![Vec3::zeros(); nodes.len()], 0.0);
        let chunk = &self.chunks[forces.chunk as usize];
        for batch in &self.batches[chunk.batches.start as usize..chunk.batches.end as usize] {
            for lane in 0..BATCH {
                let local = batch.nodes.map(|nodes| nodes[lane] as usize);
                let ends = local.map(|a| [before, after].map(|u| u[nodes[a] as usize]));
                let X: [Vec3; 8] =
                    std::array::from_fn(|a| Vec3::from_fn(|i, _| batch.corners[i][a].0[lane] * CORNER_SCALE));
                for q in 0..POINTS {
                    let inverse_weight = batch.inverse_weight[q].0[lane];
                    // What pads the last batch has none.
                    if inverse_weight > 0.0 {
                        let (point, gradients) = change_of_strain(&X, &ends, q);
                        square += point.dE.norm_squared() / inverse_weight;
                        let P = point.F * point.dE / inverse_weight;
                        for (a, gradient) in local.iter().zip(&gradients) {
                            g[*a] += P * gradient;
                        }
                    }
                }
            }
        }
        if square > 0.0 {
            for (force, g) in forces.force.iter_mut().zip(&g) {
                *force += g * (lacking / square);
            }
        }
    }
}

/// F in the middle of the step and ΔE over it.
struct ChangeOfStrain {
    F: Mat3,
    dE: Mat3,
}

/// Of a point of an element with displacements [before, after] of its corners, and ∇N there [1/m].
fn change_of_strain(X: &[Vec3; 8], ends: &[[Vec3; 2]; 8], q: usize) -> (ChangeOfStrain, [Vec3; 8]) {
    let local = Hex8::local_shape_gradients()[q].map(Vec3::from);
    let outer = |vectors: [Vec3; 8], gradients: &[Vec3; 8]| {
        vectors.iter().zip(gradients).fold(Mat3::zeros(), |sum, (v, g)| sum + v * g.transpose())
    };
    let inverse = outer(*X, &local).try_inverse().unwrap_or_else(Mat3::zeros);
    let gradients = local.map(|g| inverse.tr_mul(&g));
    let H = [0, 1].map(|end| outer(ends.map(|u| u[end]), &gradients));
    let F = Mat3::identity() + (H[0] + H[1]) * 0.5;
    // ½ (F⁺ᵀ F⁺ − Fᵀ F) = sym(F_mᵀ ΔF)
    let half = F.tr_mul(&(H[1] - H[0])) * 0.5;
    (ChangeOfStrain { F, dE: half + half.transpose() }, gradients)
}

#[cfg(test)]
mod tests;
