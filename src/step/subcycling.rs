//! Sizes of explicit steps, the cycle of subcycling that a step is in, and the energy that goes with intervals of different lengths.

use super::phase::Phase;
use super::state::State;
use crate::mechanics::contact::Contact;
use crate::mechanics::force::{Activity, CycleLimits, ElementForces, ForceInput, Subcycles, Threads};
use crate::mechanics::tensor::Vec3;
use crate::plan::{Explicit, Plan};

/// Largest ratio of successive steps: the half-step scheme is accurate for slowly varying steps.
const LARGEST_GROWTH: f64 = 1.1;
/// Relative excess over the requested step that is tolerated, so that rounding does not cost a whole step.
const ROUNDING: f64 = 1e-9;
/// The same within a cycle: the critical time step, of which only a fraction is used, changes within it.
const CYCLE_SLACK: f64 = 0.05;
/// Steps from one look at whether subcycling is worthwhile to the next, outside a cycle.
const STEPS_WITHOUT_CYCLE: u64 = 8;

/// The cycle of a step.
pub(super) struct Subcycling<'p> {
    plan: &'p Plan,
    options: Explicit,
    cycle: Subcycles,
    /// What [`StepWork::change`](super::step_work::StepWork) is.
    change: Vec<Vec3>,
}

impl<'p> Subcycling<'p> {
    pub fn new(plan: &'p Plan, options: Explicit) -> Self {
        let may = plan.may_subcycle();
        Self {
            plan,
            options,
            cycle: Subcycles::new(if may { &plan.blocks } else { &[] }),
            change: vec![Vec3::zeros(); if may { plan.node_count() } else { 0 }],
        }
    }

    /// Takes the cycle of a state; returns the longest step to the next time that must be met, `longest` without a cycle [s].
    pub fn take(&mut self, state: &State, longest: f64) -> f64 {
        self.cycle.take(&state.subcycles, state.time, longest);
        self.cycle.next_time().map_or(longest, |time| time - state.time)
    }

    /// Admissible fraction of the critical time step, within the maximum of the scene [s].
    pub fn longest_stable(&self, stable: f64) -> f64 {
        (self.options.safety * stable).min(self.options.max_step)
    }

    /// The step to aim at [s], from the critical time step.
    pub fn choose_step(&self, state: &State, stable: f64) -> f64 {
        let step = self.longest_stable(stable);
        // A step of the cycle that was divided is none that grows.
        let grown = (LARGEST_GROWTH * state.last_step).max(self.cycle.step());
        if state.last_step > 0.0 { step.min(grown) } else { step }
    }

    /// Equal steps of about `target` to a time `longest` from now, which must be met; at that time itself, the last step again [s].
    pub fn divide(&self, longest: f64, target: f64) -> f64 {
        let slack = if self.cycle.step() > 0.0 { CYCLE_SLACK } else { ROUNDING };
        let count = (longest / target - slack).ceil().max(1.0);
        if longest > 0.0 { longest / count } else { target }
    }

    /// Which elements are evaluated.
    pub fn cycle(&self) -> &Subcycles {
        &self.cycle
    }

    /// What an evaluation at t_n reads.
    pub fn force_input<'a>(&'a self, state: &'a State) -> ForceInput<'a> {
        ForceInput { subcycles: Some(&self.cycle), ..state.force_input() }
    }

    /// What the ledger adds to `(h₊ − h₋) f_int`; empty without a cycle [N s].
    pub fn change(&self) -> &[Vec3] {
        if self.cycle.are_active() { &self.change } else { &[] }
    }

    /// Evaluates what `(h₊ − h₋) f_int` lacks of the sum over elements of their forces times the differences of their own intervals; `h` are the
    /// steps before and after [s].
    pub fn note_change(&mut self, forces: &ElementForces, activity: &Activity, h: [f64; 2]) {
        if !self.cycle.are_active() || !self.cycle.are_synchronised() {
            return;
        }
        let (assembly, difference) = (&self.plan.assembly, 2.0 * (h[1] - h[0]) / (h[0] + h[1]));
        for node in activity.stepped(0..self.change.len() as u32) {
            let impulse =
                forces.impulse_at_node(assembly, node) + forces.viscous_impulse_at_node(assembly, node);
            self.change[node] = forces.change_at_node(assembly, node) - impulse * difference;
        }
    }

    /// Goes on by a step [s] before the clock does, and prepares the next cycle where one is over.
    pub fn advance(
        &mut self,
        (state, phase): (&mut State, Phase),
        (threads, forces): (&Threads, &mut ElementForces),
        contacts: &[Contact],
        step: f64,
    ) {
        let Self { plan, options, cycle, .. } = self;
        if !plan.may_subcycle() {
            return;
        }
        std::mem::swap(cycle, &mut state.subcycles);
        let cycle = &mut state.subcycles;
        let (was_active, last) = (cycle.are_active(), step.max(cycle.step()));
        let is_over = cycle.advance(state.time + step, forces, options.safety);
        let is_due = was_active || state.step.is_multiple_of(STEPS_WITHOUT_CYCLE);
        if is_over && is_due && matches!(phase, Phase::Running) {
            let touched = contacts.iter().flat_map(|contact| contact.stencil.nodes().iter().copied());
            let limits = CycleLimits {
                longest: options.max_step.min(LARGEST_GROWTH * last),
                safety: options.safety,
                strain: options.largest_strain_increment,
            };
            cycle.prepare((threads, forces), (&plan.blocks, &plan.assembly), touched, &limits);
        }
    }
}
