//! Stress and deformation at the quadrature points, for measures and recordings: in lanes, like the evaluation.

use super::block::ElementBlock;
use super::chunk::{Chunk, NodalResponse};
use super::erosion::Erosion;
use super::first_pass::FirstPass;
use super::memory::{Past, Tension, sizes, take_over_step};
use super::nodal_volumes::shared;
use super::packed::{Batch, InBlocks, with_elements};
use super::parameters::{BlockParameters, Formulation};
use super::reduced::OnePointBatch;
use super::rows::{gather_global, keep_still, load_corners, load_fibres};
use super::shear_viscosity::stress_over_viscosity;
use crate::element::MOST_POINTS;
use crate::lanes::{BATCH, Lane, Row, dispatch_rare};
use crate::material::{Inelastic, Kinematics, Law};
use crate::real::{Outlined, Real, inverse_cbrt_m1};
use crate::tensor::{Mat3, Sym, Vec3};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// A scalar at the quadrature points of a batch: `[point][lane]`.
pub type PointScalar = [Row; MOST_POINTS];

/// The quadrature points of one batch of elements, `[point][lane]`; lanes beyond the elements of the block are padding
/// without volume.
///
/// What a one-point element has at its point stands at all eight, each with its fraction of the volume; the energy of the
/// stabilisation is not in ψ.
#[derive(Clone, Debug)]
pub struct PointBatch {
    /// Points of an element; rows beyond mean nothing, and have no volume.
    pub count: usize,
    /// Reference volume of the point [m³].
    pub volume: PointScalar,
    /// Deformation gradient F [-], `[point][3 row + column][lane]`.
    pub F: [[Row; 9]; MOST_POINTS],
    /// Cauchy stress σ [Pa], `[point][xx, yy, zz, xy, yz, xz][lane]`, with the element's pressure and the stresses of shear viscosity and relaxation in it,
    /// without bulk viscosity.
    pub cauchy: [[Row; 6]; MOST_POINTS],
    /// Strain energy per reference volume ψ [J/m³], less what is lost by softening.
    pub psi: PointScalar,
    /// Von Mises stress [Pa].
    pub von_mises: PointScalar,
    /// Pressure, positive in compression [Pa].
    pub pressure: PointScalar,
    /// Largest principal Green–Lagrange strain, the largest eigenvalue of E = ½ (FᵀF − I) [-].
    pub principal_strain: PointScalar,
    /// Its smallest eigenvalue [-].
    pub least_principal_strain: PointScalar,
    /// Largest eigenvalue of E of the mean deformation of an element, which erosion is decided by [-]; means nothing in blocks without erosion.
    pub mean_strain: Row,
    /// Volume ratio that U is evaluated at [-]: the mean over the element where it has one pressure, else J = det F of the point. Where
    /// pressure is averaged over nodes that is the element's, which shares U with them.
    pub jacobian: PointScalar,
    /// Strain rate: the largest magnitude of a principal value of dev d, d the rate of deformation [1/s]; means nothing unless
    /// [`PointInput::with_rate`].
    pub strain_rate: PointScalar,
    /// Damage: fraction by which the isochoric stress is degraded, irreversibly [-]; 0 without softening, or without a history.
    pub damage: PointScalar,
}

impl Default for PointBatch {
    fn default() -> Self {
        let zero = [Row::default(); MOST_POINTS];
        Self {
            count: 0,
            volume: zero,
            F: [[Row::default(); 9]; MOST_POINTS],
            cauchy: [[Row::default(); 6]; MOST_POINTS],
            psi: zero,
            von_mises: zero,
            pressure: zero,
            principal_strain: zero,
            least_principal_strain: zero,
            mean_strain: Row::default(),
            jacobian: zero,
            strain_rate: zero,
            damage: zero,
        }
    }
}

/// Deformation, stress and energy at one quadrature point, for recorders and measures.
#[derive(Clone, Debug, PartialEq)]
pub struct PointField {
    /// Reference position X [m].
    pub position: Vec3,
    /// Reference volume of the point [m³].
    pub volume: f64,
    /// Deformation gradient F [-].
    pub F: Mat3,
    /// Cauchy stress σ [Pa], as in a [`PointBatch`].
    pub cauchy: Mat3,
    /// Strain energy per reference volume ψ [J/m³].
    pub psi: f64,
}

/// What stresses at points are made of.
#[derive(Clone, Copy, Debug)]
pub struct PointInput<'a> {
    /// Displacements [m], nodes × 3.
    pub u: &'a [Vec3],
    /// Velocities [m/s], nodes × 3; without any there is no viscous stress.
    pub v: &'a [Vec3],
    /// History of each chunk of all blocks at the same time; without any all has relaxed.
    pub history: &'a [Vec<Row>],
    /// Eroded elements: without stress or deformation.
    pub erosion: &'a Erosion,
    /// Whether stress is requested; otherwise F, σ, von Mises stress and pressure of a [`PointBatch`] mean nothing.
    pub with_stress: bool,
    /// Whether strain rates are requested.
    pub with_rate: bool,
}

impl<'a> PointInput<'a> {
    /// At rest and relaxed at displacements [m], nodes × 3.
    pub fn at_rest(u: &'a [Vec3]) -> Self {
        Self { u, v: &[], history: &[], erosion: Erosion::none(), with_stress: true, with_rate: false }
    }
}

impl ElementBlock {
    /// Visits the batches in which anything has moved: `visit(slots of its elements in this block, points)`, in the order
    /// of the slots. Where every displacement is exactly zero there is no stress, strain or energy, unless pressure is averaged over nodes.
    pub fn for_each_moved_batch(&self, input: PointInput, visit: &mut dyn FnMut(Range<usize>, &PointBatch)) {
        let mut points = PointBatch::default();
        let at_nodes = self.nodal_state(input.u).response;
        for b in 0..self.batch_count() {
            let nodes = self.nodes_of_chunk(b / Chunk::BATCHES);
            let is_still = |node: &u16| input.u[nodes[*node as usize] as usize] == Vec3::zeros();
            if self.parameters.is_local() && self.nodes_of_batch(b).as_flattened().iter().all(is_still) {
                continue;
            }
            self.eval_points(b, input, &at_nodes, &mut points);
            visit(self.slots_of(b), &points);
        }
    }

    /// Visits every quadrature point one by one, without viscous stress: `visit(element, index in the element, point)`, elements in the order of
    /// the slots.
    pub fn for_each_point(&self, X: &[Vec3], u: &[Vec3], visit: &mut dyn FnMut(u32, usize, &PointField)) {
        let mut points = PointBatch::default();
        let at_nodes = self.nodal_state(u).response;
        for b in 0..self.batch_count() {
            self.eval_points(b, PointInput::at_rest(u), &at_nodes, &mut points);
            for slot in self.slots_of(b) {
                for q in 0..points.count {
                    let position = self.point_position(slot, q, X);
                    visit(self.elements[slot], q, &points.at(q, slot % BATCH, position));
                }
            }
        }
    }

    /// Reference position [m] of a quadrature point of the element in a slot of this block.
    pub fn point_position(&self, slot: usize, q: usize, X: &[Vec3]) -> Vec3 {
        let shape = self.kind.shapes_at(q);
        self.nodes_of(slot).iter().zip(shape).map(|(node, N)| X[*node as usize] * *N).sum()
    }

    /// Reference volume of the quadrature points of the element in a slot of this block [m³]; 0 beyond their number.
    pub fn point_volumes(&self, slot: usize) -> [f64; MOST_POINTS] {
        let rows: &[Row] =
            with_elements!(&self.packed, elements => &elements.batches[slot / BATCH].inverse_weight);
        std::array::from_fn(|q| rows.get(q).map_or(0.0, |row| 1.0 / row.0[slot % BATCH]))
    }

    /// The slots of a batch that hold elements.
    fn slots_of(&self, batch: usize) -> Range<usize> {
        batch * BATCH..((batch + 1) * BATCH).min(self.elements.len())
    }

    /// The history of a batch, where its stress depends on it.
    fn memory_of<'a>(&'a self, b: usize, history: &'a [Vec<Row>]) -> Option<BatchHistory<'a>> {
        let rows = self.history_rows();
        let of_chunk =
            history.get(self.chunk_number(b / Chunk::BATCHES)).filter(|_| self.parameters.has_memory())?;
        let first = b % Chunk::BATCHES * rows;
        Some(BatchHistory {
            parameters: &self.parameters,
            rows: &of_chunk[first + self.bulk_rows()..first + rows],
            of_point: if self.memory_points() > 1 { self.memory_rows() } else { 0 },
            size: with_elements!(&self.packed, elements => sizes(&elements.batches[b].volume)),
        })
    }

    /// All points of one batch, for those who keep no buffer.
    pub(super) fn points_of(&self, b: usize, u: &[Vec3]) -> Box<PointBatch> {
        let mut points = Box::<PointBatch>::default();
        self.eval_points(b, PointInput::at_rest(u), &self.nodal_state(u).response, &mut points);
        points
    }

    /// All points of one batch.
    fn eval_points(&self, b: usize, input: PointInput, at_nodes: &[NodalResponse], points: &mut PointBatch) {
        let PointInput { u, v, history, erosion, with_stress, with_rate } = input;
        let eta = if with_stress { self.parameters.shear_viscosity } else { 0.0 };
        with_elements!(&self.packed, elements => dispatch_rare(Points {
            response: PointResponse {
                block: self,
                with_stress,
                fibres: self.fibres_of(b),
                memory: self.memory_of(b, history),
                of_nodes: self.nodal_volumes.as_ref().map(|volumes| {
                    volumes.of_batch(&self.chunks[b / Chunk::BATCHES], &elements.batches[b].nodes, at_nodes)
                }),
            },
            batch: &elements.batches[b],
            reduced: elements.one_point.get(b),
            nodes: self.nodes_of_chunk(b / Chunk::BATCHES),
            eroded: erosion.of_batch(self, b),
            u,
            rates: Some(Rates { v, eta, are_stored: with_rate }).filter(|_| (with_rate || eta > 0.0) && !v.is_empty()),
            to: points,
        }));
    }
}

impl PointBatch {
    /// One of the points.
    fn at(&self, q: usize, lane: usize, position: Vec3) -> PointField {
        let F = Mat3::from_fn(|i, j| self.F[q][3 * i + j].0[lane]);
        let [xx, yy, zz, xy, yz, xz] = self.cauchy[q].map(|s| s.0[lane]);
        let cauchy = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let (volume, psi) = (self.volume[q].0[lane], self.psi[q].0[lane]);
        PointField { position, volume, F, cauchy, psi }
    }
}

/// History of the points of a batch.
struct BatchHistory<'a> {
    parameters: &'a BlockParameters,
    rows: &'a [Row],
    /// Rows of a point, 0 where all points share those of the first.
    of_point: usize,
    /// Edges of cubes of the volumes of the elements [m].
    size: Row,
}

impl BatchHistory<'_> {
    /// Contribution of history to the response of a point.
    #[inline(always)]
    fn inelastic<S: Simd>(
        &self,
        simd: S,
        (part, q): (usize, usize),
        (k, fibres): (&Kinematics<Lane<S>>, &[[Lane<S>; 3]]),
        tension: Lane<S>,
    ) -> Inelastic<Lane<S>> {
        let of_element = (tension, Lane::load(simd, &self.size, part));
        let mut past = Past { simd, part, rows: &self.rows[q * self.of_point..] };
        let steps = self.parameters.memory.step(0.0);
        take_over_step(self.parameters, &steps, (k, fibres), of_element, &mut past).1
    }
}

/// What the response at the points of a batch is made of, whatever its elements.
struct PointResponse<'a> {
    block: &'a ElementBlock,
    /// Whether stress is stored.
    with_stress: bool,
    fibres: &'a [[Row; 3]],
    memory: Option<BatchHistory<'a>>,
    /// Fraction s of U that is of the elements [-], and means over their nodes, where pressure is averaged over nodes.
    of_nodes: Option<(f64, [Row; 3])>,
}

/// One batch at one time.
struct Points<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    response: PointResponse<'a>,
    batch: &'a Batch<E, N, Q>,
    /// Constants of the batch in one-point elements; `None` in other formulations.
    reduced: Option<&'a E::OnePoint>,
    /// Global nodes of the chunk.
    nodes: &'a [u32],
    /// Bit mask of eroded elements, one bit per lane.
    eroded: u8,
    u: &'a [Vec3],
    rates: Option<Rates<'a>>,
    to: &'a mut PointBatch,
}

/// What rates of deformation are evaluated for.
#[derive(Clone, Copy)]
struct Rates<'a> {
    /// Velocities [m/s], nodes × 3.
    v: &'a [Vec3],
    /// Shear viscosity η [Pa s]; 0 where no viscous stress is requested.
    eta: f64,
    /// Whether strain rates are stored.
    are_stored: bool,
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for Points<'_, E, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.to.count = Q;
        self.to.damage = [Row::default(); MOST_POINTS];
        self.to.volume[Q..].fill(Row::default());
        let u = self.gather(self.u);
        let v = self.rates.map(|rates| self.gather(rates.v));
        for part in 0..BATCH / S::F64_LANES {
            self.eval::<S>(simd, part, &u, v.as_ref());
        }
    }
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> Points<'_, E, N, Q> {
    /// Nodal vectors of the batch, in lanes.
    fn gather(&self, from: &[Vec3]) -> [[Row; N]; 3] {
        let mut to = gather_global(&self.batch.nodes, self.nodes, from);
        keep_still(self.eroded, &mut to);
        to
    }

    /// The elements of a register.
    #[inline(always)]
    fn eval<S: Simd>(&mut self, simd: S, part: usize, u: &[[Row; N]; 3], v: Option<&[[Row; N]; 3]>) {
        let zero = Lane::splat(simd, 0.0);
        // Displacement gradients at all points, mean dilatation.
        let first_pass = self.batch.first_pass(simd, part, u);
        let FirstPass { cof_X, w, H, j, .. } = &first_pass;
        if self.response.block.parameters.erosion.is_some() {
            let [largest, _] = self.batch.mean_deformation(simd, part, u);
            (largest * 0.5).store(&mut self.to.mean_strain, part);
        }
        // Padding has no volume.
        let is_element = Lane::load(simd, &self.batch.volume, part).select_positive(zero + 1.0, zero);
        let rates = self.rates.zip(v.map(|v| E::local_gradients(&load_corners(simd, v, part))));
        for q in 0..Q {
            // Weight of the point in averages over the volume at rest.
            (w.0[q] * E::SCALE * is_element).store(&mut self.to.volume[q], part);
            let mut k = Kinematics::with_volume_change(&H.0[q], j.0[q], inverse_cbrt_m1(j.0[q]));
            let mut viscous = None;
            if let Some((Rates { eta, are_stored, .. }, local_v)) = &rates {
                let rate = self.batch.gradient_at(simd, part, local_v, (q, &cof_X.0[q]));
                let twice_dev_d = stress_over_viscosity(&rate, &k.cof, k.j);
                if *are_stored {
                    let [least, largest] = twice_dev_d.extreme_principals();
                    (largest.max(-least) * 0.5).store(&mut self.to.strain_rate[q], part);
                }
                viscous = (*eta > 0.0).then(|| twice_dev_d.scaled(zero.constant(*eta)));
            }
            // Reduced integration evaluates the law at the mean gradient only.
            if let Some(reduced) = self.reduced {
                k = Kinematics::new(&reduced.mean_gradient(simd, part, u));
            }
            // Not inlined, so that the kernel of a law is compiled once.
            zero.outlined(PointStress {
                response: &self.response,
                k: &k,
                mean: first_pass.mean,
                viscous: viscous.as_ref(),
                at: (simd, part, q),
                to: &mut *self.to,
            });
        }
    }
}

/// Stress, energy and strain at one point of the elements of a register.
struct PointStress<'a, S: Simd> {
    response: &'a PointResponse<'a>,
    k: &'a Kinematics<Lane<S>>,
    /// Mean of J − 1 over the element [-].
    mean: Lane<S>,
    /// Viscous Cauchy stress [Pa].
    viscous: Option<&'a Sym<Lane<S>>>,
    /// Instruction set, register of the batch and quadrature point.
    at: (S, usize, usize),
    to: &'a mut PointBatch,
}

impl<S: Simd> Outlined for PointStress<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { response: of, k, mean, viscous, at: (simd, part, q), to } = self;
        let zero = mean.zero();
        let parameters = &of.block.parameters;
        let law = &parameters.material;
        let fibres = &load_fibres(simd, of.fibres, part)[..of.fibres.len()];
        let response = law.eval(k, fibres);
        let j = if parameters.formulation == Formulation::MeanDilatation { mean } else { k.j };
        let mut psi = response.psi;
        let (energy, pressure) = match (law.volumetric(), &of.of_nodes) {
            (Some(U), Some((fraction, [energy, pressure, _]))) => (
                shared(*fraction, U.energy(j), Lane::load(simd, energy, part)),
                shared(*fraction, U.pressure(j), Lane::load(simd, pressure, part)),
            ),
            (Some(U), None) => (U.energy(j), U.pressure(j)),
            (None, _) => (zero, zero),
        };

        // History adds stress; softening degrades it.
        let tension = Tension::new(of.block, mean);
        let mut inelastic = None;
        if let Some(memory) = &of.memory {
            let added = memory.inelastic(simd, (part, q), (k, fibres), tension.energy(k));
            psi = added.damage.mul_add(-(psi + tension.energy(k)), psi);
            added.damage.store(&mut to.damage[q], part);
            inelastic = Some(added);
        }
        (psi + energy).store(&mut to.psi[q], part);

        // Extreme eigenvalues of E = ½ (C − I).
        let [least, largest] = k.C_minus_I.extreme_principals();
        (largest * 0.5).store(&mut to.principal_strain[q], part);
        (least * 0.5).store(&mut to.least_principal_strain[q], part);
        (if law.volumetric().is_some() { j + 1.0 } else { k.J }).store(&mut to.jacobian[q], part);
        if !of.with_stress {
            return;
        }

        // σ = P Fᵀ / J
        let mut P = response.first_piola(k, pressure);
        if let Some(inelastic) = &inelastic {
            P = P.plus_dot_sym(&k.F, &inelastic.S);
            P = P.plus_scaled(-inelastic.damage, &response.first_piola(k, tension.pressure(k)));
        }
        let sigma = P.dot_transposed(&k.F);
        let mut cauchy = Sym([zero; 6]);
        for (s, (i, j)) in cauchy.0.iter_mut().zip(Sym::<Lane<S>>::INDICES) {
            *s = sigma.0[i][j] / k.J;
        }
        if let Some(viscous) = viscous {
            cauchy = cauchy.plus_scaled(zero + 1.0, viscous);
        }
        for i in 0..3 {
            for j in 0..3 {
                k.F.0[i][j].store(&mut to.F[q][3 * i + j], part);
            }
        }
        for (s, to) in cauchy.0.iter().zip(&mut to.cauchy[q]) {
            s.store(to, part);
        }
        cauchy.von_mises().store(&mut to.von_mises[q], part);
        cauchy.pressure().store(&mut to.pressure[q], part);
    }
}
