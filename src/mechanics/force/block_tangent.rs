//! Tangent of a block: the stiffness of its elements, and that of pressures averaged over nodes ([`super::nodal_pressure`]).
//!
//! With such pressures the elements have a stiffness of their own ([`super::stiffness`]), their mean pressure over the nodes held, and each
//! node adds a term over its patch, the nodes of the elements around it and of those around these:
//!
//! ```text
//! K = Σ_e K_e + Σ_a (1 − s) V_a U″(J̃_a) g̃_a g̃_aᵀ
//! g̃_a = ∂J̃_a/∂u = Σ_b R_ab ∂J_b/∂u      ∂J_b/∂u = Σ_e ¼ V_e ∂J_e/∂u / V_b
//! ```
//!
//! It couples nodes up to four edges apart, so that a factor has many times the entries of one of elements alone.

use super::block::ElementBlock;
use super::nodal_volumes::{NodalState, NodalVolumes};
use crate::element::Tet4;
use crate::tensor::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// The tangent ∂f_int/∂u of a block at one displacement.
#[derive(Debug)]
pub struct BlockTangent<'a> {
    pub(super) block: &'a ElementBlock,
    /// Displacements [m], nodes × 3.
    pub(super) u: &'a [Vec3],
    pub(super) at_nodes: NodalState,
}

/// The term `modulus · g gᵀ` of a node that averages pressure.
#[derive(Debug)]
pub struct NodalTerm {
    /// (1 − s) V_a U″(J̃_a) [J].
    pub modulus: f64,
    /// Global nodes of the patch, ascending, and g = ∂J̃_a/∂u of each [1/m].
    pub patch: Vec<(u32, Vec3)>,
}

impl ElementBlock {
    /// The tangent at displacements `u` [m], nodes × 3.
    pub fn tangent_at<'a>(&'a self, u: &'a [Vec3]) -> BlockTangent<'a> {
        BlockTangent { block: self, u, at_nodes: self.nodal_state(u) }
    }

    /// Global nodes of the patch of each node that averages pressure: those that its term couples. None in other formulations.
    pub fn patches(&self) -> Vec<Vec<u32>> {
        let Some(volumes) = &self.nodal_volumes else { return Vec::new() };
        let columns = |node: usize| volumes.row(node).iter().map(|(column, _)| *column as usize);
        let patch = |node: usize| -> Vec<u32> {
            let patch: BTreeSet<usize> = columns(node).flat_map(columns).collect();
            patch.into_iter().map(|node| volumes.nodes[node]).collect()
        };
        (0..volumes.nodes.len()).map(patch).collect()
    }
}

impl BlockTangent<'_> {
    /// Visits the terms of the nodes that average pressure, with the positions at rest `X` [m]. None in other formulations.
    pub fn for_each_nodal_term(&self, X: &[Vec3], visit: &mut dyn FnMut(&NodalTerm)) {
        let Some((volumes, U)) = self.block.averaged() else { return };
        let slopes = self.volume_slopes(volumes, X);
        for node in 0..volumes.nodes.len() {
            let j = volumes.averaged_dilatation(node, &self.at_nodes.dilatation);
            let modulus = (1.0 - volumes.fraction) * U.stiffness(j) / volumes.inverse_volume(node);
            let mut patch: BTreeMap<u32, Vec3> = BTreeMap::new();
            for (b, R) in volumes.row(node) {
                let b = *b as usize;
                let scale = R * volumes.inverse_volume(b);
                for ((column, _), slope) in volumes.row(b).iter().zip(&slopes[volumes.row_range(b)]) {
                    *patch.entry(volumes.nodes[*column as usize]).or_default() += slope * scale;
                }
            }
            visit(&NodalTerm { modulus, patch: patch.into_iter().collect() });
        }
    }

    /// V_b ∂J_b/∂u [m²] for each node b along its row of R, whose columns are the nodes of its elements.
    fn volume_slopes(&self, volumes: &NodalVolumes, X: &[Vec3]) -> Vec<Vec3> {
        let Self { block, u, .. } = self;
        let mut slopes = vec![Vec3::zeros(); volumes.entries()];
        for slot in 0..block.elements.len() {
            let nodes = block.nodes_of(slot);
            let at = |i: usize| X[nodes[i] as usize] + u[nodes[i] as usize];
            let of_element = Tet4::volume_slopes(&[0, 1, 2, 3].map(at));
            let own = [0, 1, 2, 3].map(|i| volumes.nodes.binary_search(&nodes[i]).unwrap_or_default());
            for b in own {
                let first = volumes.row_range(b).start;
                for (column, slope) in own.iter().zip(&of_element) {
                    let place = volumes.row(b).partition_point(|(other, _)| (*other as usize) < *column);
                    slopes[first + place] += slope * 0.25;
                }
            }
        }
        slopes
    }
}
