//! The integrators of a plan.

use super::explicit::ExplicitStepper;
use super::implicit::ImplicitStepper;
use super::stepper::Stepper;
use crate::mechanics::force::Threads;
use crate::mechanics::sparse::SparseError;
use crate::plan::{Integrator, Plan};

/// The integrator of the preload, if there is one.
pub(super) fn preloader<'p>(
    plan: &'p Plan,
    threads: Threads,
) -> Result<Option<Box<dyn Stepper + 'p>>, SparseError> {
    let Some(options) = &plan.preload else { return Ok(None) };
    Ok(Some(Box::new(ImplicitStepper::new(plan, options, threads)?)))
}

/// The integrator that the plan names.
pub(super) fn stepper<'p>(plan: &'p Plan, threads: Threads) -> Result<Box<dyn Stepper + 'p>, SparseError> {
    Ok(match &plan.integrator {
        Integrator::Explicit(options) => Box::new(ExplicitStepper::new(plan, *options, threads)),
        Integrator::Implicit(options) => Box::new(ImplicitStepper::new(plan, options, threads)?),
    })
}
