//! The implicit step: the θ scheme with the contact law on the end velocity.
//!
//! ```text
//! M (v⁺ − v) = h [ξ f(u⁺) + (1 − ξ) f(u)] + Cᵀ p          u⁺ = u + h [θ v⁺ + (1 − θ) v]
//! p : bi-potential law on  max(g, 0)/h + C v⁺
//! ```
//!
//! With the law on the end *velocity* (Moreau 1988) θ = ½ does not chatter, as it does for ever with the law on the end
//! position: a gap that is negative already asks for no velocity. It is removed by moving nodes, as in the explicit step. For a
//! linear body without contact the energy falls by `(1 + (1 − θ)² Ω²)/(1 + θ² Ω²)` a step where ξ = θ, Ω = ωh: not at all
//! for θ = ½, and for θ > ½ by what the ledger shows as *algorithmic*.
//!
//! A step that does not converge is halved, and grown again when steps come easily.

mod iterate;
mod newton;
mod system;

use super::contact::ContactStep;
use super::explicit::place_skins;
use super::failure::{Failure, FailureCause, Stop};
use super::integrator::{Extremes, Phase, Stepper};
use super::ledger::{Energy, Half, Ledger, StepWork};
use super::motion::Motion;
use super::rigid::{RigidStep, RigidWork};
use super::run::Ask;
use super::state::State;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::{Activity, ElementForces, Threads};
use crate::mechanics::sparse::SparseError;
use crate::mechanics::tensor::Vec3;
use crate::plan::{Implicit, Plan};
use iterate::{Iterate, Step};
use newton::{Newton, Touch};
use system::System;

/// A step that took no more iterations than this was easy.
const EASY: u32 = 8;
/// Growth of the step after an easy one, up to that of the scene.
const GROWTH: f64 = 1.5;
/// A step may be longer than asked by this share, so that rounding does not cost a whole step.
const ROUNDING: f64 = 1e-9;

/// Steps a plan implicitly.
pub(super) struct ImplicitStepper<'p> {
    plan: &'p Plan,
    options: &'p Implicit,
    threads: Threads,
    motion: Motion,
    forces: ElementForces,
    activity: Activity,
    system: System<'p>,
    /// At t_n: forces and energies.
    start: Iterate,
    /// At t_{n+1}.
    newton: Newton,
    contact: Option<ContactStep<'p>>,
    rigid: Option<RigidStep<'p>>,
    /// Velocities before the forces of the step, see [`Step::v`] [m/s].
    v_before: Vec<Vec3>,
    /// Absolute positions of the skins [m].
    x: Vec<Vec3>,
    ledger: Ledger,
    energy: Energy,
    extremes: Extremes,
    /// h [s] and the step to aim at next [s].
    step: f64,
    next_target: f64,
    damping: f64,
    cuts: Cuts,
}

/// Steps that had to be cut.
#[derive(Default)]
struct Cuts {
    count: u64,
    shortest: f64,
    /// Time and reason of the first.
    first: Option<(f64, String)>,
}

impl<'p> ImplicitStepper<'p> {
    pub fn new(plan: &'p Plan, options: &'p Implicit, threads: Threads) -> Result<Self, SparseError> {
        let unknowns = options.unknowns.count();
        let forces = ElementForces::new(&plan.blocks);
        Ok(Self {
            plan,
            options,
            threads,
            motion: Motion::new(plan),
            activity: Activity::everything(plan.node_count(), &forces),
            forces,
            system: System::new(plan, options)?,
            start: Iterate::new(plan, unknowns),
            newton: Newton::new(Iterate::new(plan, unknowns), unknowns),
            contact: plan.contact.as_ref().map(|c| ContactStep::new(plan, c)),
            rigid: plan.rigid.as_ref().map(RigidStep::new),
            v_before: vec![Vec3::zeros(); plan.node_count()],
            x: vec![Vec3::zeros(); plan.node_count()],
            ledger: Ledger::new(plan),
            energy: Energy::with_capacity(plan),
            extremes: Extremes::NONE,
            step: 0.0,
            next_target: 0.0,
            damping: 0.0,
            cuts: Cuts::default(),
        })
    }

    /// One try with steps of length h.
    fn attempt(&mut self, state: &State, phase: Phase, h: f64, interrupt: Ask) -> Result<u32, Stop> {
        let Self { plan, options, threads, damping, start, system, newton, forces, x, contact, .. } = self;
        self.v_before.copy_from_slice(&state.v);
        if let Some(rigid) = &mut self.rigid {
            // Damping is in the momentum, like that of all nodes.
            rigid.turn(state, h, 0.0, &mut self.v_before)?;
        }
        let (v, f_int, damping) = (&self.v_before[..], &start.f_int[..], *damping);
        let step = Step { plan, options, threads, state, v, f_int, h, damping };
        let flying = matches!(phase, Phase::Running);
        let mut touch = Touch { contact: contact.as_mut(), rigid: self.rigid.as_ref(), x, flying };
        newton.solve(&step, system, &mut touch, forces, interrupt)
    }

    fn work<'a>(&'a self, state: &'a State, v_after: &'a [Vec3]) -> StepWork<'a> {
        let (contacts, reactions) = self.contacts();
        StepWork {
            plan: self.plan,
            state,
            v_after,
            mean_step: self.step,
            contacts,
            reactions,
            strain: &self.start.strain,
            activity: &self.activity,
            hourglass: &self.start.hourglass,
            rigid: self.rigid.as_ref().map(RigidStep::work),
        }
    }

    /// Positions of skins and rigid bodies.
    fn place(&mut self, state: &State, phase: Phase) {
        place_skins(self.plan, state, phase, &mut self.x);
        if let Some(rigid) = &mut self.rigid {
            rigid.place(self.plan, state, phase, &mut self.x);
        }
    }
}

impl Cuts {
    fn note(&mut self, time: f64, step: f64, reason: &Failure) {
        self.shortest = if self.count == 0 { step } else { self.shortest.min(step) };
        self.count += 1;
        self.first.get_or_insert_with(|| (time, reason.message.clone()));
    }
}

impl Stepper for ImplicitStepper<'_> {
    fn solve(&mut self, state: &State, phase: Phase, longest: f64, interrupt: Ask) -> Result<(), Stop> {
        self.damping = match phase {
            Phase::Settling(settle) => settle.damping,
            Phase::Running => 0.0,
        };
        self.start.u.copy_from_slice(&state.u);
        self.start.sweep(self.plan, &self.threads, state, &mut self.forces)?;
        self.extremes.smallest_j = self.extremes.smallest_j.min(self.start.smallest_j);
        self.place(state, phase);
        let restored = self.system.restore(state.implicit.tangent.as_ref(), self.damping);
        restored.map_err(|e| Failure::new(state, FailureCause::Internal, format!("There is {e}.")))?;

        let aimed = state.implicit.target_step;
        let mut target = if aimed > 0.0 { aimed } else { self.options.step };
        let mut was_cut = false;
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
                    if target < self.options.smallest_step {
                        return Err(failure.into());
                    }
                }
            }
        }
        self.extremes.smallest_step = self.extremes.smallest_step.min(self.step);
        self.extremes.most_contacts = self.extremes.most_contacts.max(self.contacts().0.len());
        Ok(())
    }

    fn balance(&mut self, state: &State) {
        let (mut ledger, mut energy) = (std::mem::take(&mut self.ledger), std::mem::take(&mut self.energy));
        ledger.copy_from(&state.ledger);
        if !state.projected.is_empty() {
            // The other side of what was taken off on arriving here.
            ledger.add_strain_of_projection(&self.start.strain, 1.0);
        }
        // Positions and velocities are of one time here: all work up to t_n has been counted.
        let mut motion = std::mem::take(&mut self.motion);
        let now = self.work(state, &state.v);
        let now = StepWork { rigid: now.rigid.map(RigidWork::unturned), ..now };
        motion.eval(&self.threads, &now);
        ledger.balance(&now, &motion, &mut energy);
        let work = self.work(state, &self.newton.end.v);
        ledger.add_work(&work, Half::Before);
        ledger.add_work(&work, Half::After);
        let Self { plan, options, threads, start, damping, step: h, .. } = &*self;
        let (v, f_int) = (&self.v_before[..], &start.f_int[..]);
        let step = Step { plan, options, threads, state, v, f_int, h: *h, damping: *damping };
        for (body, sum) in ledger.algorithmic.iter_mut().enumerate() {
            *sum += self.newton.end.dissipated(&step, body, start.strain[body]);
        }
        self.extremes.balance_error = self.extremes.balance_error.max(energy.balance_error);
        (self.ledger, self.motion, self.energy) = (ledger, motion, energy);
    }

    fn advance(&mut self, state: &mut State, phase: Phase) {
        if let Phase::Running = phase {
            self.extremes.swept_elements += self.plan.element_count() as u64;
            std::mem::swap(&mut self.ledger, &mut state.ledger);
        }
        state.u.copy_from_slice(&self.newton.end.u);
        if let Some(rigid) = &self.rigid {
            rigid.advance_between(state, &self.newton.end.v, self.options.theta, self.step);
            rigid.clear_places(state);
        }
        state.v.copy_from_slice(&self.newton.end.v);
        state.last_step = self.step;
        state.time += self.step;
        state.step += 1;
        state.implicit.target_step = self.next_target;
        if state.implicit.tangent != self.system.tangent {
            state.implicit.tangent.clone_from(&self.system.tangent);
        }
        self.place(state, phase);
        if let Some(contact) = &mut self.contact {
            let poses = self.rigid.as_mut().map_or(&mut [][..], RigidStep::poses_mut);
            state.projected.clear();
            state.projected.extend_from_slice(contact.project(&mut self.x, poses, &self.plan.inverse_mass));
            for (orientation, pose) in state.orientations.iter_mut().zip(poses) {
                *orientation = pose.orientation;
            }
            for (node, du) in &state.projected {
                state.u[*node as usize] += du;
            }
            if !state.projected.is_empty() {
                state.ledger.add_strain_of_projection(&self.newton.end.strain, -1.0);
            }
        }
    }

    fn contacts(&self) -> (&[Contact], &[Reaction]) {
        self.contact.as_ref().map_or((&[], &[]), ContactStep::results)
    }

    fn mean_step(&self, _: &State) -> f64 {
        self.step
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
        let Some((time, reason)) = &self.cuts.first else { return Vec::new() };
        vec![format!(
            "The step was cut {} times, to {:.3e} s at the shortest; first at t = {time:.4e} s: {reason}",
            self.cuts.count, self.cuts.shortest
        )]
    }
}
