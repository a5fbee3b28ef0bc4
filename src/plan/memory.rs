//! Approximate memory of a run by component, from the counts and the sizes of the stored types.

use super::body::PlanBody;
use super::compiled::Plan;
use super::integrator::Integrator;
use super::report::MemoryReport;
use crate::mechanics::contact::solution::compliance::MOST_NODES;
use crate::mechanics::contact::stencil::Stencil;
use crate::mechanics::contact::{Contact, ContactPair, Master, Reaction, Surface};
use crate::mechanics::force::ElementBlock;
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;
use crate::scene::document::{FieldName, Role};
use crate::scene::{Scene, SceneBody};

/// The program, and the buffers of a recording: resident memory of a run of `two_bars`, with glibc.
const PROGRAM_BYTES: u64 = 30_000_000;
/// What the start takes beside what stays, most of which the allocator keeps: what runs of `ball_on_block/scene_L1.json` and its refinement
/// take beyond all else, with glibc.
const START_BYTES_PER_ELEMENT: usize = 900;

/// Number of copies of frames on the way to the thread of a recording: how many steps a run may be ahead.
pub const FRAME_COPIES: usize = 16;
/// The same of the fields, each as large as the state: how many field times a run may be ahead.
pub const FIELD_COPIES: usize = 2;
/// Fraction of all possible contacts in a copy of a frame.
const CONTACTS: f64 = 0.05;

/// Bytes of an element and of a node of the tissue in the field of the stress over the depth: vertices and depths of points; line through the
/// stresses around a node, edges from it. And of a point its values, from which those exceeded in volumes are found.
const BYTES_PER_TISSUE_ELEMENT: usize = 120;
const BYTES_PER_TISSUE_NODE: usize = 110;
const BYTES_PER_TISSUE_POINT: usize = 3 * size_of::<(f64, f64)>();

/// Sizes of buffers of a run that were made with the plan [bytes].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BufferSizes {
    /// Element forces.
    pub forces: usize,
    /// Bound of the critical time step by the assembled mesh; 0 without.
    pub bound: usize,
}

impl MemoryReport {
    /// Memory of a run of a plan and its scene.
    pub(super) fn new(plan: &Plan, scene: &Scene, buffers: BufferSizes) -> Self {
        let bytes = |count: usize, size: usize| (count * size) as u64;
        let (nodes, vector) = (plan.node_count(), size_of::<Vec3>());
        let viscous = usize::from(plan.is_viscous());
        let bodies: u64 = plan
            .bodies
            .iter()
            .map(|b| {
                bytes(b.cells.connectivity().len() + b.cells.len(), 4) + bytes(b.boundary.faces.len(), 16)
            })
            .sum();
        let systems = match &plan.integrator {
            Integrator::Explicit(_) => 0,
            Integrator::Implicit(implicit) => implicit.systems.memory_bytes,
        } + plan.preload.as_ref().map_or(0, |preload| preload.systems.memory_bytes);
        let initial = plan.initial_u.len() + plan.initial_v.len();
        // Each run has fractions of its own beside those of the plan.
        let fractions = plan.fractions.iter().map(|rows| size_of_val(&rows[..]) as u64).sum::<u64>();
        let report = Self {
            program_bytes: PROGRAM_BYTES,
            start_bytes: bytes(plan.element_count(), START_BYTES_PER_ELEMENT),
            scene_bytes: scene.bodies.iter().map(body_bytes).sum::<usize>() as u64,
            plan_bytes: bytes(nodes, 3 * vector + size_of::<f64>())
                + bytes(initial, vector)
                + systems
                + bodies
                + fractions
                + plan.assembly.memory() as u64,
            elements_bytes: plan.blocks.iter().map(ElementBlock::memory).sum::<usize>() as u64,
            state_bytes: bytes(nodes, (2 + viscous) * vector) + history_bytes(plan) as u64 + fractions,
            step_bytes: bytes(nodes, (3 + viscous) * vector) + (buffers.forces + buffers.bound) as u64,
            contact_bytes: contact_bytes(plan),
            fields_bytes: fields_bytes(plan),
            measures_bytes: measures_bytes(plan),
            frames_bytes: frames_bytes(plan),
            bytes_per_element: 0.0,
        };
        report.per_element(plan.element_count())
    }

    /// That of a symmetric scene of which a sector is computed: its state and the work on it are those of the sector, and what is unfolded from it.
    pub(super) fn with_sector(self, of_sector: &Self, whole: &Plan) -> Self {
        let unfolded = 3 * size_of::<Vec3>() * whole.node_count() + recorded_history_bytes(whole);
        let report = Self {
            plan_bytes: self.plan_bytes + of_sector.plan_bytes,
            elements_bytes: self.elements_bytes + of_sector.elements_bytes,
            state_bytes: of_sector.state_bytes + unfolded as u64,
            step_bytes: of_sector.step_bytes,
            contact_bytes: of_sector.contact_bytes,
            ..self
        };
        report.per_element(whole.element_count())
    }
}

fn body_bytes(body: &SceneBody) -> usize {
    let mesh = &body.mesh;
    let of_elements = mesh.part_of.len() + body.law_of.len() + body.part_entry.len();
    size_of_val(&mesh.nodes[..])
        + size_of_val(&body.axes[..])
        + size_of::<u32>() * (mesh.cells.connectivity().len() + mesh.cells.len() + of_elements)
}

fn measures_bytes(plan: &Plan) -> u64 {
    let has_skin = !plan.measures.tissue_skin.is_empty();
    let [of_element, of_node] =
        if has_skin { [BYTES_PER_TISSUE_ELEMENT, BYTES_PER_TISSUE_NODE] } else { [0; 2] };
    let of_body = |body: &PlanBody| {
        let points: usize = body.cells.iter().map(|cell| cell.kind.element().point_count()).sum();
        BYTES_PER_TISSUE_POINT * points + of_element * body.cells.len() + of_node * body.nodes.len()
    };
    plan.bodies.iter().filter(|body| body.role == Role::Tissue).map(of_body).sum::<usize>() as u64
}

/// Copies of frames: motion of all nodes with the fields, and where the recorder has it; between them that of the boundaries, or of all nodes
/// of bodies that erode, and the contacts.
fn frames_bytes(plan: &Plan) -> u64 {
    let vectors = if plan.reads_velocities() { 3 } else { 1 };
    let kept = plan.nodes_to_keep().count();
    let of_nodes = (FIELD_COPIES * vectors + 1) * plan.node_count() + FRAME_COPIES * kept;
    let contacts = (CONTACTS * plan.most_contacts() as f64) as usize;
    let of_contacts = FRAME_COPIES * contacts * (size_of::<Contact>() + size_of::<Reaction>());
    (of_nodes * size_of::<Vec3>() + of_contacts + FIELD_COPIES * recorded_history_bytes(plan)) as u64
}

/// History that recorders read [bytes], as [`Plan::room_for_history`] makes room for it.
fn recorded_history_bytes(plan: &Plan) -> usize {
    if plan.has_memory() { history_bytes(plan) } else { 0 }
}

/// History of all elements [bytes].
fn history_bytes(plan: &Plan) -> usize {
    let rows: usize = plan.blocks.iter().map(|block| block.batch_count() * block.history_rows()).sum();
    rows * size_of::<Row>()
}

/// Bytes of a face in contact: corners, size, neighbours and faces around its corners; and of its leaf in the tree of a
/// master.
const BYTES_PER_FACE: usize = 72;
const BYTES_PER_LEAF: usize = 128;
/// Bytes of a node on a surface in contact: number, position, snapshot.
const BYTES_PER_SURFACE_NODE: usize = 40;
/// Fraction of the slave nodes that are candidates at a time, each with contact, row and reaction: a patch, not the
/// surface.
const CANDIDATES: f64 = 0.2;
const BYTES_PER_CANDIDATE: usize = 344 + 2 * size_of::<Stencil>() + size_of::<Reaction>();

fn contact_bytes(plan: &Plan) -> u64 {
    let Some(contact) = &plan.contact else { return 0 };
    let surface = |s: &Surface| s.faces.len() * BYTES_PER_FACE + s.nodes.len() * BYTES_PER_SURFACE_NODE;
    let surfaces: usize = contact.surfaces.iter().map(surface).sum();
    let of_master = |pair: &ContactPair| match pair.master {
        Master::Surface(master) => contact.surfaces[master].faces.len() * BYTES_PER_LEAF,
        Master::Plane { .. } | Master::Rigid(_) => 0,
    };
    let nodes = |surface: usize| contact.surfaces[surface].nodes.len();
    let every = || contact.pairs.every_two().surfaces();
    let leaves = contact.pairs.listed().map(|(_, pair)| of_master(pair)).sum::<usize>()
        + every().map(|surface| contact.surfaces[surface].faces.len() * BYTES_PER_LEAF).sum::<usize>();
    let slaves = contact.pairs.listed().map(|(_, pair)| nodes(pair.slave)).sum::<usize>()
        + every().map(nodes).sum::<usize>();
    let candidates = (CANDIDATES * slaves as f64) as usize;
    // Implicit steps store the compliance of these nodes: the response of all to a unit impulse at each.
    let is_explicit = matches!(plan.integrator, Integrator::Explicit(_));
    let compliance = if is_explicit { 0 } else { 8 * (3 * candidates.min(MOST_NODES)).pow(2) };
    // Positions at the end of a step, and in self-contact those at rest.
    let of_itself = contact.pairs.listed().any(|(_, pair)| pair.master == Master::Surface(pair.slave));
    let positions = (1 + usize::from(of_itself)) * plan.node_count() * size_of::<Vec3>();
    (surfaces + leaves + candidates * BYTES_PER_CANDIDATE + compliance + positions) as u64
}

fn fields_bytes(plan: &Plan) -> u64 {
    let requested = |fields: &[FieldName]| plan.fields.iter().filter(|f| fields.contains(f)).count();
    let scalars = requested(&[FieldName::VonMises, FieldName::Pressure, FieldName::PrincipalStrain]);
    let vectors = requested(&[FieldName::Displacement, FieldName::Velocity]);
    let tensors = requested(&[FieldName::ElementCauchyStress]);
    // Nodal scalars are averages of sums and need the volume around each node. All need the corners of the elements.
    let nodal = (2 * scalars + usize::from(scalars > 0)) * 8 + vectors * 24;
    let element = tensors * 104 + usize::from(scalars + tensors > 0) * 40;
    (nodal * plan.node_count() + element * plan.element_count()) as u64
}
