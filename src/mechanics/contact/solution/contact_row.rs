//! A contact in Gauss–Seidel: its nodes, its diagonal block of the Delassus operator, its relative velocity.
//!
//! A [`NormalRow`] is a frictionless contact: one unknown, one direction. A [`Row`] is a frictional one: the same and
//! two tangents. Either may have [`MomentArms`], the moment arms of the rigid bodies that it rotates, besides its nodes;
//! rows of meshes and planes have `()` instead, at no cost.

use super::local::{Local, LocalOperator};
use super::slip::ContactOperator;
use super::slip::IMMOVABLE;
use crate::contact::stencil::Stencil;
use crate::contact::{Contact, RigidSides};
use crate::tensor::{Mat3, Vec3};

/// Relative difference of diagonal entries below which they are equal: the operator is a multiple of the identity.
const ISOTROPY: f64 = 1e-14;

/// Rotations that a contact causes in addition to translations.
pub(super) trait Turning {
    /// Adds the velocities due to rotation, slave less master, to those of the nodes.
    fn add_velocity(&self, sum: Vec3, v: &[Vec3]) -> Vec3;
    /// Adds `I⁻¹ Jᵀ p` for an impulse `p` in space.
    fn push(&self, impulse: &Vec3, inverse_mass: &[Vec3], v: &mut [Vec3]);
    /// Magnitude of the velocities due to rotation.
    fn roundable(&self, v: &[Vec3]) -> f64;
}

impl Turning for () {
    #[inline]
    fn add_velocity(&self, sum: Vec3, _: &[Vec3]) -> Vec3 {
        sum
    }
    #[inline]
    fn push(&self, _: &Vec3, _: &[Vec3], _: &mut [Vec3]) {}
    #[inline]
    fn roundable(&self, _: &[Vec3]) -> f64 {
        0.0
    }
}

/// Moment arms of the rigid sides of a contact: the node of the spin, and `±J` of
/// [`crate::rigid::Pose::moment_arm`].
#[derive(Clone, Debug)]
pub(super) struct MomentArms([Option<(u32, Mat3)>; 2]);

impl MomentArms {
    /// `sides`: the rigid bodies of the slave and the master.
    pub fn new(contact: &Contact, sides: [Option<u32>; 2], rigid: &RigidSides) -> Self {
        let moment_arm = |side: usize, sign: f64| {
            let body = sides[side]? as usize;
            Some((rigid.bodies[body].spin, rigid.poses[body].moment_arm(&contact.point) * sign))
        };
        Self([moment_arm(0, 1.0), moment_arm(1, -1.0)])
    }

    /// Spin node and moment arm of each rigid side.
    pub fn into_each(self) -> impl Iterator<Item = (u32, Mat3)> {
        self.0.into_iter().flatten()
    }

    fn each(&self) -> impl Iterator<Item = &(u32, Mat3)> {
        self.0.iter().flatten()
    }

    /// Contribution to the Delassus operator in space, `Σ J I⁻¹ Jᵀ`.
    fn operator(&self, inverse_mass: &[Vec3]) -> Mat3 {
        let of_moment_arm =
            |(spin, J): &(u32, Mat3)| J * Mat3::from_diagonal(&inverse_mass[*spin as usize]) * J.transpose();
        self.each().map(of_moment_arm).sum()
    }
}

impl Turning for MomentArms {
    #[inline]
    fn add_velocity(&self, sum: Vec3, v: &[Vec3]) -> Vec3 {
        self.each().fold(sum, |sum, (spin, J)| sum + J * v[*spin as usize])
    }
    #[inline]
    fn push(&self, impulse: &Vec3, inverse_mass: &[Vec3], v: &mut [Vec3]) {
        for (spin, J) in self.each() {
            let spin = *spin as usize;
            v[spin] += inverse_mass[spin].component_mul(&J.tr_mul(impulse));
        }
    }
    fn roundable(&self, v: &[Vec3]) -> f64 {
        self.each().map(|(spin, J)| J.amax() * v[*spin as usize].amax()).sum()
    }
}

/// The normal direction of one contact, prepared for sweeps.
#[derive(Clone, Debug)]
pub(super) struct NormalRow<T = ()> {
    /// Its nodes and their signed weights.
    stencil: Stencil,
    normal: Vec3,
    /// Normal component of the relative rigid-body velocity, plus max(gap, 0)/h [m/s].
    bias: f64,
    /// Magnitude of the velocities that make up the bias.
    bias_size: f64,
    /// `W_nn`; 0 for a contact between immovable sides, which is skipped.
    pub w_nn: f64,
    /// Mean diagonal entry, `tr W / 3`.
    pub d: f64,
    /// Whether `W = d I`.
    pub isotropic: bool,
    turning: T,
}

/// One frictional contact, prepared for sweeps.
#[derive(Clone, Debug)]
pub(super) struct Row<T = ()> {
    pub normal: NormalRow<T>,
    tangents: [Vec3; 2],
    /// Relative rigid-body velocity along t1 and t2 [m/s].
    bias: [f64; 2],
    /// Diagonal block `C M⁻¹ Cᵀ` of this contact, in the local frame.
    pub W: LocalOperator,
    /// The same, factored for the local solution.
    pub operator: ContactOperator,
}

/// Squared Euclidean norm |a|².
pub(super) fn squared(a: Local) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

impl NormalRow {
    /// Gathers a contact for a step of length `h` [s], with `inverse_mass` [1/kg] per node and axis.
    pub fn new(contact: &Contact, inverse_mass: &[Vec3], h: f64) -> Self {
        Self::with_diagonal(contact, inverse_mass, h).0
    }

    /// The row, and the diagonal of C M⁻¹ Cᵀ in space.
    fn with_diagonal(contact: &Contact, inverse_mass: &[Vec3], h: f64) -> (Self, Vec3) {
        let (mut row, diagonal) = Self::of_nodes(contact, inverse_mass, h, ());
        let (least, most) = (diagonal.min(), diagonal.max());
        let trace = diagonal.sum();
        row.isotropic = most - least <= ISOTROPY * most;
        row.d = if row.isotropic { diagonal.x } else { trace / 3.0 };
        let n_n = if row.isotropic { row.d } else { row.normal.component_mul(&diagonal).dot(&row.normal) };
        row.w_nn = if n_n > IMMOVABLE * trace { n_n } else { 0.0 };
        (row, diagonal)
    }
}

impl NormalRow<MomentArms> {
    /// As [`NormalRow::new`], for a contact that rotates rigid bodies.
    pub fn turning(contact: &Contact, inverse_mass: &[Vec3], h: f64, moment_arms: MomentArms) -> Self {
        Self::with_operator(contact, inverse_mass, h, moment_arms).0
    }

    /// The row, and C M⁻¹ Cᵀ in space.
    fn with_operator(
        contact: &Contact,
        inverse_mass: &[Vec3],
        h: f64,
        moment_arms: MomentArms,
    ) -> (Self, Mat3) {
        let operator = moment_arms.operator(inverse_mass);
        let (mut row, diagonal) = Self::of_nodes(contact, inverse_mass, h, moment_arms);
        let operator = operator + Mat3::from_diagonal(&diagonal);
        let (trace, n_n) = (operator.trace(), row.normal.dot(&(operator * row.normal)));
        row.d = trace / 3.0;
        row.w_nn = if n_n > IMMOVABLE * trace { n_n } else { 0.0 };
        (row, operator)
    }
}

impl NormalRow<MomentArms> {
    /// Nodes that contribute to the velocity of the contact, each with its 3×3 coefficient in space: ±weight for a
    /// translation.
    pub fn blocks(&self) -> impl Iterator<Item = (u32, Mat3)> {
        let moved = self.stencil.each();
        let turned = self.turning.each().map(|(spin, J)| (*spin, *J));
        moved.map(|(node, weight)| (node, Mat3::identity() * weight)).chain(turned)
    }
}

impl<T: Turning> NormalRow<T> {
    /// Nodes, normal and bias, without the operator; also returns the operator's diagonal due to the nodes.
    fn of_nodes(contact: &Contact, inverse_mass: &[Vec3], h: f64, turning: T) -> (Self, Vec3) {
        // C M⁻¹ Cᵀ in space is diagonal; a node that appears once contributes its squared weight.
        let mut diagonal = Vec3::zeros();
        for (node, w) in contact.stencil.each() {
            diagonal += inverse_mass[node as usize] * (w * w);
        }
        let normal = contact.frame[0];
        let opening = contact.gap.max(0.0) / h;
        let bias = normal.dot(&contact.drift) + opening;
        let bias_size = contact.drift.amax() + opening;
        let (w_nn, d, isotropic) = (0.0, 0.0, false);
        let stencil = contact.stencil.clone();
        let row = Self { stencil, normal, bias, bias_size, w_nn, d, isotropic, turning };
        (row, diagonal)
    }

    /// Velocity of the slave side relative to the master, in space.
    #[inline]
    fn difference(&self, v: &[Vec3]) -> Vec3 {
        self.turning.add_velocity(self.stencil.difference(v), v)
    }

    /// Normal relative velocity `u_n`.
    #[inline]
    pub fn velocity(&self, v: &[Vec3]) -> f64 {
        self.normal.dot(&self.difference(v)) + self.bias
    }

    /// Adds `M⁻¹ Cᵀ p` to `v`, for an impulse p along n.
    #[inline]
    pub fn push(&self, impulse: f64, inverse_mass: &[Vec3], v: &mut [Vec3]) {
        self.push_in_space(self.normal * impulse, inverse_mass, v);
    }

    /// Adds `M⁻¹ Cᵀ p` to `v`, for an impulse p in space.
    #[inline]
    fn push_in_space(&self, impulse: Vec3, inverse_mass: &[Vec3], v: &mut [Vec3]) {
        for (&node, &w) in self.stencil.nodes().iter().zip(self.stencil.weights()) {
            let node = node as usize;
            v[node] += inverse_mass[node].component_mul(&impulse) * w;
        }
        self.turning.push(&impulse, inverse_mass, v);
    }

    /// Magnitude of the velocities that add up to `u`.
    pub fn roundable(&self, v: &[Vec3]) -> f64 {
        let nodes = self.stencil.each().map(|(node, w)| v[node as usize].amax() * w.abs());
        nodes.sum::<f64>() + self.bias_size + self.turning.roundable(v)
    }
}

impl Row {
    /// As [`NormalRow::new`], with the tangents.
    pub fn new(contact: &Contact, inverse_mass: &[Vec3], h: f64) -> Self {
        let (normal, diagonal) = NormalRow::with_diagonal(contact, inverse_mass, h);
        Self::with(contact, normal, |a| a.component_mul(&diagonal))
    }
}

impl Row<MomentArms> {
    /// As [`NormalRow::turning`], with the tangents.
    pub fn turning(contact: &Contact, inverse_mass: &[Vec3], h: f64, moment_arms: MomentArms) -> Self {
        let (normal, operator) = NormalRow::with_operator(contact, inverse_mass, h, moment_arms);
        Self::with(contact, normal, |a| operator * a)
    }
}

impl<T: Turning> Row<T> {
    /// Completes a normal row with tangents; `times_operator` multiplies by C M⁻¹ Cᵀ in space.
    fn with(contact: &Contact, normal: NormalRow<T>, times_operator: impl Fn(&Vec3) -> Vec3) -> Self {
        let [_, t1, t2] = contact.frame;
        let mut W = [[0.0; 3]; 3];
        for (row, a) in W.iter_mut().zip(&contact.frame) {
            let image = times_operator(a);
            for (x, b) in row.iter_mut().zip(&contact.frame) {
                *x = image.dot(b);
            }
        }
        let bias = [t1.dot(&contact.drift), t2.dot(&contact.drift)];
        Self { normal, tangents: [t1, t2], bias, W, operator: ContactOperator::new(&W) }
    }

    /// Relative velocity `u` in the local frame.
    #[inline]
    pub fn velocity(&self, v: &[Vec3]) -> Local {
        let w = self.normal.difference(v);
        let [t1, t2] = &self.tangents;
        [self.normal.normal.dot(&w) + self.normal.bias, t1.dot(&w) + self.bias[0], t2.dot(&w) + self.bias[1]]
    }

    /// Adds `M⁻¹ Cᵀ p` to `v`, for an impulse p in the local frame.
    #[inline]
    pub fn push(&self, impulse: Local, inverse_mass: &[Vec3], v: &mut [Vec3]) {
        let [t1, t2] = &self.tangents;
        let in_space = self.normal.normal * impulse[0] + t1 * impulse[1] + t2 * impulse[2];
        self.normal.push_in_space(in_space, inverse_mass, v);
    }
}
