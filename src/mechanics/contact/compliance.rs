//! What a unit impulse at each node of the contacts does to the velocities of all of them: the Delassus operator of bodies
//! whose nodes are coupled by a factored matrix.
//!
//! With S the matrix of an implicit step and E the columns of the identity at the nodes that contacts touch, `G = Eᵀ S⁻¹ E` serves
//! every set of contacts between those nodes, however their frames and weights change: `W = C G Cᵀ`. So it is solved for
//! when S changes or new nodes come in, not in every iteration.

use super::Contact;
use super::contact_row::signed_weights;
use super::local::Local;
use crate::mechanics::sparse::{Cholesky, Unknowns};
use crate::mechanics::tensor::Vec3;

/// G [1/kg], rows and columns 3 i + axis of the nodes; zero along axes that are held.
#[derive(Clone, Debug, Default)]
pub struct NodeCompliance {
    /// Its nodes, ascending.
    nodes: Vec<u32>,
    values: Vec<f64>,
}

impl NodeCompliance {
    /// Its nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Whether it has all nodes of the contacts.
    pub fn covers(&self, contacts: &[Contact]) -> bool {
        contacts.iter().all(|contact| {
            let (nodes, _, count) = signed_weights(contact);
            nodes[..count].iter().all(|node| self.nodes.binary_search(node).is_ok())
        })
    }

    /// Its nodes and those of the contacts, ascending.
    pub fn nodes_with(&self, contacts: &[Contact]) -> Vec<u32> {
        let mut nodes = self.nodes.clone();
        for contact in contacts {
            let (own, _, count) = signed_weights(contact);
            nodes.extend_from_slice(&own[..count]);
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Solves for the columns of `nodes` (ascending, each once). The bits depend on the list as a whole.
    pub fn solve(&mut self, nodes: Vec<u32>, unknowns: &Unknowns, factor: &mut Cholesky) {
        let n = 3 * nodes.len();
        self.nodes = nodes;
        // Free axes: which unknown, and which row of G.
        let (mut free, mut places) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for (i, node) in self.nodes.iter().enumerate() {
            for axis in 0..3 {
                if let Some(unknown) = unknowns.of(*node as usize, axis) {
                    free.push(unknown);
                    places.push(3 * i + axis);
                }
            }
        }
        let mut block = vec![0.0; free.len() * free.len()];
        factor.inverse_block(&free, &mut block);
        self.values.clear();
        self.values.resize(n * n, 0.0);
        for (row, place) in places.iter().enumerate() {
            for (column, other) in places.iter().enumerate() {
                self.values[place * n + other] = block[row * free.len() + column];
            }
        }
    }

    /// W = C G Cᵀ of contacts between its nodes, three rows (n, t1, t2) each, row by row; symmetric to the last bit.
    pub fn delassus(&self, contacts: &[Contact]) -> Vec<f64> {
        let (n, rows) = (3 * self.nodes.len(), 3 * contacts.len());
        let places: Vec<Vec<(usize, f64)>> = contacts.iter().map(|contact| self.places(contact)).collect();
        let mut W = vec![0.0; rows * rows];
        let mut on = vec![0.0; n];
        for (c, contact) in contacts.iter().enumerate() {
            for (i, direction) in contact.frame.iter().enumerate() {
                // One row of C G.
                on.fill(0.0);
                for (place, weight) in &places[c] {
                    for axis in 0..3 {
                        let factor = weight * direction[axis];
                        let G = &self.values[(3 * place + axis) * n..][..n];
                        for (on, G) in on.iter_mut().zip(G) {
                            *on += factor * G;
                        }
                    }
                }
                for d in 0..=c {
                    let mut sum = Vec3::zeros();
                    for (place, weight) in &places[d] {
                        sum += Vec3::new(on[3 * place], on[3 * place + 1], on[3 * place + 2]) * *weight;
                    }
                    for (j, direction) in contacts[d].frame.iter().enumerate() {
                        let (row, column) = (3 * c + i, 3 * d + j);
                        if column <= row {
                            W[row * rows + column] = direction.dot(&sum);
                            W[column * rows + row] = direction.dot(&sum);
                        }
                    }
                }
            }
        }
        W
    }

    /// Where the nodes of a contact are, with their weights.
    fn places(&self, contact: &Contact) -> Vec<(usize, f64)> {
        let (nodes, weights, count) = signed_weights(contact);
        let find = |i: usize| Some((self.nodes.binary_search(&nodes[i]).ok()?, weights[i]));
        (0..count).filter_map(find).collect()
    }
}

/// What the law asks of a contact: `C v + drift + max(gap, 0)/h n`, in its local frame [m/s], with nodal velocities `v`
/// relative to the flight of the bodies and `h` [s] the step.
pub fn closing_velocity(contact: &Contact, v: &[Vec3], h: f64) -> Local {
    let (nodes, weights, count) = signed_weights(contact);
    let mut relative = contact.drift;
    for i in 0..count {
        relative += v[nodes[i] as usize] * weights[i];
    }
    let [n, t1, t2] = &contact.frame;
    [n.dot(&relative) + contact.gap.max(0.0) / h, t1.dot(&relative), t2.dot(&relative)]
}

/// Adds Cᵀ p, the impulse `p` [N s] of a contact (n, t1, t2), to its nodes.
pub fn add_impulse(contact: &Contact, p: Local, to: &mut [Vec3]) {
    let (nodes, weights, count) = signed_weights(contact);
    let [n, t1, t2] = &contact.frame;
    let in_space = n * p[0] + t1 * p[1] + t2 * p[2];
    for i in 0..count {
        to[nodes[i] as usize] += in_space * weights[i];
    }
}
