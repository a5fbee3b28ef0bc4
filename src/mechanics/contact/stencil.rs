//! The nodes of a contact with signed weights, by which their velocities make up that of the contact.

use crate::followers::Followers;
use crate::tensor::Vec3;
use std::ops::Range;

/// Largest weight of a node that is rounding.
const ROUNDING: f64 = 1e-13;
/// Largest number of nodes of a contact, both sides together.
pub const MOST_NODES: usize = 32;

/// The nodes of both sides of a contact with their signed weights: those of the slave side add up to +1, those of a
/// meshed master to −1; a plane has none. A rigid body is represented by the node of its centre of mass.
///
/// With `x` the positions of the nodes, `Σ w x` is the vector from the master to the slave, and with nodal velocities
/// it is the relative velocity; an impulse `p` on the slave side is `w p` on each node. So linear momentum is
/// conserved.
#[derive(Clone, Debug, PartialEq)]
pub struct Stencil {
    nodes: [u32; MOST_NODES],
    weights: [f64; MOST_NODES],
    slaves: u8,
    count: u8,
}

impl Stencil {
    /// One slave node; the master side is empty.
    pub fn of_node(slave: u32) -> Self {
        let (mut nodes, mut weights) = ([0; MOST_NODES], [0.0; MOST_NODES]);
        (nodes[0], weights[0]) = (slave, 1.0);
        Self { nodes, weights, slaves: 1, count: 1 }
    }

    /// For nodes (global) with weights that add up to 1 on either side, and with no node in common. Weights of zero
    /// are omitted, those of a node repeated on a side are added. `None` for more than [`MOST_NODES`] nodes.
    pub fn new(
        slave: impl IntoIterator<Item = (u32, f64)>,
        master: impl IntoIterator<Item = (u32, f64)>,
    ) -> Option<Self> {
        let mut stencil = Self { nodes: [0; MOST_NODES], weights: [0.0; MOST_NODES], slaves: 0, count: 0 };
        for (node, weight) in slave {
            stencil.add(0, node, weight)?;
        }
        stencil.slaves = stencil.count;
        for (node, weight) in master {
            stencil.add(stencil.len_of_slave(), node, -weight)?;
        }
        Some(stencil)
    }

    /// A slave node against a point of a face, given by its nodes and shape functions; zero weights for a plane.
    ///
    /// Weights that are rounding belong to the largest: a node on an edge in a plane of symmetry meets that edge alone.
    pub fn node_on_face(slave: u32, face: &[u32; 4], weights: &[f64; 4]) -> Self {
        let mut stencil = Self::of_node(slave);
        let mut exact = weights.map(|weight| if weight.abs() < ROUNDING { 0.0 } else { weight });
        let lost = weights.iter().zip(exact).map(|(weight, exact)| weight - exact).sum::<f64>();
        if lost != 0.0 {
            let largest = (1..4).fold(0, |largest, i| if exact[i] > exact[largest] { i } else { largest });
            exact[largest] += lost;
        }
        for (&node, weight) in face.iter().zip(exact) {
            // Five nodes always fit.
            let _ = stencil.add(1, node, -weight);
        }
        stencil
    }

    fn add(&mut self, side: usize, node: u32, weight: f64) -> Option<()> {
        if weight == 0.0 {
            return Some(());
        }
        let count = usize::from(self.count);
        if let Some(i) = self.nodes[side..count].iter().position(|&n| n == node) {
            self.weights[side + i] += weight;
            return Some(());
        }
        *self.nodes.get_mut(count)? = node;
        self.weights[count] = weight;
        self.count += 1;
        Some(())
    }

    /// The same stencil with followers replaced by their masters: relative velocity and power of an impulse are
    /// unchanged. `None` for more than [`MOST_NODES`] nodes.
    pub fn without(&self, followers: &Followers) -> Option<Self> {
        if !self.nodes().iter().any(|node| followers.contains(*node as usize)) {
            return Some(self.clone());
        }
        let movers = |is_master: bool| {
            let nodes = self.side(is_master);
            nodes.flat_map(|(node, w)| {
                followers.movers(node).map(move |(mover, fraction)| (mover, w * fraction))
            })
        };
        Self::new(movers(false), movers(true))
    }

    /// The same stencil with other numbers of its nodes, no two of them equal.
    #[must_use]
    pub fn renumbered(&self, new: impl Fn(u32) -> u32) -> Self {
        let mut stencil = self.clone();
        stencil.nodes[..usize::from(self.count)].iter_mut().for_each(|node| *node = new(*node));
        stencil
    }

    fn len_of_slave(&self) -> usize {
        usize::from(self.slaves)
    }

    fn range(&self, range: Range<usize>) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        self.nodes[range.clone()].iter().copied().zip(self.weights[range].iter().copied())
    }

    /// All nodes (global), the slave's first, each once.
    #[inline]
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..usize::from(self.count)]
    }

    /// Signed weights of the nodes, in their order.
    #[inline]
    pub fn weights(&self) -> &[f64] {
        &self.weights[..usize::from(self.count)]
    }

    /// All nodes with their signed weights.
    pub fn each(&self) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        self.range(0..usize::from(self.count))
    }

    /// The nodes of the slave side with their weights, which add up to 1.
    pub fn slave(&self) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        self.range(0..self.len_of_slave())
    }

    /// The nodes of the master side with their signed weights, which add up to −1; none for a plane.
    pub fn master(&self) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        self.range(self.len_of_slave()..usize::from(self.count))
    }

    /// The nodes of one side with the absolute values of their weights.
    pub fn side(&self, is_master: bool) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        let (range, sign) = if is_master {
            (self.len_of_slave()..usize::from(self.count), -1.0)
        } else {
            (0..self.len_of_slave(), 1.0)
        };
        self.range(range).map(move |(node, weight)| (node, sign * weight))
    }

    /// `Σ w a` for a vector `a` at each node.
    #[inline]
    pub fn difference(&self, a: &[Vec3]) -> Vec3 {
        let (nodes, weights) = (self.nodes(), self.weights());
        nodes.iter().zip(weights).fold(Vec3::zeros(), |sum, (&node, &w)| sum + a[node as usize] * w)
    }
}

/// `Σ w a` over nodes with weights.
pub fn weighted(nodes: impl Iterator<Item = (u32, f64)>, a: impl Fn(u32) -> Vec3) -> Vec3 {
    nodes.fold(Vec3::zeros(), |sum, (node, w)| sum + a(node) * w)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact equality is intended
mod tests {
    use super::*;

    #[test]
    fn nodes_stand_once_a_side_and_weights_are_signed() {
        let s = Stencil::new([(7, 0.5), (3, 0.5)], [(4, 0.25), (5, 0.0), (4, 0.75)]).unwrap();
        assert_eq!((s.nodes(), s.weights()), (&[7, 3, 4][..], &[0.5, 0.5, -1.0][..]));
        assert_eq!(s.slave().map(|(_, w)| w).sum::<f64>(), 1.0);
        assert_eq!(s.master().collect::<Vec<_>>(), [(4, -1.0)]);
        let plane = Stencil::node_on_face(2, &[2; 4], &[0.0; 4]);
        assert_eq!(plane, Stencil::of_node(2));
        assert_eq!(Stencil::new([(0, 1.0)], (1..40).map(|n| (n, 1.0 / 39.0))), None);
    }

    #[test]
    fn a_follower_is_replaced_by_whom_it_follows() {
        let ties = std::collections::BTreeMap::from([
            (7, vec![(1, 0.5), (2, 0.5)]),
            (4, vec![(5, 0.25), (6, 0.75)]),
        ]);
        let followers = Followers::new(8, &ties).unwrap();
        let stencil = Stencil::node_on_face(7, &[3, 4, 5, 0], &[0.5, 0.25, 0.25, 0.0]);
        let free = stencil.without(&followers).unwrap();
        assert_eq!(free.slave().collect::<Vec<_>>(), [(1, 0.5), (2, 0.5)]);
        assert_eq!(free.master().collect::<Vec<_>>(), [(3, -0.5), (5, -0.3125), (6, -0.1875)]);
        let mut v: Vec<Vec3> = (0..8).map(|i| Vec3::new(f64::from(i * i), 1.0, f64::from(i).sin())).collect();
        followers.follow(&mut v);
        assert!((free.difference(&v) - stencil.difference(&v)).norm() < 1e-14);
        assert_eq!(free.without(&Followers::default()), Some(free.clone()));
    }
}
