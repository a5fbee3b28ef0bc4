//! Explicit or implicit steps where the document leaves it open: the scheme with the lower estimated cost.
//!
//! Explicit steps are limited by the crossing time of a wave through an element; implicit ones by the motion, but each
//! solves linear systems. The estimate uses the counts, the wave speeds at rest and the fixed table of [`super::cost`].

use super::budget::Budget;
use super::cost::{FactorSize, StepLoad, element_s};
use super::document::{IntegratorDocument, SceneDocument};
use super::elements::has_averaged_pressure;
use super::scene_body::SceneBody;
use super::validate::estimate::{BYTES_PER_ELEMENT, shortest_crossing, system_bytes};
use crate::mechanics::tensor::Vec3;
use crate::mesh::Cell;
use crate::mesh::surface::boundary_nodes;
use serde::{Deserialize, Serialize};

/// Default number of implicit steps of a run, unless a body moves faster.
const IMPLICIT_STEPS: f64 = 100.0;
/// Largest displacement of a body in a default implicit step, as a fraction of the shortest edge [-].
const FLOWN: f64 = 0.5;
/// Fraction of the boundary nodes that are slaves: one of the two sides.
const SLAVES: f64 = 0.5;

/// The chosen scheme, with the estimated cost of both.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct IntegratorChoice {
    /// Integrator of the run: `explicit` or `implicit`.
    pub chosen: String,
    /// Estimated cost of explicit steps.
    pub explicit: SteppingEstimate,
    /// Estimated cost of implicit steps; null where it was not estimated.
    pub implicit: Option<SteppingEstimate>,
    /// Reason for the choice, in one sentence.
    pub why: String,
}

/// Approximate cost of a time integration scheme.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SteppingEstimate {
    /// Expected time step [s].
    pub step_s: f64,
    /// Number of steps to the end.
    pub steps: f64,
    /// Time of a step on one core [s], from the table of costs.
    pub time_per_step_s: f64,
    /// Time of the run on one core [s].
    pub run_time_s: f64,
}

impl SteppingEstimate {
    fn new(duration: f64, step_s: f64, time_per_step_s: f64) -> Self {
        let steps = (duration / step_s).ceil();
        Self { step_s, steps, time_per_step_s, run_time_s: steps * time_per_step_s }
    }

    /// A phrase such as "1200 steps of 1.000e-6 s, about 12.0 s".
    pub fn in_words(&self) -> String {
        format!("{:.0} steps of {:.3e} s, about {:.3} s", self.steps, self.step_s, self.run_time_s)
    }
}

impl IntegratorChoice {
    /// The estimates and the reason in one line.
    pub fn in_words(&self) -> String {
        let implicit =
            self.implicit.as_ref().map_or_else(String::new, |i| format!("; implicit {}", i.in_words()));
        format!("explicit {}{implicit}: {}", self.explicit.in_words(), self.why)
    }
}

/// The integrator chosen for `auto`, with the reason; `None` where the document gives the integrator. `shortest_edge` of
/// any element [m], infinite without elements.
pub fn choose(
    document: &SceneDocument,
    bodies: &[SceneBody],
    shortest_edge: f64,
    budget: &Budget,
) -> Option<(IntegratorDocument, IntegratorChoice)> {
    let IntegratorDocument::Auto { step_s, theta, energy_gate } = &document.integrator else { return None };
    // Steps of both schemes, and the lower bound of the implicit cost: without matrices.
    let duration = document.end_time_s + document.dynamic_relaxation.as_ref().map_or(0.0, |s| s.duration_s);
    let implicit_step = step_s.unwrap_or_else(|| default_step(document, shortest_edge));
    let stable = IntegratorDocument::SAFETY * shortest_crossing(document, bodies);
    // Without elements there is no critical time step, and both schemes need the same resolution.
    let explicit_step = if stable.is_finite() { stable } else { implicit_step };
    let load = step_load(document, bodies);
    let explicit = SteppingEstimate::new(duration, explicit_step, load.explicit_step_s());
    let least = SteppingEstimate::new(duration, implicit_step, load.implicit_step_s(&FactorSize::default()));

    let (implicit, why) = if document.needs_explicit_steps() {
        (None, "implicit steps support neither softening nor erosion".to_owned())
    } else if document.bodies.iter().zip(bodies).any(|(body, made)| has_averaged_pressure(body, made)) {
        (
            None,
            "tetrahedra that average pressure over nodes make the matrix of implicit steps expensive"
                .to_owned(),
        )
    } else if least.run_time_s >= explicit.run_time_s {
        // Force evaluations alone take longer: no need to analyse the matrix.
        (None, "the force evaluations of implicit steps alone would take longer".to_owned())
    } else if system_bytes(load.nodes as u64, false) > budget.memory_bytes {
        (None, "the matrix of implicit steps would exceed the memory limit".to_owned())
    } else {
        match bodies.iter().map(|b| FactorSize::of(&b.mesh)).sum::<Result<FactorSize, _>>() {
            Err(error) => (None, format!("the matrix of implicit steps cannot be factored: {error}")),
            Ok(factor) => {
                let implicit = SteppingEstimate::new(duration, implicit_step, load.implicit_step_s(&factor));
                let times = explicit.run_time_s / implicit.run_time_s;
                let why = if times > 1.0 {
                    format!("implicit steps are {times:.1} times cheaper")
                } else {
                    format!("explicit steps are {:.1} times cheaper", 1.0 / times)
                };
                (Some(implicit), why)
            }
        }
    };
    // The cheaper of the two.
    let is_implicit = implicit.as_ref().is_some_and(|i| i.run_time_s < explicit.run_time_s);
    let integrator = if is_implicit {
        IntegratorDocument::implicit_with(implicit_step, *theta, *energy_gate)
    } else {
        IntegratorDocument::explicit_with((!stable.is_finite()).then_some(implicit_step), *energy_gate)
    };
    let chosen = if is_implicit { "implicit" } else { "explicit" }.to_owned();
    Some((integrator, IntegratorChoice { chosen, explicit, implicit, why }))
}

/// 1/100 of the run, but no longer than the fastest body takes for half of the shortest edge.
fn default_step(document: &SceneDocument, shortest_edge: f64) -> f64 {
    let speed = |velocity: [f64; 3]| Vec3::from(velocity).norm();
    let fastest = document.bodies.iter().map(|body| speed(body.velocity_m_per_s)).fold(0.0, f64::max);
    // Infinite where no body moves.
    let flown = FLOWN * shortest_edge / fastest;
    (document.end_time_s / IMPLICIT_STEPS).min(flown)
}

fn step_load(document: &SceneDocument, bodies: &[SceneBody]) -> StepLoad {
    let elements: usize = bodies.iter().map(|body| body.mesh.cells.len()).sum();
    let evaluated_bytes = elements * BYTES_PER_ELEMENT as usize;
    let evaluate = |(written, body): (&super::document::BodyDocument, &SceneBody)| -> f64 {
        let of_element = |(entry, cell): (&u32, Cell)| {
            let (part, material) = (&written.parts[*entry as usize], &body.materials[*entry as usize]);
            let kind = cell.kind.element();
            element_s(
                material,
                (kind, part.element(material, kind)),
                [part.shear_viscosity_pa_s > 0.0, part.has_history(material)],
                evaluated_bytes,
            )
        };
        body.part_entry.iter().zip(body.mesh.cells.iter()).map(of_element).sum()
    };
    let touches = document.bodies.len() + document.planes.len() > 1;
    let boundary_nodes_of_all: usize = bodies.iter().map(|body| boundary_nodes(&body.boundary()).len()).sum();
    StepLoad {
        elements,
        forces_s: document.bodies.iter().zip(bodies).map(evaluate).sum(),
        nodes: bodies.iter().map(|body| body.mesh.nodes.len()).sum(),
        slaves: if touches { (SLAVES * boundary_nodes_of_all as f64) as usize } else { 0 },
    }
}
