//! The messages of `api/recording.proto`, package `contuse.v1`; that file has their meaning.

use super::foxglove::{Quaternion, Vector3};

/// An array of numbers as little-endian bytes: `count` entries of `components` numbers of type `dtype` each.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PackedArray {
    /// Name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// "f32", "f64", "u32" or "u8".
    #[prost(string, tag = "2")]
    pub dtype: String,
    /// Entries.
    #[prost(uint32, tag = "3")]
    pub count: u32,
    /// Numbers an entry: 1 a scalar, 3 a vector, 6 a symmetric tensor xx, yy, zz, xy, yz, xz.
    #[prost(uint32, tag = "4")]
    pub components: u32,
    /// Unit, empty for a pure number.
    #[prost(string, tag = "5")]
    pub unit: String,
    /// Data.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
}

/// `/contact/forces`: what the contact pairs do at one time.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ContactForces {
    /// Time [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// Pairs.
    #[prost(message, repeated, tag = "3")]
    pub pairs: Vec<PairForces>,
}

/// One contact pair.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PairForces {
    /// Pair.
    #[prost(string, tag = "1")]
    pub pair: String,
    /// Slave body.
    #[prost(string, tag = "2")]
    pub slave_body: String,
    /// A body or a plane.
    #[prost(string, tag = "3")]
    pub master_body: String,
    /// On the slave, of this step [N].
    #[prost(message, optional, tag = "4")]
    pub force_n: Option<Vector3>,
    /// Force norm [N].
    #[prost(double, tag = "5")]
    pub force_norm_n: f64,
    /// On the slave, so far [N s].
    #[prost(message, optional, tag = "6")]
    pub impulse_n_s: Option<Vector3>,
    /// Impulse norm [N s].
    #[prost(double, tag = "7")]
    pub impulse_norm_n_s: f64,
    /// Patch area [m²].
    #[prost(double, tag = "8")]
    pub patch_area_m2: f64,
    /// Patch long axis [m].
    #[prost(double, tag = "9")]
    pub patch_long_axis_m: f64,
    /// Patch short axis [m].
    #[prost(double, tag = "10")]
    pub patch_short_axis_m: f64,
    /// Peak pressure [Pa].
    #[prost(double, tag = "11")]
    pub peak_pressure_pa: f64,
    /// Patch nodes.
    #[prost(uint32, tag = "12")]
    pub patch_nodes: u32,
    /// Nodes across patch.
    #[prost(uint32, tag = "13")]
    pub nodes_across_patch: u32,
    /// One entry an active contact: `node`, `position_m`, `normal`, `normal_force_n`, `tangential_force_n`, `gap_m`, `status`.
    #[prost(message, repeated, tag = "14")]
    pub contacts: Vec<PackedArray>,
}

/// `/energy`: the ledger at one time.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Energy {
    /// Time [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// Bodies.
    #[prost(message, repeated, tag = "3")]
    pub bodies: Vec<BodyEnergy>,
    /// Pairs.
    #[prost(message, repeated, tag = "4")]
    pub pairs: Vec<PairEnergy>,
    /// Kinetic, strain, viscous, friction, impact and numerical contact dissipation [J].
    #[prost(double, tag = "5")]
    pub total_j: f64,
    /// Initial total [J].
    #[prost(double, tag = "6")]
    pub initial_total_j: f64,
    /// With the work of the position projection [J].
    #[prost(double, tag = "7")]
    pub external_work_j: f64,
    /// Error of the balance over the energy scale [-].
    #[prost(double, tag = "8")]
    pub balance_error: f64,
    /// From the tissue's state; 0 without tissue [J].
    #[prost(double, tag = "9")]
    pub absorbed_by_tissue_j: f64,
    /// From the work of the reactions on it [J].
    #[prost(double, tag = "10")]
    pub absorbed_by_tissue_work_j: f64,
    /// Momentum [kg m/s].
    #[prost(message, optional, tag = "11")]
    pub momentum_kg_m_per_s: Option<Vector3>,
    /// Angular momentum [kg m²/s].
    #[prost(message, optional, tag = "12")]
    pub angular_momentum_kg_m2_per_s: Option<Vector3>,
}

/// Energy of one body; those from `viscous_j` to `projection_j` are sums so far.
#[derive(Clone, PartialEq, prost::Message)]
pub struct BodyEnergy {
    /// Body.
    #[prost(string, tag = "1")]
    pub body: String,
    /// Kinetic [J].
    #[prost(double, tag = "2")]
    pub kinetic_j: f64,
    /// Strain [J].
    #[prost(double, tag = "3")]
    pub strain_j: f64,
    /// Viscous [J].
    #[prost(double, tag = "4")]
    pub viscous_j: f64,
    /// Contact work [J].
    #[prost(double, tag = "5")]
    pub contact_work_j: f64,
    /// External work [J].
    #[prost(double, tag = "6")]
    pub external_work_j: f64,
    /// Projection [J].
    #[prost(double, tag = "7")]
    pub projection_j: f64,
    /// What of the strain energy is in the stabilisation of one-point elements [J].
    #[prost(double, tag = "8")]
    pub hourglass_j: f64,
    /// Dissipated by an implicit time integrator so far [J].
    #[prost(double, tag = "9")]
    pub algorithmic_j: f64,
    /// What of the strain energy is in the branches of Prony series [J].
    #[prost(double, tag = "10")]
    pub branches_j: f64,
    /// Strain energy that went with eroded elements so far [J].
    #[prost(double, tag = "11")]
    pub eroded_j: f64,
}

/// Energy of one contact pair, sums so far.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PairEnergy {
    /// Pair.
    #[prost(string, tag = "1")]
    pub pair: String,
    /// Friction [J].
    #[prost(double, tag = "2")]
    pub friction_j: f64,
    /// Numerical contact [J].
    #[prost(double, tag = "3")]
    pub numerical_contact_j: f64,
    /// Work on slave [J].
    #[prost(double, tag = "4")]
    pub work_on_slave_j: f64,
    /// Work on master [J].
    #[prost(double, tag = "5")]
    pub work_on_master_j: f64,
    /// What rigid bodies lost by being stopped: they do not rebound [J].
    #[prost(double, tag = "6")]
    pub impact_j: f64,
}

/// `/stress/{body}`: fields of one body at one time, in the order of the nodes and elements of its reference mesh.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Stress {
    /// Time [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// Body.
    #[prost(string, tag = "3")]
    pub body: String,
    /// The nodal fields that were asked for.
    #[prost(message, repeated, tag = "4")]
    pub nodal: Vec<PackedArray>,
    /// `cauchy_pa` × 6, the mean of each element, if asked for.
    #[prost(message, repeated, tag = "5")]
    pub element: Vec<PackedArray>,
}

/// `/reference/{body}`: the mesh at rest, once, before everything else. Where all cells are hexahedra of eight nodes it is a
/// `contuse.v1.ReferenceMesh` with `hexes`, otherwise a `contuse.v1.MixedReferenceMesh` with `cell_types` and `cell_nodes`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ReferenceMesh {
    /// Time [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Body.
    #[prost(string, tag = "2")]
    pub body: String,
    /// "projectile", "tissue" or "other".
    #[prost(string, tag = "3")]
    pub role: String,
    /// Parts.
    #[prost(string, repeated, tag = "4")]
    pub parts: Vec<String>,
    /// Positions at rest, f64 × 3 [m], nodes.
    #[prost(message, optional, tag = "5")]
    pub positions: Option<PackedArray>,
    /// u32 × 8: corner nodes of each element in the order of Gmsh, Abaqus and VTK.
    #[prost(message, optional, tag = "6")]
    pub hexes: Option<PackedArray>,
    /// u32: part of each element, an index into `parts`.
    #[prost(message, optional, tag = "7")]
    pub part_of: Option<PackedArray>,
    /// V [m/s] of x = X + V t + u.
    #[prost(message, optional, tag = "8")]
    pub flight_velocity_m_per_s: Option<Vector3>,
    /// u8: VTK's cell type of each element.
    #[prost(message, optional, tag = "9")]
    pub cell_types: Option<PackedArray>,
    /// u32: the nodes of all elements, one element after the other, each in the order of VTK.
    #[prost(message, optional, tag = "10")]
    pub cell_nodes: Option<PackedArray>,
}

/// `/pose/{body}`: where a rigid body is at one time.
#[derive(Clone, PartialEq, prost::Message)]
pub struct RigidPose {
    /// Time [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// Body.
    #[prost(string, tag = "3")]
    pub body: String,
    /// Of the centre of mass [m].
    #[prost(message, optional, tag = "4")]
    pub position_m: Option<Vector3>,
    /// From the axes of the body to those of space.
    #[prost(message, optional, tag = "5")]
    pub orientation: Option<Quaternion>,
    /// "projectile" or "other".
    #[prost(string, tag = "6")]
    pub role: String,
}

/// `/summary`: the running clinical summary. The numbers are here for plots, `json` has everything.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Summary {
    /// Time [s].
    #[prost(double, tag = "1")]
    pub time_s: f64,
    /// Step.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// A gate has failed: no number here or in `json` is a result.
    #[prost(bool, tag = "3")]
    pub withheld: bool,
    /// Over the force window, the largest of the pairs that touch the tissue [N].
    #[prost(double, tag = "4")]
    pub peak_force_n: f64,
    /// Of that pair [N s].
    #[prost(double, tag = "5")]
    pub impulse_n_s: f64,
    /// Of that pair, at its peak force [m²].
    #[prost(double, tag = "6")]
    pub patch_area_m2: f64,
    /// Absorbed energy [J].
    #[prost(double, tag = "7")]
    pub absorbed_energy_j: f64,
    /// Balance error.
    #[prost(double, tag = "8")]
    pub balance_error: f64,
    /// Numerical contact dissipation [J].
    #[prost(double, tag = "9")]
    pub numerical_contact_dissipation_j: f64,
    /// One for each threshold.
    #[prost(message, repeated, tag = "10")]
    pub depths: Vec<DepthAbove>,
    /// All of the summary.
    #[prost(string, tag = "11")]
    pub json: String,
    /// Error of the peak force [N]; absent, as those below, where none was estimated.
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
    /// Half width of the error bar.
    #[prost(double, tag = "1")]
    pub half_width: f64,
    /// Whether the error leaves something of the number: if not, it is no result.
    #[prost(bool, tag = "2")]
    pub resolved: bool,
}

/// Depth and volume of significant stress at one threshold of the von Mises stress, the largest so far.
#[derive(Clone, PartialEq, prost::Message)]
pub struct DepthAbove {
    /// Threshold [Pa].
    #[prost(double, tag = "1")]
    pub threshold_pa: f64,
    /// Depth [m].
    #[prost(double, tag = "2")]
    pub depth_m: f64,
    /// Volume [m³].
    #[prost(double, tag = "3")]
    pub volume_m3: f64,
    /// Error of the depth [m]; absent, as that below, where none was estimated.
    #[prost(message, optional, tag = "4")]
    pub depth_error: Option<NumberError>,
    /// Error of the volume [m³].
    #[prost(message, optional, tag = "5")]
    pub volume_error: Option<NumberError>,
}
