//! One implicit step of a given size: Newton's iteration on the end velocity, with the contact law solved in every
//! iteration.
//!
//! Linearised at v_k, the momentum balance is `S (v − v_k) + g(v_k) = Cᵀ p`, and the contacts see `C v = W p + C
//! v_free` with `v_free = v_k − S⁻¹ g`, `W = C S⁻¹ Cᵀ`. The matrix S is updated only when convergence with the present
//! one is slow. The residual `g − Cᵀ p` decreases along the step from (v_k, p_k) to (v, p), which a line search can
//! enforce.

use super::contact_law::{closing, solve_contacts};
use super::iterate::{Iterate, Step, energy};
use super::midpoint::turn_on;
use super::system::{Linearisation, System};
use crate::mechanics::contact::detection::known::is_known;
use crate::mechanics::contact::solution::compliance::add_impulse;
use crate::mechanics::contact::{Reaction, RigidSides};
use crate::mechanics::force::ElementForces;
use crate::mechanics::sparse::SparseError;
use crate::mechanics::tensor::Vec3;
use crate::plan::Prescribed;
use crate::step::contact::ContactStep;
use crate::step::failure::{Failure, FailureCause, Stop};
use crate::step::interrupt::Ask;
use crate::step::loads;
use crate::step::phase::Phase;
use crate::step::rigid::RigidStep;

/// Maximum number of iterations per step.
const MOST_ITERATIONS: u32 = 30;
/// Estimated number of remaining iterations above which the matrix is updated.
const PATIENCE: f64 = 8.0;
/// Maximum number of halvings in a line search.
const MOST_HALVINGS: u32 = 6;
/// Sufficient decrease: fraction of the decrease predicted for a full step that a shortened one must achieve.
const SUFFICIENT: f64 = 1e-4;
/// Rounds of search for contacts closed by the reactions.
const MOST_ROUNDS: u32 = 4;
/// The same in quasi-static steps, where contacts close one after the other until a body is supported.
const MOST_STATIC_ROUNDS: u32 = 20;
/// Fraction of the prescribed displacement increment used to probe the reaction forces.
const PROBE: f64 = 1e-6;
/// Relative closing velocity, with respect to its contributions, beyond which a contact closes.
const CLOSING: f64 = 1e-9;

/// Work arrays of the iteration.
pub(super) struct Newton {
    /// Current iterate of the end of the step.
    pub end: Iterate,
    /// Previous iterate: velocity and impulses.
    before: (Vec<Vec3>, Vec<Vec3>),
    /// Full-step iterate: velocity and impulses.
    goal: (Vec<Vec3>, Vec<Vec3>),
    x: Vec<f64>,
    /// First-order residual due to the prescribed displacement increments [√J].
    driven: f64,
}

/// Positions at the start of the step and context of contact detection.
pub(super) struct Touch<'a, 'p> {
    pub contact: Option<&'a mut ContactStep<'p>>,
    /// Rigid bodies at the start of the step.
    pub rigid: Option<&'a RigidStep<'p>>,
    /// Absolute positions of the contact surfaces [m].
    pub x: &'a [Vec3],
    /// Whether bodies are in flight, and whether friction is limited.
    pub phase: Phase,
    /// Called in every iteration, also by the contact solver.
    pub interrupt: Ask<'a>,
}

impl Newton {
    pub fn new(end: Iterate, unknowns: usize) -> Self {
        let nodes = || vec![Vec3::zeros(); end.v.len()];
        Self {
            before: (nodes(), nodes()),
            goal: (nodes(), nodes()),
            x: vec![0.0; unknowns],
            driven: 0.0,
            end,
        }
    }

    /// Solves for the end of the step; returns the number of iterations.
    pub fn solve(
        &mut self,
        step: &Step,
        system: &mut System,
        touch: &mut Touch,
        forces: &mut ElementForces,
    ) -> Result<u32, Stop> {
        let interrupt = touch.interrupt;
        self.start(step, forces)?;
        system.forget_contacts();
        let mut is_first = true;
        let mut is_fresh = false;
        let mut rounds = 0;
        for iteration in 1..=MOST_ITERATIONS {
            if let Some(interrupt) = interrupt() {
                return Err(Stop::Interrupted(interrupt));
            }
            // Update the matrix if the step size has changed.
            if system.tangent.as_ref().is_none_or(|t| (t.step / step.h - 1.0).abs() > 0.1) {
                self.take(step, system)?;
                is_fresh = true;
            }
            // Interruption of the contact solver is not a failure.
            let stop = |failure: Failure| interrupt().map_or_else(|| failure.into(), Stop::Interrupted);
            self.aim(step, system, touch, forces, is_first).map_err(stop)?;
            is_first = false;
            // Line search along the full step.
            let expected = self.expected_fall(step);
            let fraction = self.search(step, system, forces, expected)?;
            let limit = step.options.tolerance * self.end.scale;
            let Some(fraction) = fraction else {
                // No descent direction: conclusive only with a matrix evaluated here.
                if is_fresh {
                    let why = "the line search found no decrease";
                    return Err(not_converged(step, &self.end, iteration, why).into());
                }
                self.take(step, system)?;
                is_fresh = true;
                continue;
            };
            // Converged: accept the step unless the reactions close further contacts.
            if fraction >= 1.0 && self.end.residual <= limit {
                rounds += 1;
                let most = if step.options.statics.is_some() { MOST_STATIC_ROUNDS } else { MOST_ROUNDS };
                if rounds > most || !self.has_new_contacts(step, touch)? {
                    return Ok(iteration);
                }
                continue;
            }
            // Update the matrix if convergence is slow.
            let rate = self.end.residual / expected;
            let left = (limit / self.end.residual).ln() / rate.ln();
            if fraction < 1.0 || !(rate < 1.0 && left <= PATIENCE) {
                self.take(step, system)?;
                is_fresh = true;
            }
        }
        Err(not_converged(step, &self.end, MOST_ITERATIONS, "the maximum").into())
    }

    /// Initial guess: the velocity at the start of the step, with energy-conserving forces turned with the bodies, or, if that violates an
    /// element's law, zero displacement.
    fn start(&mut self, step: &Step, forces: &mut ElementForces) -> Result<(), Failure> {
        self.end.v.copy_from_slice(&step.state.v);
        if step.options.energy_momentum {
            turn_on(step.plan, &step.options.unknowns, step.state, step.h, &mut self.end.v);
        }
        self.end.impulse.fill(Vec3::zeros());
        if self.end.eval(step, forces).is_ok() {
            return Ok(());
        }
        let back = -(1.0 - step.options.theta) / step.options.theta;
        for (v, start) in self.end.v.iter_mut().zip(&step.state.v) {
            *v = start * back;
        }
        self.end.eval(step, forces)
    }

    /// Evaluates the matrix at the current iterate.
    fn take(&self, step: &Step, system: &mut System) -> Result<(), Failure> {
        let pressures = loads::pressures(step.plan, step.load_times[1]);
        let v = self.end.velocities();
        let at = Linearisation { u: self.end.tangent_point(step), v, history: step.history, h: step.h };
        system.take(&at, step.damping, pressures).map(|_| ()).map_err(|e| memory(step, &e))
    }

    /// Computes the full-step iterate, with its contact law solved, into `goal`.
    fn aim(
        &mut self,
        step: &Step,
        system: &mut System,
        touch: &mut Touch,
        forces: &mut ElementForces,
        detect: bool,
    ) -> Result<(), Failure> {
        let unknowns = &step.options.unknowns;
        // Contact-free end velocity of a full step.
        self.x.clone_from(&self.end.residuals);
        self.driven = self.add_driven(step, forces)?;
        system.solve(&mut self.x);
        let (v, impulse) = &mut self.goal;
        let (rigid, sides) = (touch.rigid, sides_of(touch.rigid));
        v.copy_from_slice(&self.end.v);
        unknowns.for_each(|unknown, node, axis| v[node][axis] -= self.x[unknown]);
        for prescribed in &step.plan.loads.prescribed {
            v[prescribed.node as usize][prescribed.axis] = step.prescribed_velocity(prescribed);
        }
        step.plan.assembly.followers().follow(v);
        impulse.fill(Vec3::zeros());
        let Some(contact) = touch.contact.as_deref_mut() else { return Ok(()) };
        let failed = |(cause, message)| Failure::new(step.state, cause, message);
        // Detection, once per step.
        if detect {
            within_reach(step, v, &mut self.before.0);
            let within = &self.before.0[..];
            contact.detect(step.plan, rigid, touch.x, step.h, touch.phase, within).map_err(failed)?;
            let (contacts, reactions) = contact.problem();
            reactions.clear();
            reactions.resize(contacts.len(), Reaction::default());
        }
        if contact.results().0.is_empty() {
            return Ok(());
        }
        if !system.is_definite() {
            let message = "The matrix of the step is not positive definite.".into();
            return Err(Failure::new(step.state, FailureCause::NewtonNotConverged, message));
        }
        // Contact reactions and the velocity with them.
        solve_contacts(step, system, contact, &sides, touch.interrupt, v).map_err(failed)?;
        let (contacts, reactions) = contact.results();
        for (contact, reaction) in contacts.iter().zip(reactions) {
            add_impulse(contact, &sides, reaction.impulse, impulse);
        }
        system.respond(reactions, impulse, &mut self.x);
        unknowns.for_each(|unknown, node, axis| v[node][axis] += self.x[unknown]);
        step.plan.assembly.followers().follow(v);
        Ok(())
    }

    /// Residual that a full step should remove [√J], including the impulses by which the contacts violate their law
    /// before it. A body in free flight has no residual until contact acts on it.
    fn expected_fall(&self, step: &Step) -> f64 {
        let changes = self.goal.1.iter().zip(&self.end.impulse).enumerate();
        let change: f64 = changes.map(|(a, (goal, now))| energy(&(goal - now), &step.plan.inertia(a))).sum();
        self.end.residual + change.sqrt() + self.driven
    }

    /// Adds to `x`, the momentum residual, its first-order increment due to prescribed displacements: their columns are
    /// not in the matrix, and the full increment at once could invert the adjacent elements. Returns its size [√J].
    fn add_driven(&mut self, step: &Step, forces: &mut ElementForces) -> Result<f64, Failure> {
        let loads = &step.plan.loads.prescribed;
        let way = |v: &[Vec3], p: &Prescribed| step.prescribed_velocity(p) - v[p.node as usize][p.axis];
        if loads.iter().all(|p| way(&self.end.v, p) == 0.0) {
            return Ok(0.0);
        }
        self.before.0.copy_from_slice(&self.end.v);
        for p in loads {
            self.end.v[p.node as usize][p.axis] += PROBE * way(&self.before.0, p);
        }
        self.end.eval(step, forces)?;
        let mut size = 0.0;
        step.options.unknowns.for_each(|unknown, node, axis| {
            let gain = (self.end.residuals[unknown] - self.x[unknown]) / PROBE;
            self.x[unknown] += gain;
            size += gain * gain / step.plan.inertia(node)[axis];
        });
        self.end.v.copy_from_slice(&self.before.0);
        self.end.eval(step, forces)?;
        Ok(size.sqrt())
    }

    /// Line search towards the goal until the residual satisfies the decrease from `expected`: the step fraction,
    /// `None` if there is no decrease.
    fn search(
        &mut self,
        step: &Step,
        system: &mut System,
        forces: &mut ElementForces,
        expected: f64,
    ) -> Result<Option<f64>, Failure> {
        self.before.0.copy_from_slice(&self.end.v);
        self.before.1.copy_from_slice(&self.end.impulse);
        let mut fraction = 1.0;
        for _ in 0..=MOST_HALVINGS {
            blend(&mut self.end.v, &self.before.0, &self.goal.0, fraction);
            blend(&mut self.end.impulse, &self.before.1, &self.goal.1, fraction);
            // A violated element law means that the step is too long.
            let is_inside = self.end.eval(step, forces).is_ok();
            let within = self.end.residual <= step.options.tolerance * self.end.scale;
            let falls = || self.end.residual <= (1.0 - SUFFICIENT * fraction) * expected;
            if is_inside && (within || falls() || self.decreases_residual(step, system, fraction)) {
                return Ok(Some(fraction));
            }
            fraction *= 0.5;
        }
        self.end.v.copy_from_slice(&self.before.0);
        self.end.impulse.copy_from_slice(&self.before.1);
        self.end.eval(step, forces)?;
        Ok(None)
    }

    /// Quasi-static: whether the next step with this matrix would be shorter than this one (the natural test of
    /// Deuflhard 2011, section 3.1.2). If volume is stiff and shape is soft, forces grow along every long step towards
    /// equilibrium, and a test of their residual alone would reject all steps.
    fn decreases_residual(&mut self, step: &Step, system: &mut System, fraction: f64) -> bool {
        if step.options.statics.is_none() {
            return false;
        }
        let unknowns = &step.options.unknowns;
        let mut way = 0.0;
        unknowns.for_each(|unknown, node, axis| {
            self.x[unknown] = self.end.residuals[unknown] - self.end.impulse[node][axis];
            let full = self.goal.0[node][axis] - self.before.0[node][axis];
            way += full * full * step.plan.mass[node];
        });
        system.solve(&mut self.x);
        let mut next = 0.0;
        unknowns
            .for_each(|unknown, node, _| next += self.x[unknown] * self.x[unknown] * step.plan.mass[node]);
        next <= (1.0 - 0.5 * fraction).powi(2) * way
    }

    /// Whether the reactions close contacts that the free motion would leave open; these are added to the list.
    fn has_new_contacts(&self, step: &Step, touch: &mut Touch) -> Result<bool, Failure> {
        let (rigid, sides) = (touch.rigid, sides_of(touch.rigid));
        // Detect contacts at the current iterate, keeping the known ones aside.
        let Some(contact) = touch.contact.as_deref_mut() else { return Ok(false) };
        let (contacts, reactions) = contact.problem();
        let known = (std::mem::take(contacts), std::mem::take(reactions));
        let detected = contact.detect(step.plan, rigid, touch.x, step.h, touch.phase, &self.end.v);
        detected.map_err(|(cause, message)| Failure::new(step.state, cause, message))?;
        let (contacts, reactions) = contact.problem();
        let found = std::mem::replace(contacts, known.0);
        *reactions = known.1;
        // Add the unknown contacts that close.
        let mut is_new = false;
        for candidate in found {
            let is_known = is_known(contacts, &candidate);
            let opening = closing(step, &candidate, &sides, &self.end.v)[0];
            let size = candidate.stencil.slave().map(|(n, w)| self.end.v[n as usize].amax() * w).sum::<f64>()
                + candidate.drift.amax();
            if !is_known && opening < -CLOSING * size {
                let place = contacts.partition_point(|c| c.key() < candidate.key());
                contacts.insert(place, candidate);
                reactions.insert(place, Reaction::default());
                is_new = true;
            }
        }
        Ok(is_new)
    }
}

/// The rigid bodies that contacts rotate.
pub(super) fn sides_of<'a>(rigid: Option<&'a RigidStep>) -> RigidSides<'a> {
    rigid.map_or(RigidSides::NONE, |rigid| rigid.work().sides)
}

/// Convex combination `to = from + fraction (goal − from)`.
fn blend(to: &mut [Vec3], from: &[Vec3], goal: &[Vec3], fraction: f64) {
    for ((to, from), goal) in to.iter_mut().zip(from).zip(goal) {
        *to = if fraction >= 1.0 { *goal } else { from + (goal - from) * fraction };
    }
}

/// Velocities `v` with those of unsupported bodies limited to the range of detection.
fn within_reach(step: &Step, v: &[Vec3], to: &mut [Vec3]) {
    to.copy_from_slice(v);
    for under_constrained in step.options.statics.iter().flat_map(|statics| &statics.under_constrained) {
        let nodes = &step.plan.bodies[under_constrained.body].nodes;
        for v in &mut to[nodes.start as usize..nodes.end as usize] {
            let way = v.norm() * step.h;
            if way > under_constrained.reach {
                *v *= under_constrained.reach / way;
            }
        }
    }
}

fn not_converged(step: &Step, end: &Iterate, iterations: u32, why: &str) -> Failure {
    if let Some((body, force)) = end.pushed(step) {
        let message = format!(
            "No reaction balances a resultant of [{:.3e}, {:.3e}, {:.3e}] N on the body `{}`, which is under-constrained.",
            force.x, force.y, force.z, step.plan.bodies[body].name
        );
        return Failure::new(step.state, FailureCause::UnderConstrained, message);
    }
    if !end.residual.is_finite() {
        let message = format!("In a step of {:.3e} s the residual is not a number.", step.h);
        return Failure::new(step.state, FailureCause::NotFinite, message);
    }
    if step.options.statics.is_some() {
        let message = format!(
            "A load step of {:.3e} s did not converge: the residual is {:.1e} of the forces (limit {:.0e}) after {iterations} \
             iterations, {why}.",
            step.h,
            end.residual / end.scale,
            step.options.tolerance
        );
        return Failure::new(step.state, FailureCause::NewtonNotConverged, message);
    }
    let message = format!(
        "A step of {:.3e} s did not converge: the residual is {:.1e} of the impulses (limit {:.0e}) after {iterations} iterations, \
         {why}.",
        step.h,
        end.residual / end.scale,
        step.options.tolerance
    );
    Failure::new(step.state, FailureCause::NewtonNotConverged, message)
}

fn memory(step: &Step, error: &SparseError) -> Failure {
    Failure::new(step.state, FailureCause::Internal, format!("The matrix could not be factorised: {error}."))
}
