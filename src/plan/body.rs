//! A body of a plan.

use crate::mechanics::contact::Surface;
use crate::mechanics::force::{ElementBlock, Erosion};
use crate::mechanics::material::Validity;
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Cell, Cells, surface};
use crate::scene::document::Role;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

/// A body of a plan, deformable or rigid.
#[derive(Debug)]
pub struct PlanBody {
    /// Name, unique in the scene.
    pub name: String,
    /// Projectile, tissue or other.
    pub role: Role,
    /// Range of its global node numbers.
    pub nodes: Range<u32>,
    /// Range of its global element numbers.
    pub elements: Range<u32>,
    /// Velocity V_b of its frame [m/s]: x = X + V_b t + u.
    pub flight_velocity: Vec3,
    /// Kind and global nodes of its elements, in order.
    pub cells: Cells,
    /// Part of each of its elements, as an index into `parts`.
    pub part_of: Vec<u32>,
    /// Names of its parts, as in the mesh.
    pub parts: Vec<String>,
    /// Range of validity of the law of each part.
    pub validity: Vec<Validity>,
    /// Name of the set of the library that each part has, if it is one.
    pub sets: Vec<Option<String>>,
    /// Whether its elements may be eroded.
    pub erodes: bool,
    /// Its boundary surface at the start: outward faces with global nodes. A rigid body has its centre and no faces.
    pub boundary: Surface,
    /// Its index among the rigid bodies, if it is one.
    pub rigid: Option<usize>,
    /// Total mass of the body [kg].
    pub mass: f64,
    /// Σ m X of its nodes [kg m].
    pub first_moment: Vec3,
    /// Fraction of its polar moment of inertia lost by moving mass inwards (`contact.mass_redistribution`) [-].
    pub inertia_lost: f64,
}

impl PlanBody {
    /// Names of its parts in a block of its elements.
    pub(super) fn parts_of(&self, block: &ElementBlock) -> Vec<String> {
        let parts: BTreeSet<u32> =
            block.elements.iter().map(|e| self.part_of[(e - self.elements.start) as usize]).collect();
        parts.into_iter().map(|part| self.parts[part as usize].clone()).collect()
    }

    /// Its elements that are not eroded, in ascending order.
    pub fn intact<'a>(&'a self, erosion: &'a Erosion) -> impl Iterator<Item = Cell<'a>> {
        let numbered = self.elements.clone().zip(self.cells.iter());
        numbered.filter(|(element, _)| !erosion.contains(*element)).map(|(_, cell)| cell)
    }

    /// Its boundary surface without eroded elements: with the faces that erosion has exposed.
    pub fn boundary_after(&self, erosion: &Erosion) -> Cow<'_, Surface> {
        if !erosion.elements().iter().any(|element| self.elements.contains(element)) {
            return Cow::Borrowed(&self.boundary);
        }
        let faces = surface::boundary(&self.intact(erosion).collect());
        Cow::Owned(Surface::new(surface::boundary_nodes(&faces), faces))
    }
}
