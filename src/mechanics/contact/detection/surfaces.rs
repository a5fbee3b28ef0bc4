//! The sides of contact pairs: the surfaces that contacts are found on, and that their gaps are measured on again.

use super::boundary::Boundary;
use crate::contact::pairs::Pairs;
use crate::contact::{Master, Surface};
use crate::tensor::Vec3;
use std::sync::Arc;

/// Topology and sizes of the surfaces of contact pairs. Constant over a run; its copies share the surfaces.
#[derive(Clone, Debug)]
pub struct PairSurfaces {
    /// The surfaces, by index.
    pub(super) boundaries: Arc<[Boundary]>,
    /// The pairs, by number.
    pub(super) pairs: Pairs,
}

impl PairSurfaces {
    /// The `surfaces` of `pairs`, at the positions `x` [m] of all nodes *at the start of the run* (also for a restart).
    pub fn new(surfaces: &[Surface], pairs: &Pairs, x: &[Vec3]) -> Self {
        let boundaries = surfaces.iter().map(|surface| Boundary::new(surface, x)).collect();
        Self { boundaries, pairs: pairs.clone() }
    }

    /// The same surfaces in other pairs.
    pub(super) fn in_pairs(&self, pairs: Pairs) -> Self {
        Self { boundaries: self.boundaries.clone(), pairs }
    }

    /// The slave's surface of a pair.
    pub(in crate::contact) fn slave(&self, pair: usize) -> &Boundary {
        &self.boundaries[self.pairs.get(pair).slave]
    }

    /// The master's surface of a pair; `None` for a plane or a rigid body.
    pub(in crate::contact) fn master(&self, pair: usize) -> Option<&Boundary> {
        match self.pairs.get(pair).master {
            Master::Surface(master) => Some(&self.boundaries[master]),
            Master::Plane { .. } | Master::Rigid(_) => None,
        }
    }

    /// Point and normal of a pair's plane with the size [m] that tolerances refer to; `None` for another master.
    pub(in crate::contact) fn plane(&self, pair: usize) -> Option<(Vec3, Vec3, f64)> {
        match self.pairs.get(pair).master {
            Master::Plane { point, normal } => Some((point, normal, self.slave(pair).mean_size)),
            Master::Surface(_) | Master::Rigid(_) => None,
        }
    }
}
