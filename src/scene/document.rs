//! The scene document: what a user writes, with the unit in every name. Every struct refuses unknown fields.

use super::prony_document::PronyDocument;
use crate::mechanics::contact::Discretisation;
use crate::mechanics::force;
use crate::mechanics::material::{Material, PronySeries};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::accuracy_document::{AccuracyDocument, AskedNumber};
pub use super::integrator_document::IntegratorDocument;
pub use super::loads_document::{FaceLoadDocument, PreloadDocument, PrescribedDocument, RampDocument};
pub use super::materials::{Families, I4Invariants, MaterialDocument, MatrixDocument, VolumetricDocument};
pub use super::measures_document::{ForceFilter, MeasuresDocument, PersonDocument, Region};
pub use super::mesh_document::{
    Generator, LayerDocument, LimbSegmentDocument, MeshDocument, MeshFileDocument, PlacementDocument,
    RotationDocument,
};
pub use super::refinement_document::{Around, RefinementDocument};
pub use super::rigid_document::{RigidDocument, ShapeDocument};
pub use super::solver_document::{ContactSolver, ErrorBarsDocument, Keep, SolverDocument};

/// One scene: bodies, what may touch, how long, what to record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneDocument {
    /// Name of the scene, for reports.
    pub name: String,
    /// What it shows, for people.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// The bodies, one or more.
    pub bodies: Vec<BodyDocument>,
    /// Fixed rigid planes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<PlaneDocument>,
    /// What may touch what.
    #[serde(default)]
    pub contact: ContactDocument,
    /// Acceleration of gravity [m/s²].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_m_per_s2: Option<[f64; 3]>,
    /// How gravity grows; constant by default, over a quasi-static run from 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_ramp: Option<RampDocument>,
    /// Load quasi-statically before the clock starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preload: Option<PreloadDocument>,
    /// Settle under gravity with damping before the clock starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settle: Option<SettleDocument>,
    /// How to step.
    #[serde(default)]
    pub integrator: IntegratorDocument,
    /// How to solve, apart from what.
    #[serde(default, skip_serializing_if = "SolverDocument::is_default")]
    pub solver: SolverDocument,
    /// How exact the numbers shall be, and how long that may take; without it the meshes are run as they are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyDocument>,
    /// What to record and how often.
    #[serde(default)]
    pub record: RecordDocument,
    /// What the measures need to know.
    #[serde(default)]
    pub measures: MeasuresDocument,
}

/// What a body is in the story; the measures speak of the tissue and the projectile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// It hits.
    Projectile,
    /// It is hit: absorbed energy and depth are measured in it.
    Tissue,
    /// Neither.
    #[default]
    Other,
}

/// One body: deformable, with `mesh` and `parts`, or `rigid`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyDocument {
    /// Name, unique in the scene.
    pub name: String,
    /// Role in the story.
    #[serde(default)]
    pub role: Role,
    /// A body that does not deform; instead of a mesh and what goes with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rigid: Option<RigidDocument>,
    /// Where the mesh comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshDocument>,
    /// Where it stands, applied to the mesh: scale, then rotation, then translation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placement: Option<PlacementDocument>,
    /// Where the elements of the placed mesh are to be small.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinement: Vec<RefinementDocument>,
    /// Node sets chosen by place, besides those that the mesh brings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<SetDocument>,
    /// One entry for every part of the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartDocument>,
    /// Initial velocity of flight [m/s].
    #[serde(default)]
    pub velocity_m_per_s: [f64; 3],
    /// Initial spin about the centre of mass [rad/s].
    #[serde(default)]
    pub spin_rad_per_s: [f64; 3],
    /// A deformation that the body starts from, at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_deformation: Option<InitialDeformation>,
    /// Node sets held fixed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixed: Vec<FixedDocument>,
    /// Node sets whose displacement is given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prescribed: Vec<PrescribedDocument>,
    /// Pressures and tractions on faces of the skin.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub face_loads: Vec<FaceLoadDocument>,
}

/// A node set chosen by place: all nodes of the placed mesh in a box, its faces included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetDocument {
    /// Name, unlike those of the mesh.
    pub name: String,
    /// Lowest corner of the box [m].
    pub min_m: [f64; 3],
    /// Highest corner of the box [m].
    pub max_m: [f64; 3],
}

/// Material and element of one part of the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartDocument {
    /// Name of the part in the mesh; `*` stands for every part without an entry of its own.
    pub part: String,
    /// Density at rest [kg/m³].
    pub density_kg_per_m3: f64,
    /// The constitutive law.
    pub material: MaterialDocument,
    /// Shear viscosity η [Pa s] of the part (Kelvin–Voigt): beside the law's stress acts 2 η dev d, d the rate of deformation. In explicit
    /// steps only.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub shear_viscosity_pa_s: f64,
    /// Relaxation of the stress of a split law. In explicit steps; a quasi-static run finds what is left when all has relaxed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prony_series: Option<PronyDocument>,
    /// What its elements bear before they are given up: for skin that tears. In explicit steps only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<ErosionDocument>,
    /// Element formulation; by default `mean_dilatation` for split laws and `full` for coupled ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formulation: Option<Formulation>,
    /// Material axes of the part; by default those of the mesh, else x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fibre_frame: Option<FibreFrameDocument>,
}

/// Erosion of a part: an element beyond a limit loses its stress and its strain energy for good; its mass stays with the nodes. Both
/// are looked at in the mean over the element.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErosionDocument {
    /// Largest principal stretch that an element bears [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stretch: Option<f64>,
    /// Least share of its volume at rest that it bears [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_ratio: Option<f64>,
}

impl ErosionDocument {
    /// As the elements know it.
    pub fn limits(&self) -> force::ErosionLimits {
        force::ErosionLimits {
            stretch: self.stretch.unwrap_or(f64::INFINITY),
            volume_ratio: self.volume_ratio.unwrap_or(0.0),
        }
    }
}

impl PartDocument {
    /// The law under slow loading; `None` where it cannot be made.
    pub fn law(&self) -> Option<Material> {
        let material = self.material.to_material()?;
        self.prony_series.as_ref().map_or(Some(material), |prony| prony.slow_law(material))
    }
    /// Its Prony series.
    pub fn series(&self) -> PronySeries {
        self.prony_series.as_ref().map_or(PronySeries::NONE, PronyDocument::series)
    }
    /// Whether its stress depends on rate or history, bulk viscosity apart.
    pub fn is_viscous(&self) -> bool {
        self.shear_viscosity_pa_s > 0.0 || self.prony_series.is_some()
    }
    /// The element that is asked for, or else mean dilatation for split laws and full integration for coupled ones.
    pub fn element(&self, material: &Material) -> force::Formulation {
        match self.formulation {
            Some(Formulation::MeanDilatation) => force::Formulation::MeanDilatation,
            Some(Formulation::Reduced) => force::Formulation::Reduced,
            None if material.volumetric().is_some() => force::Formulation::MeanDilatation,
            Some(Formulation::Full) | None => force::Formulation::Full,
        }
    }
}

/// Element formulation of an eight-node hexahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// 2×2×2 points for the isochoric part, one mean dilatation and one pressure per element.
    MeanDilatation,
    /// 2×2×2 points for everything.
    Full,
    /// One point, with a physical stabilisation of the hourglass modes whose energy the ledger shows.
    Reduced,
}

/// Material axes of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FibreFrameDocument {
    /// The axes that the mesh carries (limb segments do; an error where it has none).
    // With braces: serde lets unknown fields pass in a tagged unit variant.
    Mesh {},
    /// One frame for the whole part: e1 along `axis`, e2 the part of `plane` normal to it.
    Constant {
        /// Direction of e1.
        axis: [f64; 3],
        /// A direction in the plane of e1 and e2.
        plane: [f64; 3],
    },
    /// Around an axis: e1 along it, e2 circumferential, e3 radial.
    Cylindrical {
        /// A point on the axis [m].
        origin_m: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
    },
}

/// Nodes held fixed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedDocument {
    /// Name of a node set of the mesh; `*` for all nodes.
    pub set: String,
    /// Which axes.
    #[serde(default = "all_axes")]
    pub axes: Vec<Axis>,
}

fn all_axes() -> Vec<Axis> {
    vec![Axis::X, Axis::Y, Axis::Z]
}

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

/// A deformation that a body starts from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum InitialDeformation {
    /// Volume-preserving radial motion of a hollow ball: r³ = R³ + A³ (λ³ − 1).
    SphericalInflation {
        /// Centre [m].
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

/// A fixed rigid half space: material must stay where `normal · (x − point) ≥ 0`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneDocument {
    /// Name, unique among bodies and planes.
    pub name: String,
    /// A point on the plane [m].
    pub point_m: [f64; 3],
    /// Normal, out of the solid half space; of any length.
    pub normal: [f64; 3],
}

/// What may touch what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactDocument {
    /// `"all"` (every body with every other body and plane), or a list of pairs. Bodies of either that deform meet themselves, too, see
    /// `self_contact`.
    #[serde(default)]
    pub pairs: ContactPairs,
    /// Whether bodies meet themselves.
    #[serde(default, skip_serializing_if = "SelfContact::is_default")]
    pub self_contact: SelfContact,
    /// Coulomb friction μ of pairs that do not give their own [-].
    #[serde(default)]
    pub friction: f64,
    /// Largest scaled residual of the contact solver [-].
    #[serde(default = "default_contact_tolerance")]
    pub tolerance: f64,
    /// Share of the mass of skin nodes that is moved inwards, 0 … 0.95 [-]: lowers what a lumped node loses when it is caught,
    /// and shortens the step.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub mass_redistribution: f64,
    /// How the contact of two meshes is made discrete. `mortar` passes on a pressure between meshes that do not match.
    #[serde(default, skip_serializing_if = "ContactDiscretisation::is_default")]
    pub discretisation: ContactDiscretisation,
}

/// Whether bodies that deform meet themselves, such as where they fold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SelfContact {
    /// All of them that may touch anything.
    #[default]
    Auto,
    /// None, listed or not.
    None,
}

impl SelfContact {
    #[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// How the contact of two meshes is made discrete.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactDiscretisation {
    /// Each slave node against the closest face of the master; nodes of the master in slave faces beyond 1 % of a face; sharp edges
    /// against edges, also those that deformation makes: nothing slips between the nodes of either side.
    #[default]
    TwoPass,
    /// Each slave node against the closest face of the master, and nothing else.
    NodeToSurface,
    /// Means over the slave's faces with dual shape functions, and the rest as with `two_pass`. Faces that are not wholly above the master, and self-contact, keep
    /// nodes against faces.
    Mortar,
}

impl ContactDiscretisation {
    #[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// As detection names it.
    pub fn method(self) -> Discretisation {
        match self {
            Self::NodeToSurface => Discretisation::NodeToSurface,
            Self::Mortar => Discretisation::Mortar,
            Self::TwoPass => Discretisation::TwoPass,
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_nothing(share: &f64) -> bool {
    *share == 0.0
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
            discretisation: ContactDiscretisation::default(),
        }
    }
}

/// All pairs or a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ContactPairs {
    /// `"all"`
    All(AllPairs),
    /// Only these.
    List(Vec<PairDocument>),
}

impl Default for ContactPairs {
    fn default() -> Self {
        Self::All(AllPairs::All)
    }
}

/// The word `"all"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AllPairs {
    /// Every body with every other body and plane, and with itself if it deforms.
    All,
}

/// One pair that may touch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairDocument {
    /// Two names of bodies or planes; the same body twice asks for self-contact.
    pub between: [String; 2],
    /// Coulomb friction μ [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// Settle before the clock starts: gravity on, damping on, full stick; in the last third of the time with the friction of the scene, so
/// that what it cannot hold slips before the clock starts. A body with a velocity waits where the scene puts it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SettleDocument {
    /// How long [s].
    pub duration_s: f64,
    /// Mass-proportional damping α, force −α M v [1/s].
    pub damping_per_s: f64,
}

/// What to record and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordDocument {
    /// Fields to record at the field times; empty for none.
    #[serde(default = "default_fields")]
    pub fields: Vec<FieldName>,
    /// Times of the fields [s]; the run hits them exactly. The start and the end are always recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_times_s: Option<Vec<f64>>,
    /// Or every so often [s]; by default a fiftieth of the run. Not together with `field_times_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_interval_s: Option<f64>,
    /// Contact forces and energy every so many steps.
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
    /// The bodies that meet themselves though no pair says so, by index: those that deform and may touch anything else.
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

    /// Whether a mesh comes from a file.
    pub fn has_mesh_file(&self) -> bool {
        self.bodies.iter().any(|body| matches!(body.mesh, Some(MeshDocument::File(_))))
    }

    /// Whether a part has what only explicit steps know: viscosity, relaxation, erosion.
    pub fn needs_explicit_steps(&self) -> bool {
        let parts = self.bodies.iter().flat_map(|body| &body.parts);
        parts.into_iter().any(|part| part.is_viscous() || part.erosion.is_some())
    }

    /// Whether a thing is put back that plans leave out.
    pub fn keeps(&self, thing: Keep) -> bool {
        self.solver.keep.contains(&thing)
    }

    /// The fields that are recorded, each once: those asked for, or all where the unasked ones are kept.
    pub fn recorded_fields(&self) -> Vec<FieldName> {
        let recorded =
            |field: &FieldName| self.record.fields.contains(field) || self.keeps(Keep::UnaskedFields);
        FieldName::ALL.into_iter().filter(recorded).collect()
    }
}

/// A field of the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldName {
    /// Von Mises stress at the nodes [Pa].
    VonMises,
    /// Pressure at the nodes, positive in compression [Pa].
    Pressure,
    /// Largest principal Green–Lagrange strain at the nodes [-].
    PrincipalStrain,
    /// Displacement at the nodes [m].
    Displacement,
    /// Velocity at the nodes [m/s].
    Velocity,
    /// Mean Cauchy stress of each element, 6 components [Pa].
    ElementCauchyStress,
}

impl FieldName {
    /// All of them, in their order.
    pub const ALL: [Self; 6] = [
        Self::VonMises,
        Self::Pressure,
        Self::PrincipalStrain,
        Self::Displacement,
        Self::Velocity,
        Self::ElementCauchyStress,
    ];
}
