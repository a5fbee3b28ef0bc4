//! The implicit step: the θ scheme with the contact law on the end velocity.
//!
//! ```text
//! M (v⁺ − v) = h [ξ f(u⁺) + (1 − ξ) f(u)] + Cᵀ p          u⁺ = u + h [θ v⁺ + (1 − θ) v]
//! p : bi-potential law on  max(g, 0)/h + C v⁺
//! ```
//!
//! With the law on the end *velocity* (Moreau 1988) θ = ½ does not chatter, as it would indefinitely with the law on
//! the end position: a negative gap demands no velocity. It is removed by moving nodes, as in the explicit step. For a
//! linear body without contact the energy decreases by the factor `(1 + (1 − θ)² Ω²)/(1 + θ² Ω²)` per step if ξ = θ, Ω
//! = ωh: not at all for θ = ½, and for θ > ½ by the *algorithmic* dissipation in the ledger.
//!
//! Viscosity and memory act in f, with the history at t_n: that at the end of a step is stored when the step is accepted.
//!
//! A step that does not converge is halved, and increased again when steps converge easily.
//!
//! In *quasi-static* steps ([`Statics`]) the same iteration finds equilibrium at the end of a load step, with v⁺ the
//! displacement of the step over h:
//!
//! ```text
//! 0 = h f(u⁺, t⁺) + Cᵀ p          u⁺ = u + h v⁺          p : bi-potential law on  g/h + C v⁺
//! ```
//!
//! Without inertia nothing rebounds, so the law closes negative gaps as well, and no projection is needed. The state
//! has no velocity between load steps, but the contacts that support the bodies ([`super::state::Held`]).
//!
//! [`Statics`]: crate::plan::Statics

mod contact_law;
mod cuts;
mod iterate;
mod midpoint;
mod newton;
mod system;

use super::contact::ContactStep;
use super::energy::Energy;
use super::failure::{Failure, FailureCause, Stop};
use super::interrupt::Ask;
use super::ledger::Ledger;
use super::loads;
use super::motion::Motion;
use super::phase::Phase;
use super::place::place_surfaces;
use super::rigid::RigidStep;
use super::state::{Held, State};
use super::step_work::{Half, StepWork};
use super::stepper::{Extremes, Stepper};
use crate::mechanics::contact::solution::compliance::add_impulse;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::{Activity, ElementForces, Threads};
use crate::mechanics::lanes::Row;
use crate::mechanics::sparse::SparseError;
use crate::mechanics::tensor::Vec3;
use crate::plan::{Implicit, Plan};
use cuts::Cuts;
use iterate::{Iterate, Step};
use newton::{Newton, Touch, sides_of};
use system::System;

/// Number of iterations up to which a step counts as easy.
const EASY: u32 = 8;
/// Growth of the step after an easy one, up to that of the scene.
const GROWTH: f64 = 1.5;
/// Attempts of a step whose contacts have no solution: shorter steps seldom give them one.
const MOST_JAMS: u32 = 3;
/// Relative excess over the requested step that is tolerated, so that rounding does not cost a whole step.
const ROUNDING: f64 = 1e-9;

/// Advances a plan implicitly.
pub(super) struct ImplicitStepper<'p> {
    plan: &'p Plan,
    options: &'p Implicit,
    threads: Threads,
    motion: Motion,
    forces: ElementForces,
    activity: Activity,
    system: System<'p>,
    /// Forces and energies at t_n.
    start: Iterate,
    /// History of the elements at t_n, chunk by chunk; empty if nothing depends on time.
    history: Vec<Vec<Row>>,
    /// Strain energies of the chunks at t_n [J], if energy-conserving forces are used.
    energies: Vec<f64>,
    /// Newton iteration for t_{n+1}.
    newton: Newton,
    contact: Option<ContactStep<'p>>,
    rigid: Option<RigidStep<'p>>,
    /// Absolute positions of the contact surfaces [m].
    x: Vec<Vec3>,
    /// Mean forces of loads in the step [N], as the ledger counts them; empty if the plan has none.
    f_ext: Vec<Vec3>,
    /// Impulses on prescribed nodes in the step [N s].
    prescribed: Vec<f64>,
    /// In quasi-static steps, the contacts that support the bodies at t_n.
    held: Held,
    /// Their reactions over the step to t_{n+1}.
    held_on: Vec<Reaction>,
    ledger: Ledger,
    energy: Energy,
    extremes: Extremes,
    /// Step size h [s].
    step: f64,
    next_target: f64,
    damping: f64,
    cuts: Cuts,
}

impl<'p> ImplicitStepper<'p> {
    pub fn new(plan: &'p Plan, options: &'p Implicit, threads: Threads) -> Result<Self, SparseError> {
        let forces = ElementForces::new(&plan.blocks);
        let has_history = options.rate_effects && plan.has_memory();
        Ok(Self {
            plan,
            options,
            contact: plan.contact.as_ref().map(|c| ContactStep::new(plan, c, &threads)),
            threads,
            motion: Motion::new(plan),
            activity: Activity::everything(plan.node_count(), &forces),
            forces,
            system: System::new(plan, options)?,
            start: Iterate::new(plan, options),
            history: if has_history { plan.room_for_history() } else { Vec::new() },
            energies: Vec::new(),
            newton: Newton::new(Iterate::new(plan, options), options.unknowns.count()),
            rigid: plan.rigid.as_ref().map(RigidStep::new),
            x: vec![Vec3::zeros(); plan.node_count()],
            f_ext: vec![Vec3::zeros(); if plan.loads.has_forces() { plan.node_count() } else { 0 }],
            prescribed: vec![0.0; plan.loads.prescribed.len()],
            held: Held::default(),
            held_on: Vec::new(),
            ledger: Ledger::new(plan),
            energy: Energy::with_capacity(plan),
            extremes: Extremes::NONE,
            step: 0.0,
            next_target: 0.0,
            damping: 0.0,
            cuts: Cuts::default(),
        })
    }

    /// Attempts one step of size h.
    fn attempt(&mut self, state: &State, phase: Phase, h: f64, interrupt: Ask) -> Result<u32, Stop> {
        let Self { plan, options, threads, damping, start, system, newton, forces, x, contact, .. } = self;
        let step = Step {
            plan,
            options,
            threads,
            state,
            start,
            energies: &self.energies,
            history: &self.history,
            load_times: [state.time, state.time + h].map(|time| phase.load_time(time)),
            h,
            damping: *damping,
        };
        let mut touch = Touch { contact: contact.as_mut(), rigid: self.rigid.as_ref(), x, phase, interrupt };
        let iterations = newton.solve(&step, system, &mut touch, forces)?;
        match &mut self.rigid {
            Some(rigid) if options.statics.is_some() => rigid.turn_statically(state, &newton.end.v, h),
            Some(rigid) => rigid.turn(state, &newton.end.v, options.theta, h)?,
            None => {}
        }
        Ok(iterations)
    }

    fn work<'a>(&'a self, state: &'a State, v_after: &'a [Vec3]) -> StepWork<'a> {
        let (contacts, reactions) = self.contacts_of_step();
        let [start, end] = [state.time, state.time + self.step]
            .map(|time| loads::gravity(self.plan, Phase::Running.load_time(time)));
        let weight = self.weight_of_end();
        StepWork {
            plan: self.plan,
            state,
            v_after,
            mean_step: self.step,
            step_change: 0.0,
            f_int: &[],
            contacts,
            reactions,
            gravity: end * weight + start * (1.0 - weight),
            f_ext: &self.f_ext,
            prescribed: &self.prescribed,
            strain: &self.start.strain,
            activity: &self.activity,
            hourglass: &self.start.hourglass,
            branches: &self.start.branches,
            rigid: self.rigid.as_ref().map(RigidStep::work),
        }
    }

    /// Absolute positions of contact surfaces and rigid bodies.
    fn place(&mut self, state: &State, phase: Phase) {
        let surfaces = self.plan.contact.as_ref().map_or(&[][..], |contact| &contact.surfaces);
        place_surfaces(self.plan, surfaces, (state, phase), &mut self.x);
        if let Some(rigid) = &mut self.rigid {
            rigid.place(self.plan, state, phase, &mut self.x);
        }
    }

    /// Weight of the end of the step in the load forces whose work the ledger counts [-]: as in the momentum balance;
    /// in quasi-static steps one half, which makes the work second-order accurate.
    fn weight_of_end(&self) -> f64 {
        if self.options.statics.is_some() { 0.5 } else { self.options.xi }
    }

    fn contacts_of_step(&self) -> (&[Contact], &[Reaction]) {
        self.contact.as_ref().map_or((&[], &[]), ContactStep::results)
    }

    /// The reactions at the start of a load step, as impulses over it, and on the nodes.
    fn hold_on(&mut self) {
        let scale = if self.held.step > 0.0 { self.step / self.held.step } else { 0.0 };
        self.held_on.clear();
        self.held_on
            .extend(self.held.reactions.iter().map(|r| Reaction { impulse: r.impulse.map(|p| scale * p) }));
        let sides = sides_of(self.rigid.as_ref());
        self.start.impulse.fill(Vec3::zeros());
        for (contact, reaction) in self.held.contacts.iter().zip(&self.held_on) {
            add_impulse(contact, &sides, reaction.impulse, &mut self.start.impulse);
        }
    }

    /// Adds the work of the step.
    fn add_step(&mut self, state: &State, ledger: &mut Ledger) {
        if self.options.statics.is_some() {
            self.hold_on();
        }
        let load_times = [state.time, state.time + self.step].map(|time| Phase::Running.load_time(time));
        let weight = self.weight_of_end();
        let ends = self.start.f_ext.iter().zip(&self.newton.end.f_ext);
        for (f_ext, (start, end)) in self.f_ext.iter_mut().zip(ends) {
            *f_ext = end * weight + start * (1.0 - weight);
        }
        let Self { plan, options, threads, start, newton, prescribed, .. } = self;
        let step = Step {
            plan,
            options,
            threads,
            state,
            start,
            energies: &self.energies,
            history: &self.history,
            load_times,
            h: self.step,
            damping: self.damping,
        };
        newton.end.prescribed_impulses(&step, prescribed);
        for body in 0..ledger.algorithmic.len() {
            let driven = newton.end.driven_work(&step, body);
            let by_rate = newton.end.rate_work(&step, body);
            ledger.viscous[body] += by_rate;
            let dissipated = newton.end.dissipated(&step, body, start.elastic(body));
            ledger.algorithmic[body] += dissipated + driven - by_rate;
            ledger.external[body] += driven;
        }
        ledger.add_branch_work(&self.newton.end.branches, weight);
        let work = self.work(state, &self.newton.end.v);
        if self.options.statics.is_some() {
            // The velocity is that of the whole step, the reactions those of both ends.
            let start = StepWork { contacts: &self.held.contacts, reactions: &self.held_on, ..work };
            ledger.add_work(&start, Half::After);
        } else {
            ledger.add_work(&work, Half::Before);
        }
        ledger.add_work(&work, Half::After);
    }
}

impl Stepper for ImplicitStepper<'_> {
    fn solve(&mut self, state: &State, phase: Phase, longest: f64, interrupt: Ask) -> Result<(), Stop> {
        self.damping = phase.damping();
        // Forces and energies at t_n.
        self.start.u.copy_from_slice(&state.u);
        self.start.v.copy_from_slice(&state.v);
        let history = (&state.history[..], 0.0);
        self.start.evaluate(self.plan, &self.threads, state, history, &mut self.forces)?;
        self.forces.copy_history(&mut self.history);
        self.extremes.smallest_j = self.extremes.smallest_j.min(self.start.smallest_j);
        if self.options.energy_momentum {
            self.forces.chunk_energies(&mut self.energies);
        }
        loads::eval_forces(self.plan, &state.u, phase.load_time(state.time), &mut self.start.f_ext);
        if self.options.statics.is_some() {
            self.held.clone_from(&state.implicit.held);
            if longest == 0.0 {
                // At the end there is no further step: the supporting contacts are known.
                self.step = state.last_step;
                return Ok(());
            }
        }
        // Contact geometry and the matrix of the saved state.
        self.place(state, phase);
        let restored = self.system.restore(state.implicit.tangent.as_ref(), self.damping);
        restored.map_err(|e| Failure::new(state, FailureCause::Internal, format!("There is {e}.")))?;

        // Attempt the step, halving it until it converges.
        let aimed = state.implicit.target_step;
        let mut target = if aimed > 0.0 { aimed } else { self.options.step };
        let mut was_cut = false;
        let mut first_failure = None;
        let mut jams = 0;
        loop {
            let count = (longest / target - ROUNDING).ceil().max(1.0);
            self.step = if longest > 0.0 { longest / count } else { target };
            match self.attempt(state, phase, self.step, interrupt) {
                Ok(iterations) => {
                    let is_easy = iterations <= EASY && !was_cut;
                    self.next_target =
                        if is_easy { (GROWTH * target).min(self.options.step) } else { target };
                    break;
                }
                Err(Stop::Interrupted(interrupt)) => return Err(Stop::Interrupted(interrupt)),
                Err(Stop::Failed(failure)) => {
                    target = 0.5 * self.step;
                    was_cut = true;
                    self.cuts.note(state.time, target, &failure);
                    let is_under_constrained = failure.cause == FailureCause::UnderConstrained;
                    jams += u32::from(failure.cause == FailureCause::ContactJammed);
                    if target < self.options.smallest_step || jams >= MOST_JAMS {
                        // The diagnosis of the whole step is more informative than that of its last part.
                        let cause =
                            if is_under_constrained { first_failure.unwrap_or(failure) } else { failure };
                        return Err(cause.into());
                    }
                    if is_under_constrained {
                        first_failure.get_or_insert(failure);
                    }
                }
            }
        }
        self.extremes.smallest_step = self.extremes.smallest_step.min(self.step);
        self.extremes.most_contacts = self.extremes.most_contacts.max(self.contacts_of_step().0.len());
        Ok(())
    }

    fn balance(&mut self, state: &State) {
        let (mut ledger, mut energy) = (std::mem::take(&mut self.ledger), std::mem::take(&mut self.energy));
        ledger.copy_from(&state.ledger);
        if !state.projected.is_empty() {
            // Counterpart of the subtraction when this time was reached.
            ledger.add_strain_of_projection(&self.start.strain, 1.0);
            ledger.add_strain_of_projection(self.start.branches.of_bodies(), -1.0);
        }
        // Positions and velocities refer to one time here: all work up to t_n has been counted.
        let mut motion = std::mem::take(&mut self.motion);
        let now = self.work(state, &state.v);
        motion.eval(&self.threads, &now);
        ledger.balance(&now, &motion, &mut energy);
        self.add_step(state, &mut ledger);
        self.extremes.balance_error = self.extremes.balance_error.max(energy.balance_error);
        (self.ledger, self.motion, self.energy) = (ledger, motion, energy);
    }

    fn advance(&mut self, state: &mut State, phase: Phase) {
        // Ledger and motion.
        if let Phase::Running = phase {
            self.extremes.evaluated_elements += self.plan.element_count() as u64;
            std::mem::swap(&mut self.ledger, &mut state.ledger);
        }
        state.u.copy_from_slice(&self.newton.end.u);
        if self.options.statics.is_none() {
            state.v.copy_from_slice(&self.newton.end.v);
        }
        if let Some(rigid) = &self.rigid {
            rigid.advance(state);
        }
        if !self.history.is_empty() {
            self.forces.swap_history(&mut state.history);
        }
        // Clock and memory of the integrator.
        state.last_step = self.step;
        state.time += self.step;
        state.step += 1;
        state.implicit.target_step = self.next_target;
        if state.implicit.tangent != self.system.tangent {
            state.implicit.tangent.clone_from(&self.system.tangent);
        }
        // A quasi-static step keeps the supporting contacts, and needs no projection.
        if self.options.statics.is_some() {
            let (contacts, reactions) = self.contacts_of_step();
            state.implicit.held.contacts.clear();
            state.implicit.held.contacts.extend_from_slice(contacts);
            state.implicit.held.reactions.clear();
            state.implicit.held.reactions.extend_from_slice(reactions);
            state.implicit.held.step = self.step;
            return;
        }
        // Position projection.
        self.place(state, phase);
        if let Some(contact) = &mut self.contact {
            let poses = self.rigid.as_mut().map_or(&mut [][..], RigidStep::poses_mut);
            state.projected.clear();
            state.projected.extend_from_slice(contact.project(self.plan, &mut self.x, poses, 1.0));
            for (orientation, pose) in state.orientations.iter_mut().zip(poses) {
                *orientation = pose.orientation;
            }
            for (node, du) in &state.projected {
                state.u[*node as usize] += du;
            }
            self.plan.assembly.followers().follow(&mut state.u);
            if !state.projected.is_empty() {
                state.ledger.add_strain_of_projection(&self.newton.end.strain, -1.0);
                state.ledger.add_strain_of_projection(self.newton.end.branches.of_bodies(), 1.0);
            }
        }
    }

    fn contacts(&self) -> (&[Contact], &[Reaction]) {
        if self.options.statics.is_some() {
            return (&self.held.contacts, &self.held.reactions);
        }
        self.contacts_of_step()
    }

    fn history(&self) -> &[Vec<Row>] {
        &self.history
    }

    fn mean_step(&self, _: &State) -> f64 {
        if self.options.statics.is_some() && self.held.step > 0.0 { self.held.step } else { self.step }
    }

    fn v_after<'a>(&'a self, state: &'a State) -> &'a [Vec3] {
        &state.v
    }

    fn energy(&self) -> &Energy {
        &self.energy
    }

    fn extremes(&self) -> &Extremes {
        &self.extremes
    }

    fn unconverged(&self) -> (u64, f64) {
        self.contact.as_ref().map_or((0, 0.0), |contact| contact.unconverged)
    }

    fn warnings(&self) -> Vec<String> {
        self.cuts.warning().into_iter().collect()
    }
}
