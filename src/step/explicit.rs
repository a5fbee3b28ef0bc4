//! The explicit step: central differences with velocities at half steps, contact on the end-of-step gap.
//!
//! ```text
//! f   = f_ext − f_int(u_n)
//! v*  = v₋ + h̄ M⁻¹ f                      h̄ = ½ (h₋ + h₊)
//! p   : bi-potential law on  max(g, 0)/h₊ + C v₊,   v₊ = v* + M⁻¹ Cᵀ p
//! u_{n+1} = u_n + h₊ v₊
//! ```
//!
//! The constraint acts on the *end-of-step* gap with the end velocity, so nothing penetrates and no contact is
//! activated late (Stewart & Trinkle 1996). With h₋ = 0 the first half step, `v_½ = v_0 + (h/2) a_0`, is the same
//! formula.

use super::assembled::AssembledStep;
use super::branches::Branches;
use super::contact::ContactStep;
use super::energy::Energy;
use super::erosion::{erode, follow};
use super::failure::{Failure, FailureCause, Stop, check_block, check_collapse, fastest_stretched};
use super::interrupt::Ask;
use super::ledger::Ledger;
use super::loads;
use super::motion::Motion;
use super::phase::Phase;
use super::place::place_surfaces;
use super::rigid::{LARGEST_TURN, RigidStep};
use super::state::State;
use super::step_work::{Half, StepWork};
use super::stepper::{Extremes, Stepper};
use crate::mechanics::contact::{Contact, RigidSides};
use crate::mechanics::force::{Activity, ElementForces, ForceInput, Threads};
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;
use crate::plan::{Explicit, Plan};

/// Largest ratio of successive steps: the half-step scheme is accurate for slowly varying steps.
const LARGEST_GROWTH: f64 = 1.1;
/// Reduction of the largest strain increment in the step in which a pair first touches: bulk viscosity, and its bound
/// on the step, respond to the strain rate only afterwards.
const FIRST_TOUCH: f64 = 0.2;

/// Relative excess over the requested step that is tolerated, so that rounding does not cost a whole step.
const ROUNDING: f64 = 1e-9;

/// Advances a plan explicitly. Holds the work arrays of a step, so that a step allocates nothing; they carry nothing
/// between steps.
pub(super) struct ExplicitStepper<'p> {
    plan: &'p Plan,
    options: Explicit,
    threads: Threads,
    forces: ElementForces,
    assembled: AssembledStep<'p>,
    activity: Activity,
    /// Number of eroded elements accounted for.
    gone: usize,
    /// Whether elements at rest have been made inactive.
    has_been_inactive: bool,
    /// Number of elements evaluated last.
    evaluated: u64,
    strain: Vec<f64>,
    hourglass: Vec<f64>,
    /// Part of it in the branches of Prony series and in internal variables.
    branches: Branches,
    /// History of the elements for recorders; empty where no stress depends on it.
    history: Vec<Vec<Row>>,
    /// Energy dissipated by bulk viscosity in the step to t_n, by body [J].
    viscous: Vec<f64>,
    /// Sums with both halves of the work at t_n; moved to the state on advancing.
    ledger: Ledger,
    /// The balance at t_n, after [`Stepper::balance`].
    energy: Energy,
    motion: Motion,
    f_int: Vec<Vec3>,
    /// Viscous part of it [N]; empty if no part is viscous.
    f_viscous: Vec<Vec3>,
    /// Forces of loads at t_n [N]; empty if the plan has none.
    f_ext: Vec<Vec3>,
    /// Impulses on prescribed nodes [N s].
    prescribed: Vec<f64>,
    /// Impulses of the contacts on the nodes [N s]; empty if nothing is prescribed.
    touched: Vec<Vec3>,
    x: Vec<Vec3>,
    /// v₊, relative to the rigid-body velocity V [m/s].
    v_after: Vec<Vec3>,
    contact: Option<ContactStep<'p>>,
    rigid: Option<RigidStep<'p>>,
    /// Next step h₊ [s].
    step: f64,
    /// Extremes of the run so far.
    extremes: Extremes,
}

impl<'p> ExplicitStepper<'p> {
    pub fn new(plan: &'p Plan, options: Explicit, threads: Threads) -> Self {
        let nodes = plan.node_count();
        let forces = ElementForces::new(&plan.blocks);
        Self {
            plan,
            options,
            contact: plan.contact.as_ref().map(|c| ContactStep::new(plan, c, &threads)),
            threads,
            activity: Activity::everything(nodes, &forces),
            assembled: AssembledStep::new(plan),
            forces,
            gone: 0,
            has_been_inactive: false,
            evaluated: 0,
            strain: vec![0.0; plan.bodies.len()],
            hourglass: vec![0.0; plan.bodies.len()],
            branches: Branches::of(plan),
            history: plan.room_for_history(),
            viscous: vec![0.0; plan.bodies.len()],
            ledger: Ledger::new(plan),
            energy: Energy::with_capacity(plan),
            motion: Motion::new(plan),
            f_int: vec![Vec3::zeros(); nodes],
            f_viscous: vec![Vec3::zeros(); if plan.is_viscous() { nodes } else { 0 }],
            f_ext: vec![Vec3::zeros(); if plan.loads.has_forces() { nodes } else { 0 }],
            prescribed: vec![0.0; plan.loads.prescribed.len()],
            touched: vec![Vec3::zeros(); if plan.loads.prescribed.is_empty() { 0 } else { nodes }],
            x: vec![Vec3::zeros(); nodes],
            v_after: vec![Vec3::zeros(); nodes],
            rigid: plan.rigid.as_ref().map(RigidStep::new),
            step: 0.0,
            extremes: Extremes::NONE,
        }
    }
}

impl Stepper for ExplicitStepper<'_> {
    /// Computes everything at t_n up to the velocity v₊: internal forces, step size (at most `longest`, to reach the
    /// next time that must be met exactly), contact. The state is unchanged until [`Stepper::advance`], so that a copy
    /// of it restarts the run with the same bits.
    fn solve(&mut self, state: &State, phase: Phase, longest: f64, _: Ask) -> Result<(), Stop> {
        self.threads.clone().inside(|| self.solve_step(state, phase, longest))
    }

    /// Balances the ledger at t_n, after [`Stepper::solve`].
    fn balance(&mut self, state: &State) {
        let (mut ledger, mut energy) = (std::mem::take(&mut self.ledger), std::mem::take(&mut self.energy));
        let mut motion = std::mem::take(&mut self.motion);
        ledger.copy_from(&state.ledger);
        for (sum, dissipated) in ledger.viscous.iter_mut().zip(&self.viscous) {
            *sum += dissipated;
        }
        ledger.add_viscous(self.plan, state, &self.activity, (&self.f_viscous, &self.branches));
        ledger.add_projection(self.plan, &state.projected, &self.f_int);
        let work = self.work(state);
        if state.last_step == 0.0 {
            // At the start no work has been done, and the velocity is known at t_0 itself.
            let start = work.at_the_start();
            motion.eval(&self.threads, &start);
            ledger.balance(&start, &motion, &mut energy);
            ledger.add_work(&work, Half::Before);
            ledger.add_first_half_step(&work, &self.f_int);
        } else {
            ledger.add_work(&work, Half::Before);
            motion.eval(&self.threads, &work);
            ledger.balance(&work, &motion, &mut energy);
        }
        ledger.add_work(&work, Half::After);
        self.extremes.balance_error = self.extremes.balance_error.max(energy.balance_error);
        (self.ledger, self.motion, self.energy) = (ledger, motion, energy);
    }

    /// Advances to t_{n+1}, and projects out the penetration left by linearisation.
    fn advance(&mut self, state: &mut State, phase: Phase) {
        // Erode elements at t_n, before the displacement update.
        if let Phase::Running = phase {
            let forces = (&mut self.forces, &self.threads);
            erode(self.plan, forces, (state, &mut self.ledger, &self.branches), (self.step, &self.v_after));
        }
        // Displacement update of the active nodes.
        let (h, activity) = (self.step, &self.activity);
        let arrays = (&mut state.u[..], &mut self.v_after[..]);
        self.threads.for_each_run(Activity::NODES, arrays, |run, u, v_after| {
            if activity.active()[run] {
                u.iter_mut().zip(v_after).for_each(|(u, v)| *u += *v * h);
            }
        });
        self.plan.assembly.followers().follow(&mut state.u);
        // Nodes without integration have zero in both.
        std::mem::swap(&mut state.v, &mut self.v_after);
        std::mem::swap(&mut state.viscous_force, &mut self.f_viscous);
        self.forces.swap_history(&mut state.history);
        self.assembled.advance(state);
        // No ledger is kept during dynamic relaxation.
        if let Phase::Running = phase {
            self.extremes.evaluated_elements += self.evaluated;
            std::mem::swap(&mut self.ledger, &mut state.ledger);
        }
        // Advance the clock and the rigid bodies.
        state.last_step = self.step;
        state.time += self.step;
        state.step += 1;
        if let Some(rigid) = &self.rigid {
            rigid.advance(state);
        }
        // Position projection, with its work and the nodes it activates.
        self.place(state, phase);
        if let Some(contact) = &mut self.contact {
            state.projected.clear();
            let poses = self.rigid.as_mut().map_or(&mut [][..], RigidStep::poses_mut);
            let fraction = (self.step / self.plan.report.stable_step_s).min(1.0);
            let shifts = contact.project(self.plan, &mut self.x, poses, fraction);
            state.projected.extend_from_slice(shifts);
            for (orientation, pose) in state.orientations.iter_mut().zip(poses) {
                *orientation = pose.orientation;
            }
            for (node, du) in &state.projected {
                state.u[*node as usize] += du;
                self.forces.forget_lengths(&self.plan.assembly, *node);
            }
            let Plan { blocks, assembly, .. } = self.plan;
            let moved = state.projected.iter().map(|(node, _)| *node);
            self.activity.activate_nodes(&mut self.forces, blocks, assembly, moved);
            state.ledger.add_projection(self.plan, &state.projected, &self.f_int);
            self.plan.assembly.followers().follow(&mut state.u);
        }
    }

    fn note_history(&mut self) {
        self.forces.copy_history(&mut self.history);
    }

    fn history(&self) -> &[Vec<Row>] {
        &self.history
    }

    fn contacts(&self) -> (&[Contact], &[crate::mechanics::contact::Reaction]) {
        self.contact.as_ref().map_or((&[], &[]), ContactStep::results)
    }

    fn unconverged(&self) -> (u64, f64) {
        self.contact.as_ref().map_or((0, 0.0), |contact| contact.unconverged)
    }

    fn mean_step(&self, state: &State) -> f64 {
        0.5 * (state.last_step + self.step)
    }

    fn v_after<'a>(&'a self, _: &'a State) -> &'a [Vec3] {
        &self.v_after
    }

    fn energy(&self) -> &Energy {
        &self.energy
    }

    fn extremes(&self) -> &Extremes {
        &self.extremes
    }
}

impl ExplicitStepper<'_> {
    fn work<'a>(&'a self, state: &'a State) -> StepWork<'a> {
        let (contacts, reactions) = self.contacts();
        StepWork {
            plan: self.plan,
            state,
            v_after: &self.v_after,
            mean_step: self.mean_step(state),
            step_change: self.step - state.last_step,
            f_int: &self.f_int,
            contacts,
            reactions,
            gravity: loads::gravity(self.plan, Phase::Running.load_time(state.time)),
            f_ext: &self.f_ext,
            prescribed: &self.prescribed,
            strain: &self.strain,
            activity: &self.activity,
            hourglass: &self.hourglass,
            branches: &self.branches,
            rigid: self.rigid.as_ref().map(RigidStep::work),
        }
    }

    fn solve_step(&mut self, state: &State, phase: Phase, longest: f64) -> Result<(), Stop> {
        // Internal forces and critical time step at t_n.
        follow(self.plan, state, &mut self.gone, &mut self.forces, self.contact.as_mut());
        let (stable, stiffest) = self.evaluate(state)?;
        self.assembled.evaluate(&self.threads, &self.forces, state);
        self.deactivate_at_rest(state);
        self.place(state, phase);
        loads::eval_forces(self.plan, &state.u, phase.load_time(state.time), &mut self.f_ext);
        // A step shortened to meet a time is no sign of collapse, nor is the growth from it.
        check_collapse(self.plan, state, self.longest_stable(stable), || stiffest)?;
        let mut target = self.choose_step(state, stable);
        loop {
            // Equal steps to the time that must be met; at that time itself, the last step again.
            let count = (longest / target - ROUNDING).ceil().max(1.0);
            self.step = if longest > 0.0 { longest / count } else { target };
            self.accelerate(state, phase);
            self.solve_contact(state, phase)?;
            self.activate_reached();
            // Shorten the step if the strain increment or a rotation would be too large.
            let fraction = if self.touches_anew(state) { FIRST_TOUCH } else { 1.0 };
            let strain_limit = fraction * self.options.largest_strain_increment;
            let rate = self.forces.largest_stretch_rate(
                &self.threads,
                &self.plan.blocks,
                &self.v_after,
                self.step,
                strain_limit,
            );
            if !rate.is_finite() {
                let message = "A velocity became infinite or not a number.".into();
                return Err(Failure::new(state, FailureCause::NotFinite, message).into());
            }
            let spin = self.rigid.as_ref().map_or(0.0, |rigid| rigid.fastest_spin(&self.v_after));
            let excess = self.step * (rate / strain_limit).max(spin / LARGEST_TURN);
            if excess <= 1.0 {
                break;
            }
            target = self.step * (0.9 / excess).max(0.1);
            check_collapse(self.plan, state, target, || {
                fastest_stretched(self.plan, &state.u, &self.v_after)
            })?;
        }
        // Free rotation of rigid bodies, and the reactions of prescribed motion.
        if let Some(rigid) = &mut self.rigid {
            rigid.turn(state, &self.v_after, 1.0, self.step)?;
        }
        self.weigh_prescribed(state, phase);
        self.extremes.smallest_step = self.extremes.smallest_step.min(self.step);
        Ok(())
    }

    /// Evaluates internal forces; returns the critical time step and the element that determines it. Fails if an
    /// element is inverted or a fibre overstretched.
    fn evaluate(&mut self, state: &State) -> Result<(f64, Option<u32>), Failure> {
        self.strain.fill(0.0);
        self.hourglass.fill(0.0);
        self.viscous.fill(0.0);
        let input = ForceInput { v: &state.v, ..state.force_input() };
        self.forces.evaluate(&self.threads, &self.plan.blocks, &input);
        self.forces.add_viscous(&self.threads, &self.plan.blocks, &input, &state.v);
        self.branches.evaluate(self.plan, &self.forces);
        self.evaluated = self.forces.active_elements(&self.plan.blocks) as u64;
        let mut stable = (f64::INFINITY, None);
        for (index, block) in self.plan.blocks.iter().enumerate() {
            let totals = self.forces.totals(index);
            self.extremes.smallest_j = self.extremes.smallest_j.min(totals.smallest_j.0);
            check_block(self.plan, block, &totals, state)?;
            self.strain[block.body] += totals.strain + totals.branches;
            self.hourglass[block.body] += totals.hourglass;
            self.viscous[block.body] += totals.viscous;
            let (step, slot) = totals.stable_step;
            if step < stable.0 {
                stable = (step, block.elements.get(slot).copied());
            }
        }
        Ok(stable)
    }

    /// Deactivates elements at rest, after the first evaluation, which covers all elements.
    fn deactivate_at_rest(&mut self, state: &State) {
        if self.plan.skip_inactive_elements && !self.has_been_inactive {
            let Plan { blocks, assembly, .. } = self.plan;
            self.activity.deactivate_at_rest(&mut self.forces, blocks, assembly, (&state.u, &state.v));
            self.has_been_inactive = true;
        }
    }

    /// Activates the elements reached by the forces and the contacts of this step.
    fn activate_reached(&mut self) {
        let Plan { blocks, assembly, .. } = self.plan;
        let Self { activity, forces, v_after, contact, .. } = self;
        activity.activate_moving(forces, blocks, assembly, v_after);
        let contacts = contact.as_ref().map_or(&[][..], |contact| contact.results().0);
        let nodes = contacts.iter().flat_map(|contact| contact.stencil.nodes().iter().copied());
        let moving = nodes.filter(|node| v_after[*node as usize] != Vec3::zeros());
        activity.activate_nodes(forces, blocks, assembly, moving);
    }

    /// Absolute positions x_n of the contact surfaces, the only ones needed.
    fn place(&mut self, state: &State, phase: Phase) {
        let surfaces = self.contact.as_ref().map_or(&[][..], ContactStep::surfaces);
        place_surfaces(self.plan, surfaces, (state, phase), &mut self.x);
        if let Some(rigid) = &mut self.rigid {
            rigid.place(self.plan, state, phase, &mut self.x);
        }
    }

    /// Admissible fraction of the critical time step, within the maximum of the scene [s].
    fn longest_stable(&self, stable: f64) -> f64 {
        (self.options.safety * stable).min(self.options.max_step)
    }

    fn choose_step(&self, state: &State, stable: f64) -> f64 {
        let mut step = self.longest_stable(stable);
        if state.last_step > 0.0 {
            step = step.min(LARGEST_GROWTH * state.last_step);
        }
        step
    }

    /// Evaluates f_int, the sum of the elastic and viscous element forces, and v* = v₋ + h̄ M⁻¹ f; during dynamic
    /// relaxation with the damping −α M v at the mean velocity.
    fn accelerate(&mut self, state: &State, phase: Phase) {
        let mean_step = self.mean_step(state);
        let Self { plan, forces, activity, f_ext, f_viscous, .. } = self;
        // Viscous forces at the moving nodes.
        let gravity = loads::gravity(plan, phase.load_time(state.time));
        let damping = 0.5 * phase.damping() * mean_step;
        for node in activity.stepped(0..f_viscous.len() as u32) {
            f_viscous[node] = forces.viscous_at_node(&plan.assembly, node);
        }
        // Contact-free velocity of the active nodes.
        let arrays = (&mut self.f_int[..], &mut self.v_after[..]);
        self.threads.for_each_run(Activity::NODES, arrays, |run, f_int, v_after| {
            if !activity.active()[run] {
                return;
            }
            for (i, (f_int, v_after)) in f_int.iter_mut().zip(v_after).enumerate() {
                let node = run * Activity::NODES + i;
                *f_int = forces.at_node(&plan.assembly, node);
                if let Some(viscous) = f_viscous.get(node) {
                    *f_int += viscous;
                }
                let mut force = gravity * plan.mass[node] - *f_int;
                if let Some(load) = f_ext.get(node) {
                    force += load;
                }
                let v = state.v[node] + force.component_mul(&plan.inverse_mass[node]) * mean_step;
                *v_after = if damping > 0.0 { (v - state.v[node] * damping) / (1.0 + damping) } else { v };
            }
        });
        // Prescribed components follow their displacement.
        let end = phase.load_time(state.time + self.step);
        for p in &plan.loads.prescribed {
            let node = p.node as usize;
            let way = plan.loads.displacement(p, end) - state.u[node][p.axis];
            self.v_after[node][p.axis] = way / self.step;
        }
        if let Some(rigid) = &self.rigid {
            rigid.damp(state, damping, &mut self.v_after);
        }
        self.plan.assembly.followers().follow(&mut self.v_after);
    }

    /// Evaluates the impulses required by prescribed motion, given the contact reactions.
    fn weigh_prescribed(&mut self, state: &State, phase: Phase) {
        let mean_step = self.mean_step(state);
        let Self { plan, f_int, f_ext, v_after, contact, rigid, prescribed, touched, .. } = self;
        let (contacts, reactions) = contact.as_ref().map_or((&[][..], &[][..]), ContactStep::results);
        let sides = rigid.as_ref().map_or(RigidSides::NONE, |rigid| rigid.work().sides);
        let gravity = loads::gravity(plan, phase.load_time(state.time));
        let forces = [&f_int[..], f_ext];
        loads::weigh_prescribed(
            plan,
            [&state.v, v_after],
            forces,
            (gravity, mean_step),
            (contacts, reactions, &sides),
            touched,
            prescribed,
        );
    }

    /// Whether a pair has its first reactions in this step.
    fn touches_anew(&self, state: &State) -> bool {
        let (contacts, reactions) = self.contacts();
        contacts.iter().zip(reactions).any(|(c, r)| r.impulse[0] != 0.0 && !state.ledger.has_touched(c.pair))
    }

    fn solve_contact(&mut self, state: &State, phase: Phase) -> Result<(), Failure> {
        let Some(contact) = &mut self.contact else { return Ok(()) };
        let rigid = self.rigid.as_ref();
        let solved = contact.solve(self.plan, rigid, &self.x, self.step, phase, &mut self.v_after);
        self.plan.assembly.followers().follow(&mut self.v_after);
        self.extremes.most_contacts = self.extremes.most_contacts.max(contact.results().0.len());
        solved.map_err(|(cause, message)| Failure::new(state, cause, message))
    }
}
