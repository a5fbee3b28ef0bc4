//! Reports on a plan and its scene.

use super::body::PlanBody;
use super::by_pair::{MOST_LISTED_BODIES, MOST_LISTED_PAIRS};
use super::capped_bulk;
use super::compiled::Plan;
use super::cost;
use super::integrator::Integrator;
use super::memory::BufferSizes;
use super::named_materials::NamedMaterialReport;
use super::omitted::omitted;
use super::report::{
    BlockReport, IntegratorReport, MemoryReport, PairReport, PlanReport, RefinementReport, RigidReport,
};
use super::stable_step::StableSteps;
use crate::mechanics::contact::solution::solvers::Method;
use crate::mechanics::contact::{ContactPair, Master};
use crate::mechanics::force::{ElementBlock, Formulation};
use crate::mechanics::rigid::RigidBody;
use crate::scene::document::Keep;
use crate::scene::{Scene, SceneBody};

/// Relative amount by which a step may exceed its nominal length, as in the stepper.
const ROUNDING: f64 = 1e-9;

/// Report of a compiled plan, given the critical time steps of its elements and the size of their buffers.
pub(super) fn report(plan: &Plan, scene: &Scene, steps: &StableSteps, buffers: BufferSizes) -> PlanReport {
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
    let evaluated_bytes = plan.blocks.iter().map(ElementBlock::memory).sum::<usize>() + buffers.forces;
    let blocks: Vec<BlockReport> = plan
        .blocks
        .iter()
        .enumerate()
        .take(MOST_LISTED_BODIES)
        .map(|(i, block)| of_block(plan, block, steps.smallest_of(i), evaluated_bytes))
        .collect();
    let pairs: Vec<PairReport> = of_pairs(plan);
    let memory = MemoryReport::new(plan, scene, buffers);
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
    let capped_bulk_moduli = capped_bulk::in_words(plan, scene);
    kept.extend(capped_bulk_moduli.clone());
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
        capped_bulk_moduli,
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
    BlockReport {
        body: body.name.clone(),
        parts: body.parts_of(block),
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
        history: p.history_titles(),
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

impl RefinementReport {
    /// Reports of all locally refined bodies of a plan.
    pub(super) fn of(plan: &Plan, scene: &Scene) -> Vec<Self> {
        let of_body = |(body, scene_body): (&PlanBody, &SceneBody)| {
            let [elements_before, elements_split] = scene_body.refined?;
            let hanging_nodes = scene_body.mesh.hanging.len();
            let elements = body.elements.len();
            Some(Self { body: body.name.clone(), elements_before, elements_split, elements, hanging_nodes })
        };
        plan.bodies.iter().zip(&scene.bodies).filter_map(of_body).collect()
    }
}

impl RigidReport {
    /// Reports of all rigid bodies of a plan.
    pub(super) fn of(plan: &Plan) -> Vec<Self> {
        let Some(rigid) = &plan.rigid else { return Vec::new() };
        let of_body = |(body, &index): (&RigidBody, &usize)| Self {
            body: plan.bodies[index].name.clone(),
            shape: body.shape.name().into(),
            mass_kg: body.mass,
            inertia_kg_m2: body.inertia.into(),
        };
        rigid.bodies.iter().zip(&rigid.of_body).map(of_body).collect()
    }
}
