//! Messages of `api/recording.proto`, package `contuse.v1`, which documents them.

use super::foxglove::{Quaternion, Vector3};

/// An array of numbers as little-endian bytes: `count` entries of `components` numbers of type `dtype` each.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PackedArray {
    /// Name of the quantity.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Type of the numbers: "f32", "f64", "u32" or "u8".
    #[prost(string, tag = "2")]
    pub dtype: String,
    /// Number of entries in the array.
    #[prost(uint32, tag = "3")]
    pub count: u32,
    /// Numbers per entry: 1 a scalar, 3 a vector, 6 a symmetric tensor xx, yy, zz, xy, yz, xz.
    #[prost(uint32, tag = "4")]
    pub components: u32,
    /// Unit of the numbers, empty if dimensionless.
    #[prost(string, tag = "5")]
    pub unit: String,
    /// Numbers packed as little-endian bytes.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
}

/// `/contact/forces`: forces of the contact pairs at one time.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ContactForces {
    /// Simulated time of the sample [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Number of the step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// One entry for each contact pair.
    #[prost(message, repeated, tag = "3")]
    pub pairs: Vec<PairForces>,
}

/// Forces of one contact pair.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PairForces {
    /// Name of the pair.
    #[prost(string, tag = "1")]
    pub pair: String,
    /// Name of the slave body.
    #[prost(string, tag = "2")]
    pub slave_body: String,
    /// Name of the master, a body or a plane.
    #[prost(string, tag = "3")]
    pub master_body: String,
    /// Resultant force on the slave in this step [N].
    #[prost(message, optional, tag = "4")]
    pub force_n: Option<Vector3>,
    /// Norm of that force [N].
    #[prost(double, tag = "5")]
    pub force_norm_n: f64,
    /// Impulse on the slave so far [N s].
    #[prost(message, optional, tag = "6")]
    pub impulse_n_s: Option<Vector3>,
    /// Norm of that impulse [N s].
    #[prost(double, tag = "7")]
    pub impulse_norm_n_s: f64,
    /// Area of the contact patch [m²].
    #[prost(double, tag = "8")]
    pub patch_area_m2: f64,
    /// Long axis of the contact patch [m].
    #[prost(double, tag = "9")]
    pub patch_long_axis_m: f64,
    /// Short axis of the contact patch [m].
    #[prost(double, tag = "10")]
    pub patch_short_axis_m: f64,
    /// Largest nodal pressure in the patch [Pa].
    #[prost(double, tag = "11")]
    pub peak_pressure_pa: f64,
    /// Number of slave nodes that carry force.
    #[prost(uint32, tag = "12")]
    pub patch_nodes: u32,
    /// Nodes across the short axis of the patch.
    #[prost(uint32, tag = "13")]
    pub nodes_across_patch: u32,
    /// One entry for each active contact: `node`, `position_m`, `normal`, `normal_force_n`, `tangential_force_n`,
    /// `gap_m`, `status`.
    #[prost(message, repeated, tag = "14")]
    pub contacts: Vec<PackedArray>,
}

/// `/energy`: the energy ledger at one time.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Energy {
    /// Simulated time of the sample [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Number of the step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// One entry for each body.
    #[prost(message, repeated, tag = "3")]
    pub bodies: Vec<BodyEnergy>,
    /// One entry for each contact pair.
    #[prost(message, repeated, tag = "4")]
    pub pairs: Vec<PairEnergy>,
    /// Sum of kinetic and strain energy, and of viscous, friction, impact and numerical contact dissipation [J].
    #[prost(double, tag = "5")]
    pub total_j: f64,
    /// Total energy at the start [J].
    #[prost(double, tag = "6")]
    pub initial_total_j: f64,
    /// Work of external forces, including that of the position projection [J].
    #[prost(double, tag = "7")]
    pub external_work_j: f64,
    /// Error of the balance over the energy scale [-].
    #[prost(double, tag = "8")]
    pub balance_error: f64,
    /// Energy absorbed by the tissue, from its state; 0 without tissue [J].
    #[prost(double, tag = "9")]
    pub absorbed_by_tissue_j: f64,
    /// Energy absorbed by the tissue, from the work of the reactions on it [J].
    #[prost(double, tag = "10")]
    pub absorbed_by_tissue_work_j: f64,
    /// Total linear momentum [kg m/s].
    #[prost(message, optional, tag = "11")]
    pub momentum_kg_m_per_s: Option<Vector3>,
    /// Total angular momentum about the origin [kg m²/s].
    #[prost(message, optional, tag = "12")]
    pub angular_momentum_kg_m2_per_s: Option<Vector3>,
}

/// Energies of one body; those from `viscous_j` to `projection_j` are accumulated.
#[derive(Clone, PartialEq, prost::Message)]
pub struct BodyEnergy {
    /// Name of the body.
    #[prost(string, tag = "1")]
    pub body: String,
    /// Kinetic energy of the body [J].
    #[prost(double, tag = "2")]
    pub kinetic_j: f64,
    /// Strain energy of the body [J].
    #[prost(double, tag = "3")]
    pub strain_j: f64,
    /// Viscous dissipation in the body [J].
    #[prost(double, tag = "4")]
    pub viscous_j: f64,
    /// Work of the contact reactions [J].
    #[prost(double, tag = "5")]
    pub contact_work_j: f64,
    /// Work of external forces [J].
    #[prost(double, tag = "6")]
    pub external_work_j: f64,
    /// Work of the position projection [J].
    #[prost(double, tag = "7")]
    pub projection_j: f64,
    /// Part of the strain energy in the stabilisation of one-point elements [J].
    #[prost(double, tag = "8")]
    pub hourglass_j: f64,
    /// Energy dissipated by an implicit time integrator so far [J].
    #[prost(double, tag = "9")]
    pub algorithmic_j: f64,
    /// Part of the strain energy in the branches of Prony series [J].
    #[prost(double, tag = "10")]
    pub branches_j: f64,
    /// Strain energy removed with eroded elements so far [J].
    #[prost(double, tag = "11")]
    pub eroded_j: f64,
    /// Branches of the Prony series of its parts, one for each relaxation time.
    #[prost(message, repeated, tag = "12")]
    pub branches: Vec<BranchEnergy>,
}

/// Energy of a branch of relaxation of one body.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct BranchEnergy {
    /// Relaxation time of the branch [s].
    #[prost(double, tag = "1")]
    pub relaxation_time_s: f64,
    /// Energy stored in the branch [J].
    #[prost(double, tag = "2")]
    pub stored_j: f64,
    /// Energy dissipated by the branch so far [J].
    #[prost(double, tag = "3")]
    pub dissipated_j: f64,
}

/// Energies of one contact pair, accumulated.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PairEnergy {
    /// Name of the pair.
    #[prost(string, tag = "1")]
    pub pair: String,
    /// Friction dissipation of the pair [J].
    #[prost(double, tag = "2")]
    pub friction_j: f64,
    /// Numerical contact dissipation [J].
    #[prost(double, tag = "3")]
    pub numerical_contact_j: f64,
    /// Work on the slave's body [J].
    #[prost(double, tag = "4")]
    pub work_on_slave_j: f64,
    /// Work on the master's body [J].
    #[prost(double, tag = "5")]
    pub work_on_master_j: f64,
    /// Energy lost by rigid bodies when stopped: they do not rebound [J].
    #[prost(double, tag = "6")]
    pub impact_j: f64,
}

/// `/stress/{body}`: fields of one body at one time, in the order of the nodes and elements of its reference mesh.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Stress {
    /// Simulated time of the sample [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Number of the step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// Name of the body.
    #[prost(string, tag = "3")]
    pub body: String,
    /// The requested nodal fields.
    #[prost(message, repeated, tag = "4")]
    pub nodal: Vec<PackedArray>,
    /// `cauchy_pa` × 6, the mean over each element, if requested; `eroded`, 1 for each eroded element, where elements may
    /// erode.
    #[prost(message, repeated, tag = "5")]
    pub element: Vec<PackedArray>,
}

/// `/reference/{body}`: the undeformed mesh, once, before everything else. If all cells are eight-node hexahedra it is
/// a `contuse.v1.ReferenceMesh` with `hexes`, otherwise a `contuse.v1.MixedReferenceMesh` with `cell_types` and
/// `cell_nodes`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ReferenceMesh {
    /// Simulated time of the sample [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Name of the body.
    #[prost(string, tag = "2")]
    pub body: String,
    /// Role of the body: "projectile", "tissue" or "other".
    #[prost(string, tag = "3")]
    pub role: String,
    /// Names of the parts.
    #[prost(string, repeated, tag = "4")]
    pub parts: Vec<String>,
    /// Reference positions of the nodes, f64 × 3 [m].
    #[prost(message, optional, tag = "5")]
    pub positions: Option<PackedArray>,
    /// u32 × 8: corner nodes of each element in the order of Gmsh, Abaqus and VTK.
    #[prost(message, optional, tag = "6")]
    pub hexes: Option<PackedArray>,
    /// u32: part of each element, an index into `parts`.
    #[prost(message, optional, tag = "7")]
    pub part_of: Option<PackedArray>,
    /// Flight velocity V [m/s] in x = X + V t + u.
    #[prost(message, optional, tag = "8")]
    pub flight_velocity_m_per_s: Option<Vector3>,
    /// u8: VTK's cell type of each element.
    #[prost(message, optional, tag = "9")]
    pub cell_types: Option<PackedArray>,
    /// u32: nodes of all elements in sequence, each in the order of VTK.
    #[prost(message, optional, tag = "10")]
    pub cell_nodes: Option<PackedArray>,
}

/// `/pose/{body}`: position and orientation of a rigid body at one time.
#[derive(Clone, PartialEq, prost::Message)]
pub struct RigidPose {
    /// Simulated time of the sample [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Number of the step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// Name of the body.
    #[prost(string, tag = "3")]
    pub body: String,
    /// Position of the centre of mass [m].
    #[prost(message, optional, tag = "4")]
    pub position_m: Option<Vector3>,
    /// Rotation from the body axes to the space axes.
    #[prost(message, optional, tag = "5")]
    pub orientation: Option<Quaternion>,
    /// Role of the body: "projectile" or "other".
    #[prost(string, tag = "6")]
    pub role: String,
}

/// `/summary`: the running clinical summary. The numbers are for plots; `json` is complete.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Summary {
    /// Simulated time of the sample [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Number of the step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// Whether a gate has failed: then no number here or in `json` is a result.
    #[prost(bool, tag = "3")]
    pub withheld: bool,
    /// Peak force over the force window, the largest among the pairs on the tissue [N].
    #[prost(double, tag = "4")]
    pub peak_force_n: f64,
    /// Impulse of that pair [N s].
    #[prost(double, tag = "5")]
    pub impulse_n_s: f64,
    /// Patch area of that pair at its peak force [m²].
    #[prost(double, tag = "6")]
    pub patch_area_m2: f64,
    /// Energy absorbed by the tissue [J].
    #[prost(double, tag = "7")]
    pub absorbed_energy_j: f64,
    /// Error of the energy balance over the energy scale [-].
    #[prost(double, tag = "8")]
    pub balance_error: f64,
    /// Numerical contact dissipation [J].
    #[prost(double, tag = "9")]
    pub numerical_contact_dissipation_j: f64,
    /// One entry for each stress threshold.
    #[prost(message, repeated, tag = "10")]
    pub depths: Vec<DepthAbove>,
    /// The complete summary as JSON.
    #[prost(string, tag = "11")]
    pub json: String,
    /// Error of the peak force [N]; absent, like those below, if not estimated.
    #[prost(message, optional, tag = "12")]
    pub peak_force_error: Option<NumberError>,
    /// Error of the impulse [N s].
    #[prost(message, optional, tag = "13")]
    pub impulse_error: Option<NumberError>,
    /// Error of the patch area [m²].
    #[prost(message, optional, tag = "14")]
    pub patch_area_error: Option<NumberError>,
    /// Error of the absorbed energy [J].
    #[prost(message, optional, tag = "15")]
    pub absorbed_energy_error: Option<NumberError>,
}

/// Estimated numerical error of a number, in its unit.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct NumberError {
    /// Half-width of the error bar.
    #[prost(double, tag = "1")]
    pub half_width: f64,
    /// Whether the number exceeds its error: if not, it is no result.
    #[prost(bool, tag = "2")]
    pub resolved: bool,
}

/// Depth and volume of significant stress at one threshold of the von Mises stress, the largest so far.
#[derive(Clone, PartialEq, prost::Message)]
pub struct DepthAbove {
    /// Threshold of the von Mises stress [Pa].
    #[prost(double, tag = "1")]
    pub threshold_pa: f64,
    /// Largest depth so far [m].
    #[prost(double, tag = "2")]
    pub depth_m: f64,
    /// Largest volume so far [m³].
    #[prost(double, tag = "3")]
    pub volume_m3: f64,
    /// Error of the depth [m]; absent, like that below, if not estimated.
    #[prost(message, optional, tag = "4")]
    pub depth_error: Option<NumberError>,
    /// Error of the volume [m³].
    #[prost(message, optional, tag = "5")]
    pub volume_error: Option<NumberError>,
}
