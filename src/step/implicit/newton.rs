//! One implicit step of a given size: Newton's iteration on the end velocity, with the contact law solved in every iteration.
//!
//! Linearised at v_k, the momentum is `S (v − v_k) + g(v_k) = Cᵀ p`, and the contacts see `C v = W p + C v_free` with
//! `v_free = v_k − S⁻¹ g`, `W = C S⁻¹ Cᵀ`. The matrix S is taken anew only when the iteration with the one at hand is slow. The
//! residual `g − Cᵀ p` falls along the step from (v_k, p_k) to (v, p), so a line search can hold it to that.

use super::iterate::{Iterate, Step, energy};
use super::system::System;
use crate::mechanics::contact::compliance::{add_impulse, closing_velocity};
use crate::mechanics::contact::delassus::Delassus;
use crate::mechanics::contact::problem::{ContactProblem, ProblemError};
use crate::mechanics::contact::solvers::{self, Options};
use crate::mechanics::contact::{Contact, Reaction, RigidSides};
use crate::mechanics::force::ElementForces;
use crate::mechanics::sparse::SparseError;
use crate::mechanics::tensor::Vec3;
use crate::step::contact::ContactStep;
use crate::step::failure::{Failure, FailureCause, Stop};
use crate::step::rigid::RigidStep;
use crate::step::run::Ask;

/// Iterations of one step.
const MOST_ITERATIONS: u32 = 30;
/// A matrix is taken anew when the iteration with the one at hand would need more than this many further ones.
const PATIENCE: f64 = 8.0;
/// Halvings of a line search.
const MOST_HALVINGS: u32 = 6;
/// Share of the decrease that a full step promises which a shortened one must keep.
const SUFFICIENT: f64 = 1e-4;
/// Normal compliance below this share of the trace: nothing can move along n.
const IMMOVABLE: f64 = 1e-12;
/// Rounds in which contacts that the reactions close are looked for.
const MOST_ROUNDS: u32 = 4;
/// An opening velocity below minus this share of the velocities that it comes from closes a contact.
const CLOSING: f64 = 1e-9;

/// Buffers of the iteration.
pub(super) struct Newton {
    /// The end that is tried.
    pub end: Iterate,
    /// The one before: velocity and impulses.
    before: (Vec<Vec3>, Vec<Vec3>),
    /// Where a full step leads.
    goal: (Vec<Vec3>, Vec<Vec3>),
    x: Vec<f64>,
}

/// The positions at the start of the step and how contact is asked about.
pub(super) struct Touch<'a, 'p> {
    pub contact: Option<&'a mut ContactStep<'p>>,
    /// The rigid bodies at the start of the step.
    pub rigid: Option<&'a RigidStep<'p>>,
    /// Absolute positions of the skins [m].
    pub x: &'a [Vec3],
    /// Whether the bodies fly: not while settling.
    pub flying: bool,
}

impl Newton {
    pub fn new(end: Iterate, unknowns: usize) -> Self {
        let nodes = || vec![Vec3::zeros(); end.v.len()];
        Self { before: (nodes(), nodes()), goal: (nodes(), nodes()), x: vec![0.0; unknowns], end }
    }

    /// Finds the end of the step; returns the iterations that it took.
    pub fn solve(
        &mut self,
        step: &Step,
        system: &mut System,
        touch: &mut Touch,
        forces: &mut ElementForces,
        interrupt: Ask,
    ) -> Result<u32, Stop> {
        self.start(step, forces)?;
        system.forget_contacts();
        let mut is_first = true;
        let mut is_fresh = false;
        let mut rounds = 0;
        for iteration in 1..=MOST_ITERATIONS {
            if let Some(interrupt) = interrupt() {
                return Err(Stop::Interrupted(interrupt));
            }
            if system.tangent.as_ref().is_none_or(|t| (t.step / step.h - 1.0).abs() > 0.1) {
                self.take(step, system)?;
                is_fresh = true;
            }
            self.aim(step, system, touch, is_first)?;
            is_first = false;
            let expected = self.expected_fall(step);
            let share = self.search(step, forces, expected)?;
            let limit = step.options.tolerance * self.end.scale;
            let Some(share) = share else {
                // No way down: with a matrix from elsewhere that says little.
                if is_fresh {
                    let why = "the line search found no decrease";
                    return Err(not_converged(step, &self.end, iteration, why).into());
                }
                self.take(step, system)?;
                is_fresh = true;
                continue;
            };
            if share >= 1.0 && self.end.residual <= limit {
                rounds += 1;
                if rounds > MOST_ROUNDS || !self.has_new_contacts(step, touch)? {
                    return Ok(iteration);
                }
                continue;
            }
            let rate = self.end.residual / expected;
            let left = (limit / self.end.residual).ln() / rate.ln();
            if share < 1.0 || !(rate < 1.0 && left <= PATIENCE) {
                self.take(step, system)?;
                is_fresh = true;
            }
        }
        Err(not_converged(step, &self.end, MOST_ITERATIONS, "so many are allowed").into())
    }

    /// From the velocity at the start of the step, or where that leads out of the law of an element, from its positions.
    fn start(&mut self, step: &Step, forces: &mut ElementForces) -> Result<(), Failure> {
        self.end.v.copy_from_slice(step.v);
        self.end.impulse.fill(Vec3::zeros());
        if self.end.eval(step, forces).is_ok() {
            return Ok(());
        }
        let back = -(1.0 - step.options.theta) / step.options.theta;
        for (v, start) in self.end.v.iter_mut().zip(step.v) {
            *v = start * back;
        }
        self.end.eval(step, forces)
    }

    /// Takes the matrix where the iteration is.
    fn take(&self, step: &Step, system: &mut System) -> Result<(), Failure> {
        system.take(&self.end.u, step.h, step.damping).map(|_| ()).map_err(|e| memory(step, &e))
    }

    /// The end of a full step, with the contact law solved for it, into `goal`.
    fn aim(
        &mut self,
        step: &Step,
        system: &mut System,
        touch: &mut Touch,
        detect: bool,
    ) -> Result<(), Failure> {
        let unknowns = &step.options.unknowns;
        self.x.clone_from(&self.end.lack);
        system.solve(&mut self.x);
        let (v, impulse) = &mut self.goal;
        let (rigid, sides) = (touch.rigid, sides_of(touch.rigid));
        v.copy_from_slice(&self.end.v);
        unknowns.for_each(|unknown, node, axis| v[node][axis] -= self.x[unknown]);
        impulse.fill(Vec3::zeros());
        let Some(contact) = touch.contact.as_deref_mut() else { return Ok(()) };
        let failed = |(cause, message)| Failure::new(step.state, cause, message);
        if detect {
            contact.detect(step.plan, rigid, touch.x, step.h, touch.flying, v).map_err(failed)?;
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
        solve_contacts(step, system, contact, &sides, touch.flying, v).map_err(failed)?;
        let (contacts, reactions) = contact.results();
        for (contact, reaction) in contacts.iter().zip(reactions) {
            add_impulse(contact, &sides, reaction.impulse, impulse);
        }
        unknowns.gather(impulse, &mut self.x);
        system.solve(&mut self.x);
        unknowns.for_each(|unknown, node, axis| v[node][axis] += self.x[unknown]);
        Ok(())
    }

    /// What a full step is to remove [√J]: the residual, and the impulses by which the contacts break their law before it. A
    /// body in free flight lacks no momentum until it is told that it touches.
    fn expected_fall(&self, step: &Step) -> f64 {
        let changes = self.goal.1.iter().zip(&self.end.impulse).enumerate();
        let change: f64 = changes.map(|(a, (goal, now))| energy(&(goal - now), &step.plan.inertia(a))).sum();
        self.end.residual + change.sqrt()
    }

    /// Goes towards the goal as far as the residual is below what was `expected` to be removed: the share of the way, `None` if
    /// it is nowhere.
    fn search(
        &mut self,
        step: &Step,
        forces: &mut ElementForces,
        expected: f64,
    ) -> Result<Option<f64>, Failure> {
        self.before.0.copy_from_slice(&self.end.v);
        self.before.1.copy_from_slice(&self.end.impulse);
        let mut share = 1.0;
        for _ in 0..=MOST_HALVINGS {
            blend(&mut self.end.v, &self.before.0, &self.goal.0, share);
            blend(&mut self.end.impulse, &self.before.1, &self.goal.1, share);
            // An element beyond its law is a step too far.
            let is_inside = self.end.eval(step, forces).is_ok();
            let within = self.end.residual <= step.options.tolerance * self.end.scale;
            if is_inside && (within || self.end.residual <= (1.0 - SUFFICIENT * share) * expected) {
                return Ok(Some(share));
            }
            share *= 0.5;
        }
        self.end.v.copy_from_slice(&self.before.0);
        self.end.impulse.copy_from_slice(&self.before.1);
        self.end.eval(step, forces)?;
        Ok(None)
    }

    /// Whether the reactions close contacts that the free motion would not have closed; these are put on the list.
    fn has_new_contacts(&self, step: &Step, touch: &mut Touch) -> Result<bool, Failure> {
        let (rigid, sides) = (touch.rigid, sides_of(touch.rigid));
        let Some(contact) = touch.contact.as_deref_mut() else { return Ok(false) };
        let (contacts, reactions) = contact.problem();
        let known = (std::mem::take(contacts), std::mem::take(reactions));
        let detected = contact.detect(step.plan, rigid, touch.x, step.h, touch.flying, &self.end.v);
        detected.map_err(|(cause, message)| Failure::new(step.state, cause, message))?;
        let (contacts, reactions) = contact.problem();
        let found = std::mem::replace(contacts, known.0);
        *reactions = known.1;
        let mut is_new = false;
        for candidate in found {
            // The node of a mesh is in a pair once; a rigid body touches at several points.
            let slave_is_rigid = sides.of_pair(candidate.pair)[0].is_some();
            let is_known = contacts.iter().any(|c| {
                (c.pair, c.slave) == (candidate.pair, candidate.slave)
                    && (!slave_is_rigid || c.point == candidate.point)
            });
            let opening = closing_velocity(&candidate, &sides, &self.end.v, step.h)[0];
            let size = self.end.v[candidate.slave as usize].amax() + candidate.drift.amax();
            if !is_known && opening < -CLOSING * size {
                let key = |c: &Contact| (c.pair, c.slave, c.face);
                let place = contacts.partition_point(|c| key(c) < key(&candidate));
                contacts.insert(place, candidate);
                reactions.insert(place, Reaction::default());
                is_new = true;
            }
        }
        Ok(is_new)
    }
}

fn sides_of<'a>(rigid: Option<&'a RigidStep>) -> RigidSides<'a> {
    rigid.map_or(RigidSides::NONE, |rigid| rigid.work().sides)
}

/// `to = from + share (goal − from)`.
fn blend(to: &mut [Vec3], from: &[Vec3], goal: &[Vec3], share: f64) {
    for ((to, from), goal) in to.iter_mut().zip(from).zip(goal) {
        *to = if share >= 1.0 { *goal } else { from + (goal - from) * share };
    }
}

/// Reactions of the contacts, from the velocities without them; contacts whose sides cannot move are dropped. Where nothing rubs
/// each has one unknown.
fn solve_contacts(
    step: &Step,
    system: &mut System,
    contact: &mut ContactStep,
    sides: &RigidSides,
    flying: bool,
    v_free: &[Vec3],
) -> Result<(), (FailureCause, String)> {
    let unknowns = contact.unknowns(flying);
    let mut W = system.delassus(contact.results().0, sides, unknowns);
    if drop_immovable(contact, unknowns, &W) {
        W = system.delassus(contact.results().0, sides, unknowns);
    }
    let (contacts, reactions) = contact.results();
    let closing = |c: &Contact| closing_velocity(c, sides, v_free, step.h).into_iter().take(unknowns);
    let q: Vec<f64> = contacts.iter().flat_map(closing).collect();
    let mut r: Vec<f64> = reactions.iter().flat_map(|r| r.impulse.into_iter().take(unknowns)).collect();
    let internal = |e: ProblemError| (FailureCause::NotFinite, format!("There is no contact problem: {e}."));
    let options = Options { tolerance: contact.tolerance(), ..Options::default() };
    let report = if unknowns == 1 {
        solvers::solve_frictionless(&W, &q, &mut r, &options)
    } else {
        let mu = contacts.iter().map(|c| contact.friction(c.pair, flying)).collect();
        let W = Delassus::dense(contacts.len(), W).map_err(|e| internal(e.into()))?;
        ContactProblem::new(W, q, mu).map(|problem| solvers::solve(&problem, &mut r, &options))
    };
    let report = report.map_err(internal)?;
    let (_, reactions) = contact.problem();
    for (reaction, r) in reactions.iter_mut().zip(r.chunks_exact(unknowns)) {
        *reaction = Reaction::default();
        reaction.impulse[..unknowns].copy_from_slice(r);
    }
    if report.converged { Ok(()) } else { contact.accept(report.error_scaled, None) }
}

/// Drops the contacts along whose normal nothing can move; whether there were any. W has so many `unknowns` a contact.
fn drop_immovable(contact: &mut ContactStep, unknowns: usize, W: &[f64]) -> bool {
    let (contacts, reactions) = contact.problem();
    let rows = unknowns * contacts.len();
    let own = |c: usize, i: usize| W[(unknowns * c + i) * (rows + 1)];
    let trace = |c: usize| (0..unknowns).map(|i| own(c, i)).sum::<f64>();
    let largest = (0..contacts.len()).map(trace).fold(0.0, f64::max);
    // With a normal alone there is nothing of the contact's own to compare with.
    let size = |c: usize| if unknowns == 1 { largest } else { trace(c) };
    let keep: Vec<bool> = (0..contacts.len()).map(|c| own(c, 0) > IMMOVABLE * size(c)).collect();
    if keep.iter().all(|keep| *keep) {
        return false;
    }
    let mut place = keep.iter();
    contacts.retain(|_| place.next().copied().unwrap_or(true));
    let mut place = keep.iter();
    reactions.retain(|_| place.next().copied().unwrap_or(true));
    true
}

fn not_converged(step: &Step, end: &Iterate, iterations: u32, why: &str) -> Failure {
    let message = format!(
        "A step of {:.3e} s did not converge: the momentum lacks {:.1e} of the impulses (limit {:.0e}) after {iterations} iterations, \
         {why}.",
        step.h,
        end.residual / end.scale,
        step.options.tolerance
    );
    Failure::new(step.state, FailureCause::NewtonNotConverged, message)
}

fn memory(step: &Step, error: &SparseError) -> Failure {
    Failure::new(step.state, FailureCause::Internal, format!("The matrix could not be factored: {error}."))
}
