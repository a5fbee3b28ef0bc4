//! Contact of a plan: surfaces, pairs, settings of the solver.

use super::by_pair::ByPair;
use crate::mechanics::contact::detection::rigid_detection::MOST_POINTS;
use crate::mechanics::contact::pairs::Pairs;
use crate::mechanics::contact::solution::solvers::Method;
use crate::mechanics::contact::{ContactPair, Discretisation, Master, Surface};

/// Contact pairs with their surfaces and solver settings.
#[derive(Debug)]
pub struct ContactPlan {
    /// One surface for each body in contact, in the order of the bodies.
    pub surfaces: Vec<Surface>,
    /// Body index of each surface.
    pub surface_body: Vec<usize>,
    /// Contact pairs; those with a rigid side come last.
    pub pairs: Pairs,
    /// Body index of each rigid body.
    pub rigid_body: Vec<usize>,
    /// Names of the two sides of each listed pair.
    pub listed_names: ByPair<[String; 2]>,
    /// Largest scaled residual of the solver [-].
    pub tolerance: f64,
    /// Discretisation of contact between two meshes.
    pub discretisation: Discretisation,
    /// Solver of the library that is given `W`, if the scene names one.
    pub solver: Option<Method>,
    /// Whether self-contact is searched for in every step, even where no parts can have come close.
    pub always_searches_self_contact: bool,
}

impl ContactPlan {
    /// Bodies of slave and master of a pair; `None` for a plane.
    pub fn bodies_of(&self, pair: &ContactPair) -> (usize, Option<usize>) {
        let master = match pair.master {
            Master::Surface(master) => Some(self.surface_body[master]),
            Master::Rigid(rigid) => Some(self.rigid_body[rigid]),
            Master::Plane { .. } => None,
        };
        (self.surface_body[pair.slave], master)
    }
    /// Bodies of slave and master of each pair, with the number of the pair.
    pub fn each_bodies(&self) -> impl Iterator<Item = (usize, (usize, Option<usize>))> {
        self.pairs.each().map(|(number, pair)| (number, self.bodies_of(&pair)))
    }
    /// Largest number of contacts in a step: one for each slave node of each pair, two where it may lie in a valley, and
    /// those between nodes. Of every two of many bodies, a usual number: one for each node.
    pub fn most_contacts(&self) -> usize {
        self.most_mesh_contacts() + self.most_rigid_contacts()
    }
    /// As [`ContactPlan::most_contacts`], for the pairs without a rigid side.
    pub fn most_mesh_contacts(&self) -> usize {
        let of_pair = |pair: &ContactPair| {
            let slaves = self.surfaces[pair.slave].nodes.len();
            match pair.master {
                // Valleys; master nodes in the slave; edges, of which a surface has two for each of its nodes.
                Master::Surface(master)
                    if master != pair.slave && self.discretisation != Discretisation::NodeToSurface =>
                {
                    let masters = self.surfaces[master].nodes.len();
                    2 * slaves + masters + 2 * slaves.min(masters)
                }
                _ => slaves,
            }
        };
        let listed = self.pairs.listed().take_while(|(number, _)| *number < self.pairs.mesh_count());
        let every = self.pairs.every_two().surfaces().map(|surface| self.surfaces[surface].nodes.len());
        listed.map(|(_, pair)| of_pair(pair)).sum::<usize>() + every.sum::<usize>()
    }
    /// As [`ContactPlan::most_contacts`], for the pairs with a rigid side: two rigid sides touch in a few points, a face in
    /// one or two, or in a few where the surface has few faces.
    pub fn most_rigid_contacts(&self) -> usize {
        let of_pair = |pair: &ContactPair| {
            let Surface { nodes, faces, .. } = &self.surfaces[pair.slave];
            nodes.len() + 2 * faces.len() + MOST_POINTS
        };
        self.pairs.rigid().0.iter().map(of_pair).sum()
    }
}
