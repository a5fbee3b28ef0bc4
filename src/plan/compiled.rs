//! The compiled scene: all that a run reads.

use super::body::PlanBody;
use super::contact_plan::ContactPlan;
use super::distant::DistantPair;
use super::holder::{Hold, Holder};
use super::integrator::{DynamicRelaxation, Implicit, Integrator};
use super::loads::Loads;
use super::measure_plan::MeasurePlan;
use super::report::PlanReport;
use super::rigid::RigidPlan;
use super::sector::mapping::Sector;
use crate::mechanics::contact::ContactPair;
use crate::mechanics::force::{AssembledRows, ElementBlock, ElementForces};
use crate::mechanics::lanes::Row;
use crate::mechanics::material::Validity;
use crate::mechanics::rigid::{Pose, RigidBody, Rotation};
use crate::mechanics::tensor::Vec3;
use crate::scene::document::FieldName;

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
    /// Initial velocity relative to the rigid-body velocity V of the body [m/s], nodes × 3; empty when all are zero.
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
    /// What is computed instead, if the scene is symmetric.
    pub sector: Option<SectorPlan>,
}

/// What is computed of a symmetric scene instead of the whole.
#[derive(Debug)]
pub struct SectorPlan {
    /// Plan of the sector.
    pub plan: Box<Plan>,
    /// How the whole follows from it.
    pub sector: Sector,
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
    /// Position of a node at the start of the run [m].
    pub fn start_of(&self, node: u32) -> Vec3 {
        self.X[node as usize] + self.initial_u.get(node as usize).copied().unwrap_or_default()
    }
    /// Whether the stress of a part depends on its history: by a memory or by internal variables of its law.
    pub fn has_memory(&self) -> bool {
        self.blocks.iter().any(|block| block.parameters.has_memory())
    }
    /// The nodes needed between the look times: boundary nodes, and in bodies that erode all that may become such.
    pub fn nodes_to_keep(&self) -> impl Iterator<Item = u32> {
        self.bodies.iter().flat_map(|body| {
            let (all, boundary) =
                if body.erodes { (body.nodes.clone(), &[][..]) } else { (0..0, &body.boundary.nodes[..]) };
            all.chain(boundary.iter().copied())
        })
    }
    /// Buffer for the history seen by recorders, by chunk; empty where no stress depends on history.
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
    /// Whether what is evaluated at the field times needs velocities: as a field, for viscous stresses, or for the strain rates that
    /// are compared with those of the tests of a law.
    pub fn reads_velocities(&self) -> bool {
        self.fields.contains(&FieldName::Velocity) || self.is_viscous() || self.compares_rates()
    }
    /// Whether strain rates are compared with those of tests: a part has them, or is a set of the library, whose tests had some.
    pub fn compares_rates(&self) -> bool {
        let has_rates = |law: &Validity| law.strain_rate.is_some();
        self.bodies
            .iter()
            .any(|body| body.validity.iter().any(has_rates) || body.sets.iter().any(Option::is_some))
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
    /// Rigid bodies of the plan; may be empty.
    pub fn rigid_bodies(&self) -> &[RigidBody] {
        self.rigid.as_ref().map_or(&[], |rigid| &rigid.bodies)
    }
    /// Pose of a rigid body at a time [s] with displacement `u` [m] of its centre.
    pub fn pose(
        &self,
        rigid: &RigidPlan,
        index: usize,
        time: f64,
        u: &[Vec3],
        orientation: Rotation,
    ) -> Pose {
        let centre = rigid.bodies[index].centre as usize;
        Pose { centre: self.position(rigid.of_body[index], centre, time, &u[centre]), orientation }
    }
    /// Supports of the bodies selected by `is_of`; `on_plane` if they may touch a plane.
    pub fn supports(&self, is_of: impl Fn(usize) -> bool, on_plane: bool) -> Holder {
        Holder(std::array::from_fn(|axis| {
            let of_axis = self.loads.prescribed.iter().enumerate();
            let driven = of_axis.filter(|(_, p)| p.axis == axis && is_of(self.body_of_node(p.node)));
            let driven: Vec<usize> = driven.map(|(index, _)| index).collect();
            let nodes = self.bodies.iter().enumerate().filter(|(b, _)| is_of(*b));
            // Of a rigid body the centre, not the spin.
            let end =
                |body: &PlanBody| if body.rigid.is_some() { body.nodes.start + 1 } else { body.nodes.end };
            let nodes = nodes.flat_map(|(_, body)| body.nodes.start as usize..end(body) as usize);
            // Driven nodes are held nodes with a prescribed velocity.
            let without_mass = nodes.filter(|node| self.holds(*node, axis)).count();
            match (on_plane || without_mass > driven.len(), driven.is_empty()) {
                (true, _) => Hold::Fixed,
                (false, false) => Hold::Driven(driven),
                (false, true) => Hold::Free,
            }
        }))
    }
}
