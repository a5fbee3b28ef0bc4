//! What the plan kept, what it left out, and why.

use super::Plan;
use crate::mechanics::contact::Master;
use crate::mechanics::force::{ElementBlock, ElementForces, SweepInput, Threads};
use crate::mechanics::material::Material;
use crate::mechanics::tensor::Vec3;
use crate::scene::document::SceneDocument;
use serde::Serialize;

/// Element-steps per second and core that the run time is estimated with: a fixed table, never a stopwatch, so that a
/// scene always gets the same plan.
const ELEMENT_STEPS_PER_SECOND: f64 = 3.0e6;

/// The plan in figures and words.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of elements.
    pub elements: usize,
    /// Bytes of the plan and one state, about.
    pub memory_bytes: u64,
    /// Stable step at the start [s].
    pub stable_step_s: f64,
    /// Steps to the end at that step.
    pub expected_steps: u64,
    /// Expected run time on one core [s], from a fixed table of costs (never a stopwatch).
    pub expected_run_time_s: f64,
    /// Element, material and count of each block; slave, master and friction of each pair; …
    pub kept: Vec<String>,
    /// What is absent, each with its reason.
    pub left_out: Vec<LeftOut>,
}

/// Something that the plan does without.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

/// Describes a compiled plan.
pub(super) fn report(plan: &Plan, document: &SceneDocument) -> PlanReport {
    let stable_step_s = plan.explicit.max_step.min(plan.explicit.safety * stable_step(plan));
    let settling = plan.settle.map_or(0.0, |s| s.duration);
    let expected_steps = ((plan.end_time + settling) / stable_step_s).ceil() as u64;
    PlanReport {
        nodes: plan.node_count(),
        elements: plan.element_count(),
        memory_bytes: memory(plan),
        stable_step_s,
        expected_steps,
        expected_run_time_s: expected_steps as f64 * plan.element_count() as f64 / ELEMENT_STEPS_PER_SECOND,
        kept: kept(plan),
        left_out: left_out(plan, document),
    }
}

/// Stable step at the start [s], safety not applied.
fn stable_step(plan: &Plan) -> f64 {
    let rest;
    let u = if plan.initial_u.is_empty() {
        rest = vec![Vec3::zeros(); plan.node_count()];
        &rest
    } else {
        &plan.initial_u
    };
    let zero = vec![0.0; plan.slot_count()];
    let input = SweepInput { u, inverse_step: 0.0, dilatation: &zero, viscous_pressure: &zero };
    let mut forces = ElementForces::new(&plan.blocks);
    forces.sweep(&Threads::ONE, &plan.blocks, &input);
    (0..plan.blocks.len()).map(|block| forces.totals(block).stable_step.0).fold(f64::INFINITY, f64::min)
}

fn memory(plan: &Plan) -> u64 {
    // Positions, masses and the plan's initial state; u, v, forces, positions and end positions of a run.
    let node = size_of::<Vec3>() * 8 + size_of::<f64>();
    // Dilatation and viscous pressure of the state.
    let slot = 2 * size_of::<f64>();
    let forces = ElementForces::new(&plan.blocks).memory();
    let blocks: usize = plan.blocks.iter().map(ElementBlock::memory).sum();
    let bodies: usize = plan.bodies.iter().map(|b| b.hexes.len() * 36 + b.skin.faces.len() * 40).sum();
    (plan.node_count() * node + plan.slot_count() * slot + blocks + forces + bodies + plan.assembly.memory())
        as u64
}

fn kept(plan: &Plan) -> Vec<String> {
    let mut kept: Vec<String> = plan.blocks.iter().map(|block| describe_block(plan, block)).collect();
    if let Some(contact) = &plan.contact {
        for pair in &contact.pairs {
            let master = match pair.master {
                Master::Surface(surface) => format!("{} faces", contact.surfaces[surface].faces.len()),
                Master::Plane { .. } => "a plane".into(),
            };
            let slaves = contact.surfaces[pair.slave].nodes.len();
            kept.push(format!(
                "contact {}: {slaves} slave nodes against {master}, friction {}",
                pair.name, pair.mu
            ));
        }
    }
    kept
}

fn describe_block(plan: &Plan, block: &ElementBlock) -> String {
    let p = &block.parameters;
    let law = match p.material {
        Material::MooneyRivlin(_) => "Mooney–Rivlin".to_owned(),
        Material::NeoHookean(_) => "neo-Hookean".to_owned(),
        Material::CoupledNeoHookean(_) => "coupled neo-Hookean".to_owned(),
        Material::HolzapfelGasserOgden(_) => {
            format!("Holzapfel–Gasser–Ogden with {} fibre families", p.material.family_count())
        }
    };
    let formulation = if p.mean_dilatation { "mean dilatation" } else { "full integration" };
    format!("{}: {} hex8, {formulation}, {law}", plan.bodies[block.body].name, block.elements.len())
}

fn left_out(plan: &Plan, document: &SceneDocument) -> Vec<LeftOut> {
    let mut list = Vec::new();
    let mut leave = |absent: bool, what: &str, why: &str| {
        if absent {
            list.push(LeftOut { what: what.into(), why: why.into() });
        }
    };
    leave(plan.contact.is_none(), "contact", "the scene has no pair that may touch");
    let frictionless = plan.contact.as_ref().is_some_and(|c| c.pairs.iter().all(|p| p.mu == 0.0));
    leave(frictionless, "tangential reactions", "every pair is frictionless: one unknown a contact");
    leave(plan.gravity.is_none(), "gravity", "the scene gives none");
    leave(plan.settle.is_none(), "settling", "the scene asks for none");
    leave(plan.blocks.iter().all(|b| b.parameters.material.family_count() == 0), "fibres", "no law has any");
    leave(plan.initial_u.is_empty(), "initial deformation", "every body starts undeformed");
    leave(plan.initial_v.is_empty(), "initial spin", "no body spins");
    leave(document.record.fields.is_empty(), "stress fields", "the scene records none");
    leave(true, "history variables", "every law is elastic");
    list
}
