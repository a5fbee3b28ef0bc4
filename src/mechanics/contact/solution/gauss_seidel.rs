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
mod progress;
mod rows;
mod sweeper;

use crate::contact::{Contact, Reaction, RigidSides};
use crate::tensor::Vec3;
use groups::Groups;
pub use progress::{Options, SolveReport};
use progress::{Scale, Sweeps};
use sweeper::Sweeper;

/// Sweeps over all contacts before those that are not connected go on by themselves.
const TOGETHER: usize = 50;

/// Buffers of the solver, kept by the caller between steps: it allocates only where contacts have become more, or groups of them are swept
/// for the first time.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    all: Sweeper,
    groups: Groups,
}

impl Workspace {
    /// Reserves memory for so many contacts of meshes, and for so many with a rigid side.
    pub fn with_capacity(contacts: usize, rigid_contacts: usize) -> Self {
        Self { all: Sweeper::with_capacity(contacts, rigid_contacts), groups: Groups::default() }
    }
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
    let Workspace { all, groups } = workspace;
    all.prepare(contacts, rigid, inverse_mass, h);

    // The scale of the residual; if no contact closes, p = 0 is the solution.
    let closing = all.begin(v);
    if closing == 0.0 {
        return SolveReport {
            sweeps: 0,
            residual: 0.0,
            residual_of_motion: 0.0,
            residual_of_free: 0.0,
            converged: true,
        };
    }
    let scale = Scale { closing, sizes: None };
    let mut sweeps = Sweeps::beginning(options);
    sweeps.done = all.start_without_friction(inverse_mass, v, reactions, options);
    // Most problems are solved in few sweeps over all contacts.
    let together = TOGETHER.min(options.max_sweeps);
    let report = all.sweep_until(together, &mut sweeps, &scale, inverse_mass, v, reactions);
    if report.converged || together >= options.max_sweeps {
        return report;
    }
    // In others one group of contacts holds up all: each goes on by itself.
    groups.find(contacts, rigid, inverse_mass);
    if groups.are_one() {
        return all.sweep_until(options.max_sweeps, &mut sweeps, &scale, inverse_mass, v, reactions);
    }
    let of_all = scale.found(&all.measure(v, reactions));
    let longest = groups.solve(contacts, rigid, (inverse_mass, h, v), reactions, options, &of_all);
    scale.report(sweeps.done + longest, &all.measure(v, reactions), options.tolerance)
}

#[cfg(test)]
mod tests;
