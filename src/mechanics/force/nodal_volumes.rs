//! The volumes around the nodes of a block, for pressure averaged over nodes ([`super::nodal_pressure`]).

use super::Threads;
use super::chunk::{Chunk, ChunkForces, NodalResponse};
use super::parameters::{BlockInput, BlockParameters, Formulation};
use crate::lanes::{BATCH, Row};
use crate::material::Volumetric;
use crate::real::Real;
use std::collections::BTreeMap;
use std::ops::Range;

/// Largest modulus of the elements' fraction over the shear modulus, c [-]. From 0.03 to 0.3 the deflection of a cantilever changes by one per
/// cent; at 1 it is stiffer, and the pressure less smooth.
const STABILISATION: f64 = 0.3;

/// Nodes whose response is computed as one task.
const NODES: usize = 512;

/// The volumes around the nodes of a block.
#[derive(Debug)]
pub(super) struct NodalVolumes {
    /// Fraction s of U that is of the elements [-].
    pub fraction: f64,
    /// Global nodes of the block, ascending.
    pub nodes: Vec<u32>,
    /// For each node of each chunk, in their order, its number among the nodes of the block.
    number: Vec<u32>,
    /// Where the list of each node starts, nodes + 1.
    start: Vec<u32>,
    /// (chunk of the block, node in the chunk), ascending.
    places: Vec<(u32, u32)>,
    /// Inverse reference volume 1/V_a of each node [1/m³].
    inverse: Vec<f64>,
    /// R, row by row: where each begins, nodes + 1, and its columns, ascending, with their values.
    rows: Vec<u32>,
    neighbours: Vec<(u32, f64)>,
}

impl NodalVolumes {
    /// Nodal volumes of a block from its elements, chunks and nodes; `None` if the formulation does not average pressure.
    pub fn new(
        parameters: &BlockParameters,
        inputs: &[BlockInput],
        chunks: &[Chunk],
        chunk_nodes: &[u32],
    ) -> Option<Self> {
        if parameters.formulation != Formulation::NodalPressure {
            return None;
        }
        let mut nodes = chunk_nodes.to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        let of = |node: &u32| nodes.binary_search(node).unwrap_or_default();
        let number: Vec<u32> = chunk_nodes.iter().map(|node| of(node) as u32).collect();

        // The places of each node.
        let mut start = vec![0; nodes.len() + 1];
        for node in &number {
            start[*node as usize + 1] += 1;
        }
        for node in 0..nodes.len() {
            start[node + 1] += start[node];
        }
        let (mut next, mut places) = (start.clone(), vec![(0, 0); number.len()]);
        for (c, chunk) in chunks.iter().enumerate() {
            for (i, place) in chunk.nodes.clone().enumerate() {
                let next = &mut next[number[place as usize] as usize];
                places[*next as usize] = (c as u32, i as u32);
                *next += 1;
            }
        }

        // V_a and V_a R.
        let mut volume = vec![0.0; nodes.len()];
        let mut joint: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); nodes.len()];
        for input in inputs {
            let part = input.geometry.total_volume() / input.nodes.len() as f64;
            let own: Vec<usize> = input.nodes.iter().map(of).collect();
            for a in &own {
                volume[*a] += part;
                for b in &own {
                    *joint[*a].entry(*b as u32).or_default() += part / own.len() as f64;
                }
            }
        }
        let (mut rows, mut neighbours) = (vec![0], Vec::new());
        for (joint, volume) in joint.iter().zip(&volume) {
            neighbours.extend(joint.iter().map(|(node, part)| (*node, part / volume)));
            rows.push(neighbours.len() as u32);
        }
        let (G, K) = parameters.material.moduli_at_rest();
        let fraction = if K > 0.0 { (STABILISATION * G / K).min(1.0) } else { 1.0 };
        let inverse = volume.into_iter().map(|V| 1.0 / V).collect();
        Some(Self { fraction, nodes, number, start, places, inverse, rows, neighbours })
    }

    /// Copies the responses at the nodes of a chunk.
    pub fn gather(&self, chunk: &Chunk, from: &[NodalResponse], to: &mut [NodalResponse]) {
        let numbers = &self.number[chunk.nodes.start as usize..chunk.nodes.end as usize];
        to.iter_mut().zip(numbers).for_each(|(to, number)| *to = from[*number as usize]);
    }

    /// The fraction s, and the means over the nodes of the elements of a batch of a chunk.
    pub fn of_batch<const N: usize>(
        &self,
        chunk: &Chunk,
        nodes: &[[u16; BATCH]; N],
        from: &[NodalResponse],
    ) -> (f64, [Row; 3]) {
        let numbers = &self.number[chunk.nodes.start as usize..chunk.nodes.end as usize];
        (self.fraction, mean_over_nodes(nodes, |node| &from[numbers[node as usize] as usize]))
    }

    /// J_a − 1 [-] of a node, from the sums of the chunks [m³].
    #[inline]
    fn dilatation<'a>(&self, node: usize, sums: impl Fn(usize) -> &'a [f64]) -> f64 {
        let places = &self.places[self.start[node] as usize..self.start[node + 1] as usize];
        let sum = places.iter().fold(0.0, |sum, (chunk, i)| sum + sums(*chunk as usize)[*i as usize]);
        sum * self.inverse[node]
    }

    /// The row of a node in R.
    #[inline]
    pub fn row(&self, node: usize) -> &[(u32, f64)] {
        &self.neighbours[self.row_range(node)]
    }

    /// Where the row of a node is among all of R.
    #[inline]
    pub fn row_range(&self, node: usize) -> Range<usize> {
        self.rows[node] as usize..self.rows[node + 1] as usize
    }

    /// Number of entries of R.
    pub fn entries(&self) -> usize {
        self.neighbours.len()
    }

    /// 1/V_a [1/m³].
    pub fn inverse_volume(&self, node: usize) -> f64 {
        self.inverse[node]
    }

    /// J̃_a − 1 [-] of a node, from J − 1 of all nodes.
    #[inline]
    pub fn averaged_dilatation(&self, node: usize, dilatation: &[f64]) -> f64 {
        self.row(node).iter().fold(0.0, |sum, (b, R)| sum + R * dilatation[*b as usize])
    }

    /// Computes the responses of the nodes of a block from the sums of its chunks [m³].
    pub fn respond<'a>(
        &self,
        threads: &Threads,
        U: Volumetric,
        state: &mut NodalState,
        sums: impl Fn(usize) -> &'a [f64] + Copy + Send + Sync,
    ) {
        let NodalState { dilatation, own, response } = state;
        // Each loop reads what the one before has written of the neighbours.
        let mut nothing = vec![(); dilatation.len()];
        threads.for_each_run(NODES, (&mut dilatation[..], &mut nothing[..]), |run, dilatation, _| {
            let nodes = (run * NODES..).zip(dilatation);
            nodes.for_each(|(node, to)| *to = self.dilatation(node, sums));
        });
        threads.for_each_run(NODES, (&mut own[..], &mut nothing[..]), |run, own, _| {
            for (node, to) in (run * NODES..).zip(own) {
                let j = self.averaged_dilatation(node, dilatation);
                *to = [U.energy(j), U.pressure(j), U.stiffness(j).max(0.0)];
            }
        });
        threads.for_each_run(NODES, (&mut response[..], &mut nothing[..]), |run, response, _| {
            for (node, to) in (run * NODES..).zip(response) {
                *to = [0.0; 3];
                for (b, R) in self.row(node) {
                    to.iter_mut().zip(&own[*b as usize]).for_each(|(to, value)| *to += R * value);
                }
            }
        });
    }

    /// Memory of the lists of a block [bytes].
    pub fn memory(&self) -> usize {
        4 * (self.nodes.len() + self.number.len() + self.start.len())
            + 8 * (self.places.len() + self.inverse.len())
            + 4 * self.rows.len()
            + 16 * self.neighbours.len()
    }
}

/// Nodal quantities of a block during an evaluation; empty in other formulations.
#[derive(Debug, Default)]
pub(super) struct NodalState {
    /// J_a − 1 [-].
    pub dilatation: Vec<f64>,
    /// At the nodes' own J̃_a, and averaged over the neighbours.
    own: Vec<NodalResponse>,
    pub response: Vec<NodalResponse>,
}

impl NodalState {
    /// With room for the nodes of a block.
    pub fn of(volumes: Option<&NodalVolumes>) -> Self {
        let nodes = volumes.map_or(0, |volumes| volumes.inverse.len());
        Self { dilatation: vec![0.0; nodes], own: vec![[0.0; 3]; nodes], response: vec![[0.0; 3]; nodes] }
    }

    /// Memory of the responses at the nodes [bytes].
    pub fn memory(&self) -> usize {
        size_of_val(&self.dilatation[..]) + 2 * size_of_val(&self.response[..])
    }
}

impl ChunkForces {
    /// Means of the responses over the nodes of the elements of a batch; nothing in other formulations.
    #[inline(always)]
    pub(super) fn average_over_nodes<const N: usize>(&self, nodes: &[[u16; BATCH]; N], to: &mut [Row; 3]) {
        if !self.nodal.is_empty() {
            *to = mean_over_nodes(nodes, |node| &self.nodal[node as usize]);
        }
    }
}

/// Means of the responses over the nodes of the elements of a batch.
#[inline(always)]
pub(super) fn mean_over_nodes<'a, const N: usize>(
    nodes: &[[u16; BATCH]; N],
    response: impl Fn(u16) -> &'a NodalResponse,
) -> [Row; 3] {
    let mut sums = [Row::default(); 3];
    for nodes in nodes {
        for (lane, node) in nodes.iter().enumerate() {
            for (sum, value) in sums.iter_mut().zip(response(*node)) {
                sum.0[lane] += value * const { 1.0 / N as f64 };
            }
        }
    }
    sums
}

/// The volumetric quantity of an element, of which the fraction s is its own.
#[inline(always)]
pub(super) fn shared<R: Real>(fraction: f64, own: R, of_nodes: R) -> R {
    of_nodes.mul_add(own.constant(1.0 - fraction), own * fraction)
}
