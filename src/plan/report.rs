//! Report of a plan: what it kept, what it omitted and why, and its estimated cost.

use super::by_pair::{MOST_LISTED_BODIES, MOST_LISTED_PAIRS};
use super::memory::MemoryReport;
use super::named_materials::NamedMaterialReport;
use super::omitted::{Omitted, omitted};
use super::refinement::RefinementReport;
use super::rigid::RigidReport;
use super::stable_step::{StableStepReport, StableSteps};
use super::{Integrator, Plan, SystemSize, cost};
use crate::mechanics::contact::solution::solvers::Method;
use crate::mechanics::contact::{ContactPair, Master};
use crate::mechanics::force::{ElementBlock, Formulation};
use crate::scene::document::Keep;
use crate::scene::{IntegratorChoice, Scene};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Report of a plan, in numbers and words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct PlanReport {
    /// Number of nodes of meshes.
    pub nodes: usize,
    /// Number of elements of all bodies.
    pub elements: usize,
    /// Approximate memory of a run [bytes].
    pub memory_bytes: u64,
    /// Memory by component [bytes].
    pub memory: MemoryReport,
    /// Initial time step [s]: the smallest critical time step times the safety factor, or the scene's `max_step_s`.
    pub stable_step_s: f64,
    /// What determines the critical time step.
    pub stable_step: StableStepReport,
    /// Number of steps to the end at that step; a run that crushes elements or stretches fibres shortens the step, and
    /// takes more.
    pub expected_steps: u64,
    /// Run time of these steps on one core [s] if every element is active in every step, from a fixed table of costs,
    /// without recording.
    pub expected_run_time_s: f64,
    /// Element blocks, by kernel; of more than 64 the first.
    pub blocks: Vec<BlockReport>,
    /// Number of all element blocks.
    pub block_count: usize,
    /// Parts whose material is a set of the library.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub named_materials: Vec<NamedMaterialReport>,
    /// Bodies that are locally refined.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinements: Vec<RefinementReport>,
    /// Rigid bodies with their mass and inertia; of more than 64 the first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_bodies: Vec<RigidReport>,
    /// Contact pairs that are computed, with their surfaces and settings; of more than 64 the first.
    pub pairs: Vec<PairReport>,
    /// Number of all contact pairs that are computed.
    pub pair_count: usize,
    /// Time integration scheme with its parameters and, for implicit steps, the size of the system.
    pub integrator: IntegratorReport,
    /// Integrator, blocks, rigid bodies and pairs in words.
    pub kept: Vec<String>,
    /// What is absent, each with its reason.
    pub omitted: Vec<Omitted>,
    /// What is kept though the scene may not need it, because it was requested.
    pub restored: Vec<Keep>,
}

/// Time integration of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct IntegratorReport {
    /// `explicit`, `implicit` or `quasi_static`.
    pub kind: String,
    /// Intended time step [s].
    pub step_s: f64,
    /// Weight θ of the end of the step [-]; null for explicit and quasi-static steps.
    pub theta: Option<f64>,
    /// Size of the linear systems of implicit steps; null for explicit steps.
    pub systems: Option<SystemSize>,
    /// How the scheme was chosen, where the scene leaves it open (`auto`), with the estimated cost of both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<IntegratorChoice>,
}

impl IntegratorReport {
    fn new(integrator: &Integrator, stable_step_s: f64, choice: Option<IntegratorChoice>) -> Self {
        match integrator {
            Integrator::Explicit(_) => {
                Self { kind: "explicit".into(), step_s: stable_step_s, theta: None, systems: None, choice }
            }
            Integrator::Implicit(implicit) => Self {
                kind: if implicit.statics.is_some() { "quasi_static" } else { "implicit" }.into(),
                step_s: implicit.step,
                theta: implicit.statics.is_none().then_some(implicit.theta),
                systems: Some(implicit.systems),
                choice,
            },
        }
    }

    fn in_words(&self) -> Option<String> {
        let size = self.systems?;
        let kind =
            self.theta.map_or_else(|| "quasi-static".into(), |theta| format!("implicit (θ = {theta})"));
        Some(format!(
            "{kind} steps of {:.3e} s: {} unknowns, a factor of {:.2} M entries in {:.3} GFLOP",
            self.step_s,
            size.unknowns,
            1e-6 * size.factor_entries as f64,
            1e-9 * size.factor_flops
        ))
    }
}

/// Elements of one body with the same law and formulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct BlockReport {
    /// Name of the body.
    pub body: String,
    /// Names of the parts in this block.
    pub parts: Vec<String>,
    /// Number of elements in this block.
    pub elements: usize,
    /// Their kind: `hex8`, `wedge6`, `tet10`, `tet4`.
    pub kind: String,
    /// Name of the constitutive law.
    pub law: String,
    /// Number of fibre families that are evaluated.
    pub fibre_families: usize,
    /// Element formulation and integration.
    pub formulation: String,
    /// Shear viscosity [Pa s].
    pub shear_viscosity_pa_s: f64,
    /// Number of terms of the Prony series.
    pub prony_branches: usize,
    /// Whether its stress softens.
    pub softens: bool,
    /// Whether elements may be eroded.
    pub erodes: bool,
    /// Smallest initial critical time step of its elements, without safety factor [s].
    pub smallest_stable_step_s: f64,
    /// Element-steps per second and core assumed for the run time.
    pub element_steps_per_s: f64,
}

/// A contact pair: its sides, the discretisation, friction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct PairReport {
    /// Names of the sides, slave first.
    pub name: String,
    /// Number of nodes on the slave surface; 0 for a rigid body.
    pub slave_nodes: usize,
    /// Number of faces of the master; null for a plane or a rigid body.
    pub master_faces: Option<usize>,
    /// Names of the rigid shapes among slave and master.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_shapes: Vec<String>,
    /// Coulomb friction μ [-].
    pub friction: f64,
    /// Unknowns per contact: one if frictionless, otherwise three.
    pub unknowns_per_contact: u32,
}

/// Relative amount by which a step may exceed its nominal length, as in the stepper.
const ROUNDING: f64 = 1e-9;

/// Report of a compiled plan, given the critical time steps of its elements and the size of their force buffers [bytes].
pub(super) fn report(plan: &Plan, scene: &Scene, steps: &StableSteps, forces_bytes: usize) -> PlanReport {
    let (safety, max_step) = match &plan.integrator {
        Integrator::Explicit(explicit) => (explicit.safety, explicit.max_step),
        Integrator::Implicit(_) => (1.0, f64::INFINITY),
    };
    let stable_step_s = max_step.min(safety * steps.smallest());
    let integrator = IntegratorReport::new(&plan.integrator, stable_step_s, scene.choice.clone());
    let step_s = integrator.step_s;
    let relaxation = plan.dynamic_relaxation.map_or(0.0, |s| s.duration);
    // Field times are hit exactly, by equal steps from one to the next.
    let stops = plan.field_times.windows(2).map(|pair| pair[1] - pair[0]).chain([relaxation]);
    let expected_steps = stops.map(|interval| (interval / step_s - ROUNDING).ceil().max(0.0) as u64).sum();
    let evaluated_bytes = plan.blocks.iter().map(ElementBlock::memory).sum::<usize>() + forces_bytes;
    let blocks: Vec<BlockReport> = plan
        .blocks
        .iter()
        .enumerate()
        .take(MOST_LISTED_BODIES)
        .map(|(i, block)| of_block(plan, block, steps.smallest_of(i), evaluated_bytes))
        .collect();
    let pairs: Vec<PairReport> = of_pairs(plan);
    let memory = MemoryReport::new(plan, forces_bytes);
    let mut rigid_bodies = RigidReport::of(plan);
    rigid_bodies.truncate(MOST_LISTED_BODIES);
    let words =
        blocks.iter().map(BlockReport::in_words).chain(rigid_bodies.iter().map(RigidReport::in_words));
    // What was kept, in words.
    let choice =
        scene.choice.iter().map(|choice| format!("{} steps, chosen: {}", choice.chosen, choice.in_words()));
    let mut kept: Vec<String> = choice.chain(integrator.in_words()).collect();
    kept.extend(statics_in_words(plan));
    let refinements = RefinementReport::of(plan, scene);
    kept.extend(refinements.iter().map(RefinementReport::in_words));
    kept.extend(words);
    let (block_count, rigid_count) = (plan.blocks.len(), plan.rigid_bodies().len());
    if block_count > blocks.len() {
        kept.push(format!("{block_count} element blocks, of which the first {} are listed", blocks.len()));
    }
    if rigid_count > rigid_bodies.len() {
        kept.push(format!(
            "{rigid_count} rigid bodies, of which the first {} are listed",
            rigid_bodies.len()
        ));
    }
    kept.extend(pairs.iter().map(PairReport::in_words));
    let pair_count = plan.contact.as_ref().map_or(0, |contact| contact.pairs.len());
    if pair_count > pairs.len() {
        kept.push(format!("{pair_count} contact pairs, of which the first {} are listed", pairs.len()));
    }
    let solver = plan.contact.as_ref().and_then(|contact| contact.solver);
    let is_explicit = matches!(plan.integrator, Integrator::Explicit(_));
    kept.extend(solver.map(|solver| solver_in_words(solver, is_explicit)));
    if is_explicit
        && !plan.blocks.is_empty()
        && !plan.skip_inactive_elements
        && !scene.document.keeps(Keep::InactiveElements)
    {
        kept.push(
            "inactive elements: gravity, dynamic relaxation or initial motion moves all nodes from the start"
                .into(),
        );
    }
    PlanReport {
        nodes: plan.mesh_node_count(),
        elements: plan.element_count(),
        memory_bytes: memory.total_bytes(),
        memory,
        stable_step_s,
        stable_step: steps.report(&plan.blocks, &plan.bodies, (safety, max_step)),
        expected_steps,
        expected_run_time_s: cost::run_time_s(plan, expected_steps, evaluated_bytes),
        integrator,
        kept,
        blocks,
        block_count,
        named_materials: NamedMaterialReport::of(scene),
        refinements,
        rigid_bodies,
        pairs,
        pair_count,
        omitted: omitted(plan, scene),
        restored: scene.document.solver.keep.clone(),
    }
}

/// The quasi-static preload or run, in words.
fn statics_in_words(plan: &Plan) -> Vec<String> {
    let mut words = Vec::new();
    let run = match &plan.integrator {
        Integrator::Implicit(implicit) => implicit.statics.as_ref(),
        Integrator::Explicit(_) => None,
    };
    if let Some(preload) = &plan.preload {
        let steps = (1.0 / preload.step).round();
        words.push(format!(
            "quasi-static preload in {steps} load steps: {} unknowns",
            preload.unknowns.count()
        ));
    }
    let preload = plan.preload.as_ref().and_then(|preload| preload.statics.as_ref());
    for under_constrained in run.or(preload).iter().flat_map(|statics| &statics.under_constrained) {
        words.push(format!(
            "{}: under-constrained, {} of 6 rigid motions are left to contact; its quasi-static matrix is stabilised, its equilibrium is not",
            plan.bodies[under_constrained.body].name, under_constrained.motions
        ));
    }
    words
}

/// The chosen contact solver and its cost, in words.
fn solver_in_words(solver: Method, is_explicit: bool) -> String {
    let by_products = solver == Method::AcceleratedGradient && !is_explicit;
    let how = if by_products { "matrix-free" } else { "W formed in every step" };
    format!("contact problems solved by {}, {how}", solver.name())
}

fn of_block(
    plan: &Plan,
    block: &ElementBlock,
    smallest_stable_step_s: f64,
    evaluated_bytes: usize,
) -> BlockReport {
    let (p, body) = (&block.parameters, &plan.bodies[block.body]);
    let parts: BTreeSet<u32> =
        block.elements.iter().map(|e| body.part_of[(e - body.elements.start) as usize]).collect();
    BlockReport {
        body: body.name.clone(),
        parts: parts.into_iter().map(|part| body.parts[part as usize].clone()).collect(),
        elements: block.elements.len(),
        kind: body.cells.kind((block.elements[0] - body.elements.start) as usize).table().name.into(),
        law: p.material.name().into(),
        fibre_families: p.material.family_count(),
        formulation: match p.formulation {
            Formulation::MeanDilatation if p.has_single_precision(block.kind) => {
                "mean dilatation, single precision"
            }
            Formulation::MeanDilatation => "mean dilatation",
            Formulation::Full => "full integration",
            Formulation::NodalPressure => "averaged nodal pressure (all elements in every step)",
            Formulation::Reduced => "one point, stabilised",
        }
        .into(),
        shear_viscosity_pa_s: p.shear_viscosity,
        prony_branches: p.memory.prony.branches().len(),
        softens: p.memory.softening.onset.is_finite(),
        erodes: p.erosion.is_some(),
        smallest_stable_step_s,
        element_steps_per_s: cost::element_steps_per_s(block, evaluated_bytes),
    }
}

fn of_pairs(plan: &Plan) -> Vec<PairReport> {
    let Some(contact) = &plan.contact else { return Vec::new() };
    let of_pair = |(index, pair): (usize, ContactPair)| {
        let sides = plan.rigid.as_ref().map_or([None; 2], |rigid| rigid.sides_of(index));
        let shapes = sides.iter().flatten().map(|body| &plan.rigid_bodies()[*body as usize].shape);
        PairReport {
            name: plan.name_of(index),
            slave_nodes: if sides[0].is_some() { 0 } else { contact.surfaces[pair.slave].nodes.len() },
            master_faces: match pair.master {
                Master::Surface(master) => Some(contact.surfaces[master].faces.len()),
                Master::Plane { .. } | Master::Rigid(_) => None,
            },
            rigid_shapes: shapes.map(|shape| shape.name().to_owned()).collect(),
            friction: pair.law.mu(),
            unknowns_per_contact: pair.law.unknowns(),
        }
    };
    contact.pairs.each().take(MOST_LISTED_PAIRS).map(of_pair).collect()
}

impl BlockReport {
    fn in_words(&self) -> String {
        let Self {
            body,
            elements,
            kind,
            formulation,
            law,
            fibre_families,
            shear_viscosity_pa_s,
            prony_branches,
            softens,
            erodes,
            ..
        } = self;
        let fibres = match fibre_families {
            0 => String::new(),
            1 => " with 1 fibre family".into(),
            n => format!(" with {n} fibre families"),
        };
        let viscous = if *shear_viscosity_pa_s > 0.0 {
            format!(", viscosity {shear_viscosity_pa_s} Pa s")
        } else {
            String::new()
        };
        let relaxing = match prony_branches {
            0 => String::new(),
            n => format!(", Prony series of {n} with the energy of each branch"),
        };
        let softening = if *softens { ", softening" } else { "" };
        let eroding = if *erodes { ", with erosion" } else { "" };
        format!(
            "{body}: {elements} {kind}, {formulation}, {law}{fibres}{viscous}{relaxing}{softening}{eroding}"
        )
    }
}

impl PairReport {
    /// The master in words: its number of faces, or its rigid shape.
    pub fn master_in_words(&self) -> String {
        let rigid_master = self.rigid_shapes.get(usize::from(self.slave_nodes == 0));
        match (self.master_faces, rigid_master) {
            (Some(faces), _) => format!("{faces} faces"),
            (None, Some(shape)) => format!("a rigid {shape}"),
            (None, None) => "a plane".into(),
        }
    }

    fn in_words(&self) -> String {
        let slave = match self.slave_nodes {
            0 => self.rigid_shapes.first().map_or_else(String::new, |shape| format!("a rigid {shape}")),
            nodes => format!("{nodes} slave nodes"),
        };
        let master = self.master_in_words();
        let unknowns = if self.unknowns_per_contact == 1 { "1 unknown" } else { "3 unknowns" };
        format!(
            "contact {}: {slave} against {master}, friction {}, {unknowns} per contact",
            self.name, self.friction
        )
    }
}
