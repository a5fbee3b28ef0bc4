//! The properties of a contact that projection, the contact law and the recognition of contacts detected again read: they know no
//! detector.

/// Fraction of the usual correction for places between nodes, which may begin to touch at any depth.
pub const SLOW: f64 = 0.1;

/// The properties of a kind of contact. Each detector defines those of its own, mostly as a variation of [`Kind::NODE`]. Kinds with equal
/// properties are one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    /// How projection measures its gap at new positions; not read where a side is rigid, since these contacts are detected again.
    pub gap: Gap,
    /// Penetration that projection leaves, as a fraction of the size of the face, or of the rigid body where that is smaller [-].
    pub kept: f64,
    /// Fraction of the largest correction of a contact that projection may make [-].
    pub pace: f64,
    /// Whether the friction of its pair acts on it.
    pub has_friction: bool,
    /// When it is the same as another one.
    pub identity: Identity,
}

/// How a gap is measured at new positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gap {
    /// From the slave node to the closest point of the master's face or plane.
    ToMaster,
    /// From the master node to the closest point of the slave's face, `face`.
    ToSlave,
    /// Between the same points of both sides, along the same normal.
    ConstantWeights,
    /// Not at all: projection leaves the contact as it is.
    NotMeasured,
}

/// What two contacts of the same pair and slave have in common if they are the same contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Identity {
    /// Pair and slave node suffice: the node has no other contact of this identity or the next.
    Node,
    /// The normal, nearly: one of several faces at the node.
    Normal,
    /// Kind and nodes.
    Nodes,
    /// Kind, nodes and weights: several places of a face.
    Weights,
    /// Kind and point of action: several points of a rigid body.
    Point,
}

impl Kind {
    /// A slave node against a face, a plane or a rigid body, at the closest point: at most one per node and pair.
    pub const NODE: Self =
        Self { gap: Gap::ToMaster, kept: 0.0, pace: 1.0, has_friction: true, identity: Identity::Node };
}
