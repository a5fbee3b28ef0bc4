//! Contacts that share no movable node are problems of their own. Each such group is swept and extrapolated by itself, so that a hard one
//! costs nothing in the others.

use super::super::connected::Connected;
use super::progress::{Options, Scale, Sweeps};
use super::sweeper::Sweeper;
use crate::contact::{Contact, Reaction, RigidSides};
use crate::tensor::Vec3;

/// Groups of connected contacts, with buffers for one of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups {
    connected: Connected,
    /// A contact of each node, if any has been found.
    of_node: Vec<Option<u32>>,
    /// The contacts, group by group.
    order: Vec<usize>,
    contacts: Vec<Contact>,
    reactions: Vec<Reaction>,
    sweeper: Sweeper,
}

impl Groups {
    /// Finds the groups of the contacts of a step; arguments as of `solve_with_rigid`.
    pub fn find(&mut self, contacts: &[Contact], rigid: &RigidSides, inverse_mass: &[Vec3]) {
        self.connected.restart(contacts.len());
        self.of_node.clear();
        self.of_node.resize(inverse_mass.len(), None);
        for (c, contact) in contacts.iter().enumerate() {
            let spin = |body: u32| rigid.bodies[body as usize].spin;
            let spins = rigid.of_pair(contact.pair).into_iter().flatten().map(spin);
            for node in contact.stencil.nodes().iter().copied().chain(spins).map(|node| node as usize) {
                if inverse_mass[node] == Vec3::zeros() {
                    continue;
                }
                match self.of_node[node] {
                    Some(other) => self.connected.join(c, other as usize),
                    None => self.of_node[node] = Some(c as u32),
                }
            }
        }
        self.connected.close();
        let firsts = self.connected.firsts();
        self.order.clear();
        self.order.extend(0..contacts.len());
        self.order.sort_unstable_by_key(|&c| (firsts[c], c));
    }

    /// Whether all contacts are connected.
    pub fn are_one(&self) -> bool {
        self.connected.firsts().iter().all(|first| *first == 0)
    }

    /// Sweeps over each group from the present impulses and velocities; returns the largest number of sweeps over one of them. Of what the
    /// residuals of all contacts are relative to, a group has a share by its number of contacts: together they are within the tolerance
    /// of the whole.
    pub fn solve(
        &mut self,
        contacts: &[Contact],
        rigid: &RigidSides,
        (inverse_mass, h, v): (&[Vec3], f64, &mut [Vec3]),
        reactions: &mut [Reaction],
        options: &Options,
        of_all: &Scale,
    ) -> usize {
        let Self { connected, order, contacts: own, reactions: of_group, sweeper, .. } = self;
        let firsts = connected.firsts();
        let mut longest = 0;
        for group in order.chunk_by(|&a, &b| firsts[a] == firsts[b]) {
            own.clear();
            own.extend(group.iter().map(|&c| contacts[c].clone()));
            of_group.clear();
            of_group.extend(group.iter().map(|&c| reactions[c]));
            sweeper.prepare(own, rigid, inverse_mass, h);
            let scale = of_all.share(group.len() as f64 / contacts.len() as f64);
            let mut sweeps = Sweeps::beginning(options);
            sweeper.sweep_until(options.max_sweeps, &mut sweeps, &scale, inverse_mass, v, of_group);
            longest = longest.max(sweeps.done);
            for (&c, reaction) in group.iter().zip(of_group.iter()) {
                reactions[c] = *reaction;
            }
        }
        longest
    }
}
