//! Approximate memory of a run by component, from the counts and the sizes of the stored types.

use super::compiled::Plan;
use super::integrator::Integrator;
use super::report::MemoryReport;
use crate::mechanics::contact::solution::compliance::MOST_NODES;
use crate::mechanics::contact::stencil::Stencil;
use crate::mechanics::contact::{ContactPair, Master, Reaction, Surface};
use crate::mechanics::force::ElementBlock;
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;
use crate::scene::document::FieldName;

impl MemoryReport {
    /// Memory of a plan whose element forces take `forces_bytes`.
    pub(super) fn new(plan: &Plan, forces_bytes: usize) -> Self {
        let bytes = |count: usize, size: usize| (count * size) as u64;
        let (nodes, vector) = (plan.node_count(), size_of::<Vec3>());
        let rows = plan.blocks.iter().map(|block| block.batch_count() * block.history_rows()).sum();
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
        let report = Self {
            plan_bytes: bytes(nodes, 2 * vector + size_of::<f64>())
                + bytes(initial, vector)
                + systems
                + bodies
                + plan.assembly.memory() as u64,
            elements_bytes: plan.blocks.iter().map(ElementBlock::memory).sum::<usize>() as u64,
            state_bytes: bytes(nodes, (2 + viscous) * vector) + bytes(rows, size_of::<Row>()),
            step_bytes: bytes(nodes, (3 + viscous) * vector) + forces_bytes as u64,
            contact_bytes: contact_bytes(plan),
            fields_bytes: fields_bytes(plan),
            bytes_per_element: 0.0,
        };
        Self { bytes_per_element: report.total_bytes() as f64 / plan.element_count().max(1) as f64, ..report }
    }
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
    // Positions at the end of a step are needed by contact alone.
    let positions = plan.node_count() * size_of::<Vec3>();
    (surfaces + leaves + candidates * BYTES_PER_CANDIDATE + compliance + positions) as u64
}

fn fields_bytes(plan: &Plan) -> u64 {
    let requested = |fields: &[FieldName]| plan.fields.iter().filter(|f| fields.contains(f)).count();
    let scalars = requested(&[FieldName::VonMises, FieldName::Pressure, FieldName::PrincipalStrain]);
    let vectors = requested(&[FieldName::Displacement, FieldName::Velocity]);
    let tensors = requested(&[FieldName::ElementCauchyStress]);
    // Nodal scalars are averages and need the volume around each node. All need the corners of the elements.
    let nodal = (scalars + usize::from(scalars > 0)) * 8 + vectors * 24;
    let element = tensors * 56 + usize::from(scalars + tensors > 0) * 32;
    (nodal * plan.node_count() + element * plan.element_count()) as u64
}
