//! Frictional contact by the bi-potential method.
//!
//! The data are a list of [`Surface`]s and their [`pairs`] (constant). [`detection`] finds the [`Contact`]s of a step: nodes with
//! signed weights ([`stencil`]), a frame, a gap and a [`kind`], whatever the geometry. [`solution`] knows these alone and changes the nodal
//! velocities so that the law holds at the end of the step; [`projection`] removes the penetration that linearisation left.

pub mod detection;
pub mod kind;
pub mod pairs;
pub mod projection;
pub mod solution;
pub mod stencil;

use super::rigid::{Pose, RigidBody};
use super::tensor::Vec3;
use kind::Kind;
use stencil::Stencil;

/// Allowed penetration of a master node into the slave, as a fraction of the size of the slave's face.
pub const ALLOWED: f64 = 0.01;

/// The boundary surface of one body. That of a rigid body is its centre, without faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Global numbers of the nodes on the surface, sorted.
    pub nodes: Vec<u32>,
    /// Corner nodes (global) of each face, counter-clockwise seen from outside; a triangle repeats its last node.
    pub faces: Vec<[u32; 4]>,
    /// Nodes (global, sorted) on a plane of symmetry normal to x, y and z: there the surface ends, and its mirror image continues it
    /// on the lower side.
    pub mirrored: [Vec<u32>; 3],
}

impl Surface {
    /// A surface that no mirror image continues.
    pub fn new(nodes: Vec<u32>, faces: Vec<[u32; 4]>) -> Self {
        Self { nodes, faces, ..Self::default() }
    }
}

/// The obstacle of the slave nodes of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Master {
    /// The faces of a surface, by index; for self-contact the slave's own.
    Surface(usize),
    /// A fixed half space: `normal · (x − point) ≥ 0` outside.
    Plane {
        /// A point on the plane [m].
        point: Vec3,
        /// Unit normal, out of the plane.
        normal: Vec3,
    },
    /// A rigid body, by index.
    Rigid(usize),
}

/// Two sides that may touch: the slave's nodes against the master's faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPair {
    /// Surface whose nodes are the slaves.
    pub slave: usize,
    /// The obstacle that they must not enter.
    pub master: Master,
    /// The law of its contacts.
    pub law: ContactLaw,
}

/// The contact law of a pair, which determines the number of unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// Signorini's law alone: one unknown per contact.
    Frictionless,
    /// With Coulomb friction μ [-], 0 to ∞ (full stick): three unknowns per contact.
    Coulomb(f64),
}

impl ContactLaw {
    /// The law with the fewest unknowns for a coefficient of friction [-].
    pub fn of(mu: f64) -> Self {
        if mu == 0.0 { Self::Frictionless } else { Self::Coulomb(mu) }
    }
    /// Coulomb friction μ [-].
    pub fn mu(self) -> f64 {
        match self {
            Self::Frictionless => 0.0,
            Self::Coulomb(mu) => mu,
        }
    }
    /// Number of unknowns per contact.
    pub fn unknowns(self) -> u32 {
        match self {
            Self::Frictionless => 1,
            Self::Coulomb(_) => 3,
        }
    }
}

/// Largest component of a normal along an axis that counts as a tangent, which changes the limit of friction by its square, and the largest
/// distance from the nodes that do not move along it, as a fraction of a face.
const MOST_TILT: f64 = 0.05;

/// Discretisation of the contact of two meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Discretisation {
    /// Each slave node against the closest face, in addition to [`guard`].
    #[default]
    TwoPass,
    /// Each slave node against the closest face.
    NodeToSurface,
    /// Means over the slave's faces with dual shape functions, in addition to [`guard`]; not for self-contact.
    Mortar,
}

/// One candidate contact of a step: a point of the slave side against one of the master side, each a mean of nodes. A
/// side that is a rigid body is represented by the node of its centre of mass with weight 1, and also rotates, about
/// `point`.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Index of the pair.
    pub pair: u32,
    /// How its gap is measured again, what penetration it keeps, whether it has friction, when another contact is the same.
    pub kind: Kind,
    /// Slave node (global); where the slave side has several, a representative one.
    pub slave: u32,
    /// Index of the master's face, or of a representative one; `u32::MAX` for a plane or a rigid body.
    pub face: u32,
    /// The nodes of both sides with signed weights.
    pub stencil: Stencil,
    /// Local frame: n (from the master towards the slave), t1, t2, right-handed orthonormal.
    pub frame: [Vec3; 3],
    /// Signed gap at the start of the step, along n [m], positive open.
    pub gap: f64,
    /// Point of action of the reaction, at the start of the step [m]: the slave node, or a point of a rigid body.
    pub point: Vec3,
    /// V_slave − V_master: the relative rigid-body velocity of the two bodies [m/s], to which nodal velocities
    /// are relative. Zero from detection, which does not know it: [`Contact::complete`].
    pub drift: Vec3,
    /// Its law, likewise; frictionless from detection.
    pub law: ContactLaw,
}

impl Contact {
    /// The contacts of a step are in ascending order of it.
    pub fn key(&self) -> (u32, u32, u32) {
        (self.pair, self.slave, self.face)
    }

    /// Gives it the law of its pair, and the relative flight velocity of its two sides [m/s].
    pub fn complete(&mut self, law: ContactLaw, drift: Vec3) {
        self.law = if self.kind.has_friction { law } else { ContactLaw::Frictionless };
        self.drift = drift;
    }
}

impl Contact {
    /// Makes an axis along which the slave does not move, as in a plane of symmetry, a tangent without compliance: the frame is turned, and the
    /// master is met at those of its nodes that do not move either. A face beside such a plane is slightly tilted, so that the closest point is
    /// slightly beside the plane, and along a tangent of almost no compliance rounding becomes large reactions. `inverse_mass` per node and axis
    /// [1/kg]; not for sides that are rigid, which also rotate.
    pub fn align_with_supports(&mut self, inverse_mass: &[Vec3]) {
        let is_held = |axis: usize, node: u32| inverse_mass[node as usize][axis] == 0.0;
        let stencil = &self.stencil;
        let of_held = |axis: usize| stencil.side(true).filter(move |(node, _)| is_held(axis, *node));
        let share = |axis: usize| of_held(axis).map(|(_, weight)| weight).sum::<f64>();
        let is_tangent = |axis: &usize| {
            self.frame[0][*axis].abs() <= MOST_TILT
                && stencil.side(false).all(|(node, _)| is_held(*axis, node))
                && share(*axis) >= 1.0 - MOST_TILT
        };
        let Some(axis) = (0..3).find(is_tangent) else { return };
        let share = share(axis);
        let master = of_held(axis).map(|(node, weight)| (node, weight / share));
        let Some(aligned) = Stencil::new(stencil.side(false), master) else { return };
        let mut normal = self.frame[0];
        normal[axis] = 0.0;
        let (normal, held) = (normal.normalize(), Vec3::ith(axis, 1.0));
        (self.stencil, self.frame) = (aligned, [normal, held.cross(&normal), held]);
    }
}

/// The rigid bodies that the contacts of a step rotate.
#[derive(Clone, Copy, Debug)]
pub struct RigidSides<'a> {
    /// Rigid bodies of slave and master, by index, of each pair with a rigid side; empty if there are none.
    pub of_pairs: &'a [[Option<u32>; 2]],
    /// Number of the first of these pairs.
    pub first: usize,
    /// All rigid bodies, by index.
    pub bodies: &'a [RigidBody],
    /// Their poses at the start of the step.
    pub poses: &'a [Pose],
}

impl RigidSides<'_> {
    /// For contacts without any rigid side.
    pub const NONE: RigidSides<'static> = RigidSides { of_pairs: &[], first: 0, bodies: &[], poses: &[] };

    /// The rigid bodies of slave and master of a pair.
    pub fn of_pair(&self, pair: u32) -> [Option<u32>; 2] {
        let place = (pair as usize).checked_sub(self.first);
        place.and_then(|place| self.of_pairs.get(place).copied()).unwrap_or([None; 2])
    }
}

/// Solution of the contact law for one contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Impulse of the step on the slave in the local frame (n, t1, t2) [N s]; the master gets the opposite.
    pub impulse: [f64; 3],
}
