//! Velocities of the contact nodes due to a unit impulse at each of them: the Delassus operator of bodies whose nodes
//! are coupled by a factored matrix.
//!
//! With S the matrix of an implicit step and E the columns of the identity at the nodes that contacts touch, `G = Eᵀ
//! S⁻¹ E` serves every set of contacts between those nodes, however their frames and weights change: `W = C G Cᵀ`. So
//! G is computed only when S changes or new nodes are added, not in every iteration. A rigid side of a contact is
//! represented by the two nodes of its body, centre and spin.

use super::contact_row::MomentArms;
use super::delassus::Block;
use super::local::Local;
use crate::contact::{Contact, RigidSides};
use crate::sparse::{Cholesky, PatternInverse, Unknowns};
use crate::tensor::{Mat3, Vec3};

/// Number of contact nodes beyond which W is not formed: products are as fast there even where iterations with them converge
/// slowly (docs/performance.md).
pub const MOST_NODES: usize = 400;
/// Number of contacts whose diagonal blocks of W are computed together.
const CONTACTS_AT_A_TIME: usize = 32;

/// G [1/kg], rows and columns 3 i + axis of the nodes; zero along fixed axes.
#[derive(Clone, Debug, Default)]
pub struct NodeCompliance {
    /// Global node numbers, ascending.
    nodes: Vec<u32>,
    values: Vec<f64>,
}

impl NodeCompliance {
    /// Global numbers of its nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Whether it contains all nodes of the contacts.
    pub fn covers(&self, contacts: &[Contact], rigid: &RigidSides) -> bool {
        let is_here = |entry: RowEntry| self.nodes.binary_search(&entry.node()).is_ok();
        contacts.iter().all(|contact| row_entries(contact, rigid).all(is_here))
    }

    /// Its nodes together with those of the contacts, ascending.
    pub fn nodes_with(&self, contacts: &[Contact], rigid: &RigidSides) -> Vec<u32> {
        let mut nodes = self.nodes.clone();
        for contact in contacts {
            nodes.extend(row_entries(contact, rigid).map(RowEntry::node));
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Solves for the columns of `nodes` (ascending, each once). The bits depend on the list as a whole.
    pub fn solve(&mut self, nodes: Vec<u32>, unknowns: &Unknowns, factor: &mut Cholesky) {
        let n = 3 * nodes.len();
        self.nodes = nodes;
        // Free axes: number of the unknown, and row of G.
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

    /// W = C G Cᵀ of contacts between its nodes, row by row, `unknowns` rows each: (n, t1, t2), or n alone; symmetric
    /// to the last bit.
    pub fn delassus(&self, contacts: &[Contact], rigid: &RigidSides, unknowns: usize) -> Vec<f64> {
        let (n, rows) = (3 * self.nodes.len(), unknowns * contacts.len());
        let places: Vec<Vec<(usize, RowEntry)>> =
            contacts.iter().map(|contact| self.places(contact, rigid)).collect();
        let mut W = vec![0.0; rows * rows];
        let mut on = vec![0.0; n];
        for (c, contact) in contacts.iter().enumerate() {
            for (i, direction) in contact.frame[..unknowns].iter().enumerate() {
                // One row of C G.
                on.fill(0.0);
                for (place, entry) in &places[c] {
                    let pull = entry.pull(direction);
                    for axis in 0..3 {
                        let factor = pull[axis];
                        let G = &self.values[(3 * place + axis) * n..][..n];
                        for (on, G) in on.iter_mut().zip(G) {
                            *on += factor * G;
                        }
                    }
                }
                // Products with the columns of Cᵀ, up to the diagonal; the rest by symmetry.
                for d in 0..=c {
                    let mut sum = Vec3::zeros();
                    for (place, entry) in &places[d] {
                        sum +=
                            entry.velocity(&Vec3::new(on[3 * place], on[3 * place + 1], on[3 * place + 2]));
                    }
                    for (j, direction) in contacts[d].frame[..unknowns].iter().enumerate() {
                        let (row, column) = (unknowns * c + i, unknowns * d + j);
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

    /// The diagonal blocks of W. The nodes of one side of a contact are mostly those of one element, so that the inverse in the
    /// pattern of the factor has them; the others are solved for, a few contacts at a time to save memory.
    pub fn own_blocks(
        contacts: &[Contact],
        rigid: &RigidSides,
        unknowns: &Unknowns,
        factor: &mut Cholesky,
    ) -> Vec<Block> {
        let mut blocks = vec![Block::default(); contacts.len()];
        let own = |of: &Self, contacts: &[Contact]| -> Vec<Block> {
            let (W, rows) = (of.delassus(contacts, rigid, 3), 3 * contacts.len());
            let of_contact =
                |c: usize| [0, 1, 2].map(|i| [0, 1, 2].map(|j| W[(3 * c + i) * rows + 3 * c + j]));
            (0..contacts.len()).map(of_contact).collect()
        };
        let mut others: Vec<usize> = (0..contacts.len()).collect();
        if let Some(inverse) = factor.pattern_inverse() {
            others.retain(|&c| {
                let contact = &contacts[c..=c];
                let nodes = Self::default().nodes_with(contact, rigid);
                let few = Self::of_pattern(nodes, unknowns, &inverse);
                let found = few.map(|few| own(&few, contact));
                blocks[c] = found.as_ref().map_or(blocks[c], |found| found[0]);
                found.is_none()
            });
        }
        let mut few = Self::default();
        for chunk in others.chunks(CONTACTS_AT_A_TIME) {
            let of_chunk: Vec<Contact> = chunk.iter().map(|&c| contacts[c].clone()).collect();
            few.solve(Self::default().nodes_with(&of_chunk, rigid), unknowns, factor);
            for (&c, block) in chunk.iter().zip(own(&few, &of_chunk)) {
                blocks[c] = block;
            }
        }
        blocks
    }

    /// The block of the compliance that belongs to `nodes` (ascending), if the pattern has all their entries.
    fn of_pattern(nodes: Vec<u32>, unknowns: &Unknowns, inverse: &PatternInverse) -> Option<Self> {
        let n = 3 * nodes.len();
        let mut values = vec![0.0; n * n];
        let unknown = |i: usize| unknowns.of(nodes[i / 3] as usize, i % 3);
        for row in 0..n {
            for column in 0..=row {
                if let (Some(i), Some(j)) = (unknown(row), unknown(column)) {
                    let entry = inverse.entry(i, j)?;
                    (values[row * n + column], values[column * n + row]) = (entry, entry);
                }
            }
        }
        Some(Self { nodes, values })
    }

    /// Rows of G and coefficients of the nodes of a contact.
    fn places(&self, contact: &Contact, rigid: &RigidSides) -> Vec<(usize, RowEntry)> {
        let find = |entry: RowEntry| Some((self.nodes.binary_search(&entry.node()).ok()?, entry));
        row_entries(contact, rigid).filter_map(find).collect()
    }
}

/// Whether contacts have too many nodes for W to be formed.
pub fn are_many(contacts: &[Contact], rigid: &RigidSides) -> bool {
    NodeCompliance::default().nodes_with(contacts, rigid).len() > MOST_NODES
}

/// Contribution of a node to the velocity of a contact.
#[derive(Clone, Copy, Debug)]
enum RowEntry {
    /// Translation with a signed weight.
    Moved(u32, f64),
    /// Rotation about a moment arm: the spin of a rigid body.
    Turned(u32, Mat3),
}

impl RowEntry {
    fn node(self) -> u32 {
        match self {
            Self::Moved(node, _) | Self::Turned(node, _) => node,
        }
    }
    /// Contribution of the velocity of the node [m/s or rad/s] to that of the contact.
    fn velocity(self, v: &Vec3) -> Vec3 {
        match self {
            Self::Moved(_, weight) => v * weight,
            Self::Turned(_, J) => J * v,
        }
    }
    /// Impulse on the node due to an impulse on the contact in space.
    fn pull(self, impulse: &Vec3) -> Vec3 {
        match self {
            Self::Moved(_, weight) => impulse * weight,
            Self::Turned(_, J) => J.tr_mul(impulse),
        }
    }
}

/// Coefficients of all nodes of a contact.
fn row_entries<'a>(contact: &'a Contact, rigid: &RigidSides) -> impl Iterator<Item = RowEntry> + use<'a> {
    let moved = contact.stencil.each().map(|(node, weight)| RowEntry::Moved(node, weight));
    let moment_arms = MomentArms::new(contact, rigid.of_pair(contact.pair), rigid);
    moved.chain(moment_arms.into_each().map(|(spin, J)| RowEntry::Turned(spin, J)))
}

/// Velocity that enters the contact law: `C v + drift + max(gap, 0)/h n`, in the local frame [m/s], with nodal
/// velocities `v` relative to the rigid-body velocities V and the step `h` [s].
pub fn closing_velocity(contact: &Contact, rigid: &RigidSides, v: &[Vec3], h: f64) -> Local {
    let [n, t1, t2] = relative_velocity(contact, rigid, v, contact.drift);
    [n + contact.gap.max(0.0) / h, t1, t2]
}

/// `C v + drift` of a contact in its local frame [m/s], with nodal velocities `v` and `drift` in space.
pub fn relative_velocity(contact: &Contact, rigid: &RigidSides, v: &[Vec3], drift: Vec3) -> Local {
    let each = row_entries(contact, rigid).map(|entry| entry.velocity(&v[entry.node() as usize]));
    let relative = each.fold(drift, |sum, velocity| sum + velocity);
    contact.frame.map(|direction| direction.dot(&relative))
}

/// Adds Cᵀ p, for the impulse `p` [N s] of a contact (n, t1, t2), to its nodes.
pub fn add_impulse(contact: &Contact, rigid: &RigidSides, p: Local, to: &mut [Vec3]) {
    let [n, t1, t2] = &contact.frame;
    let in_space = n * p[0] + t1 * p[1] + t2 * p[2];
    for entry in row_entries(contact, rigid) {
        to[entry.node() as usize] += entry.pull(&in_space);
    }
}
