//! Tangent stiffness K = ∂f_int/∂u of elements, for implicit steps: the exact derivative of what the internal force evaluation computes.
//!
//! At a point, `A = ∂P/∂F` comes from dual numbers through the same law, so there is no second formula. A split law in mean
//! dilatation, `W = Σ_q w ψ(F_q) + V U(J̄)`, has
//!
//! ```text
//! K = Σ_q w ∇Nᵀ (∂²ψ/∂F² + U′(J̄) ∂cof F/∂F) ∇N + U″(J̄)/V c cᵀ          c = Σ_q w cof F ∇N = V ∂J̄/∂u
//! ```
//!
//! (Simo, Taylor & Pister 1985). Where pressure is averaged over nodes, it is `s U′(J̄)` and the mean of the nodes, which is held here: what that
//! changes with is in [`super::block_tangent`]. One-point elements are differentiated whole, stabilisation included, and so is the corner penalty. Bulk viscosity is no part
//! of implicit steps, so it is none of this either.

use super::block_tangent::BlockTangent;
use super::chunk::Chunk;
use super::first_pass::FirstPass;
use super::nodal_volumes::shared;
use super::packed::{Batch, InBlocks, with_elements};
use super::parameters::Formulation;
use super::pressure::{Barrier, corners_may_fold, point_is_crushed};
use super::reduced::{NoOnePoint, OnePointElement, ReducedBatch};
use super::rows::{gather_global, load_corners, load_fibres};
use crate::dual::Dual;
use crate::element::{Element, Hex8, Hourglass, MOST_NODES, Modes, eval_corner_penalty};
use crate::lanes::{BATCH, Lane, Row, dispatch_rare};
use crate::material::{Kinematics, Law, MAX_FAMILIES, Material, volume_change};
use crate::real::{Outlined, Real};
use crate::tensor::Tensor;
use pulp::{Simd, WithSimd};

/// Pairs of nodes (a, b) with a ≥ b of the elements that have most.
pub const CORNER_PAIRS: usize = MOST_NODES * (MOST_NODES + 1) / 2;

/// Where the pair of corners (a, b), a ≥ b, is stored.
#[inline(always)]
pub const fn corner_pair(a: usize, b: usize) -> usize {
    a * (a + 1) / 2 + b
}

/// Stiffness matrices of one batch of elements [N/m], lane by lane: `[corner_pair(a, b)][3 i + j]` is the force on corner a
/// along i by a displacement of corner b along j; the rest is the transpose.
#[derive(Clone, Debug)]
pub struct StiffnessBatch(pub Vec<[Row; 9]>);

impl StiffnessBatch {
    /// All pairs of corners with zero stiffness.
    pub fn zeros() -> Self {
        Self(vec![[Row::default(); 9]; CORNER_PAIRS])
    }
}

impl BlockTangent<'_> {
    /// Tangent stiffness of the elements of a batch.
    pub fn eval_batch(&self, batch: usize, stiffness: &mut StiffnessBatch) {
        let Self { block, u, at_nodes } = self;
        let chunk = &block.chunks[batch / Chunk::BATCHES];
        let nodes = block.nodes_of_chunk(batch / Chunk::BATCHES);
        with_elements!(&block.packed, elements => dispatch_rare(Stiffness {
            law: &block.parameters.material,
            mean_dilatation: block.parameters.formulation == Formulation::MeanDilatation,
            of_nodes: block.nodal_volumes.as_ref().map(|volumes| {
                volumes.of_batch(chunk, &elements.batches[batch].nodes, &at_nodes.response)
            }),
            batch: &elements.batches[batch],
            reduced: elements.one_point.get(batch),
            fibres: block.fibres_of(batch),
            u: gather_global(&elements.batches[batch].nodes, nodes, u),
            to: stiffness,
        }));
    }
}

/// A batch at one displacement.
struct Stiffness<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    law: &'a Material,
    mean_dilatation: bool,
    /// Fraction s of U that is of the elements [-], and means over their nodes, where pressure is averaged over nodes.
    of_nodes: Option<(f64, [Row; 3])>,
    batch: &'a Batch<E, N, Q>,
    /// Constants of the batch in one-point elements; `None` in other formulations.
    reduced: Option<&'a E::OnePoint>,
    fibres: &'a [[Row; 3]],
    u: [[Row; N]; 3],
    to: &'a mut StiffnessBatch,
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for Stiffness<'_, E, N, Q>
where
    E::OnePoint: OnePointStiffness<E, N, Q>,
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for part in 0..BATCH / S::F64_LANES {
            match self.reduced {
                Some(reduced) => reduced.eval_stiffness(simd, part, &mut self),
                None => self.eval_points(simd, part),
            }
        }
    }
}

/// A dual number whose value does not depend on the direction.
#[inline(always)]
pub(super) fn fixed<R: Real>(value: R) -> Dual<R> {
    Dual { value, slope: value.zero() }
}

/// [`fixed`] in every component.
#[inline(always)]
pub(super) fn fixed_tensor<R: Real>(t: &Tensor<R>) -> Tensor<Dual<R>> {
    let mut out = Tensor([[fixed(t.0[0][0]); 3]; 3]);
    for i in 0..3 {
        for j in 0..3 {
            out.0[i][j] = fixed(t.0[i][j]);
        }
    }
    out
}

/// [`fixed`] in every corner.
#[inline(always)]
fn fixed_corners<R: Real, const N: usize>(values: &[[R; N]; 3]) -> [[Dual<R>; N]; 3] {
    let mut out = [[fixed(values[0][0]); N]; 3];
    for (out, value) in out.as_flattened_mut().iter_mut().zip(values.as_flattened()) {
        *out = fixed(*value);
    }
    out
}

/// Fibre directions of the elements of a register, without slope.
#[inline(always)]
pub(super) fn fixed_fibres<S: Simd>(
    simd: S,
    rows: &[[Row; 3]],
    part: usize,
) -> [[Dual<Lane<S>>; 3]; MAX_FAMILIES] {
    let fibres = load_fibres(simd, rows, part);
    let mut out = [[fixed(Lane::splat(simd, 0.0)); 3]; MAX_FAMILIES];
    for (out, a) in out.iter_mut().zip(&fibres) {
        for i in 0..3 {
            out[i] = fixed(a[i]);
        }
    }
    out
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> Stiffness<'_, E, N, Q> {
    /// Adds the stiffness of every quadrature point of a register.
    #[inline(always)]
    fn eval_points<S: Simd>(&mut self, simd: S, part: usize) {
        let zero = Lane::splat(simd, 0.0);
        let directions = fixed_fibres(simd, self.fibres, part);
        let first_pass = self.batch.first_pass(simd, part, &self.u);
        let FirstPass { cof_X, w, H, .. } = &first_pass;
        let (mean, smallest) = (first_pass.mean, first_pass.smallest);
        let inverse_volume = Lane::load(simd, &self.batch.scaled_inverse_volume, part);
        let mean = Dual { value: mean, slope: zero + 1.0 };
        let U = self.law.volumetric();
        let pressure = match U {
            Some(U) if self.mean_dilatation => Some(U.pressure(mean)),
            Some(U) => self.of_nodes.as_ref().map(|(fraction, of_nodes)| {
                let of_nodes = fixed(Lane::load(simd, &of_nodes[1], part));
                shared(*fraction, U.pressure(mean), of_nodes)
            }),
            None => None,
        };

        let mut smallest_j = Row::default();
        smallest.store(&mut smallest_j, part);
        let barrier =
            (self.mean_dilatation && pressure.is_some() && point_is_crushed::<S>(&smallest_j, part))
                .then(|| Barrier::new(self.law.moduli_at_rest().0));
        let mut sums = [[zero; 9]; CORNER_PAIRS];
        let mut volume_slope = [[zero; 3]; N];
        for q in 0..Q {
            let fibres = &directions[..self.fibres.len()];
            let pressure_of_element = pressure.map(|p| (p.value, barrier));
            let A =
                zero.outlined(TangentAt { law: self.law, H: &H.0[q], fibres, pressure: pressure_of_element });
            // Gradients are those of the local cube times the scaled cofactor.
            let g = gradients::<E, _, N, Q>(
                q,
                &cof_X.0[q].scaled(Lane::load(simd, &self.batch.inverse_weight[q], part)),
            );
            let weight = w.0[q] * E::SCALE;
            add_pairs(&mut sums, &A, &g, weight);
            if pressure.is_some() {
                let cof_F = H.0[q].plus(&Tensor::diagonal(zero + 1.0)).cofactor().scaled(weight);
                for (slope, g) in volume_slope.iter_mut().zip(&g) {
                    let on = cof_F.apply(g);
                    for i in 0..3 {
                        slope[i] += on[i];
                    }
                }
            }
        }
        let bulk = pressure.map_or(zero, |p| p.slope * inverse_volume * (1.0 / E::SCALE));
        for a in 0..N {
            for b in 0..=a {
                let (sum, to) = (&sums[corner_pair(a, b)], &mut self.to.0[corner_pair(a, b)]);
                for i in 0..3 {
                    let c = volume_slope[a][i] * bulk;
                    for j in 0..3 {
                        c.mul_add(volume_slope[b][j], sum[3 * i + j]).store(&mut to[3 * i + j], part);
                    }
                }
            }
        }
        if !E::CORNERS.is_empty() && corners_may_fold::<S>(smallest, first_pass.mean, part) {
            self.add_corner_penalty(simd, part);
        }
    }

    /// The force of the corner penalty differentiated along each nodal displacement.
    #[inline(always)]
    fn add_corner_penalty<S: Simd>(&mut self, simd: S, part: usize) {
        let X = fixed_corners(&self.batch.corners_at_rest(simd, part));
        let k = self.batch.corner_stiffness.each_ref().map(|row| fixed(Lane::load(simd, row, part)));
        let mut u = fixed_corners(&load_corners(simd, &self.u, part));
        for column in 0..3 * N {
            let (b, j) = (column / 3, column % 3);
            u[j][b].slope = u[j][b].value.constant(1.0);
            let forces = eval_corner_penalty(E::CORNERS, &X, &u, k).forces;
            for a in b..N {
                for i in 0..3 {
                    let to = &mut self.to.0[corner_pair(a, b)][3 * i + j];
                    (Lane::load(simd, to, part) + forces[i][a].slope).store(to, part);
                }
            }
            u[j][b].slope = u[j][b].value.zero();
        }
    }
}

/// The stiffness of one-point elements.
trait OnePointStiffness<E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    /// Evaluates the stiffness of the elements of a register.
    fn eval_stiffness<S: Simd>(&self, simd: S, part: usize, to: &mut Stiffness<'_, E, N, Q>);
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> OnePointStiffness<E, N, Q> for NoOnePoint {
    fn eval_stiffness<S: Simd>(&self, _: S, _: usize, _: &mut Stiffness<'_, E, N, Q>) {
        match *self {}
    }
}

impl OnePointStiffness<Hex8, 8, 8> for ReducedBatch {
    /// The force differentiated along each nodal displacement.
    #[inline(always)]
    fn eval_stiffness<S: Simd>(&self, simd: S, part: usize, to: &mut Stiffness<'_, Hex8, 8, 8>) {
        let (A, B) = self.gradient_vectors(simd, part);
        let at_point = self.one_point(simd, part, A, B);
        let element = lift(&at_point);
        let directions = fixed_fibres(simd, to.fibres, part);
        let mut u = fixed_corners(&load_corners(simd, &to.u, part));
        for column in 0..24 {
            let (b, j) = (column / 3, column % 3);
            u[j][b].slope = u[j][b].value.constant(1.0);
            let modes = Modes::new(&u);
            let H = modes.mean_gradient(&element.A, &element.B);
            let k = Kinematics::new(&H);
            let p = to.law.volumetric().map_or(k.j.zero(), |U| U.pressure(k.j));
            let P = to.law.eval(&k, &directions[..to.fibres.len()]).first_piola(&k, p);
            let forces = element.nodal_forces(&P, &element.hourglass(&modes, &H));
            for a in b..8 {
                for i in 0..3 {
                    forces[i][a].slope.store(&mut to.to.0[corner_pair(a, b)][3 * i + j], part);
                }
            }
            u[j][b].slope = u[j][b].value.zero();
        }
        let modes = Modes::new(&load_corners(simd, &to.u, part));
        let H = modes.mean_gradient(&A, &B);
        if at_point.corners_may_fold(volume_change(&H), &at_point.hourglass(&modes, &H), part) {
            to.add_corner_penalty(simd, part);
        }
    }
}

/// A = ∂P/∂F [Pa], `[3 i + J][3 k + L]`, at a point: with the element's pressure [Pa] held and its barrier, or else with the point's own `U′`.
struct TangentAt<'a, R> {
    law: &'a Material,
    H: &'a Tensor<R>,
    fibres: &'a [[Dual<R>; 3]],
    pressure: Option<(R, Option<Barrier>)>,
}

impl<R: Real> Outlined for TangentAt<'_, R> {
    type Output = [[R; 9]; 9];

    #[inline(always)]
    fn run(self) -> [[R; 9]; 9] {
        let Self { law, H, fibres, pressure } = self;
        let U = law.volumetric();
        let mut A = [[H.0[0][0]; 9]; 9];
        let mut lifted = fixed_tensor(H);
        for column in 0..9 {
            let (k, l) = (column / 3, column % 3);
            lifted.0[k][l].slope = H.0[0][0].constant(1.0);
            let kinematics = Kinematics::new(&lifted);
            let p = match (pressure, U) {
                (Some((p, None)), _) => fixed(p),
                (Some((p, Some(barrier))), _) => fixed(p) + barrier.pressure(kinematics.j),
                (None, Some(U)) => U.pressure(kinematics.j),
                (None, None) => fixed(H.0[0][0].zero()),
            };
            store_column(&law.eval(&kinematics, fibres).first_piola(&kinematics, p), column, &mut A);
            lifted.0[k][l].slope = H.0[0][0].zero();
        }
        A
    }
}

/// Stores the derivative of P [Pa] along one component of F as a column of ∂P/∂F.
#[inline(always)]
pub(super) fn store_column<R: Real>(P: &Tensor<Dual<R>>, column: usize, A: &mut [[R; 9]; 9]) {
    for (row, A) in A.iter_mut().enumerate() {
        A[column] = P.0[row / 3][row % 3].slope;
    }
}

/// ∇N of the corners [1/m] at point `q`, `cof` the scaled cofactor of the reference geometry there.
#[inline(always)]
pub(super) fn gradients<E: Element<N, Q>, R: Real, const N: usize, const Q: usize>(
    q: usize,
    cof: &Tensor<R>,
) -> [[R; 3]; N] {
    let mut g = [[cof.0[0][0]; 3]; N];
    for (g, local) in g.iter_mut().zip(&E::shape_gradients()[q]) {
        let local = local.map(|slope| slope / E::DERIVATIVE);
        for (i, g) in g.iter_mut().enumerate() {
            let c = &cof.0[i];
            *g = c[0] * local[0] + c[1] * local[1] + c[2] * local[2];
        }
    }
    g
}

/// Adds `w ∇N_a A ∇N_b` to every pair.
#[inline(always)]
pub(super) fn add_pairs<R: Real, const N: usize>(
    sums: &mut [[R; 9]; CORNER_PAIRS],
    A: &[[R; 9]; 9],
    g: &[[R; 3]; N],
    w: R,
) {
    for b in 0..N {
        // A ∇N_b, by row (i, J) and direction k.
        let mut on = [[w; 3]; 9];
        let gb = [g[b][0] * w, g[b][1] * w, g[b][2] * w];
        for (on, A) in on.iter_mut().zip(A) {
            for (k, on) in on.iter_mut().enumerate() {
                let A = &A[3 * k..3 * k + 3];
                *on = A[2].mul_add(gb[2], A[1].mul_add(gb[1], A[0] * gb[0]));
            }
        }
        for a in b..N {
            let sum = &mut sums[corner_pair(a, b)];
            for i in 0..3 {
                for k in 0..3 {
                    let s = &mut sum[3 * i + k];
                    *s = g[a][0].mul_add(on[3 * i][k], *s);
                    *s = g[a][1].mul_add(on[3 * i + 1][k], *s);
                    *s = g[a][2].mul_add(on[3 * i + 2][k], *s);
                }
            }
        }
    }
}

/// Constants of one-point elements as dual numbers without slope.
#[inline(always)]
fn lift<R: Real>(element: &OnePointElement<R>) -> OnePointElement<Dual<R>> {
    let zero = fixed(element.volume.zero());
    let c = &element.constants;
    let mut constants = Hourglass {
        base: [[zero; 3]; 3],
        inverse_length: [zero; 3],
        plane: [[zero; 4]; 3],
        fourth: fixed(c.fourth),
        inverse_scale: fixed(c.inverse_scale),
        largest: fixed(c.largest),
    };
    for n in 0..3 {
        constants.inverse_length[n] = fixed(c.inverse_length[n]);
        for i in 0..3 {
            constants.base[n][i] = fixed(c.base[n][i]);
        }
        for i in 0..4 {
            constants.plane[n][i] = fixed(c.plane[n][i]);
        }
    }
    let mut curvature = [[zero; 3]; 4];
    for (to, from) in curvature.iter_mut().zip(&element.curvature) {
        for i in 0..3 {
            to[i] = fixed(from[i]);
        }
    }
    OnePointElement {
        volume: fixed(element.volume),
        A: fixed_tensor(&element.A),
        B: fixed_tensor(&element.B),
        curvature,
        constants,
    }
}

#[cfg(test)]
mod tests;
