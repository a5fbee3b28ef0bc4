//! A rigid body that is held or moved: what its nodes do.

use crate::scene::document::{Axis, FixedDocument, PrescribedDocument, RampDocument};

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Motion along or about an axis.
#[derive(Clone, Debug)]
pub(super) enum Motion {
    Fixed,
    /// Displacement [m] with its load curve.
    Prescribed(f64, RampDocument),
}

/// What a file says of the motion of a rigid body.
#[derive(Clone, Debug, Default)]
pub(super) struct RigidBody {
    /// Along x, y, z and about them; free where it is `None`.
    pub(super) motions: [Option<Motion>; 6],
    /// Node sets of the mesh with its own nodes, and those that move with it.
    pub(super) sets: Vec<String>,
}

impl RigidBody {
    /// Fixed components of the node set.
    pub(super) fn fixed(&self, set: &str) -> Option<FixedDocument> {
        let is_fixed = |axis: &Axis| matches!(self.motions[*axis as usize], Some(Motion::Fixed));
        let axes: Vec<Axis> = AXES.into_iter().filter(is_fixed).collect();
        (!axes.is_empty()).then(|| FixedDocument { set: set.to_owned(), axes })
    }

    /// Prescribed components of the node set. Displacements with one load curve form one vector.
    pub(super) fn prescribed(&self, set: &str) -> Vec<PrescribedDocument> {
        let mut found: Vec<PrescribedDocument> = Vec::new();
        for axis in AXES {
            let Some(Motion::Prescribed(value, ramp)) = &self.motions[axis as usize] else { continue };
            let known = found.iter().position(|other| other.ramp.as_ref() == Some(ramp));
            let index = known.unwrap_or_else(|| {
                let (set, ramp) = (set.to_owned(), Some(ramp.clone()));
                found.push(PrescribedDocument { set, displacement_m: [0.0; 3], axes: Vec::new(), ramp });
                found.len() - 1
            });
            found[index].displacement_m[axis as usize] = *value;
            found[index].axes.push(axis);
        }
        found
    }
}
