//! One contact as Gauss–Seidel sees it: its nodes, its own block of the Delassus operator, its relative velocity.

use super::Contact;
use super::local::{Local, LocalOperator};
use crate::mechanics::tensor::Vec3;

/// Two numbers of a diagonal closer than this are equal: the operator is a multiple of the identity.
const ISOTROPY: f64 = 1e-14;
/// Normal compliance below this share of the trace: nothing can move along n.
const IMMOVABLE: f64 = 1e-12;

/// One contact, ready for sweeps.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Its nodes and their signed weights: the slave (+1), then the master's with a weight (−w).
    nodes: [u32; 5],
    weights: [f64; 5],
    node_count: usize,
    pub frame: [Vec3; 3],
    /// Local drift + (max(gap, 0)/h) n.
    bias: Local,
    /// `W_nn`, 0 for a contact between immovable sides, which is skipped.
    pub w_nn: f64,
    /// `tr W / 3`.
    pub d: f64,
    /// `W = d I`.
    pub isotropic: bool,
    /// `C M⁻¹ Cᵀ` of this contact alone, in the local frame.
    pub W: LocalOperator,
}

/// |a|².
pub(super) fn squared(a: Local) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

impl Row {
    /// Gathers a contact for a step of length `h` [s], with `inverse_mass` [1/kg] per node and axis.
    pub fn new(contact: &Contact, inverse_mass: &[Vec3], h: f64) -> Self {
        let (nodes, weights, node_count) = signed_weights(contact);
        // C M⁻¹ Cᵀ in space is diagonal; a node that appears once contributes its squared weight.
        let mut diagonal = Vec3::zeros();
        for i in 0..node_count {
            diagonal += inverse_mass[nodes[i] as usize] * (weights[i] * weights[i]);
        }
        let (least, most) = (diagonal.min(), diagonal.max());
        let isotropic = most - least <= ISOTROPY * most;
        let frame = contact.frame;
        let mut W = [[0.0; 3]; 3];
        for (row, a) in W.iter_mut().zip(&frame) {
            for (x, b) in row.iter_mut().zip(&frame) {
                *x = a.component_mul(&diagonal).dot(b);
            }
        }
        let trace = diagonal.sum();
        let d = if isotropic { diagonal.x } else { trace / 3.0 };
        let n_n = if isotropic { d } else { W[0][0] };
        let w_nn = if n_n > IMMOVABLE * trace { n_n } else { 0.0 };
        let opening = contact.gap.max(0.0) / h;
        let bias = [
            frame[0].dot(&contact.drift) + opening,
            frame[1].dot(&contact.drift),
            frame[2].dot(&contact.drift),
        ];
        Self { nodes, weights, node_count, frame, bias, w_nn, d, isotropic, W }
    }

    /// `v_slave − Σ w_a v_a`, in space.
    #[inline]
    fn difference(&self, v: &[Vec3]) -> Vec3 {
        let mut sum = v[self.nodes[0] as usize];
        for i in 1..self.node_count {
            sum += v[self.nodes[i] as usize] * self.weights[i];
        }
        sum
    }

    /// `u` in the local frame.
    #[inline]
    pub fn relative_velocity(&self, v: &[Vec3]) -> Local {
        let w = self.difference(v);
        [0, 1, 2].map(|i| self.frame[i].dot(&w) + self.bias[i])
    }

    /// `u_n` alone.
    #[inline]
    pub fn normal_velocity(&self, v: &[Vec3]) -> f64 {
        self.frame[0].dot(&self.difference(v)) + self.bias[0]
    }

    /// Adds `M⁻¹ Cᵀ` of an impulse in space.
    #[inline]
    pub fn push(&self, impulse: Vec3, inverse_mass: &[Vec3], v: &mut [Vec3]) {
        for i in 0..self.node_count {
            let node = self.nodes[i] as usize;
            v[node] += inverse_mass[node].component_mul(&impulse) * self.weights[i];
        }
    }

    /// The size of the velocities that add up to `u`.
    pub fn roundable(&self, v: &[Vec3]) -> f64 {
        let nodes = (0..self.node_count).map(|i| v[self.nodes[i] as usize].amax() * self.weights[i].abs());
        nodes.sum::<f64>() + squared(self.bias).sqrt()
    }
}

/// The nodes of a contact with signed weights: the slave first, then the master's nodes of non-zero weight, each once.
fn signed_weights(contact: &Contact) -> ([u32; 5], [f64; 5], usize) {
    let mut nodes = [contact.slave; 5];
    let mut weights = [0.0; 5];
    weights[0] = 1.0;
    let mut count = 1;
    for (&node, &w) in contact.master.iter().zip(&contact.weights) {
        if w == 0.0 {
            continue;
        }
        if let Some(i) = nodes[..count].iter().position(|&n| n == node) {
            weights[i] -= w;
        } else {
            nodes[count] = node;
            weights[count] = -w;
            count += 1;
        }
    }
    (nodes, weights, count)
}
