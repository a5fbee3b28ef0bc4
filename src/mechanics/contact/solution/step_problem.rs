//! The contact problem of a step with lumped masses, with `W = C M⁻¹ Cᵀ` and q explicit, which
//! [`super::gauss_seidel`] never forms; and the solution of a step by a solver of the library.

use super::contact_row::{MomentArms, Row};
use super::delassus::{Block, Delassus};
use super::problem::{ContactProblem, ProblemError};
use super::solvers::{self, Options, SolveReport};
use crate::contact::{Contact, Reaction, RigidSides};
use crate::tensor::{Mat3, Vec3};

/// The problem whose solution is the impulses of a step of length `h` [s]: `u = W p + q` [m/s] with `u_n` the end-of-step
/// gap over h, as in [`super::gauss_seidel`].
///
/// `inverse_mass` per node and axis [1/kg]; `v` [m/s] the velocities *after* the impulses of
/// `reactions`, which are subtracted again; `rigid` the bodies that they rotate.
///
/// # Errors
/// [`ProblemError`] where a number is not finite.
pub fn step_problem(
    contacts: &[Contact],
    reactions: &[Reaction],
    (inverse_mass, rigid): (&[Vec3], &RigidSides),
    h: f64,
    v: &[Vec3],
) -> Result<ContactProblem, ProblemError> {
    let rows: Vec<Row<MomentArms>> = contacts.iter().map(|c| row(c, (inverse_mass, rigid), h)).collect();
    let mut free = v.to_vec();
    take_off(contacts, reactions, (inverse_mass, rigid), h, &mut free);
    // Free velocities and coefficients of friction.
    let q = rows.iter().flat_map(|row| row.velocity(&free)).collect();
    let mu = contacts.iter().map(|c| c.law.mu()).collect();
    // (node, contact, ∂(relative velocity)/∂v of the node), sorted so that the contacts of a node are adjacent.
    let mut entries: Vec<(u32, usize, Mat3)> = Vec::new();
    for (c, row) in rows.iter().enumerate() {
        entries.extend(row.normal.blocks().map(|(node, J)| (node, c, J)));
    }
    entries.sort_by_key(|&(node, contact, _)| (node, contact));
    // Contacts with a node in common are coupled through its mass.
    let blocks = entries.chunk_by(|a, b| a.0 == b.0).flat_map(|at_node| {
        let m = inverse_mass[at_node[0].0 as usize];
        let M = Mat3::from_diagonal(&m);
        at_node.iter().flat_map(move |&(_, c, J_c)| {
            at_node.iter().map(move |&(_, d, J_d)| {
                (c, d, coupling(&contacts[c].frame, &contacts[d].frame, &(J_c * M * J_d.transpose())))
            })
        })
    });
    ContactProblem::new(Delassus::from_blocks(contacts.len(), blocks)?, q, mu)
}

/// Subtracts the effect of `reactions` from the velocities `v` [m/s]; other arguments as of [`step_problem`].
pub fn take_off(
    contacts: &[Contact],
    reactions: &[Reaction],
    (inverse_mass, rigid): (&[Vec3], &RigidSides),
    h: f64,
    v: &mut [Vec3],
) {
    for (contact, reaction) in contacts.iter().zip(reactions) {
        row(contact, (inverse_mass, rigid), h).push(reaction.impulse.map(|p| -p), inverse_mass, v);
    }
}

/// Finds impulses and end velocities as [`super::gauss_seidel::solve_with_rigid`], by a solver of the library: W is
/// formed, and memory allocated. Contacts with both sides immovable along n get no reaction. `None` where there are
/// no others.
///
/// Arguments as of [`step_problem`], but `reactions` are the initial guess, and `v` [m/s] the velocities without
/// them; on return, the impulses found and the velocities after them.
///
/// # Errors
/// [`ProblemError`] where a number is not finite.
pub fn solve_step(
    contacts: &[Contact],
    reactions: &mut [Reaction],
    masses: (&[Vec3], &RigidSides),
    h: f64,
    v: &mut [Vec3],
    options: &Options,
) -> Result<Option<SolveReport>, ProblemError> {
    // Contacts that can move.
    let is_movable = |c: &usize| row(&contacts[*c], masses, h).normal.w_nn > 0.0;
    let movable: Vec<usize> = (0..contacts.len()).filter(is_movable).collect();
    if movable.is_empty() {
        reactions.fill(Reaction::default());
        return Ok(None);
    }
    // Solve for their reactions, and apply these.
    let chosen: Vec<Contact> = movable.iter().map(|&c| contacts[c].clone()).collect();
    let problem = step_problem(&chosen, &[], masses, h, v)?;
    let mut r: Vec<f64> = movable.iter().flat_map(|&c| reactions[c].impulse).collect();
    reactions.fill(Reaction::default());
    let report = solvers::solve(&problem, &mut r, options);
    for ((&c, contact), impulse) in movable.iter().zip(&chosen).zip(r.chunks_exact(3)) {
        if impulse.iter().any(|p| *p != 0.0) {
            reactions[c].impulse.copy_from_slice(impulse);
            row(contact, masses, h).push(reactions[c].impulse, masses.0, v);
        }
    }
    Ok(Some(report))
}

fn row(contact: &Contact, (inverse_mass, rigid): (&[Vec3], &RigidSides), h: f64) -> Row<MomentArms> {
    Row::turning(contact, inverse_mass, h, MomentArms::new(contact, rigid.of_pair(contact.pair), rigid))
}

/// Block `T_c A T_dᵀ` of W, with T the local frames.
fn coupling(c: &[Vec3; 3], d: &[Vec3; 3], A: &Mat3) -> Block {
    c.map(|a| d.map(|b| a.dot(&(A * b))))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::contact::solution::gauss_seidel::{Options, Workspace, solve};
    use crate::contact::{ContactLaw, kind::Kind, stencil::Stencil};

    #[test]
    fn the_impulses_of_a_step_solve_the_problem_of_the_step() {
        // Two nodes on one face of four: its nodes couple them.
        let frame = [Vec3::z(), Vec3::x(), Vec3::y()];
        let contact = |slave, weights| Contact {
            pair: 0,
            kind: Kind::NODE,
            slave,
            face: 0,
            stencil: Stencil::node_on_face(slave, &[0, 1, 2, 3], &weights),
            frame,
            gap: 1e-4 * f64::from(slave),
            point: Vec3::zeros(),
            drift: Vec3::new(0.3, 0.1, -5.0),
            law: ContactLaw::Coulomb(0.4),
        };
        let contacts = [contact(4, [0.1, 0.2, 0.3, 0.4]), contact(5, [0.4, 0.3, 0.2, 0.1])];
        let h = 1e-3;
        let inverse_mass: Vec<Vec3> = (0..6).map(|i| Vec3::repeat(1.0 + f64::from(i))).collect();
        let mut v: Vec<Vec3> = (0..6).map(|i| Vec3::new(0.1 * f64::from(i), 0.2, -0.1)).collect();
        let mut reactions = Vec::new();
        let options = Options { tolerance: 1e-13, max_sweeps: 1000, acceptable: 0.0 };
        let mut workspace = Workspace::default();
        let report = solve(&contacts, &inverse_mass, h, &mut v, &mut reactions, &options, &mut workspace);
        assert!(report.converged);
        let problem = step_problem(&contacts, &reactions, (&inverse_mass, &RigidSides::NONE), h, &v).unwrap();
        let r: Vec<f64> = reactions.iter().flat_map(|reaction| reaction.impulse).collect();
        assert!(r[0] > 0.0 && r[3] > 0.0);
        assert!(problem.error_scaled(&r) <= 1e-12, "{:e}", problem.error_scaled(&r));
    }
}
