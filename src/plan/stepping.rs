//! Time integration of a plan: options from the scene, and the unknowns of implicit systems.

use super::integrator::{Explicit, Implicit, Integrator, SystemSize};
use super::parts::{CompileError, Parts};
use super::statics::Statics;
use crate::mechanics::force::ElementBlock;
use crate::mechanics::sparse::Unknowns;
use crate::scene::document::{IntegratorDocument, SceneDocument};

/// Default smallest implicit step, as a fraction of the step [-].
const SMALLEST_STEP: f64 = 1e-4;

/// The integrator; an implicit one includes the order of elimination.
pub(super) fn integrator(document: &IntegratorDocument, parts: &Parts) -> Result<Integrator, CompileError> {
    Ok(match document {
        IntegratorDocument::Auto { .. } => return Err(CompileError::NoIntegrator),
        IntegratorDocument::Explicit { safety_factor, max_step_s, largest_strain_increment, .. } => {
            Integrator::Explicit(Explicit {
                safety: *safety_factor,
                max_step: max_step_s.unwrap_or(f64::INFINITY),
                largest_strain_increment: *largest_strain_increment,
            })
        }
        IntegratorDocument::Implicit {
            step_s,
            theta,
            xi,
            energy_momentum,
            newton_tolerance,
            smallest_step_s,
            ..
        } => {
            let unknowns = unknowns(parts)?;
            Integrator::Implicit(Box::new(Implicit {
                step: *step_s,
                smallest_step: smallest_step_s.unwrap_or(SMALLEST_STEP * step_s),
                statics: None,
                theta: *theta,
                xi: xi.unwrap_or(*theta),
                rate_effects: true,
                energy_momentum: *energy_momentum,
                tolerance: *newton_tolerance,
                systems: SystemSize::new(&unknowns)?,
                unknowns,
            }))
        }
        IntegratorDocument::QuasiStatic { step_s, real_time, newton_tolerance, smallest_step_s, .. } => {
            let smallest = smallest_step_s.unwrap_or(SMALLEST_STEP * step_s);
            let steps = [*step_s, smallest];
            let options = quasi_static(parts, steps, *newton_tolerance)?;
            Integrator::Implicit(Box::new(Implicit { rate_effects: *real_time, ..options }))
        }
    })
}

/// The unknowns of implicit steps, in the order of elimination.
fn unknowns(parts: &Parts) -> Result<Unknowns, CompileError> {
    let is_free = |node: usize, axis: usize| parts.inverse_mass[node][axis] > 0.0;
    let elements = parts.bodies.iter().flat_map(|body| body.cells.iter());
    // Nodes that average pressure couple their patches.
    let patches: Vec<Vec<u32>> = parts.blocks.iter().flat_map(ElementBlock::patches).collect();
    let nodes = elements.map(|cell| cell.nodes).chain(patches.iter().map(Vec::as_slice));
    Ok(Unknowns::with_followers(parts.X.len(), is_free, nodes, parts.followers.clone())?)
}

/// Options of equilibrium without mass, with the step and the smallest step [s] of the pseudo-time.
fn quasi_static(
    parts: &Parts,
    [step, smallest_step]: [f64; 2],
    tolerance: f64,
) -> Result<Implicit, CompileError> {
    let unknowns = unknowns(parts)?;
    Ok(Implicit {
        step,
        smallest_step,
        statics: Some(Statics::new(parts)),
        theta: 1.0,
        xi: 1.0,
        rate_effects: false,
        energy_momentum: false,
        tolerance,
        systems: SystemSize::new(&unknowns)?,
        unknowns,
    })
}

/// Quasi-static loading before the clock starts, over a pseudo-time of 1 s.
pub(super) fn preload(
    document: &SceneDocument,
    parts: &Parts,
) -> Result<Option<Box<Implicit>>, CompileError> {
    let Some(preload) = &document.preload else { return Ok(None) };
    let step = 1.0 / f64::from(preload.steps.max(1));
    let options = quasi_static(parts, [step, SMALLEST_STEP * step], preload.newton_tolerance)?;
    Ok(Some(Box::new(options)))
}

/// Linear and quadratic bulk viscosity [-]; zero for implicit steps.
pub(super) fn bulk_viscosities(document: &IntegratorDocument) -> [f64; 2] {
    match document {
        IntegratorDocument::Explicit { linear_bulk_viscosity, quadratic_bulk_viscosity, .. } => {
            [*linear_bulk_viscosity, *quadratic_bulk_viscosity]
        }
        _ => [0.0; 2],
    }
}
