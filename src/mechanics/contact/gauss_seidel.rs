//! Block Gauss–Seidel over the contacts of a step, on nodal velocities: the Delassus operator is never formed.
//!
//! Unknowns are the impulses `p = (p_n, p_t1, p_t2)` [N s] of each contact. With M lumped, C the local relative
//! velocity `v_slave − Σ w_a v_a + drift` and `h` the step,
//!
//! ```text
//! v⁺ = v* + M⁻¹ Cᵀ p,     u = C v⁺ + drift + (max(gap, 0)/h) n,     K_μ ∋ p ⊥ u + μ ‖u_t‖ n ∈ K_μ*
//! ```
//!
//! so that `u_n ≥ 0` is the end-of-step gap over h (Stewart & Trinkle; Moreau). A negative gap enters as zero: it is
//! removed by [`super::projection`], never by velocity. Each visit solves one contact exactly ([`super::local`]) and
//! adds what changed to the velocities of its nodes at once. The order is that of the list, so results are
//! reproducible. Where sweeps stop making progress (strong friction may cycle), steps with friction are damped.
//!
//! μ = ∞ (nothing slips) is discontinuous where a contact is about to open: a knot of such contacts may have no
//! solution, and then the sweeps do not converge and say so; a large finite μ has one.
//!
//! Rigid bodies on each other couple their contacts over many, and a tower that sticks bends like a beam: sweeps alone would
//! take tens of thousands. Where a slave is a rigid body, so that no mesh is between, each sweep is therefore a step of a nonlinear
//! conjugate gradient (Silcowitz-Hansen, Niebe & Erleben 2010, "A nonsmooth nonlinear conjugate gradient method for interactive
//! contact force problems"): what it changed is the gradient, and the last direction is added once more, unless changes have grown. The
//! result is that of a sweep, so it obeys the law as it does without.
//!
//! Everywhere else sweeps that go on for long are extrapolated (`extrapolation.rs`): nodes, edges and faces of a mesh that hold the same
//! rigid body depend on each other so closely that sweeps alone take hundreds.
//!
//! A pair whose law is [`ContactLaw::Frictionless`] has one unknown per contact: no tangents and no 3×3 blocks anywhere.
//! The law is chosen once for a run of contacts. Coulomb's law with μ = 0 has three unknowns, and gives the same normal impulses and end
//! velocities to the last bit: its tangential ones are exact zeros, and no residual counts what friction does not resist.

mod extrapolation;
mod rows;

use super::contact_row::{Levers, NormalRow, Row};
use super::local::Local;
use super::{Contact, ContactLaw, Kind, Reaction, RigidSides};
use crate::mechanics::tensor::Vec3;
use extrapolation::Extrapolation;
use rows::{Block, Friction, Rows, Sums};

/// Residuals below this many roundings of the velocities they come from cannot be lowered.
const ROUNDINGS: f64 = 16.0;
/// Sweeps between two looks at progress.
const PATIENCE: usize = 50;
/// The same where directions are conjugate: changes grow and fall on the way.
const CONJUGATE_PATIENCE: usize = 500;
/// Progress over them below this ratio of changes is none.
const STALLED: f64 = 0.9;
/// Sweeps that must lower the change of a sweep to a half, or those at an acceptable residual are ended.
const LAST_LOOKS: usize = 250;
/// Largest residual against the free velocities, over the tolerance, of a converged solution: so many times larger may the impulses be
/// than those velocities ask for by themselves.
const HIDDEN: f64 = 1e4;
/// Factor on the steps of frictional contacts each time there was none, and its least value.
const DAMPING: (f64, f64) = (0.7, 0.05);

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Largest scaled residual [-] of a converged solution.
    pub tolerance: f64,
    /// Most sweeps over all contacts.
    pub max_sweeps: usize,
    /// Scaled residual [-] at which sweeps that make no progress are ended.
    pub acceptable: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_sweeps: 1000, acceptable: 0.0 }
    }
}

/// How the solution ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// Sweeps over all contacts.
    pub sweeps: usize,
    /// Scaled natural-map residual [-]: `‖D^½ F‖ / max(‖D^½ p‖, ‖D^−½ q‖)`, with `D = tr W_cc / 3` a contact, F at
    /// `ρ = 1/D`, and q the free relative velocities of the contacts that close.
    pub residual: f64,
    /// The same against the free velocities alone, `‖D^½ F‖ / ‖D^−½ q‖` [-]: no growth of the impulses hides a contact that nothing
    /// can stop.
    pub residual_of_free: f64,
    /// The residual is within the tolerance, or at the rounding of the velocities.
    pub converged: bool,
}

/// Memory of the solver, kept by the caller between steps so that nothing is allocated.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    meshes: Rows<()>,
    rigid: Rows<Levers>,
    blocks: Vec<Block>,
    conjugate: Conjugate,
    extrapolation: Extrapolation,
}

/// The direction of the conjugate gradient; empty where no rigid body touches a plane or another.
#[derive(Clone, Debug, Default)]
struct Conjugate {
    /// Impulses before the sweep.
    before: Vec<Local>,
    direction: Vec<Local>,
}

/// Finds impulses and end velocities so that every contact obeys its law.
///
/// `contacts` sorted by pair; `laws` one a pair; `inverse_mass` per node and axis [1/kg], 0 where fixed; `h` [s] the step
/// over which the end velocities act; `v` [m/s] per node, v* in, v⁺ out; `reactions` is resized to the contacts. Nodes
/// without a reaction keep their bits.
///
/// Contacts whose both sides are immovable along n get no reaction. Does not allocate once `workspace` has grown.
#[allow(clippy::too_many_arguments)] // each is an array of its own owner; a struct of borrows would only rename them
pub fn solve(
    contacts: &[Contact],
    laws: &[ContactLaw],
    inverse_mass: &[Vec3],
    h: f64,
    v: &mut [Vec3],
    reactions: &mut Vec<Reaction>,
    options: &Options,
    workspace: &mut Workspace,
) -> SolveReport {
    let none = RigidSides::NONE;
    solve_with_rigid(contacts, laws, &none, inverse_mass, h, v, reactions, options, workspace)
}

/// As [`solve`], where sides may be rigid bodies.
///
/// W may have a rank far below the number of contacts then (four corners of one face): the impulses are not unique, but the
/// motion is, and the sweeps converge to one of the solutions.
#[allow(clippy::too_many_arguments)] // as for `solve`
pub fn solve_with_rigid(
    contacts: &[Contact],
    laws: &[ContactLaw],
    rigid: &RigidSides,
    inverse_mass: &[Vec3],
    h: f64,
    v: &mut [Vec3],
    reactions: &mut Vec<Reaction>,
    options: &Options,
    workspace: &mut Workspace,
) -> SolveReport {
    reactions.clear();
    reactions.resize(contacts.len(), Reaction::default());
    workspace.prepare(contacts, laws, rigid, inverse_mass, h);

    // What the contacts that close ask for; if none does, p = 0 is the solution.
    let closing = workspace.closing(v);
    if closing == 0.0 {
        return SolveReport { sweeps: 0, residual: 0.0, residual_of_free: 0.0, converged: true };
    }

    let (mut residual, mut residual_of_free) = (f64::INFINITY, f64::INFINITY);
    let (mut damping, mut last_look) = (1.0, f64::INFINITY);
    let (mut last_change, mut half, mut least) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    let start = workspace.start_without_friction(inverse_mass, v, reactions, options);
    let patience = if workspace.conjugate.direction.is_empty() { PATIENCE } else { CONJUGATE_PATIENCE };
    for sweep in 1..=options.max_sweeps {
        workspace.remember(reactions);
        let sums = workspace.sweep(inverse_mass, v, reactions, Friction::Damped(damping));
        let change = sums.change;
        least = least.min(change);
        if sweep % patience == 0 {
            let change = least.sqrt() / damping;
            if change > STALLED * last_look {
                damping = (DAMPING.0 * damping).max(DAMPING.1);
            }
            (last_look, least) = (change, f64::INFINITY);
        }
        let hint = (sums.change / closing.max(sums.impulse)).sqrt();
        let is_stuck = sweep % LAST_LOOKS == 0 && hint / damping > half && options.acceptable > 0.0;
        if sweep % LAST_LOOKS == 0 {
            half = 0.5 * hint / damping;
        }
        // The change of a sweep only hints at the residual, at no cost; a look at all contacts decides.
        if sweep == 1 || is_stuck || hint <= 10.0 * options.tolerance || sweep == options.max_sweeps {
            let sums = workspace.measure(v, reactions);
            residual = (sums.change / closing.max(sums.impulse)).sqrt();
            residual_of_free = (sums.change / closing).sqrt();
            let rounding = ROUNDINGS * f64::EPSILON * sums.rounding.sqrt();
            // Impulses that grow without end must not hide what they do not stop.
            let is_small = residual <= options.tolerance && residual_of_free <= HIDDEN * options.tolerance;
            if is_small || sums.change.sqrt() <= rounding {
                return SolveReport { sweeps: start + sweep, residual, residual_of_free, converged: true };
            }
            if is_stuck && residual <= options.acceptable {
                return SolveReport { sweeps: start + sweep, residual, residual_of_free, converged: false };
            }
        }
        if damping >= 1.0 && sweep < options.max_sweeps {
            workspace.go_on(change, last_change, inverse_mass, v, reactions);
            last_change = change;
        }
    }
    SolveReport { sweeps: start + options.max_sweeps, residual, residual_of_free, converged: false }
}

impl Workspace {
    /// With room for so many contacts of so many pairs, and for so many where a side is a rigid body.
    pub fn with_capacity(contacts: usize, rigid_contacts: usize, pairs: usize) -> Self {
        Self {
            meshes: Rows::with_capacity(contacts),
            rigid: Rows::with_capacity(rigid_contacts),
            blocks: Vec::with_capacity(pairs + contacts),
            extrapolation: Extrapolation::with_capacity(contacts + rigid_contacts),
            conjugate: Conjugate::with_capacity(if rigid_contacts > 0 {
                contacts + rigid_contacts
            } else {
                0
            }),
        }
    }

    fn prepare(
        &mut self,
        contacts: &[Contact],
        laws: &[ContactLaw],
        rigid: &RigidSides,
        inverse_mass: &[Vec3],
        h: f64,
    ) {
        self.meshes.clear();
        self.rigid.clear();
        self.blocks.clear();
        let mut start = 0;
        let is_alike =
            |a: &Contact, b: &Contact| a.pair == b.pair && (a.kind == Kind::Side) == (b.kind == Kind::Side);
        for run in contacts.chunk_by(is_alike) {
            let law = run[0].law(laws);
            let sides = rigid.of_pair(run[0].pair);
            let turns = sides != [None; 2];
            let rows = if turns {
                let levers = |c: &Contact| Levers::new(c, sides, rigid);
                self.rigid.extend(
                    law,
                    run.iter().map(|c| (c, levers(c))),
                    |(c, levers)| NormalRow::turning(c, inverse_mass, h, levers),
                    |(c, levers)| Row::turning(c, inverse_mass, h, levers),
                )
            } else {
                self.meshes.extend(
                    law,
                    run.iter(),
                    |c| NormalRow::new(c, inverse_mass, h),
                    |c| Row::new(c, inverse_mass, h),
                )
            };
            self.blocks.push(Block { law, turns, contacts: start..start + run.len(), rows });
            start += run.len();
        }
        self.extrapolation.restart();
        let has_no_mesh = |c: &Contact| rigid.of_pair(c.pair)[0].is_some();
        self.conjugate.restart(if contacts.iter().any(has_no_mesh) { contacts.len() } else { 0 });
    }

    /// What a sweep starts from.
    fn remember(&mut self, reactions: &[Reaction]) {
        if self.conjugate.direction.is_empty() {
            self.extrapolation.remember(reactions);
        } else {
            self.conjugate.remember(reactions);
        }
    }

    /// Goes on from what a sweep led to, which changed the impulses by `change` and the one before by `last_change` (squares).
    fn go_on(
        &mut self,
        change: f64,
        last_change: f64,
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
    ) {
        let step = if self.conjugate.direction.is_empty() {
            self.extrapolation.step(reactions, change)
        } else {
            Some(self.conjugate.step(reactions, change / last_change))
        };
        let Some(step) = step else { return };
        for block in &self.blocks {
            let contacts = block.contacts.clone();
            let (reactions, step) = (&mut reactions[contacts.clone()], &step[contacts]);
            if block.turns {
                self.rigid.add(block, step, inverse_mass, v, reactions);
            } else {
                self.meshes.add(block, step, inverse_mass, v, reactions);
            }
        }
    }

    /// `Σ D⁻¹ |q|²` of the contacts that close; without friction tangential velocities ask for nothing.
    fn closing(&self, v: &[Vec3]) -> f64 {
        let mut closing = 0.0;
        for block in &self.blocks {
            if block.turns {
                self.rigid.add_closing(block, v, &mut closing);
            } else {
                self.meshes.add_closing(block, v, &mut closing);
            }
        }
        closing
    }

    /// Where a slave is a rigid body: the normal impulses as they would be without friction, which are most of what a pile of
    /// bodies carries and are found in far fewer sweeps. The number of sweeps.
    fn start_without_friction(
        &mut self,
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
        options: &Options,
    ) -> usize {
        if self.conjugate.direction.is_empty() {
            return 0;
        }
        let (mut sweeps, mut last_change) = (0, f64::INFINITY);
        while sweeps < options.max_sweeps {
            sweeps += 1;
            self.remember(reactions);
            let sums = self.sweep(inverse_mass, v, reactions, Friction::None);
            if sums.change <= (options.tolerance * options.tolerance) * sums.impulse {
                break;
            }
            self.go_on(sums.change, last_change, inverse_mass, v, reactions);
            last_change = sums.change;
        }
        self.conjugate.restart(reactions.len());
        sweeps
    }

    fn sweep(
        &self,
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
        friction: Friction,
    ) -> Sums {
        let mut sums = Sums::default();
        for block in &self.blocks {
            let reactions = &mut reactions[block.contacts.clone()];
            if block.turns {
                self.rigid.sweep(block, friction, inverse_mass, v, reactions, &mut sums);
            } else {
                self.meshes.sweep(block, friction, inverse_mass, v, reactions, &mut sums);
            }
        }
        sums
    }

    /// The natural map of all contacts at the present velocities.
    fn measure(&self, v: &[Vec3], reactions: &[Reaction]) -> Sums {
        let mut sums = Sums::default();
        for block in &self.blocks {
            let reactions = &reactions[block.contacts.clone()];
            if block.turns {
                self.rigid.measure(block, v, reactions, &mut sums);
            } else {
                self.meshes.measure(block, v, reactions, &mut sums);
            }
        }
        sums
    }
}

impl Conjugate {
    fn with_capacity(contacts: usize) -> Self {
        Self { before: Vec::with_capacity(contacts), direction: Vec::with_capacity(contacts) }
    }

    fn restart(&mut self, contacts: usize) {
        self.direction.clear();
        self.direction.resize(contacts, [0.0; 3]);
    }

    fn remember(&mut self, reactions: &[Reaction]) {
        self.before.clear();
        self.before.extend(reactions.iter().map(|reaction| reaction.impulse));
    }

    /// The step `β d` along the last direction d, none where changes grow (β ≥ 1), and the next one, `β d + (p − p_before)`.
    fn step(&mut self, reactions: &[Reaction], beta: f64) -> &[Local] {
        let beta = if beta < 1.0 { beta } else { 0.0 };
        for ((direction, before), reaction) in self.direction.iter_mut().zip(&mut self.before).zip(reactions)
        {
            for i in 0..3 {
                let step = beta * direction[i];
                direction[i] = step + (reaction.impulse[i] - before[i]);
                before[i] = step;
            }
        }
        &self.before
    }
}

#[cfg(test)]
mod tests;
