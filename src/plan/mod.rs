//! The plan: a scene compiled to what it needs. Immutable during the run; features that are not needed are absent.

mod blocks;
mod by_pair;
mod compile;
mod contact;
mod contact_mass;
mod cost;
mod distant;
mod holder;
mod loads;
mod memory;
mod named_materials;
mod omitted;
mod parts;
mod refinement;
mod report;
mod requested;
mod rigid;
mod stable_step;
mod statics;
mod stepping;
#[cfg(test)]
mod tests;

pub use by_pair::{ByPair, MOST_LISTED_BODIES, MOST_LISTED_PAIRS};
pub use compile::{compile, recompile};
pub use distant::DistantPair;
pub use holder::Holder;
pub use loads::{FacePressure, LoadTime, Loads, NodalForces, Prescribed, Ramp};
pub use memory::MemoryReport;
pub use named_materials::NamedMaterialReport;
pub use omitted::Omitted;
pub use parts::CompileError;
pub use refinement::RefinementReport;
pub use report::{BlockReport, IntegratorReport, PairReport, PlanReport};
pub use requested::CUTS;
pub use rigid::{RigidPlan, RigidReport};
pub use stable_step::{ElementsWithin, StableStepReport};
pub use statics::{Statics, UnderConstrained};

use crate::mechanics::contact::detection::rigid_detection::MOST_POINTS;
use crate::mechanics::contact::pairs::Pairs;
use crate::mechanics::contact::solution::solvers::Method;
use crate::mechanics::contact::{ContactPair, Discretisation, Master, Surface};
use crate::mechanics::force::{AssembledRows, ElementBlock, ElementForces, Erosion};
use crate::mechanics::lanes::Row;
use crate::mechanics::material::Validity;
use crate::mechanics::sparse::{Cholesky, SparseError, SymmetricMatrix, Unknowns};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Cell, Cells, surface};
use crate::scene::document::{FieldName, ForceFilter, PersonDocument, Role};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ops::Range;

/// What stepping a scene requires. Nodes and elements are numbered consecutively over all bodies. A rigid body has two
/// nodes, see [`crate::mechanics::rigid`].
#[derive(Debug)]
pub struct Plan {
    /// Name of the scene.
    pub name: String,
    /// Bodies, in the order of the scene.
    pub bodies: Vec<PlanBody>,
    /// Reference positions X [m], nodes × 3.
    pub X: Vec<Vec3>,
    /// Inverse of the mass that its own elements lump at each node, also of followers, 0 along axes on which it is held [1/kg].
    pub own_inverse_mass: Vec<Vec3>,
    /// What the assembled mesh leaves of the volumetric stiffness of each element in its initial critical time step, chunk by chunk [-];
    /// empty with implicit steps, see [`AssembledBound`](crate::mechanics::force::AssembledBound).
    pub fractions: Vec<Vec<AssembledRows>>,
    /// Lumped (row sum) mass [kg], nodes; 0 for the spin of a rigid body and for followers, whose mass their masters carry.
    pub mass: Vec<f64>,
    /// 1/m along each axis [1/kg], 0 where the node is held or follows others; 1/I [1/(kg m²)] for the spin of a rigid
    /// body; nodes × 3.
    pub inverse_mass: Vec<Vec3>,
    /// Rigid bodies; `None` when there are none.
    pub rigid: Option<RigidPlan>,
    /// Elements, in blocks of one kernel each.
    pub blocks: Vec<ElementBlock>,
    /// Force contributions that each node sums, in fixed order; and which nodes follow others.
    pub assembly: crate::mechanics::force::Assembly,
    /// Contact, if anything may touch.
    pub contact: Option<ContactPlan>,
    /// Requested pairs that cannot meet before the end; they are not in `contact`.
    pub distant_pairs: Vec<DistantPair>,
    /// Whether elements that nothing has reached yet are not evaluated in a step.
    pub skip_inactive_elements: bool,
    /// Acceleration of gravity [m/s²].
    pub gravity: Option<Vec3>,
    /// Loads besides gravity and contact.
    pub loads: Loads,
    /// Quasi-static loading before the clock starts, in steps of a pseudo-time of 1 s.
    pub preload: Option<Box<Implicit>>,
    /// Dynamic relaxation before the clock starts.
    pub dynamic_relaxation: Option<DynamicRelaxation>,
    /// Initial displacement [m], nodes × 3; empty when all are zero.
    pub initial_u: Vec<Vec3>,
    /// Initial velocity relative to the body's flight [m/s], nodes × 3; empty when all are zero.
    pub initial_v: Vec<Vec3>,
    /// Time integration scheme with its options.
    pub integrator: Integrator,
    /// Largest error of the energy balance [-].
    pub energy_gate: f64,
    /// Energy that rounding alone may produce [J]; below it the balance is not meaningful.
    pub rounding_energy: f64,
    /// Supports of the bodies: planes, held and driven nodes. Without any, a common velocity of all bodies has no effect.
    pub holder: Holder,
    /// Simulated time to the end [s].
    pub end_time: f64,
    /// Times [s] that the run hits exactly and records fields at, ascending; from 0 to the end.
    pub field_times: Vec<f64>,
    /// Fields that are recorded at those times.
    pub fields: Vec<FieldName>,
    /// Contact and energy are recorded every so many steps.
    pub every_steps: u32,
    /// Whether runs for its error bars precede the run.
    pub has_error_bars: bool,
    /// Inputs of the measures.
    pub measures: MeasurePlan,
    /// What was kept, what was omitted, and why.
    pub report: PlanReport,
}

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
        Cow::Owned(Surface { nodes: surface::boundary_nodes(&faces), faces })
    }
}

/// Contact pairs with their surfaces and solver settings.
#[derive(Debug)]
pub struct ContactPlan {
    /// One surface for each body in contact, in the order of the bodies.
    pub surfaces: Vec<Surface>,
    /// Body index of each surface.
    pub surface_body: Vec<usize>,
    /// Contact pairs; those with a rigid side come last.
    pub pairs: Pairs,
    /// Body index of each rigid body.
    pub rigid_body: Vec<usize>,
    /// Names of the two sides of each listed pair.
    pub listed_names: ByPair<[String; 2]>,
    /// Largest scaled residual of the solver [-].
    pub tolerance: f64,
    /// Discretisation of contact between two meshes.
    pub discretisation: Discretisation,
    /// Solver of the library that is given `W`, if the scene names one.
    pub solver: Option<Method>,
    /// Whether self-contact is searched for in every step, even where no parts can have come close.
    pub always_looks_at_itself: bool,
}

/// Dynamic relaxation before the clock starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicRelaxation {
    /// Duration of the relaxation [s].
    pub duration: f64,
    /// Mass-proportional damping α [1/s].
    pub damping: f64,
}

/// Time integration scheme with its parameters.
#[derive(Clone, Debug)]
pub enum Integrator {
    /// Central differences with a lumped mass matrix.
    Explicit(Explicit),
    /// The θ scheme, or equilibrium without mass.
    Implicit(Box<Implicit>),
}

/// Options of the explicit integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explicit {
    /// Safety factor: fraction of the critical time step [-].
    pub safety: f64,
    /// Largest step [s]; infinite if none is given.
    pub max_step: f64,
    /// Largest change of length of an edge or diagonal in a step, `h max|D|` [-].
    pub largest_strain_increment: f64,
}

/// Options of the implicit integrator, and the unknowns of its systems.
#[derive(Clone, Debug)]
pub struct Implicit {
    /// Time step, unless it has to be cut [s].
    pub step: f64,
    /// The run fails when a step would have to be shorter than this [s].
    pub smallest_step: f64,
    /// Data for equilibrium without mass, with θ = ξ = 1; `None` with mass.
    pub statics: Option<Statics>,
    /// Weight θ of the end velocity in the update of positions [-], ½ … 1.
    pub theta: f64,
    /// Weight ξ of the end forces [-], ½ … 1.
    pub xi: f64,
    /// Whether time is real for viscosity and relaxation; else all has relaxed.
    pub rate_effects: bool,
    /// Whether the mean forces of a step conserve energy and momenta; θ = ξ = ½ then.
    pub energy_momentum: bool,
    /// Largest residual of the momentum, relative to the impulses of the step [-].
    pub tolerance: f64,
    /// Unknowns in the order of elimination.
    pub unknowns: Unknowns,
    /// Size of the linear systems.
    pub systems: SystemSize,
}

impl Implicit {
    /// 1 with mass, 0 without [-].
    pub fn inertia(&self) -> f64 {
        if self.statics.is_some() { 0.0 } else { 1.0 }
    }
}

/// Sizes of the linear systems of implicit steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SystemSize {
    /// Unknown velocity components (degrees of freedom).
    pub unknowns: usize,
    /// Entries of the lower triangle of the matrix.
    pub matrix_entries: usize,
    /// Entries of the factor.
    pub factor_entries: usize,
    /// Floating-point operations of one factorisation.
    pub factor_flops: f64,
    /// Size of matrix, factor and working memory [bytes].
    pub memory_bytes: u64,
}

impl SystemSize {
    fn new(unknowns: &Unknowns) -> Result<Self, SparseError> {
        let matrix = SymmetricMatrix::new(unknowns);
        let factor = Cholesky::new(&matrix)?;
        Ok(Self {
            unknowns: unknowns.count(),
            matrix_entries: matrix.entries(),
            factor_entries: factor.entries(),
            factor_flops: factor.flops(),
            memory_bytes: (matrix.memory() + factor.memory()) as u64,
        })
    }
}

/// Artificial end of the modelled tissue: held nodes, cuts, faces that are not skin. Waves that reach it would be
/// transmitted or reflected differently in reality.
#[derive(Clone, Debug, PartialEq)]
pub struct TissueEnd {
    /// Name of the node set or the cut, for messages.
    pub name: String,
    /// Global numbers of its nodes, ascending.
    pub nodes: Vec<u32>,
}

/// Averaging of the peak force of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ForceAverage {
    /// Over a fraction of the duration of contact, but at least some steps.
    #[default]
    OfContact,
    /// Over this time [s].
    Window(f64),
    /// Filtered instead of averaged.
    Filter(ForceFilter),
}

/// Inputs of the measures.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurePlan {
    /// Thresholds of von Mises stress [Pa], ascending.
    pub stress_thresholds: Vec<f64>,
    /// Thresholds of strain energy density [J/m³], ascending.
    pub energy_density_thresholds: Vec<f64>,
    /// Thresholds of the largest principal strain [-], ascending.
    pub strain_thresholds: Vec<f64>,
    /// Volume for which the strain and the stress exceeded in it are reported [m³].
    pub exceeded_in_volume: f64,
    /// The person who is hit, and where.
    pub person: Option<PersonDocument>,
    /// Averaging of the peak force.
    pub force_average: ForceAverage,
    /// Artificial ends of the modelled tissue.
    pub tissue_ends: Vec<TissueEnd>,
    /// Whether the tissue starts undeformed and at rest in its own frame, and nothing but contact can deform it.
    pub moved_by_contact_alone: bool,
    /// Skin of the tissue from which depth is measured: faces with global nodes; empty if there is no tissue.
    pub tissue_skin: Vec<[u32; 4]>,
}

impl ContactPlan {
    /// Bodies of slave and master of a pair; `None` for a plane.
    pub fn bodies_of(&self, pair: &ContactPair) -> (usize, Option<usize>) {
        let master = match pair.master {
            Master::Surface(master) => Some(self.surface_body[master]),
            Master::Rigid(rigid) => Some(self.rigid_body[rigid]),
            Master::Plane { .. } => None,
        };
        (self.surface_body[pair.slave], master)
    }
    /// Bodies of slave and master of each pair, with the number of the pair.
    pub fn each_bodies(&self) -> impl Iterator<Item = (usize, (usize, Option<usize>))> {
        self.pairs.each().map(|(number, pair)| (number, self.bodies_of(&pair)))
    }
    /// Largest number of contacts in a step: one for each slave node of each pair, two where it may lie in a valley, and
    /// those between nodes. Of every two of many bodies, a usual number: one for each node.
    pub fn most_contacts(&self) -> usize {
        self.most_mesh_contacts() + self.most_rigid_contacts()
    }
    /// As [`ContactPlan::most_contacts`], for the pairs without a rigid side.
    pub fn most_mesh_contacts(&self) -> usize {
        let of_pair = |pair: &ContactPair| {
            let slaves = self.surfaces[pair.slave].nodes.len();
            match pair.master {
                // Valleys; master nodes in the slave; edges, of which a surface has two for each of its nodes.
                Master::Surface(master)
                    if master != pair.slave && self.discretisation != Discretisation::NodeToSurface =>
                {
                    let masters = self.surfaces[master].nodes.len();
                    2 * slaves + masters + 2 * slaves.min(masters)
                }
                _ => slaves,
            }
        };
        let listed = self.pairs.listed().take_while(|(number, _)| *number < self.pairs.mesh_count());
        let every = self.pairs.every_two().surfaces().map(|surface| self.surfaces[surface].nodes.len());
        listed.map(|(_, pair)| of_pair(pair)).sum::<usize>() + every.sum::<usize>()
    }
    /// As [`ContactPlan::most_contacts`], for the pairs with a rigid side: two rigid sides touch in a few points, a face in
    /// one or two, or in a few where the surface has few faces.
    pub fn most_rigid_contacts(&self) -> usize {
        let of_pair = |pair: &ContactPair| {
            let Surface { nodes, faces } = &self.surfaces[pair.slave];
            nodes.len() + 2 * faces.len() + MOST_POINTS
        };
        self.pairs.rigid().0.iter().map(of_pair).sum()
    }
}

impl Plan {
    /// As [`ContactPlan::most_contacts`]; 0 without contact.
    pub fn most_contacts(&self) -> usize {
        self.contact.as_ref().map_or(0, ContactPlan::most_contacts)
    }
    /// Names of slave and master of a pair, by its number; empty without contact.
    pub fn names_of(&self, pair: usize) -> [&str; 2] {
        let Some(contact) = &self.contact else { return [""; 2] };
        if let Some([slave, master]) = contact.listed_names.get(pair) {
            return [slave, master];
        }
        let (slave, master) = contact.bodies_of(&contact.pairs.get(pair));
        [&self.bodies[slave].name, master.map_or("", |master| &self.bodies[master].name)]
    }
    /// Name of a pair in reports, such as "ball–thigh".
    pub fn name_of(&self, pair: usize) -> String {
        self.names_of(pair).join("–")
    }
    /// Bodies that may come into contact with themselves.
    pub fn bodies_that_meet_themselves(&self) -> impl Iterator<Item = &PlanBody> {
        let bodies = |contact: &'_ ContactPlan, pair: &ContactPair| contact.bodies_of(pair);
        let pairs = self
            .contact
            .iter()
            .flat_map(move |contact| contact.pairs.listed().map(move |(_, pair)| bodies(contact, pair)));
        pairs.filter(|(slave, master)| *master == Some(*slave)).map(|(slave, _)| &self.bodies[slave])
    }
    /// Whether the run is quasi-static, without mass.
    pub fn is_static(&self) -> bool {
        matches!(&self.integrator, Integrator::Implicit(implicit) if implicit.statics.is_some())
    }
    /// Number of nodes, those of rigid bodies included.
    pub fn node_count(&self) -> usize {
        self.X.len()
    }
    /// Number of nodes of meshes.
    pub fn mesh_node_count(&self) -> usize {
        self.bodies.iter().filter(|b| b.rigid.is_none()).map(|b| b.nodes.len()).sum()
    }
    /// Number of elements of all bodies.
    pub fn element_count(&self) -> usize {
        self.bodies.last().map_or(0, |b| b.elements.end as usize)
    }
    /// Whether a part has stress relaxation.
    pub fn has_memory(&self) -> bool {
        self.blocks.iter().any(|block| !block.parameters.memory.is_empty())
    }
    /// Buffer for the history seen by recorders, by chunk; empty without stress relaxation.
    pub fn room_for_history(&self) -> Vec<Vec<Row>> {
        if self.has_memory() { ElementForces::no_history(&self.blocks) } else { Vec::new() }
    }
    /// Whether elements may be eroded.
    pub fn erodes(&self) -> bool {
        self.bodies.iter().any(|body| body.erodes)
    }
    /// Whether the stress of a part depends on rate or history, apart from bulk viscosity.
    pub fn is_viscous(&self) -> bool {
        self.blocks.iter().any(|block| block.parameters.is_viscous())
    }
    /// Number of force slots of all blocks, padding included.
    pub fn slot_count(&self) -> usize {
        self.blocks.last().map_or(0, ElementBlock::end_slot)
    }
    /// Position x = X + V_b t + u [m] of a node of a body at a time [s] with displacement u [m]; bodies do not fly before t
    /// = 0.
    pub fn position(&self, body: usize, node: usize, time: f64, u: &Vec3) -> Vec3 {
        self.X[node] + self.bodies[body].flight_velocity * time.max(0.0) + u
    }
    /// Factor from a node's velocity to its momentum: m [kg] along each axis, or the moments of inertia [kg m²] of a rigid
    /// body for its spin.
    pub fn inertia(&self, node: usize) -> Vec3 {
        if self.mass[node] > 0.0 {
            return Vec3::repeat(self.mass[node]);
        }
        self.inverse_mass[node].map(|inverse| 1.0 / inverse)
    }
    /// Whether a node is held or driven along an axis; false for followers, even if their masters are held.
    pub fn holds(&self, node: usize, axis: usize) -> bool {
        self.inverse_mass[node][axis] == 0.0 && !self.assembly.followers().contains(node)
    }
    /// Index of the body that owns a node.
    pub fn body_of_node(&self, node: u32) -> usize {
        self.bodies.partition_point(|b| b.nodes.end <= node)
    }
    /// Index of the body that owns an element.
    pub fn body_of_element(&self, element: u32) -> usize {
        self.bodies.partition_point(|b| b.elements.end <= element)
    }
}
