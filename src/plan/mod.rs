//! The plan: a scene compiled to what it needs. Immutable while it runs; everything not needed is absent.

mod asked;
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
mod rigid;
mod stable_step;
mod statics;
mod stepping;
#[cfg(test)]
mod tests;

pub use asked::CUTS;
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
pub use rigid::{RigidPlan, RigidReport};
pub use stable_step::{ElementsWithin, StableStepReport};
pub use statics::{Statics, Unheld};

use crate::mechanics::contact::rigid_detection::MOST_POINTS;
use crate::mechanics::contact::solvers::Method;
use crate::mechanics::contact::{ContactPair, Discretisation, Master, Surface};
use crate::mechanics::force::{ElementBlock, ElementForces, Erosion};
use crate::mechanics::lanes::Row;
use crate::mechanics::material::Validity;
use crate::mechanics::sparse::{Cholesky, SparseError, SymmetricMatrix, Unknowns};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Cell, Cells, surface};
use crate::scene::document::{FieldName, ForceFilter, PersonDocument, Role};
use serde::Serialize;
use std::borrow::Cow;
use std::ops::Range;

/// What is needed to step one scene. Nodes and elements of all bodies are numbered through, body after body. A rigid body has
/// two nodes, see [`crate::mechanics::rigid`].
#[derive(Debug)]
pub struct Plan {
    /// Name of the scene.
    pub name: String,
    /// The bodies.
    pub bodies: Vec<PlanBody>,
    /// Reference positions X [m], nodes × 3.
    pub X: Vec<Vec3>,
    /// Lumped (row sum) mass [kg], nodes; 0 for the spin of a rigid body and for nodes that follow others, whose masters have it.
    pub mass: Vec<f64>,
    /// 1/m along each axis [1/kg], 0 where the node is held fixed or follows others; 1/I [1/(kg m²)] for the spin of a rigid body; nodes × 3.
    pub inverse_mass: Vec<Vec3>,
    /// The rigid bodies; `None` when there are none.
    pub rigid: Option<RigidPlan>,
    /// Elements, in blocks of one kernel each.
    pub blocks: Vec<ElementBlock>,
    /// Which force contributions each node sums, in which order; and which nodes follow others.
    pub assembly: crate::mechanics::force::Assembly,
    /// Contact, when anything may touch.
    pub contact: Option<ContactPlan>,
    /// Pairs that were asked for and cannot meet before the end; they are not in `contact`.
    pub distant_pairs: Vec<DistantPair>,
    /// Whether elements that nothing has reached yet are left out of a step.
    pub skip_inactive_elements: bool,
    /// Acceleration of gravity [m/s²].
    pub gravity: Option<Vec3>,
    /// What else acts on nodes.
    pub loads: Loads,
    /// Quasi-static loading before the clock starts: in steps of a pseudo-time of 1 s.
    pub preload: Option<Box<Implicit>>,
    /// Settling before the clock starts.
    pub settle: Option<Settle>,
    /// Displacement at the start [m], nodes × 3; empty when all are zero.
    pub initial_u: Vec<Vec3>,
    /// Velocity at the start relative to the body's flight [m/s], nodes × 3; empty when all are zero.
    pub initial_v: Vec<Vec3>,
    /// How to step in time.
    pub integrator: Integrator,
    /// Largest error of the energy balance [-].
    pub energy_gate: f64,
    /// Energy that rounding alone may stir up [J]: below it nothing is known about the balance.
    pub rounding_energy: f64,
    /// What holds the bodies: planes, held and driven nodes. Where nothing does, all may fly along together, and nothing is changed by
    /// it.
    pub holder: Holder,
    /// Simulated time to the end [s].
    pub end_time: f64,
    /// Times [s] that the run hits exactly and records fields at, ascending; the first is 0, the last the end.
    pub field_times: Vec<f64>,
    /// Fields asked for.
    pub fields: Vec<FieldName>,
    /// Contact and energy are recorded every so many steps.
    pub every_steps: u32,
    /// Whether cheaper runs, which error bars come from, go before it.
    pub has_cheaper_runs: bool,
    /// What the measures need.
    pub measures: MeasurePlan,
    /// What was kept, what was left out, and why.
    pub report: PlanReport,
}

/// One body of a plan.
#[derive(Debug)]
pub struct PlanBody {
    /// Name.
    pub name: String,
    /// Role in the story.
    pub role: Role,
    /// Its nodes.
    pub nodes: Range<u32>,
    /// Its elements.
    pub elements: Range<u32>,
    /// Velocity V_b of its frame [m/s]: x = X + V_b t + u.
    pub flight_velocity: Vec3,
    /// Kind and nodes (global) of its elements, in their order.
    pub cells: Cells,
    /// Part of each of its elements, an index into `parts`.
    pub part_of: Vec<u32>,
    /// Names of its parts.
    pub parts: Vec<String>,
    /// How far the law of each part may be believed.
    pub validity: Vec<Validity>,
    /// Whether elements of it may be given up.
    pub erodes: bool,
    /// Its skin at the start: outward faces with global nodes. A rigid body has its centre and no faces.
    pub boundary: Surface,
    /// Its index among the rigid bodies, if it is one.
    pub rigid: Option<usize>,
    /// Mass [kg].
    pub mass: f64,
    /// Σ m X of its nodes [kg m].
    pub first_moment: Vec3,
    /// Share of its polar moment of inertia that `contact.mass_redistribution` takes by moving mass inwards [-].
    pub inertia_lost: f64,
}

impl PlanBody {
    /// Its elements that are left, in the order of their numbers.
    pub fn intact<'a>(&'a self, erosion: &'a Erosion) -> impl Iterator<Item = Cell<'a>> {
        let numbered = self.elements.clone().zip(self.cells.iter());
        numbered.filter(|(element, _)| !erosion.contains(*element)).map(|(_, cell)| cell)
    }

    /// Its skin without the elements that are gone: faces that they have laid bare are in it, their own are not.
    pub fn skin_after(&self, erosion: &Erosion) -> Cow<'_, Surface> {
        if !erosion.elements().iter().any(|element| self.elements.contains(element)) {
            return Cow::Borrowed(&self.boundary);
        }
        let faces = surface::boundary(&self.intact(erosion).collect());
        Cow::Owned(Surface { nodes: surface::boundary_nodes(&faces), faces })
    }
}

/// What may touch what.
#[derive(Debug)]
pub struct ContactPlan {
    /// One surface a body that takes part, in the order of the bodies.
    pub surfaces: Vec<Surface>,
    /// Body of each surface.
    pub surface_body: Vec<usize>,
    /// The pairs; those with a rigid side come last.
    pub pairs: Vec<ContactPair>,
    /// How many of them have no rigid side.
    pub mesh_pairs: usize,
    /// For each pair the bodies of slave and master (`None` for a plane).
    pub pair_bodies: Vec<(usize, Option<usize>)>,
    /// Names of both sides of each pair.
    pub pair_names: Vec<[String; 2]>,
    /// Largest scaled residual of the solver [-].
    pub tolerance: f64,
    /// How contacts of two meshes are made discrete.
    pub discretisation: Discretisation,
    /// The solver of the library that gets `W`, where the scene names one.
    pub solver: Option<Method>,
    /// Whether surfaces are searched for contact with themselves in every step, also where nothing can have come near.
    pub always_looks_at_itself: bool,
}

/// Settling before the clock starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settle {
    /// How long [s].
    pub duration: f64,
    /// Mass-proportional damping α [1/s].
    pub damping: f64,
}

/// How to step in time.
#[derive(Clone, Debug)]
pub enum Integrator {
    /// Central differences.
    Explicit(Explicit),
    /// The θ scheme, or equilibrium without mass.
    Implicit(Box<Implicit>),
}

/// Options of the explicit integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explicit {
    /// Share of the stable step [-].
    pub safety: f64,
    /// Largest step [s]; infinite when none was given.
    pub max_step: f64,
    /// Largest change of length of an edge or diagonal in a step, `h max|D|` [-].
    pub largest_strain_increment: f64,
}

/// Options of the implicit integrator, and the unknowns of its systems.
#[derive(Clone, Debug)]
pub struct Implicit {
    /// Step, unless it has to be cut [s].
    pub step: f64,
    /// A step that would have to be shorter than this ends the run [s].
    pub smallest_step: f64,
    /// What equilibrium without mass needs, with θ = ξ = 1; `None` with mass.
    pub statics: Option<Statics>,
    /// Weight θ of the end velocity in the motion [-], ½ … 1.
    pub theta: f64,
    /// Weight ξ of the end forces [-], ½ … 1.
    pub xi: f64,
    /// Whether the mean forces of a step conserve energy and momenta; θ = ξ = ½ then.
    pub energy_momentum: bool,
    /// Largest residual of the momentum, relative to the impulses of the step [-].
    pub tolerance: f64,
    /// Unknowns in the order of elimination.
    pub unknowns: Unknowns,
    /// What its systems cost.
    pub systems: SystemSize,
}

impl Implicit {
    /// 1 with mass, 0 without [-].
    pub fn inertia(&self) -> f64 {
        if self.statics.is_some() { 0.0 } else { 1.0 }
    }
}

/// Sizes of the linear systems of implicit steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SystemSize {
    /// Unknowns.
    pub unknowns: usize,
    /// Entries of the matrix, its lower triangle.
    pub matrix_entries: usize,
    /// Entries of the factor.
    pub factor_entries: usize,
    /// Floating-point operations of a factorisation.
    pub factor_flops: f64,
    /// Bytes of matrix, factor and working memory.
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

/// Where the tissue of the model ends: held nodes, cuts, what is no skin. What reaches it would go on in reality, or be reflected.
#[derive(Clone, Debug, PartialEq)]
pub struct TissueEnd {
    /// What it is, in words.
    pub name: String,
    /// Its nodes (global), ascending.
    pub nodes: Vec<u32>,
}

/// What the peak force of a contact is averaged over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ForceAverage {
    /// A share of the contact's duration, and some steps at least.
    #[default]
    OfContact,
    /// This time [s].
    Window(f64),
    /// Filtered instead.
    Filter(ForceFilter),
}

/// What the measures need.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurePlan {
    /// Thresholds of von Mises stress [Pa], ascending.
    pub stress_thresholds: Vec<f64>,
    /// Thresholds of strain energy density [J/m³], ascending.
    pub energy_density_thresholds: Vec<f64>,
    /// Thresholds of the largest principal strain [-], ascending.
    pub strain_thresholds: Vec<f64>,
    /// Who is hit, and where.
    pub person: Option<PersonDocument>,
    /// What the peak force is averaged over.
    pub force_average: ForceAverage,
    /// Where the tissue of the model ends.
    pub tissue_ends: Vec<TissueEnd>,
    /// Whether the tissue starts undeformed and at rest in its own frame, and nothing but contact can deform it.
    pub moved_by_contact_alone: bool,
    /// Skin of the tissue from which depth is measured: faces with global nodes; empty when there is no tissue.
    pub tissue_skin: Vec<[u32; 4]>,
}

impl ContactPlan {
    /// The most contacts that a step can have: one for each slave node of each pair, two where it may lie in a valley, and what is met
    /// between nodes.
    pub fn most_contacts(&self) -> usize {
        self.most_mesh_contacts() + self.most_rigid_contacts()
    }
    /// As [`ContactPlan::most_contacts`], of the pairs without a rigid side.
    pub fn most_mesh_contacts(&self) -> usize {
        let of_pair = |pair: &ContactPair| {
            let slaves = self.surfaces[pair.slave].nodes.len();
            match pair.master {
                // In valleys; nodes of the master in the slave; edges, of which a surface has two for each of its nodes.
                Master::Surface(master)
                    if master != pair.slave && self.discretisation != Discretisation::NodeToSurface =>
                {
                    let masters = self.surfaces[master].nodes.len();
                    2 * slaves + masters + 2 * slaves.min(masters)
                }
                _ => slaves,
            }
        };
        self.pairs[..self.mesh_pairs].iter().map(of_pair).sum()
    }
    /// As [`ContactPlan::most_contacts`], of the pairs with a rigid side; two rigid sides touch in a few points, a face in one or two,
    /// or in a few where it is one of few.
    pub fn most_rigid_contacts(&self) -> usize {
        let of_pair = |pair: &ContactPair| {
            let Surface { nodes, faces } = &self.surfaces[pair.slave];
            nodes.len() + 2 * faces.len() + MOST_POINTS
        };
        self.pairs[self.mesh_pairs..].iter().map(of_pair).sum()
    }
}

impl Plan {
    /// As [`ContactPlan::most_contacts`]; 0 without contact.
    pub fn most_contacts(&self) -> usize {
        self.contact.as_ref().map_or(0, ContactPlan::most_contacts)
    }
    /// The bodies that may touch themselves.
    pub fn bodies_that_meet_themselves(&self) -> impl Iterator<Item = &PlanBody> {
        let pairs = self.contact.iter().flat_map(|contact| &contact.pair_bodies);
        pairs.filter(|(slave, master)| *master == Some(*slave)).map(|(slave, _)| &self.bodies[*slave])
    }
    /// Whether the run is without mass.
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
    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.bodies.last().map_or(0, |b| b.elements.end as usize)
    }
    /// Whether stresses relax.
    pub fn has_memory(&self) -> bool {
        self.blocks.iter().any(|block| !block.parameters.prony.is_none())
    }
    /// Room for the history that recorders see, chunk by chunk; none where nothing relaxes.
    pub fn room_for_history(&self) -> Vec<Vec<Row>> {
        if self.has_memory() { ElementForces::no_history(&self.blocks) } else { Vec::new() }
    }
    /// Whether elements may be given up.
    pub fn erodes(&self) -> bool {
        self.bodies.iter().any(|body| body.erodes)
    }
    /// Whether the stress of a part depends on rate or history, bulk viscosity apart.
    pub fn is_viscous(&self) -> bool {
        self.blocks.iter().any(|block| block.parameters.is_viscous())
    }
    /// Number of slots of all blocks, padding included.
    pub fn slot_count(&self) -> usize {
        self.blocks.last().map_or(0, ElementBlock::end_slot)
    }
    /// Position x = X + V_b t + u [m] of a node of a body at a time [s] with displacement u [m]; nothing flies before 0.
    pub fn position(&self, body: usize, node: usize, time: f64, u: &Vec3) -> Vec3 {
        self.X[node] + self.bodies[body].flight_velocity * time.max(0.0) + u
    }
    /// What a node's velocity is multiplied with to give its momentum: m [kg] along each axis, or the moments of inertia [kg m²] of
    /// a rigid body for its spin.
    pub fn inertia(&self, node: usize) -> Vec3 {
        if self.mass[node] > 0.0 {
            return Vec3::repeat(self.mass[node]);
        }
        self.inverse_mass[node].map(|inverse| 1.0 / inverse)
    }
    /// Whether a node is held or driven along an axis; one that follows others is not, whoever holds them.
    pub fn holds(&self, node: usize, axis: usize) -> bool {
        self.inverse_mass[node][axis] == 0.0 && !self.assembly.followers().contains(node)
    }
    /// The body that owns a node.
    pub fn body_of_node(&self, node: u32) -> usize {
        self.bodies.partition_point(|b| b.nodes.end <= node)
    }
    /// The body that owns an element.
    pub fn body_of_element(&self, element: u32) -> usize {
        self.bodies.partition_point(|b| b.elements.end <= element)
    }
}
