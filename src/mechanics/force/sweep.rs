//! The force sweep: nodal forces, strain energy, viscous pressure and stable step of a chunk, in SIMD lanes.

use super::block::{Batch, BlockParameters, CORNER_SCALE, ElementBlock};
use super::chunk::ChunkForces;
use super::totals::{BatchTotals, BlockTotals};
use crate::mechanics::element::{Hex8, LocalGradients, POINTS};
use crate::mechanics::lanes::{Aligned, BATCH, Lane, Row};
use crate::mechanics::material::{
    Invariants, Kinematics, Law, MAX_FAMILIES, Material, Volumetric, volume_change,
};
use crate::mechanics::real::{Real, inverse_cbrt_m1};
use crate::mechanics::tensor::{Tensor, Vec3};
use pulp::{Simd, WithSimd};

/// What a sweep reads of the state.
#[derive(Clone, Copy, Debug)]
pub struct SweepInput<'a> {
    /// Displacement u_n [m], nodes × 3.
    pub u: &'a [Vec3],
    /// 1/h₋, the reciprocal of the last step [1/s]; 0 at the start.
    pub inverse_step: f64,
    /// J̄ − 1 at t_{n−1} of each slot of all blocks [-].
    pub dilatation: &'a [f64],
    /// Viscous pressure at t_{n−1} of each slot of all blocks [Pa].
    pub viscous_pressure: &'a [f64],
}

/// A monomorphised sweep behind one dynamic call a chunk.
pub(super) trait Kernel: std::fmt::Debug + Send + Sync {
    fn sweep(&self, block: &ElementBlock, input: &SweepInput, forces: &mut ChunkForces);
}

/// The kernel of a law and a formulation. A coupled law, which knows no mean dilatation, costs no kernel for it.
pub(super) fn kernel(parameters: &BlockParameters) -> Box<dyn Kernel> {
    match parameters.material {
        Material::CoupledNeoHookean(law) => new_kernel::<_, false>(law),
        Material::MooneyRivlin(law) => kernel_of_split(law, parameters),
        Material::NeoHookean(law) => kernel_of_split(law, parameters),
        Material::HolzapfelGasserOgden(law) => kernel_of_split(law, parameters),
    }
}

fn kernel_of_split<L: Law + std::fmt::Debug>(law: L, parameters: &BlockParameters) -> Box<dyn Kernel> {
    if parameters.mean_dilatation { new_kernel::<_, true>(law) } else { new_kernel::<_, false>(law) }
}

fn new_kernel<L: Law + std::fmt::Debug, const MEAN: bool>(law: L) -> Box<dyn Kernel> {
    Box::new(LawKernel::<_, MEAN> { law, arch: pulp::Arch::new() })
}

/// `MEAN`: one mean dilatation and pressure an element (Simo, Taylor & Pister 1985); else every point its own.
#[derive(Debug)]
struct LawKernel<L, const MEAN: bool> {
    law: L,
    arch: pulp::Arch,
}

impl<L: Law + std::fmt::Debug, const MEAN: bool> Kernel for LawKernel<L, MEAN> {
    fn sweep(&self, block: &ElementBlock, input: &SweepInput, forces: &mut ChunkForces) {
        self.arch.dispatch(Sweep::<L, MEAN> { law: self.law, block, input, forces });
    }
}

struct Sweep<'a, L, const MEAN: bool> {
    law: L,
    block: &'a ElementBlock,
    input: &'a SweepInput<'a>,
    forces: &'a mut ChunkForces,
}

impl<L: Law, const MEAN: bool> WithSimd for Sweep<'_, L, MEAN> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { law, block, input, forces } = self;
        let families = law.family_count();
        let first_batch = block.chunks[forces.chunk as usize].batches.start as usize;
        for (u, node) in forces.u.iter_mut().zip(block.nodes_of_chunk(forces.chunk as usize)) {
            *u = input.u[*node as usize];
        }
        forces.force.fill(Vec3::zeros());
        let mut buffer = [[Row([0.0; BATCH]); 8]; 3];
        for i in 0..forces.batches.len() {
            if forces.awake & (1 << i) == 0 {
                continue;
            }
            let b = first_batch + i;
            let batch = &block.batches[b];
            let element = ElementSweep::<L> {
                law,
                batch,
                parameters: &block.parameters,
                fibres: &block.fibres[b * families..(b + 1) * families],
                inverse_step: input.inverse_step,
            };
            let slots = block.first_slot + b * BATCH..block.first_slot + (b + 1) * BATCH;
            let mut before = [Row([0.0; BATCH]); 2];
            before[0].0.copy_from_slice(&input.dilatation[slots.clone()]);
            before[1].0.copy_from_slice(&input.viscous_pressure[slots]);
            gather(&batch.nodes, &forces.u, &mut buffer);
            let (after, totals) = (&mut forces.after[i], &mut forces.batches[i]);
            for part in 0..BATCH / S::F64_LANES {
                element.sweep::<S, MEAN>(simd, part, &mut buffer, &before, after, totals);
            }
            add(&buffer, &batch.nodes, &mut forces.force);
        }
        forces.totals = BlockTotals::of_batches(first_batch * BATCH, &forces.batches);
    }
}

/// Nodal vectors of a batch, transposed into lanes: `[component][corner]`.
#[inline(always)]
pub(super) fn gather(nodes: &[[u16; BATCH]; 8], from: &[Vec3], to: &mut [[Row; 8]; 3]) {
    for (corner, nodes) in nodes.iter().enumerate() {
        for (lane, node) in nodes.iter().enumerate() {
            let value = &from[*node as usize];
            to[0][corner].0[lane] = value.x;
            to[1][corner].0[lane] = value.y;
            to[2][corner].0[lane] = value.z;
        }
    }
}

/// Adds the reverse of [`gather`], corner by corner, lane by lane.
#[inline(always)]
fn add(from: &[[Row; 8]; 3], nodes: &[[u16; BATCH]; 8], to: &mut [Vec3]) {
    for (corner, nodes) in nodes.iter().enumerate() {
        for (lane, node) in nodes.iter().enumerate() {
            let force = &mut to[*node as usize];
            force.x += from[0][corner].0[lane];
            force.y += from[1][corner].0[lane];
            force.z += from[2][corner].0[lane];
        }
    }
}

/// One batch, one law.
struct ElementSweep<'a, L> {
    law: L,
    batch: &'a Batch,
    parameters: &'a BlockParameters,
    fibres: &'a [[Row; 3]],
    inverse_step: f64,
}

/// The volumetric part of an element at one state.
#[derive(Clone, Copy)]
struct Pressure<R> {
    /// p = U′ − q [Pa], positive in tension.
    p: R,
    /// U″ [Pa], not negative.
    stiffness: R,
}

impl<L: Law> ElementSweep<'_, L> {
    /// `buffer` holds displacements on entry and forces on return; `before` and `after` are (J̄ − 1, viscous pressure).
    #[inline(always)]
    fn sweep<S: Simd, const MEAN: bool>(
        &self,
        simd: S,
        part: usize,
        buffer: &mut [[Row; 8]; 3],
        before: &[Row; 2],
        after: &mut [Row; 2],
        totals: &mut BatchTotals,
    ) {
        // A macro, not a closure: that would be compiled without the instruction set of this function.
        macro_rules! load {
            ($x:expr) => {
                Lane::load(simd, $x, part)
            };
        }
        let zero = Lane::splat(simd, 0.0);
        let no_tensor = Tensor::diagonal(zero);
        let local_X = Aligned(Hex8::local_gradients(&load_corners(simd, &self.batch.corners, part)));
        let local_u = Aligned(Hex8::local_gradients(&load_corners(simd, buffer, part)));

        // First pass: reference geometry, displacement gradients and the element's volume. Weights w are over CORNER_SCALE.
        let (mut cof_X, mut H) = (Aligned([no_tensor; POINTS]), Aligned([no_tensor; POINTS]));
        let (mut w, mut j) = (Aligned([zero; POINTS]), Aligned([zero; POINTS]));
        let (mut change, mut smallest) = (zero, zero.constant(f64::MAX));
        for q in 0..POINTS {
            let X = Hex8::local_gradient_at(&local_X.0, q);
            let cof = X.cofactor();
            w.0[q] = X.determinant_by(&cof);
            H.0[q] = Hex8::local_gradient_at(&local_u.0, q)
                .dot_transposed(&cof)
                .scaled(load!(&self.batch.inverse_weight[q]));
            cof_X.0[q] = cof;
            j.0[q] = volume_change(&H.0[q]);
            change = w.0[q].mul_add(j.0[q], change);
            smallest = smallest.min(j.0[q]);
        }
        // The iteration of a root is one long chain of operations: alone in a loop, those of several points overlap.
        let mut a = Aligned([zero; POINTS]);
        for q in 0..POINTS {
            a.0[q] = inverse_cbrt_m1(j.0[q]);
        }
        let volume = load!(&self.batch.volume);
        let mean = change * load!(&self.batch.scaled_inverse_volume);
        let viscous = self.viscous_pressure(load!(&self.batch.length), mean, load!(&before[0]));

        // Second pass: stresses.
        let U = self.law.volumetric();
        let element_pressure = match U {
            Some(U) if MEAN => Some(pressure_at(U, mean, viscous.0)),
            _ => None,
        };
        let mut sums: Aligned<LocalGradients<Lane<S>>> = Aligned([[[[zero; 2]; 2]; 3]; 3]);
        let (mut strain, mut tangent, mut cofactor, mut exponent) = (zero, zero, zero, zero);
        for q in 0..POINTS {
            let k = Kinematics::with_volume_change(&H.0[q], j.0[q], a.0[q]);
            let mut fibres = [[zero; 3]; MAX_FAMILIES];
            for (a, lanes) in fibres.iter_mut().zip(self.fibres) {
                *a = [load!(&lanes[0]), load!(&lanes[1]), load!(&lanes[2])];
            }
            let fibres = &fibres[..self.fibres.len()];
            let response = self.law.eval(&k, fibres);
            let mut psi = response.psi;
            let pressure = match (element_pressure, U) {
                (Some(pressure), _) => pressure,
                (None, Some(U)) => {
                    psi += U.energy(k.j);
                    pressure_at(U, k.j, viscous.0)
                }
                (None, None) => Pressure { p: -viscous.0, stiffness: zero },
            };
            strain = w.0[q].mul_add(psi, strain);
            let P = response.first_piola(&k, pressure.p);
            Hex8::add_local_stress(&mut sums.0, q, &P, &cof_X.0[q]);

            // |cof F|² = I2
            let invariants = Invariants::new(&k);
            let bound = self.law.eval_stiffness_bound(&k, &invariants, fibres);
            let bound = pressure.stiffness.mul_add(invariants.I2, bound);
            let bound = (pressure.p.abs() * 2.0).mul_add(invariants.max_C.sqrt(), bound);
            tangent = tangent.max(bound);
            cofactor = cofactor.max(invariants.I2);
            exponent = exponent.max(self.law.eval_fibre_exponent(&k, fibres));
        }
        strain = strain * CORNER_SCALE;
        if let (true, Some(U)) = (MEAN, U) {
            strain = volume.mul_add(U.energy(mean), strain);
        }

        let forces = Hex8::nodal_forces(&sums.0);
        for (rows, forces) in buffer.iter_mut().zip(&forces) {
            for (row, force) in rows.iter_mut().zip(forces) {
                force.store(row, part);
            }
        }
        mean.store(&mut after[0], part);
        viscous.0.store(&mut after[1], part);
        strain.store(&mut totals.strain, part);
        let dissipated = (viscous.0 + load!(&before[1])) * (load!(&before[0]) - mean) * volume * 0.5;
        dissipated.store(&mut totals.viscous, part);
        let bound = load!(&self.batch.frequency_bound);
        stable_step(bound * tangent, bound * cofactor * viscous.1).store(&mut totals.stable_step, part);
        smallest.store(&mut totals.smallest_j, part);
        exponent.store(&mut totals.fibre_exponent, part);
    }

    /// (q, η/J̄): viscous pressure `q = ρ L |ε̇| (b1 c + b2² L |ε̇|)` in compression, zero else [Pa], and its slope against ε̇
    /// [Pa s], with ε̇ the volumetric rate over the last step (Landshoff 1955; von Neumann & Richtmyer 1950).
    #[inline(always)]
    fn viscous_pressure<R: Real>(&self, length: R, mean: R, before: R) -> (R, R) {
        let p = self.parameters;
        let J = mean + 1.0;
        let rate = ((before - mean) * self.inverse_step / J).max(mean.zero());
        let density = J.constant(p.density) / J;
        let linear = p.linear_viscosity * p.wave_speed();
        let quadratic = p.quadratic_viscosity * p.quadratic_viscosity;
        let scaled_rate = length * rate * quadratic;
        let q = density * length * rate * (scaled_rate + linear);
        (q, density * length * (scaled_rate * 2.0 + linear) / J)
    }
}

/// Nodal values of the elements of a register.
#[inline(always)]
pub(super) fn load_corners<S: Simd>(simd: S, rows: &[[Row; 8]; 3], part: usize) -> [[Lane<S>; 8]; 3] {
    let mut lanes = [[Lane::splat(simd, 0.0); 8]; 3];
    for i in 0..3 {
        for corner in 0..8 {
            lanes[i][corner] = Lane::load(simd, &rows[i][corner], part);
        }
    }
    lanes
}

#[inline(always)]
fn pressure_at<R: Real>(U: Volumetric, j: R, viscous: R) -> Pressure<R> {
    Pressure { p: U.pressure(j) - viscous, stiffness: U.stiffness(j).max(j.zero()) }
}

/// h = (2/ω)(√(1 + ζ²) − ζ) with ω² and the viscous eigenvalue λ_C = 2 ζ ω; without overflow where ω = 0 (padding).
#[inline(always)]
fn stable_step<R: Real>(omega_squared: R, viscous_eigenvalue: R) -> R {
    let half = viscous_eigenvalue * 0.5;
    let root = half.mul_add(half, omega_squared).sqrt();
    // 2 (√(ω² + a²) − a)/ω² = 2/(√(ω² + a²) + a)
    root.constant(2.0) / (root + half + 1e-30)
}
