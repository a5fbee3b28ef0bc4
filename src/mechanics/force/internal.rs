//! The internal force evaluation: nodal forces, strain energy, viscous pressure and critical time step of a chunk, in SIMD lanes.

use super::block::{BULK_ROWS, ElementBlock};
use super::chunk::ChunkForces;
use super::first_pass::FirstPass;
use super::nodal_volumes::shared;
use super::packed::{Batch, InBlocks, Packed};
use super::parameters::BlockParameters;
use super::pressure::{
    Barrier, Pressure, corners_may_fold, point_is_crushed, pressure_at, tangent_bound, viscous_pressure,
};
use super::rows::{add_in, gather_in, load_corners, load_fibres, store_corners};
use super::shear_viscosity::ShearViscosity;
use super::totals::{BatchTotals, BlockTotals};
use crate::element::{Element, eval_corner_penalty};
use crate::lanes::{Aligned, BATCH, Lane, Row, WithRegisters};
use crate::material::{Invariants, Kinematics, Law, Material};
use crate::real::{Real, inverse_cbrt_m1};
use crate::registers::Registers;
use crate::tensor::Vec3;
use pulp::{Simd, WithSimd};

/// Per element of a batch: the fraction of the volumetric stiffness in the critical time step, and the weight d [-].
pub type AssembledRows = [Row; 2];

/// Elements that keep all of their stiffness, with equal weights.
pub(super) const WHOLE: AssembledRows = [Row([1.0; BATCH]); 2];

/// Inputs of an evaluation from the state.
#[derive(Clone, Copy, Debug)]
pub struct ForceInput<'a> {
    /// Displacement u_n [m], nodes × 3.
    pub u: &'a [Vec3],
    /// 1/h₋, the reciprocal of the last step [1/s]; 0 at the start.
    pub inverse_step: f64,
    /// History at t_{n−1} of each chunk of all blocks; empty where no step is behind the elements.
    pub history: &'a [Vec<Row>],
    /// What the assembled mesh leaves of the volumetric stiffness of each element in its critical time step, chunk by chunk,
    /// see [`AssembledBound`](super::AssembledBound); empty for all of it.
    pub fractions: &'a [Vec<AssembledRows>],
    /// Velocities [m/s], nodes × 3, at which shear viscosity is evaluated in the same pass over the elements; empty to leave it to
    /// [`ElementForces::add_viscous`](super::ElementForces::add_viscous).
    pub v: &'a [Vec3],
}

impl<'a> ForceInput<'a> {
    /// At these displacements [m], with no step behind the elements.
    pub fn at(u: &'a [Vec3]) -> Self {
        Self { u, inverse_step: 0.0, history: &[], fractions: &[], v: &[] }
    }
}

/// What a formulation does to the elements of a batch that fit into a register.
pub(super) trait ElementKernel<E: InBlocks<N, Q>, const N: usize, const Q: usize>: Copy {
    /// Whether it leaves the first pass over all points of the elements in [`BatchLanes::first_pass`].
    const HAS_POINTS: bool;

    /// Forces and totals of the elements in the `part`-th register.
    fn evaluate<S: Registers, L: Law>(
        self,
        element: &ElementForcePass<L, E, N, Q>,
        simd: S,
        part: usize,
        lanes: &mut BatchLanes<S, N, Q>,
        totals: &mut BatchTotals,
    );
}

/// The state of a batch, lane by lane.
pub(super) struct BatchLanes<S: Registers, const N: usize, const Q: usize> {
    /// Displacements on entry [m], forces on return [N]: `[component][node]`.
    pub nodal: [[Row; N]; 3],
    /// J̄ − 1 [-] and viscous pressure [Pa] at t_{n−1}; zero without bulk viscosity.
    pub before: [Row; BULK_ROWS],
    /// The same at t_n.
    pub after: [Row; BULK_ROWS],
    /// Means over the nodes of the elements, where pressure is averaged over nodes.
    pub of_nodes: [Row; 3],
    /// Fraction of the volumetric stiffness in the critical time step [-].
    pub fraction: Row,
    /// Room for the first pass.
    pub first_pass: FirstPass<Lane<S>, Q>,
}

impl<S: Registers, const N: usize, const Q: usize> BatchLanes<S, N, Q> {
    /// Stores J̄ − 1 [-] and the viscous pressure [Pa] at t_n.
    #[inline(always)]
    pub fn store_history(&mut self, dilatation: Lane<S>, viscous_pressure: Lane<S>, part: usize) {
        dilatation.store(&mut self.after[0], part);
        viscous_pressure.store(&mut self.after[1], part);
    }

    /// What bulk viscosity dissipated in the step to t_n [J], by its mean pressure; the history must be stored.
    #[inline(always)]
    pub fn dissipated(&self, simd: S, volume: Lane<S>, part: usize) -> Lane<S> {
        let before = [Lane::load(simd, &self.before[0], part), Lane::load(simd, &self.before[1], part)];
        let after = [Lane::load(simd, &self.after[0], part), Lane::load(simd, &self.after[1], part)];
        (after[1] + before[1]) * (before[0] - after[0]) * volume * 0.5
    }
}

/// The evaluation of a chunk: monomorphised for the law, the formulation and the element.
pub(super) struct Evaluation<'a, L, K, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    pub law: L,
    pub formulation: K,
    pub elements: &'a Packed<E, N, Q>,
    pub block: &'a ElementBlock,
    pub input: &'a ForceInput<'a>,
    pub forces: &'a mut ChunkForces,
}

impl<L, K: ElementKernel<E, N, Q>, E: InBlocks<N, Q>, const N: usize, const Q: usize>
    Evaluation<'_, L, K, E, N, Q>
{
    /// Evaluates it in plain `f64`, for which no law has a kernel of its own.
    pub fn without_wide_registers(self) {
        let Self { formulation, elements, block, input, forces, .. } = self;
        let law = block.parameters.material;
        in_plain_numbers(Evaluation { law, formulation, elements, block, input, forces });
    }
}

/// Not inlined, so that it is compiled once and not for each law.
#[inline(never)]
fn in_plain_numbers<K: ElementKernel<E, N, Q>, E: InBlocks<N, Q>, const N: usize, const Q: usize>(
    evaluation: Evaluation<Material, K, E, N, Q>,
) {
    pulp::Scalar::new().vectorize(evaluation);
}

impl<L: Law, K: ElementKernel<E, N, Q>, E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd
    for Evaluation<'_, L, K, E, N, Q>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.with_registers(simd);
    }
}

impl<L: Law, K: ElementKernel<E, N, Q>, E: InBlocks<N, Q>, const N: usize, const Q: usize> WithRegisters
    for Evaluation<'_, L, K, E, N, Q>
{
    #[inline(always)]
    fn with_registers<S: Registers>(self, simd: S) {
        let Self { law, formulation, elements, block, input, forces } = self;
        let families = law.family_count();
        let first_batch = block.chunks[forces.chunk as usize].batches.start as usize;
        // Displacements of the chunk's nodes, and its own sums at them: chunks share no memory.
        for (u, node) in forces.u.iter_mut().zip(block.nodes_of_chunk(forces.chunk as usize)) {
            *u = input.u[*node as usize];
        }
        forces.force.fill(Vec3::zeros());
        let eta = block.parameters.shear_viscosity;
        forces.has_shear_viscosity = K::HAS_POINTS && eta > 0.0 && !input.v.is_empty();
        if forces.has_shear_viscosity {
            forces.begin_viscous(block, input.v);
        }
        // Lanes of one batch, reused for all.
        let zero = Row([0.0; BATCH]);
        let first_pass = FirstPass::new(Lane::splat(simd, 0.0));
        let (nodal, mut rates, of_nodes) = ([[zero; N]; 3], [[zero; N]; 3], [zero; 3]);
        let (before, after) = ([zero; BULK_ROWS], [zero; BULK_ROWS]);
        let mut lanes = BatchLanes { nodal, before, after, of_nodes, fraction: WHOLE[0], first_pass };
        // Constants of the chunk: history of the last step, fractions of the assembled bound.
        let fraction = block.nodal_volumes.as_ref().map_or(1.0, |volumes| volumes.fraction);
        let (rows, bulk) = (block.history_rows(), block.bulk_rows());
        let number = block.chunk_number(forces.chunk as usize);
        let (before, fractions) = (input.history.get(number), input.fractions.get(number));
        for i in 0..forces.batches.len() {
            if forces.active & (1 << i) == 0 {
                continue;
            }
            // Law and geometry of this batch.
            let b = first_batch + i;
            let nodes = &elements.batches[b].nodes;
            let element = ElementForcePass {
                law,
                batch: &elements.batches[b],
                one_point: elements.one_point.get(b),
                parameters: &block.parameters,
                fibres: &block.fibres[b * families..(b + 1) * families],
                inverse_step: input.inverse_step,
                fraction,
            };
            // Gather: history, displacements (relative to one node in single precision), mean dilatation of the nodes.
            let history = i * rows..i * rows + bulk;
            if let Some(before) = before {
                lanes.before[..bulk].copy_from_slice(&before[history.clone()]);
            }
            lanes.fraction = fractions.and_then(|rows| rows.get(i)).unwrap_or(&WHOLE)[0];
            gather_in::<S, N>(nodes, &forces.u, forces.eroded_lanes(i), &mut lanes.nodal);
            if forces.has_shear_viscosity {
                gather_in::<S, N>(nodes, &forces.v, forces.eroded_lanes(i), &mut rates);
            }
            forces.average_over_nodes(nodes, &mut lanes.of_nodes);
            // Corner forces, register by register; those of shear viscosity from the same first pass.
            for part in 0..BATCH / S::LANES {
                let totals = &mut forces.batches[i];
                formulation.evaluate(&element, simd, part, &mut lanes, totals);
                if forces.has_shear_viscosity {
                    let (batch, first) = (element.batch, &lanes.first_pass);
                    let rates = &mut rates;
                    Lane::splat(simd, 0.0).outlined(ShearViscosity {
                        simd,
                        batch,
                        part,
                        eta,
                        first,
                        rates,
                        totals,
                    });
                }
            }
            // Scatter to the sums of the chunk; in single precision the forces of an element are made to sum to zero.
            forces.history[history].copy_from_slice(&lanes.after[..bulk]);
            add_in::<S, N>(&mut lanes.nodal, nodes, &mut forces.force);
            if forces.has_shear_viscosity {
                add_in::<S, N>(&mut rates, nodes, &mut forces.viscous);
            }
        }
        forces.totals = BlockTotals::of_batches(first_batch * BATCH, &forces.batches);
    }
}

/// One batch, one law.
pub(super) struct ElementForcePass<'a, L, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    pub law: L,
    pub batch: &'a Batch<E, N, Q>,
    /// Constants of the batch in one-point elements; `None` in other formulations.
    pub one_point: Option<&'a E::OnePoint>,
    pub parameters: &'a BlockParameters,
    pub fibres: &'a [[Row; 3]],
    pub inverse_step: f64,
    /// Fraction of U(J) that is not of the nodes [-].
    pub fraction: f64,
}

/// All points of the element. `MEAN`: one mean dilatation and pressure an element (Simo, Taylor & Pister 1985), which with `NODAL` is in part
/// that of its nodes; else every point its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct GaussPoints<const MEAN: bool, const NODAL: bool>;

impl<const MEAN: bool, const NODAL: bool, E: InBlocks<N, Q>, const N: usize, const Q: usize>
    ElementKernel<E, N, Q> for GaussPoints<MEAN, NODAL>
{
    const HAS_POINTS: bool = true;

    #[inline(always)]
    fn evaluate<S: Registers, L: Law>(
        self,
        element: &ElementForcePass<L, E, N, Q>,
        simd: S,
        part: usize,
        lanes: &mut BatchLanes<S, N, Q>,
        totals: &mut BatchTotals,
    ) {
        element.evaluate::<S, MEAN, NODAL>(simd, part, lanes, totals);
    }
}

impl<E: Element<N, Q>, const N: usize, const Q: usize> Batch<E, N, Q> {
    /// Adds the penalty on the corners of the elements of a register to their forces [N], at displacements `u` [m]; its energy [J] and
    /// its ω² [1/s²].
    #[inline(always)]
    pub(super) fn add_corner_penalty<S: Registers>(
        &self,
        (simd, part): (S, usize),
        u: &[[Row; N]; 3],
        forces: &mut [[Lane<S>; N]; 3],
    ) -> (Lane<S>, Lane<S>) {
        let stiffness = self.corner_stiffness.each_ref().map(|row| Lane::load(simd, row, part));
        let (X, u) = (self.corners_at_rest(simd, part), load_corners(simd, u, part));
        let corners = eval_corner_penalty(E::CORNERS, &X, &u, stiffness);
        for (f, on) in forces.as_flattened_mut().iter_mut().zip(corners.forces.as_flattened()) {
            *f += *on;
        }
        (corners.energy, corners.stiffness * Lane::load(simd, &self.inverse_least_mass, part))
    }

    /// X [m] of the elements of a register.
    #[inline(always)]
    pub(super) fn corners_at_rest<S: Registers>(&self, simd: S, part: usize) -> [[Lane<S>; N]; 3] {
        let mut X = load_corners(simd, &self.corners, part);
        for X in X.as_flattened_mut() {
            *X = *X * E::SCALE;
        }
        X
    }
}

impl<L: Law, E: InBlocks<N, Q>, const N: usize, const Q: usize> ElementForcePass<'_, L, E, N, Q> {
    #[inline(always)]
    fn evaluate<S: Registers, const MEAN: bool, const NODAL: bool>(
        &self,
        simd: S,
        part: usize,
        lanes: &mut BatchLanes<S, N, Q>,
        totals: &mut BatchTotals,
    ) {
        // A macro, not a closure: that would be compiled without the instruction set of this function.
        macro_rules! load {
            ($x:expr) => {
                Lane::load(simd, $x, part)
            };
        }
        let zero = Lane::splat(simd, 0.0);
        self.batch.first_pass_to(simd, part, &lanes.nodal, &mut lanes.first_pass);
        // By reference: moving the arrays out would copy them.
        let FirstPass { cof_X, w, H, j, mean, smallest } = &lanes.first_pass;
        let (mean, smallest) = (*mean, *smallest);
        // The iteration of a root is one long chain of operations: alone in a loop, those of several points overlap.
        let mut a = Aligned([zero; Q]);
        for q in 0..Q {
            a.0[q] = inverse_cbrt_m1(j.0[q]);
        }
        let volume = load!(&self.batch.volume);
        let viscous = viscous_pressure(
            self.parameters,
            self.inverse_step,
            load!(&self.batch.length),
            mean,
            load!(&lanes.before[0]),
        );

        // Padding stays without stress beside nodes that are not.
        macro_rules! of_nodes {
            ($i:expr) => {
                volume.select_positive(load!(&lanes.of_nodes[$i]), zero)
            };
        }
        // Second pass: stresses.
        let U = self.law.volumetric();
        let element_pressure = match U {
            Some(U) if NODAL => {
                let own = pressure_at(U, mean, zero);
                Some(Pressure {
                    p: shared(self.fraction, own.p, of_nodes!(1)) - viscous.0,
                    stiffness: shared(self.fraction, own.stiffness, of_nodes!(2)),
                })
            }
            Some(U) if MEAN => Some(pressure_at(U, mean, viscous.0)),
            _ => None,
        };
        smallest.store(&mut totals.smallest_j, part);
        let barrier = (MEAN && point_is_crushed::<S>(&totals.smallest_j, part))
            .then(|| Barrier::new(self.parameters.material.moduli_at_rest().0));
        let mut stabilisation = zero;
        let mut sums = Aligned(E::no_stress(zero));
        let (mut strain, mut tangent, mut cofactor, mut exponent) = (zero, zero, zero, zero);
        for q in 0..Q {
            let k = Kinematics::with_volume_change(&H.0[q], j.0[q], a.0[q]);
            let fibres = &load_fibres(simd, self.fibres, part)[..self.fibres.len()];
            let invariants = Invariants::new(&k);
            let point = self.law.eval_with_bounds(&k, &invariants, fibres);
            let mut psi = point.response.psi;
            let mut pressure = match (element_pressure, U) {
                // Its stiffness is that of the element, below.
                (Some(pressure), _) => Pressure { p: pressure.p, stiffness: zero },
                (None, Some(U)) => {
                    psi += U.energy(k.j);
                    pressure_at(U, k.j, viscous.0)
                }
                (None, None) => Pressure { p: -viscous.0, stiffness: zero },
            };
            if let Some(barrier) = barrier {
                barrier.add_to(k.j, &mut pressure);
                let energy = barrier.energy(k.j);
                psi += energy;
                stabilisation = w.0[q].mul_add(energy, stabilisation);
            }
            strain = w.0[q].mul_add(psi, strain);
            let P = point.response.first_piola(&k, pressure.p);
            E::add_local_stress(&mut sums.0, q, &P, &cof_X.0[q]);

            // |cof F|² = I2
            tangent = tangent.max(tangent_bound(point.stiffness_bound, &invariants, &pressure));
            cofactor = cofactor.max(invariants.I2);
            exponent = exponent.max(point.fibre_exponent);
        }
        strain = strain * E::SCALE;
        if let (true, Some(U)) = (MEAN, U) {
            let own = U.energy(mean);
            let energy = if NODAL { shared(self.fraction, own, of_nodes!(0)) } else { own };
            strain = volume.mul_add(energy, strain);
        }

        let mut forces = E::nodal_forces(&sums.0);
        stabilisation = stabilisation * E::SCALE;
        let mut corner_frequency = zero;
        if !E::CORNERS.is_empty() && corners_may_fold::<S>(smallest, mean, part) {
            let energy;
            (energy, corner_frequency) =
                self.batch.add_corner_penalty((simd, part), &lanes.nodal, &mut forces);
            stabilisation += energy;
            strain += energy;
        }
        store_corners(&forces, &mut lanes.nodal, part);
        strain.store(&mut totals.strain, part);
        stabilisation.store(&mut totals.hourglass, part);
        lanes.store_history(mean, viscous.0, part);
        lanes.dissipated(simd, volume, part).store(&mut totals.viscous, part);
        // The stiffness and the viscosity of the element's one pressure act along one vector, which the assembled mesh bounds more closely.
        let bound = load!(&self.batch.frequency_bound);
        let volumetric = bound * cofactor * load!(&lanes.fraction);
        let stiffness = element_pressure.map_or(zero, |pressure| pressure.stiffness);
        let frequency = stiffness.mul_add(volumetric, bound.mul_add(tangent, corner_frequency));
        totals.store_step(frequency, volumetric * viscous.1, part);
        exponent.store(&mut totals.fibre_exponent, part);
    }
}
