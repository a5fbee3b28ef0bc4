//! The force sweep: nodal forces, strain energy, viscous pressure and stable step of a block, in SIMD lanes.

use super::block::{Batch, BlockParameters, ElementBlock};
use crate::mechanics::element::{Hex8, LocalGradients, POINTS};
use crate::mechanics::lanes::{BATCH, Lane};
use crate::mechanics::material::{Invariants, Kinematics, Law, MAX_FAMILIES, Volumetric, volume_change};
use crate::mechanics::real::{Real, inverse_cbrt_m1};
use crate::mechanics::tensor::{Tensor, Vec3, tensor};
use crate::with_law;
use pulp::{Simd, WithSimd};

/// What a sweep reads of the state.
#[derive(Clone, Copy, Debug)]
pub struct SweepInput<'a> {
    /// Displacement u_n [m], nodes × 3.
    pub u: &'a [Vec3],
    /// 1/h₋, the reciprocal of the last step [1/s]; 0 at the start.
    pub inverse_step: f64,
    /// J̄ − 1 at t_{n−1} of each slot of the block [-].
    pub dilatation: &'a [f64],
    /// Viscous pressure at t_{n−1} of each slot of the block [Pa].
    pub viscous_pressure: &'a [f64],
}

/// Where a sweep writes, for the batches that it covers.
#[derive(Debug)]
pub struct SweepOutput<'a> {
    /// Internal force on each corner, 8 a slot [N].
    pub force: &'a mut [Vec3],
    /// J̄ − 1 at t_n of each slot [-].
    pub dilatation: &'a mut [f64],
    /// Viscous pressure at t_n of each slot, ≥ 0 in compression [Pa].
    pub viscous_pressure: &'a mut [f64],
    /// Sums and extremes, one a batch.
    pub totals: &'a mut [BatchTotals],
}

/// Sums and extremes of one batch, lane by lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BatchTotals {
    /// Strain energy of each element [J].
    pub strain: [f64; BATCH],
    /// Energy that bulk viscosity dissipated in the last step [J].
    pub viscous: [f64; BATCH],
    /// Largest stable step [s].
    pub stable_step: [f64; BATCH],
    /// Smallest J − 1 over the points [-]; ≤ −1 means inverted.
    pub smallest_j: [f64; BATCH],
    /// Largest fibre exponent k2 E² over points and families [-]; 0 without fibres.
    pub fibre_exponent: [f64; BATCH],
}

/// A monomorphised sweep behind one dynamic call a block.
pub(super) trait Kernel: std::fmt::Debug + Send + Sync {
    fn sweep(&self, block: &ElementBlock, first_batch: usize, input: &SweepInput, output: SweepOutput);
}

/// The kernel of a law and a formulation.
pub(super) fn kernel(parameters: &BlockParameters) -> Box<dyn Kernel> {
    with_law!(parameters.material, law => {
        if parameters.mean_dilatation && law.volumetric().is_some() {
            Box::new(LawKernel::<_, true> { law, arch: pulp::Arch::new() })
        } else {
            Box::new(LawKernel::<_, false> { law, arch: pulp::Arch::new() })
        }
    })
}

/// `MEAN`: one mean dilatation and pressure an element (Simo, Taylor & Pister 1985); else every point its own.
#[derive(Debug)]
struct LawKernel<L, const MEAN: bool> {
    law: L,
    arch: pulp::Arch,
}

impl<L: Law + std::fmt::Debug, const MEAN: bool> Kernel for LawKernel<L, MEAN> {
    fn sweep(&self, block: &ElementBlock, first_batch: usize, input: &SweepInput, output: SweepOutput) {
        self.arch.dispatch(Sweep::<L, MEAN> { law: self.law, block, first_batch, input, output });
    }
}

struct Sweep<'a, L, const MEAN: bool> {
    law: L,
    block: &'a ElementBlock,
    first_batch: usize,
    input: &'a SweepInput<'a>,
    output: SweepOutput<'a>,
}

impl<L: Law, const MEAN: bool> WithSimd for Sweep<'_, L, MEAN> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let families = self.law.family_count();
        let mut buffer = [[[0.0; BATCH]; 8]; 3];
        for (i, totals) in self.output.totals.iter_mut().enumerate() {
            let b = self.first_batch + i;
            let batch = &self.block.batches[b];
            let slots = i * BATCH..(i + 1) * BATCH;
            let old = b * BATCH..(b + 1) * BATCH;
            gather(&batch.nodes, self.input.u, &mut buffer);
            let element = ElementSweep::<L> {
                law: self.law,
                batch,
                parameters: &self.block.parameters,
                fibres: &self.block.fibres[b * families..(b + 1) * families],
                inverse_step: self.input.inverse_step,
            };
            let mut before = [[0.0; BATCH]; 2];
            before[0].copy_from_slice(&self.input.dilatation[old.clone()]);
            before[1].copy_from_slice(&self.input.viscous_pressure[old]);
            let mut after = [[0.0; BATCH]; 2];
            for part in 0..BATCH / S::F64_LANES {
                element.sweep::<S, MEAN>(simd, part, &mut buffer, &before, &mut after, totals);
            }
            self.output.dilatation[slots.clone()].copy_from_slice(&after[0]);
            self.output.viscous_pressure[slots].copy_from_slice(&after[1]);
            scatter(&buffer, &mut self.output.force[i * BATCH * 8..(i + 1) * BATCH * 8]);
        }
    }
}

/// Nodal vectors of a batch, transposed into lanes: `[component][corner][lane]`.
#[inline(always)]
pub(super) fn gather(nodes: &[[u32; BATCH]; 8], from: &[Vec3], to: &mut [[[f64; BATCH]; 8]; 3]) {
    for (corner, nodes) in nodes.iter().enumerate() {
        for (lane, node) in nodes.iter().enumerate() {
            let value = &from[*node as usize];
            to[0][corner][lane] = value.x;
            to[1][corner][lane] = value.y;
            to[2][corner][lane] = value.z;
        }
    }
}

/// The reverse of [`gather`], into consecutive corners.
#[inline(always)]
fn scatter(from: &[[[f64; BATCH]; 8]; 3], to: &mut [Vec3]) {
    for (lane, corners) in to.chunks_exact_mut(8).enumerate() {
        for (corner, force) in corners.iter_mut().enumerate() {
            *force = Vec3::new(from[0][corner][lane], from[1][corner][lane], from[2][corner][lane]);
        }
    }
}

/// One batch, one law.
struct ElementSweep<'a, L> {
    law: L,
    batch: &'a Batch,
    parameters: &'a BlockParameters,
    fibres: &'a [[[f64; BATCH]; 3]],
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
        buffer: &mut [[[f64; BATCH]; 8]; 3],
        before: &[[f64; BATCH]; 2],
        after: &mut [[f64; BATCH]; 2],
        totals: &mut BatchTotals,
    ) {
        // A macro, not a closure: that would be compiled without the instruction set of this function.
        macro_rules! load {
            ($x:expr) => {
                Lane::load(simd, $x, part)
            };
        }
        let zero = Lane::splat(simd, 0.0);
        let mut u = [[zero; 8]; 3];
        for (u, buffer) in u.iter_mut().zip(buffer.iter()) {
            for (u, buffer) in u.iter_mut().zip(buffer) {
                *u = load!(buffer);
            }
        }
        let local = Hex8::local_gradients(&u);

        // First pass: displacement gradients and the element's volume.
        let (mut H, mut j) = ([Tensor::diagonal(zero); POINTS], [zero; POINTS]);
        let (mut volume, mut change, mut smallest) = (zero, zero, zero.constant(f64::MAX));
        for q in 0..POINTS {
            let inverse: Tensor<Lane<S>> = tensor!(k, j => load!(&self.batch.inverse_jacobian[q][3 * k + j]));
            H[q] = Hex8::local_gradient_at(&local, q).dot(&inverse);
            j[q] = volume_change(&H[q]);
            let w = load!(&self.batch.volume[q]);
            volume += w;
            change = w.mul_add(j[q], change);
            smallest = smallest.min(j[q]);
        }
        // The iteration of a root is one long chain of operations: alone in a loop, those of several points overlap.
        let mut a = [zero; POINTS];
        for q in 0..POINTS {
            a[q] = inverse_cbrt_m1(j[q]);
        }
        let mean = change / volume.max(zero.constant(f64::MIN_POSITIVE));
        let viscous = self.viscous_pressure(load!(&self.batch.length), mean, load!(&before[0]));

        // Second pass: stresses.
        let U = self.law.volumetric();
        let element_pressure = match U {
            Some(U) if MEAN => Some(pressure_at(U, mean, viscous.0)),
            _ => None,
        };
        let mut sums: LocalGradients<Lane<S>> = [[[[zero; 2]; 2]; 3]; 3];
        let (mut strain, mut tangent, mut cofactor, mut exponent) = (zero, zero, zero, zero);
        for q in 0..POINTS {
            let k = Kinematics::with_volume_change(&H[q], j[q], a[q]);
            let w = load!(&self.batch.volume[q]);
            let mut fibres = [[zero; 3]; MAX_FAMILIES];
            for (a, lanes) in fibres.iter_mut().zip(self.fibres) {
                *a = [load!(&lanes[0]), load!(&lanes[1]), load!(&lanes[2])];
            }
            let fibres = &fibres[..self.fibres.len()];
            let response = self.law.eval(&k, fibres);
            strain = w.mul_add(response.psi, strain);
            let pressure = match (element_pressure, U) {
                (Some(pressure), _) => pressure,
                (None, Some(U)) => {
                    strain = w.mul_add(U.energy(k.j), strain);
                    pressure_at(U, k.j, viscous.0)
                }
                (None, None) => Pressure { p: -viscous.0, stiffness: zero },
            };
            let P = response.P.plus_scaled(pressure.p, &k.cof);
            let inverse: Tensor<Lane<S>> = tensor!(k, j => load!(&self.batch.inverse_jacobian[q][3 * k + j]));
            Hex8::add_local_stress(&mut sums, q, &P.dot_transposed(&inverse).scaled(w));

            let invariants = Invariants::new(&k);
            let cof_squared = k.cof.double_dot(&k.cof);
            let bound = self.law.eval_stiffness_bound(&k, &invariants, fibres)
                + pressure.p.abs() * invariants.max_C.sqrt() * 2.0
                + pressure.stiffness * cof_squared;
            tangent = tangent.max(bound);
            cofactor = cofactor.max(cof_squared);
            exponent = exponent.max(self.law.eval_fibre_exponent(&k, fibres));
        }
        if let (true, Some(U)) = (MEAN, U) {
            strain = volume.mul_add(U.energy(mean), strain);
        }

        let forces = Hex8::nodal_forces(&sums);
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
