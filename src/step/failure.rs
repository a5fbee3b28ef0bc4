//! Diagnosis of a failed run: cause, place, time, and remedy.

use super::interrupt::Interrupt;
use super::state::State;
use crate::mechanics::force::{BlockTotals, ElementBlock, stretch_rate};
use crate::mechanics::tensor::Vec3;
use crate::mesh::Cell;
use crate::plan::Plan;
use serde::{Deserialize, Serialize};

/// Why a run or a job failed, as a machine-readable code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = JobFailureCause))]
#[serde(rename_all = "snake_case")]
pub enum FailureCause {
    /// The accepted scene is no longer valid (a mesh is missing, or the engine changed).
    InvalidScene,
    /// An element's Jacobian became zero or negative.
    ElementInverted,
    /// The critical time step became too small to finish.
    StepCollapsed,
    /// The critical time step collapsed because the material softens: waves of some direction have no real speed there.
    EllipticityLost,
    /// The contact solver did not reach its tolerance.
    ContactNotConverged,
    /// No reactions can stop the contacting bodies: they are squeezed or wedged between parts that cannot yield.
    ContactJammed,
    /// An implicit step did not converge at any admissible size.
    NewtonNotConverged,
    /// In a quasi-static step, a load on an unsupported body is not balanced.
    #[serde(alias = "nothing_holds")]
    UnderConstrained,
    /// The error of the energy balance exceeded its limit.
    EnergyGate,
    /// The step is longer than a rigid body's rotation allows.
    StepTooLong,
    /// A fibre was stretched beyond what its exponential can represent.
    FibreOverstretched,
    /// A number became infinite or not a number.
    NotFinite,
    /// The wall-clock budget ran out.
    Deadline,
    /// The run took more steps, or recorded more, than its estimate allows.
    Budget,
    /// The worker process was lost more often than a job may lose one.
    WorkerLost,
    /// The process of the run was refused memory.
    OutOfMemory,
    /// The process of the run was killed, or crashed.
    Killed,
    /// A defect of the program stopped the run: it panicked.
    Panicked,
    /// The recording could not be written.
    RecordingFailed,
    /// The machine or the engine failed, not the scene.
    Internal,
}

/// Location of the failed element in the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = FailedElement))]
pub struct ElementPlace {
    /// Name of the body.
    pub body: String,
    /// Name of the part.
    pub part: String,
    /// Index of the element in the body, from 0.
    pub element: u32,
    /// Centre of the element at that time [m]; absent if not finite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_m: Option<[f64; 3]>,
}

/// Diagnosis of a failed run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = JobFailure))]
#[error("{message} {remedy}")]
pub struct Failure {
    /// Machine-readable cause of the failure.
    pub cause: FailureCause,
    /// What happened, with values and limits, in a sentence.
    pub message: String,
    /// Suggested change of scene or settings.
    pub remedy: String,
    /// Simulated time [s]; absent if no run had begun, or the time is not finite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Number of the failed step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<u64>,
    /// Failed element, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element: Option<ElementPlace>,
}

impl Failure {
    /// A failure outside a run: with the remedy of its cause, but no time and no place.
    pub fn of_no_run(cause: FailureCause, message: impl Into<String>) -> Self {
        let (message, remedy) = (message.into(), cause.remedy().into());
        Self { cause, message, remedy, time_s: None, step: None, element: None }
    }

    /// Where it failed, in words, if that is an element.
    pub fn place(&self) -> Option<String> {
        let place = self.element.as_ref()?;
        let at = place.position_m.map(|[x, y, z]| format!(", at ({x:.6}, {y:.6}, {z:.6}) m"));
        let (element, part, body) = (place.element, &place.part, &place.body);
        Some(format!("element {element} of part {part} of body {body}{}", at.unwrap_or_default()))
    }

    /// A failure at the time of `state`, with the remedy of its cause and no place.
    pub(super) fn new(state: &State, cause: FailureCause, message: String) -> Self {
        let time_s = Some(state.time).filter(|time| time.is_finite());
        Self { time_s, step: Some(state.step), ..Self::of_no_run(cause, message) }
    }

    /// A run that exceeded its wall-clock budget.
    pub(super) fn deadline(plan: &Plan, state: &State) -> Self {
        let message = format!("The wall-clock budget ran out at t = {:.4e} s.", state.time);
        let failure = Self::new(state, FailureCause::Deadline, message);
        if plan.has_error_bars {
            return Self { remedy: format!("{} {WITHOUT_ERROR_BARS}", failure.remedy), ..failure };
        }
        failure
    }
}

/// Additional remedy if runs for error bars come first.
const WITHOUT_ERROR_BARS: &str = "Or skip the error bars, whose runs precede it (`--no-error-bars`, or \
    `solver.error_bars` = \"none\").";

impl FailureCause {
    /// The code as serialised.
    pub fn name(self) -> String {
        let written = serde_json::to_value(self).ok();
        written.and_then(|code| code.as_str().map(str::to_owned)).unwrap_or_else(|| "failed".into())
    }

    /// Suggested remedy, in plain words.
    pub fn remedy(self) -> &'static str {
        match self {
            // Scene and elements.
            Self::InvalidScene => {
                "Send the scene to /v1/jobs/validate, which reports every problem in detail."
            }
            Self::ElementInverted => {
                "Try `formulation: \"reduced\"` for the named part, lower the speed, or end the run before this time."
            }
            Self::StepCollapsed => {
                "Look for a crushed element or a stiffening fibre at the reported location; lower the speed, or try implicit \
                 steps (`integrator.kind`)."
            }
            Self::EllipticityLost => {
                "Lower the speed, or give the named part a law or parameters fitted at such stretches: refining \
                 the mesh or the step does not help."
            }
            Self::StepTooLong => "Give a smaller `integrator.max_step_s`, or a slower spin.",
            Self::FibreOverstretched => {
                "Lower the exponent of the law (k2 of fibres, b, C2, 1/c), or use parameters fitted at this stretch."
            }
            // Solvers and gates.
            Self::ContactNotConverged => {
                "Raise `contact.tolerance`, name another solver (`solver.contact` = \"hybrid\"), lower the friction, or avoid bodies \
                 in contact over many redundant nodes."
            }
            Self::ContactJammed => {
                "Look for bodies that are squeezed between parts that cannot yield (prescribed, fixed, planes), and move these \
                 apart; if friction wedges them, lower it."
            }
            Self::NewtonNotConverged => {
                "Lower `integrator.step_s` (try a fifth), in an implicit run raise `theta` to 0.6, or refine the mesh \
                 where it deforms most; for shocks and waves use the explicit integrator. In a `preload` give more `steps`, or a \
                 larger `newton_tolerance` (try 1e-7)."
            }
            Self::UnderConstrained => {
                "Fix some of its nodes, add friction or another body that supports it, or use explicit or implicit dynamics, \
                 in which it accelerates; a `preload` loads every body, including one that is to fall later."
            }
            Self::EnergyGate => {
                "In an explicit run lower `integrator.safety_factor` (try 0.5); in an implicit one lower `step_s`, raise `theta` to \
                 0.6 or set `energy_momentum`; in a quasi-static one give surfaces in contact whose nodes coincide different \
                 numbers of elements; or refine the mesh where the energy changes most."
            }
            Self::NotFinite => {
                "This is a defect of the scene or of the engine; keep the scene and report it."
            }
            // Limits of time, memory and storage.
            Self::Deadline => "Allow more wall-clock time, coarsen the mesh, or shorten the run.",
            Self::Budget => {
                "End the run before this time, record less, or enlarge the elements that limit the step at the end; or run it with a \
                 larger budget."
            }
            Self::WorkerLost => {
                "Check the memory of the machine and the log of the service; a smaller scene may succeed."
            }
            Self::OutOfMemory => {
                "Use fewer or larger elements or fewer threads, or ask the operator of the service for more memory."
            }
            Self::Killed => {
                "Check the system log around the end of the run for what killed it, or a lack of memory; a smaller \
                 scene may succeed."
            }
            Self::Panicked => "Report this with the id of the job and the service log around its end.",
            Self::Internal => {
                "Try again with fewer threads; if the failure persists, keep the scene and report it."
            }
            Self::RecordingFailed => {
                "Free some disk space, record less (fewer fields, a larger interval), or record to a writable folder."
            }
        }
    }
}

/// Why a step could not be completed.
#[derive(Debug)]
pub(super) enum Stop {
    /// The step failed with a diagnosis.
    Failed(Failure),
    /// Interrupted by the user or the time limit; the state is that of the step before.
    Interrupted(Interrupt),
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

/// Checks the extremes of a block for elements that violate their law.
pub(super) fn check_block(
    plan: &Plan,
    block: &ElementBlock,
    totals: &BlockTotals,
    state: &State,
) -> Result<(), Failure> {
    let diagnose = |cause: FailureCause, slot: usize, message: String| {
        let element = block.elements.get(slot).copied();
        let place = element.map(|e| place_element(plan, state, e));
        Failure { element: place, ..Failure::new(state, cause, message) }
    };
    // Inverted elements.
    let (j, slot) = totals.smallest_j;
    if j <= -1.0 {
        let message =
            format!("An element inverted: its Jacobian fell to J = {:.4} (limit: above 0).", 1.0 + j);
        return Err(diagnose(FailureCause::ElementInverted, slot, message));
    }
    // Overstretched fibres and exponential laws.
    let (exponent, slot) = totals.fibre_exponent;
    let limit = block.parameters.exponent_limit(block.kind);
    if exponent > limit {
        let law = block.parameters.material;
        let what = if law.family_count() > 0 { "A fibre" } else { "The tissue" };
        let message = format!(
            "{what} is overstretched: the exponent of its energy ({}) reached {exponent:.1} (limit {limit}).",
            law.name()
        );
        return Err(diagnose(FailureCause::FibreOverstretched, slot, message));
    }
    // Non-finite stresses or strains.
    let (stable, slot) = totals.stable_step;
    if !(j.is_finite() && stable.is_finite() && totals.strain.is_finite()) {
        return Err(diagnose(
            FailureCause::NotFinite,
            slot,
            "A stress or strain became infinite or not a number.".into(),
        ));
    }
    Ok(())
}

/// Ratio to the initial critical time step below which the step has collapsed.
const COLLAPSE: f64 = 1e-6;

/// Checks that a step [s] has not collapsed; `element` is what makes it so short.
pub(super) fn check_collapse(
    plan: &Plan,
    state: &State,
    step: f64,
    element: impl Fn() -> Option<u32>,
) -> Result<(), Failure> {
    let limit = COLLAPSE * plan.report.stable_step_s;
    if step >= limit {
        return Ok(());
    }
    let element = element();
    let softened = element.and_then(|e| lost_ellipticity(plan, &state.u, e));
    let cause = softened.as_ref().map_or(FailureCause::StepCollapsed, |_| FailureCause::EllipticityLost);
    let message = format!(
        "The step fell to {step:.3e} s, below {limit:.3e} s (10⁻⁶ of the initial critical time step): elements are being \
         crushed or stretched without bound.{}",
        softened.unwrap_or_default()
    );
    let element = element.map(|e| place_element(plan, state, e));
    Err(Failure { element, ..Failure::new(state, cause, message) })
}

/// The element that is stretched or crushed fastest along one of its lengths (edges, diagonals).
pub(super) fn fastest_stretched(plan: &Plan, u: &[Vec3], v: &[Vec3]) -> Option<u32> {
    let rate = |cell: Cell| {
        let along = |&(a, b): &(usize, usize)| {
            let (a, b) = (cell.nodes[a] as usize, cell.nodes[b] as usize);
            let dX = plan.X[b] - plan.X[a];
            stretch_rate(&dX, &(dX + (u[b] - u[a])), &(v[b] - v[a]))
        };
        let lengths = cell.kind.element().lengths();
        lengths.iter().map(along).fold(0.0, f64::max)
    };
    let rates = plan.bodies.iter().flat_map(|b| b.elements.clone().zip(b.cells.iter().map(rate)));
    rates.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(element, _)| element)
}

/// Describes the loss of ellipticity in an element whose step collapsed; `None` if waves of every direction have a real
/// speed.
fn lost_ellipticity(plan: &Plan, u: &[Vec3], element: u32) -> Option<String> {
    let slot = |block: &ElementBlock| block.elements.iter().position(|e| *e == element);
    let found = plan.blocks.iter().find_map(|block| slot(block).map(|slot| (block, slot)));
    let least = found.and_then(|(block, slot)| block.least_acoustic_eigenvalue(slot, u))?;
    (least < 0.0).then(|| {
        format!(
            " The material of the element has lost ellipticity (smallest eigenvalue of its acoustic tensor {least:.3e} Pa): its law \
             softens there, and the deformation localises."
        )
    })
}

/// Location of an element in the model.
fn place_element(plan: &Plan, state: &State, element: u32) -> ElementPlace {
    let b = plan.body_of_element(element);
    let body = &plan.bodies[b];
    let local = element - body.elements.start;
    let nodes = body.cells.nodes(local as usize);
    let center: Vec3 =
        nodes.iter().map(|node| state.position(plan, b, *node as usize)).sum::<Vec3>() / nodes.len() as f64;
    ElementPlace {
        body: body.name.clone(),
        part: body.parts[body.part_of[local as usize] as usize].clone(),
        element: local,
        position_m: Some(center.into()).filter(|x: &[f64; 3]| x.iter().all(|c| c.is_finite())),
    }
}
