//! The scene document: the user's input, with the unit in every field name. Every struct refuses unknown fields.

use super::axis::all_axes;
use crate::mechanics::contact::Discretisation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::mesh::generate::Generator;

pub use super::accuracy_document::{AccuracyDocument, RequestedNumber};
pub use super::axis::Axis;
pub use super::integrator_document::IntegratorDocument;
pub use super::loads_document::{FaceLoadDocument, PreloadDocument, PrescribedDocument, RampDocument};
pub use super::materials::{Families, I4Invariants, MaterialDocument, MatrixDocument, VolumetricDocument};
pub use super::measures_document::{ForceFilter, MeasuresDocument, PersonDocument, Region};
pub use super::mesh_document::{MeshDocument, MeshFileDocument, PlacementDocument, RotationDocument};
pub use super::part_document::{
    ErosionDocument, FibreFrameDocument, Formulation, PartDocument, StiffnessFactorDocument, SurfaceDocument,
};
pub use super::refinement_document::{Around, RefinementDocument};
pub use super::rigid_document::{RigidDocument, ShapeDocument};
pub use super::segmentation_document::{
    ClosedSurfaceDocument, CropDocument, LabelDocument, NearDocument, SegmentationDocument,
};
pub use super::solver_document::{ContactSolver, ErrorBarsDocument, Keep, SolverDocument};

/// One scene: bodies, contact, duration, and what to record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneDocument {
    /// Name of the scene, used in reports.
    pub name: String,
    /// Free text: what the scene shows.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// The bodies, one or more.
    pub bodies: Vec<BodyDocument>,
    /// Fixed rigid half-spaces that bodies may touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<PlaneDocument>,
    /// Contact pairs, friction and discretisation.
    #[serde(default)]
    pub contact: ContactDocument,
    /// Acceleration of gravity [m/s²].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_m_per_s2: Option<[f64; 3]>,
    /// Load curve of gravity; constant by default, from 0 to 1 over a quasi-static run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_ramp: Option<RampDocument>,
    /// Apply the loads quasi-statically before the clock starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preload: Option<PreloadDocument>,
    /// Dynamic relaxation under gravity, with damping, before the clock starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamic_relaxation: Option<DynamicRelaxationDocument>,
    /// Time integration: explicit, implicit, quasi-static, or chosen from the estimated cost.
    #[serde(default)]
    pub integrator: IntegratorDocument,
    /// Settings of the solution that leave the physical problem unchanged.
    #[serde(default, skip_serializing_if = "SolverDocument::is_default")]
    pub solver: SolverDocument,
    /// Required accuracy and the time it may take; without it the meshes are used as given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyDocument>,
    /// What to record, and how often.
    #[serde(default)]
    pub record: RecordDocument,
    /// Inputs of the measures.
    #[serde(default)]
    pub measures: MeasuresDocument,
}

/// Role of a body; the measures refer to the tissue and the projectile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The impacting body, whose loss of energy is reported.
    Projectile,
    /// The impacted body: absorbed energy and depth are measured in it.
    Tissue,
    /// Neither projectile nor tissue.
    #[default]
    Other,
}

/// One body: deformable, with `mesh` and `parts`, or `rigid`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyDocument {
    /// Name, unique in the scene.
    pub name: String,
    /// Projectile, tissue or other.
    #[serde(default)]
    pub role: Role,
    /// A body that does not deform; replaces `mesh` and the fields that refer to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rigid: Option<RigidDocument>,
    /// Source of the mesh: a generator or a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshDocument>,
    /// Placement of the mesh: scale, then rotation, then translation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placement: Option<PlacementDocument>,
    /// Where the placed mesh is refined.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinement: Vec<RefinementDocument>,
    /// Node sets defined by boxes, in addition to those of the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<SetDocument>,
    /// One entry for each part of the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartDocument>,
    /// Initial translational velocity [m/s].
    #[serde(default)]
    pub velocity_m_per_s: [f64; 3],
    /// Initial spin about the centre of mass [rad/s].
    #[serde(default)]
    pub spin_rad_per_s: [f64; 3],
    /// Initial deformation of the body, at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_deformation: Option<InitialDeformation>,
    /// Node sets held fixed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixed: Vec<FixedDocument>,
    /// Node sets with prescribed displacement.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prescribed: Vec<PrescribedDocument>,
    /// Pressures and tractions on boundary faces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub face_loads: Vec<FaceLoadDocument>,
}

/// A node set defined by a box: all nodes of the placed mesh inside it or on its faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetDocument {
    /// Name, different from those of the mesh.
    pub name: String,
    /// Lowest corner of the box [m].
    pub min_m: [f64; 3],
    /// Highest corner of the box [m].
    pub max_m: [f64; 3],
}

/// A node set with zero displacement along some axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedDocument {
    /// Name of a node set of the mesh; `*` for all nodes.
    pub set: String,
    /// The fixed axes; all three by default.
    #[serde(default = "all_axes")]
    pub axes: Vec<Axis>,
}

/// An initial deformation of a body, released when the clock starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum InitialDeformation {
    /// Volume-preserving radial motion of a hollow ball: r³ = R³ + A³ (λ³ − 1).
    SphericalInflation {
        /// Centre of the ball [m].
        center_m: [f64; 3],
        /// Inner radius A at rest [m].
        inner_radius_m: f64,
        /// Stretch λ at the inner radius.
        inner_stretch: f64,
    },
    /// x = c + F (X − c).
    Affine {
        /// Fixed point c [m].
        center_m: [f64; 3],
        /// Deformation gradient F, rows spatial.
        deformation_gradient: [[f64; 3]; 3],
    },
}

/// A fixed rigid half space; the admissible side is `normal · (x − point) ≥ 0`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneDocument {
    /// Name, unique among bodies and planes.
    pub name: String,
    /// Any point on the plane [m].
    pub point_m: [f64; 3],
    /// Outward normal of the solid half space; any length.
    pub normal: [f64; 3],
}

/// Contact pairs, friction and discretisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactDocument {
    /// `"all"` (every body with every other body and plane), or a list of pairs. Deformable bodies in either are also
    /// checked for self-contact, see `self_contact`.
    #[serde(default)]
    pub pairs: ContactPairs,
    /// Whether bodies are checked for self-contact.
    #[serde(default, skip_serializing_if = "SelfContact::is_default")]
    pub self_contact: SelfContact,
    /// Coulomb friction μ of pairs that do not give their own [-].
    #[serde(default)]
    pub friction: f64,
    /// Largest scaled residual of the contact solver [-].
    #[serde(default = "default_contact_tolerance")]
    pub tolerance: f64,
    /// Fraction of the mass of boundary nodes that is moved inwards, 0 … 0.95 [-]: reduces the energy that a lumped node
    /// loses on impact activation, and the time step.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub mass_redistribution: f64,
    /// Discretisation of contact between two meshes. `mortar` transmits a uniform pressure across non-matching meshes.
    #[serde(default, skip_serializing_if = "is_default", with = "ContactDiscretisation")]
    pub discretisation: Discretisation,
}

/// Self-contact of deformable bodies, for example where they fold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SelfContact {
    /// All deformable bodies that take part in any contact.
    #[default]
    Auto,
    /// None, not even listed ones.
    None,
}

impl SelfContact {
    #[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Discretisation of contact between two meshes.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Discretisation", rename_all = "snake_case")]
enum ContactDiscretisation {
    /// Each slave node against the closest master face; master nodes that penetrate a slave face by more than 1 % of a
    /// face; sharp edges against edges, also those formed by deformation.
    TwoPass,
    /// Each slave node against the closest master face, and nothing else.
    NodeToSurface,
    /// Means over the slave faces with dual shape functions, otherwise as `two_pass`. Faces that are only partly above the
    /// master, and self-contact, use nodes against faces.
    Mortar,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_default(discretisation: &Discretisation) -> bool {
    *discretisation == Discretisation::default()
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_nothing(fraction: &f64) -> bool {
    *fraction == 0.0
}

fn default_contact_tolerance() -> f64 {
    1e-10
}

impl Default for ContactDocument {
    fn default() -> Self {
        Self {
            pairs: ContactPairs::default(),
            self_contact: SelfContact::default(),
            friction: 0.0,
            tolerance: default_contact_tolerance(),
            mass_redistribution: 0.0,
            discretisation: Discretisation::default(),
        }
    }
}

/// All pairs, or a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ContactPairs {
    /// The keyword `"all"`: every two bodies, every body and plane, each deformable body with itself.
    All(AllPairs),
    /// The listed pairs only.
    List(Vec<PairDocument>),
}

impl Default for ContactPairs {
    fn default() -> Self {
        Self::All(AllPairs::All)
    }
}

/// The keyword `"all"` in place of a list of pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AllPairs {
    /// Every body with every other body and plane, and with itself if it deforms.
    All,
}

/// A contact pair with its own friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairDocument {
    /// Names of two bodies or planes; the same body twice for self-contact.
    pub between: [String; 2],
    /// Coulomb friction μ [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// Dynamic relaxation before the clock starts: gravity, damping and full stick; in the last third the friction of the
/// scene, so that what friction cannot hold slips before the clock starts. A body with a velocity stays where the scene
/// places it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DynamicRelaxationDocument {
    /// Duration of the relaxation [s].
    pub duration_s: f64,
    /// Mass-proportional damping α; force −α M v [1/s].
    pub damping_per_s: f64,
}

/// What to record and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordDocument {
    /// Fields recorded at the field times; may be empty.
    #[serde(default = "default_fields")]
    pub fields: Vec<FieldName>,
    /// Times of the fields [s], hit exactly. The start and the end are always recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_times_s: Option<Vec<f64>>,
    /// Interval between field times [s]; by default 1/50 of the run. Excludes `field_times_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_interval_s: Option<f64>,
    /// Contact forces and energies are recorded every so many steps.
    #[serde(default = "default_step_cadence")]
    pub every_steps: u32,
}

fn default_fields() -> Vec<FieldName> {
    vec![FieldName::VonMises, FieldName::Pressure, FieldName::PrincipalStrain]
}
fn default_step_cadence() -> u32 {
    1
}

impl Default for RecordDocument {
    fn default() -> Self {
        Self {
            fields: default_fields(),
            field_times_s: None,
            field_interval_s: None,
            every_steps: default_step_cadence(),
        }
    }
}

impl SceneDocument {
    /// Indices of the bodies with self-contact that no pair asks for: those that deform and may touch anything else.
    pub fn bodies_that_meet_themselves(&self) -> impl Iterator<Item = usize> {
        let may_fold = |body: &BodyDocument| match &self.contact.pairs {
            ContactPairs::All(_) => true,
            ContactPairs::List(list) => {
                let of_body = |pair: &&PairDocument| pair.between.contains(&body.name);
                let has_own = list.iter().filter(of_body).any(|pair| pair.between[0] == pair.between[1]);
                !has_own && list.iter().any(|pair| of_body(&pair))
            }
        };
        let asks = self.contact.self_contact == SelfContact::Auto;
        let meets_itself =
            move |(_, body): &(usize, &BodyDocument)| asks && body.rigid.is_none() && may_fold(body);
        self.bodies.iter().enumerate().filter(meets_itself).map(|(index, _)| index)
    }

    /// Whether any body has a mesh; rigid bodies have none.
    pub fn has_mesh(&self) -> bool {
        self.bodies.iter().any(|body| body.mesh.is_some())
    }

    /// Whether a mesh comes from a file.
    pub fn has_mesh_file(&self) -> bool {
        self.bodies.iter().any(|body| matches!(body.mesh, Some(MeshDocument::File(_))))
    }

    /// Whether a part has properties that only explicit steps support: softening, erosion.
    pub fn needs_explicit_steps(&self) -> bool {
        let parts = self.bodies.iter().flat_map(|body| &body.parts);
        parts.into_iter().any(PartDocument::needs_explicit_steps)
    }

    /// Whether the document keeps a feature that plans omit.
    pub fn keeps(&self, thing: Keep) -> bool {
        self.solver.keep.contains(&thing)
    }

    /// The recorded fields, each once: those requested, or all if unrequested fields are kept.
    pub fn recorded_fields(&self) -> Vec<FieldName> {
        let recorded =
            |field: &FieldName| self.record.fields.contains(field) || self.keeps(Keep::UnrequestedFields);
        FieldName::ALL.into_iter().filter(recorded).collect()
    }
}

/// A field that is recorded at the field times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldName {
    /// Von Mises stress at the nodes [Pa].
    VonMises,
    /// Pressure at the nodes, positive in compression [Pa].
    Pressure,
    /// Largest principal Green–Lagrange strain at the nodes [-].
    PrincipalStrain,
    /// Displacement at the nodes [m]; recorded with every other field, too, since positions follow from it.
    Displacement,
    /// Velocity at the nodes [m/s].
    Velocity,
    /// Mean Cauchy stress of each element, 6 components [Pa].
    ElementCauchyStress,
}

impl FieldName {
    /// All fields, in the order of declaration.
    pub const ALL: [Self; 6] = [
        Self::VonMises,
        Self::Pressure,
        Self::PrincipalStrain,
        Self::Displacement,
        Self::Velocity,
        Self::ElementCauchyStress,
    ];
}
