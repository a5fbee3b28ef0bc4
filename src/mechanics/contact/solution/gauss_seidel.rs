//! Block Gauss–Seidel over the contacts of a step, on nodal velocities: matrix-free, without forming the Delassus
//! operator.
//!
//! Unknowns are the impulses `p = (p_n, p_t1, p_t2)` [N s] of each contact. With M lumped, C the local relative
//! velocity `v_slave − Σ w_a v_a + drift` and `h` the step,
//!
//! ```text
//! v⁺ = v* + M⁻¹ Cᵀ p,     u = C v⁺ + drift + (max(gap, 0)/h) n,     K_μ ∋ p ⊥ u + μ ‖u_t‖ n ∈ K_μ*
//! ```
//!
//! so that `u_n ≥ 0` is the end-of-step gap over h (Stewart & Trinkle; Moreau). A negative gap enters as zero: it is
//! removed by [`crate::contact::projection::meshes`], never by velocity. Each visit solves one contact exactly ([`super::local`]) and
//! immediately adds the change to the velocities of its nodes. The order is that of the list, so results are
//! reproducible. Where sweeps stop making progress (strong friction may cycle), frictional steps are damped.
//!
//! μ = ∞ (full stick) is discontinuous where a contact is about to open: a cluster of such contacts may have no
//! solution, and then the sweeps report that they do not converge; a large finite μ has one.
//!
//! Stacked rigid bodies couple many contacts, and a tower that sticks bends like a beam: sweeps alone would take tens
//! of thousands of iterations. Where a slave is a rigid body, so that no mesh is in between, each sweep is therefore
//! a step of a nonlinear conjugate gradient (Silcowitz-Hansen, Niebe & Erleben 2010, "A nonsmooth nonlinear conjugate
//! gradient method for interactive contact force problems"): its change is the gradient, and the last direction is
//! added once more, unless changes have grown. The result is that of a sweep, so it obeys the same law.
//!
//! Elsewhere long sequences of sweeps are extrapolated (`extrapolation.rs`): nodes, edges and faces of a mesh that
//! hold the same rigid body are so strongly coupled that sweeps alone take hundreds.
//!
//! Contacts that share no movable node are problems of their own: what is not solved soon is swept group by group (`groups.rs`), so that a
//! hard group costs nothing in the others, and is extrapolated by itself.
//!
//! A pair whose law is [`ContactLaw::Frictionless`](crate::contact::ContactLaw::Frictionless) has one unknown per contact: no tangents and no 3×3 blocks.
//! The law is chosen once for a run of contacts. Coulomb's law with μ = 0 has three unknowns, and gives the same
//! normal impulses and end velocities to the last bit: its tangential impulses are exact zeros, and the residual
//! excludes what friction does not resist.

mod conjugate;
mod extrapolation;
mod groups;
mod rows;

use super::contact_row::{MomentArms, NormalRow, Row};
use crate::contact::{Contact, Reaction, RigidSides};
use crate::tensor::Vec3;
use conjugate::Conjugate;
use extrapolation::Extrapolation;
use groups::Groups;
use rows::{Block, Friction, Rows, Sums};

/// Residuals below this multiple of the rounding of the velocities that they come from cannot be reduced.
const ROUNDINGS: f64 = 16.0;
/// Sweeps over all contacts before those that are not connected go on by themselves.
const TOGETHER: usize = 50;
/// Sweeps between two checks of progress.
const PATIENCE: usize = 50;
/// The same for conjugate directions: their changes grow and fall on the way.
const CONJUGATE_PATIENCE: usize = 500;
/// Ratio of changes between two checks above which sweeps make no progress.
const STALLED: f64 = 0.9;
/// Sweeps within which the change of a sweep must halve; otherwise they end at an acceptable residual.
const LAST_LOOKS: usize = 250;
/// Largest residual relative to the free velocities, over the tolerance, of a converged solution: the factor by which
/// impulses may exceed those that the free velocities alone require.
const HIDDEN: f64 = 1e4;
/// Factor on the steps of frictional contacts whenever sweeps make no progress, and its least value.
const DAMPING: (f64, f64) = (0.7, 0.05);

/// Stopping criteria of the sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Largest scaled residual [-] of a converged solution.
    pub tolerance: f64,
    /// Largest number of sweeps over all contacts.
    pub max_sweeps: usize,
    /// Scaled residual [-] at which sweeps that make no progress stop.
    pub acceptable: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_sweeps: 1000, acceptable: 0.0 }
    }
}

/// Outcome of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// Sweeps over all contacts.
    pub sweeps: usize,
    /// Scaled natural-map residual [-]: `‖D^½ F‖ / max(‖D^½ p‖, ‖D^−½ q‖)`, with `D = tr W_cc / 3` per contact, F at
    /// `ρ = 1/D`, and q the free relative velocities of the closing contacts.
    pub residual: f64,
    /// The same relative to the free velocities alone, `‖D^½ F‖ / ‖D^−½ q‖` [-], so that growing impulses cannot hide
    /// a contact that nothing can stop.
    pub residual_of_free: f64,
    /// The residual is within the tolerance, or at the rounding of the velocities.
    pub converged: bool,
}

/// Buffers of the solver, kept by the caller between steps so that nothing is allocated.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    meshes: Rows<()>,
    rigid: Rows<MomentArms>,
    blocks: Vec<Block>,
    conjugate: Conjugate,
    extrapolation: Extrapolation,
    groups: Groups,
}

/// Finds impulses and end velocities such that every contact obeys its law.
///
/// `contacts` sorted by pair; `inverse_mass` per node and axis [1/kg], 0 where fixed; `h` [s]
/// the step over which the end velocities act; `v` [m/s] per node, v* in, v⁺ out; `reactions` is resized to the
/// contacts. Velocities of nodes without a reaction keep their bits.
///
/// Contacts with both sides immovable along n get no reaction. Does not allocate once `workspace` has grown.
#[allow(clippy::too_many_arguments)] // each is an array of its own owner; a struct of borrows would only rename them
pub fn solve(
    contacts: &[Contact],
    inverse_mass: &[Vec3],
    h: f64,
    v: &mut [Vec3],
    reactions: &mut Vec<Reaction>,
    options: &Options,
    workspace: &mut Workspace,
) -> SolveReport {
    let none = RigidSides::NONE;
    solve_with_rigid(contacts, &none, inverse_mass, h, v, reactions, options, workspace)
}

/// As [`solve`], with sides that may be rigid bodies.
///
/// The rank of W may then be far below the number of contacts (four corners of one face): the impulses are not
/// unique, but the motion is, and the sweeps converge to one of the solutions.
#[allow(clippy::too_many_arguments)] // as for `solve`
pub fn solve_with_rigid(
    contacts: &[Contact],
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
    workspace.prepare(contacts, rigid, inverse_mass, h);

    // The scale of the residual; if no contact closes, p = 0 is the solution.
    let closing = workspace.closing(v);
    if closing == 0.0 {
        return SolveReport { sweeps: 0, residual: 0.0, residual_of_free: 0.0, converged: true };
    }
    let scale = Scale { closing, size: None };
    let mut sweeps = Sweeps::beginning(options);
    sweeps.done = workspace.start_without_friction(inverse_mass, v, reactions, options);
    // Most problems are solved in few sweeps over all contacts.
    let together = TOGETHER.min(options.max_sweeps);
    let report = workspace.sweep_until(together, &mut sweeps, &scale, inverse_mass, v, reactions);
    if report.converged || together >= options.max_sweeps {
        return report;
    }
    // In others one group of contacts holds up all: each goes on by itself.
    let mut groups = std::mem::take(&mut workspace.groups);
    groups.find(contacts, rigid, inverse_mass);
    let report = if groups.are_one() {
        workspace.sweep_until(options.max_sweeps, &mut sweeps, &scale, inverse_mass, v, reactions)
    } else {
        let size = closing.max(workspace.measure(v, reactions).impulse);
        let longest =
            groups.solve(contacts, rigid, (inverse_mass, h, v), reactions, options, [closing, size]);
        let sums = workspace.measure(v, reactions);
        scale.report(sweeps.done + longest, &sums, options.tolerance)
    };
    workspace.groups = groups;
    report
}

/// What residuals are relative to.
#[derive(Clone, Copy, Debug)]
struct Scale {
    /// `Σ D⁻¹ |q|²` of the closing contacts.
    closing: f64,
    /// The larger of that and of the squared norm of the impulses, if it is given; otherwise that of the impulses found.
    size: Option<f64>,
}

impl Scale {
    /// The report on sums of the natural map after so many sweeps.
    fn report(&self, sweeps: usize, sums: &Sums, tolerance: f64) -> SolveReport {
        let size = self.size.unwrap_or(self.closing.max(sums.impulse));
        let (residual, residual_of_free) = ((sums.change / size).sqrt(), (sums.change / self.closing).sqrt());
        let rounding = ROUNDINGS * f64::EPSILON * sums.rounding.sqrt();
        // Growing impulses must not hide a contact that they do not stop.
        let is_small = residual <= tolerance && residual_of_free <= HIDDEN * tolerance;
        SolveReport {
            sweeps,
            residual,
            residual_of_free,
            converged: is_small || sums.change.sqrt() <= rounding,
        }
    }
}

/// How far sweeps have come.
#[derive(Clone, Copy, Debug)]
struct Sweeps<'a> {
    options: &'a Options,
    /// Number of sweeps without friction, and of those with it.
    done: usize,
    with_friction: usize,
    /// Factor on the steps of frictional contacts.
    damping: f64,
    /// Change of a sweep at the last check of progress [√J], and the least squared change since [J].
    last_look: f64,
    least: f64,
    /// Squared change of the last sweep [J].
    last_change: f64,
    /// Half of the relative change at the last look [-].
    half: f64,
}

impl<'a> Sweeps<'a> {
    fn beginning(options: &'a Options) -> Self {
        let never = f64::INFINITY;
        Self {
            options,
            done: 0,
            with_friction: 0,
            damping: 1.0,
            last_look: never,
            least: never,
            last_change: never,
            half: never,
        }
    }
}

impl Workspace {
    /// Sweeps until the residual is within the tolerance, or `last` sweeps with friction are done in all.
    fn sweep_until(
        &mut self,
        last: usize,
        sweeps: &mut Sweeps,
        scale: &Scale,
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
    ) -> SolveReport {
        let Options { tolerance, max_sweeps, acceptable } = *sweeps.options;
        let patience = if self.conjugate.is_empty() { PATIENCE } else { CONJUGATE_PATIENCE };
        loop {
            (sweeps.done, sweeps.with_friction) = (sweeps.done + 1, sweeps.with_friction + 1);
            self.remember(reactions);
            let sums = self.sweep(inverse_mass, v, reactions, Friction::Damped(sweeps.damping));
            sweeps.least = sweeps.least.min(sums.change);
            // Without progress, damp the frictional steps.
            if sweeps.with_friction.is_multiple_of(patience) {
                let change = sweeps.least.sqrt() / sweeps.damping;
                if change > STALLED * sweeps.last_look {
                    sweeps.damping = (DAMPING.0 * sweeps.damping).max(DAMPING.1);
                }
                (sweeps.last_look, sweeps.least) = (change, f64::INFINITY);
            }
            // At an acceptable residual, stop if the changes no longer halve.
            let hint = scale.report(sweeps.done, &sums, tolerance).residual;
            let is_look = sweeps.with_friction.is_multiple_of(LAST_LOOKS);
            let is_stuck = is_look && hint / sweeps.damping > sweeps.half && acceptable > 0.0;
            if is_look {
                sweeps.half = 0.5 * hint / sweeps.damping;
            }
            // The change of a sweep estimates the residual at no cost; the residual of all contacts decides.
            let is_last = sweeps.with_friction >= last;
            let mut pause = None;
            if sweeps.with_friction == 1 || is_stuck || hint <= 10.0 * tolerance || is_last {
                let report = scale.report(sweeps.done, &self.measure(v, reactions), tolerance);
                let is_over = report.converged || is_stuck && report.residual <= acceptable;
                if is_over || sweeps.with_friction >= max_sweeps {
                    return report;
                }
                pause = is_last.then_some(report);
            }
            // Acceleration by conjugate directions or extrapolation.
            if sweeps.damping >= 1.0 {
                self.go_on(sums.change, sweeps.last_change, inverse_mass, v, reactions);
                sweeps.last_change = sums.change;
            }
            if let Some(report) = pause {
                return report;
            }
        }
    }

    /// Reserves memory for so many contacts of meshes, and for so many with a rigid side.
    pub fn with_capacity(contacts: usize, rigid_contacts: usize) -> Self {
        Self {
            meshes: Rows::with_capacity(contacts),
            rigid: Rows::with_capacity(rigid_contacts),
            blocks: Vec::with_capacity(contacts + rigid_contacts),
            extrapolation: Extrapolation::with_capacity(contacts + rigid_contacts),
            conjugate: Conjugate::with_capacity(if rigid_contacts > 0 {
                contacts + rigid_contacts
            } else {
                0
            }),
            groups: Groups::default(),
        }
    }

    fn prepare(&mut self, contacts: &[Contact], rigid: &RigidSides, inverse_mass: &[Vec3], h: f64) {
        self.meshes.clear();
        self.rigid.clear();
        self.blocks.clear();
        let mut start = 0;
        // A run of contacts has one law and one pair.
        let is_alike = |a: &Contact, b: &Contact| a.pair == b.pair && a.law == b.law;
        for run in contacts.chunk_by(is_alike) {
            let law = run[0].law;
            let sides = rigid.of_pair(run[0].pair);
            let turns = sides != [None; 2];
            let rows = if turns {
                let moment_arms = |c: &Contact| MomentArms::new(c, sides, rigid);
                self.rigid.extend(
                    law,
                    run.iter().map(|c| (c, moment_arms(c))),
                    |(c, moment_arms)| NormalRow::turning(c, inverse_mass, h, moment_arms),
                    |(c, moment_arms)| Row::turning(c, inverse_mass, h, moment_arms),
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

    /// Stores the impulses before a sweep.
    fn remember(&mut self, reactions: &[Reaction]) {
        if self.conjugate.is_empty() {
            self.extrapolation.remember(reactions);
        } else {
            self.conjugate.remember(reactions);
        }
    }

    /// Accelerates after a sweep whose squared change of the impulses is `change`; `last_change` is that of the
    /// previous sweep.
    fn go_on(
        &mut self,
        change: f64,
        last_change: f64,
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
    ) {
        let step = if self.conjugate.is_empty() {
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

    /// `Σ D⁻¹ |q|²` of the closing contacts; frictionless ones without their tangential velocities.
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

    /// Where a slave is a rigid body: starts from the frictionless normal impulses, which carry most of the load of a
    /// pile of bodies and are found in far fewer sweeps. Returns the number of sweeps.
    fn start_without_friction(
        &mut self,
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
        options: &Options,
    ) -> usize {
        if self.conjugate.is_empty() {
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

    /// Squared sums of the natural map of all contacts at the present velocities.
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

#[cfg(test)]
mod tests;
