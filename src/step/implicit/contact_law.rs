//! The contact law in an implicit step: the reactions of the detected contacts, by the solvers of contact problems.

use super::iterate::Step;
use super::system::System;
use crate::mechanics::contact::solution::compliance::{are_many, closing_velocity};
use crate::mechanics::contact::solution::delassus::Delassus;
use crate::mechanics::contact::solution::local::Local;
use crate::mechanics::contact::solution::problem::{ContactProblem, ProblemError};
use crate::mechanics::contact::solution::slip::IMMOVABLE;
use crate::mechanics::contact::solution::solvers::{self, MatrixFree, Method, Options, SolveReport};
use crate::mechanics::contact::{Contact, Reaction, RigidSides};
use crate::mechanics::tensor::Vec3;
use crate::step::contact::{ContactStep, no_problem};
use crate::step::failure::FailureCause;
use crate::step::interrupt::Ask;

/// Tolerance of the contact law in quasi-static steps relative to that of the equilibrium, and its lower bound.
const STATIC_CONTACT: f64 = 1e-2;
const TIGHTEST_CONTACT: f64 = 1e-13;

/// Solves for the reactions of the contacts from the contact-free velocities; contacts whose sides cannot move are
/// dropped. Frictionless contacts have one unknown each. W is formed unless there are many contacts, or their solver is
/// matrix-free.
pub(super) fn solve_contacts(
    step: &Step,
    system: &mut System,
    contact: &mut ContactStep,
    sides: &RigidSides,
    interrupt: Ask,
    v_free: &[Vec3],
) -> Result<(), (FailureCause, String)> {
    let named = contact.named_solver();
    let spent = || if interrupt().is_some() { 1.0 } else { 0.0 };
    let options = Options {
        tolerance: tolerance(step, contact),
        method: named.unwrap_or_default(),
        spent: Some(&spent),
        ..Options::default()
    };
    let contacts = contact.results().0;
    let is_finite = contacts.iter().all(|c| c.law.mu().is_finite());
    let by_products = match named {
        Some(method) => method == Method::AcceleratedGradient,
        None => are_many(contacts, sides),
    };
    let report = if by_products && is_finite {
        solve_matrix_free(system, contact, sides, &options, &|c| closing(step, c, sides, v_free))
    } else {
        solve_with_matrix(system, contact, sides, &options, &|c| closing(step, c, sides, v_free))
    };
    let report = report.map_err(no_problem)?;
    report.map_or(Ok(()), |report| contact.accept_report(&report))
}

/// In quasi-static steps the free motion is large for bodies supported by contact only, and the residual of the law is
/// relative to it.
fn tolerance(step: &Step, contact: &ContactStep) -> f64 {
    match step.options.statics {
        Some(_) => contact.tolerance().min(STATIC_CONTACT * step.options.tolerance).max(TIGHTEST_CONTACT),
        None => contact.tolerance(),
    }
}

/// Solves with W stored row by row; `None` if no contact can move.
fn solve_with_matrix(
    system: &mut System,
    contact: &mut ContactStep,
    sides: &RigidSides,
    options: &Options,
    closing: &dyn Fn(&Contact) -> Local,
) -> Result<Option<SolveReport>, ProblemError> {
    let unknowns = contact.unknowns();
    let mut W = system.delassus(contact.results().0, sides, unknowns);
    let rows = unknowns * contact.results().0.len();
    if drop_immovable(contact, unknowns, |c, i| W[(unknowns * c + i) * (rows + 1)]) {
        W = system.delassus(contact.results().0, sides, unknowns);
    }
    let (contacts, reactions) = contact.results();
    if contacts.is_empty() {
        return Ok(None);
    }
    let q: Vec<f64> = contacts.iter().flat_map(|c| closing(c).into_iter().take(unknowns)).collect();
    let mut r: Vec<f64> = reactions.iter().flat_map(|r| r.impulse.into_iter().take(unknowns)).collect();
    let mu: Vec<f64> = contacts.iter().map(|c| c.law.mu()).collect();
    let report = if unknowns == 1 {
        solvers::solve_frictionless(&W, &q, &mut r, options)
    } else if contact.named_solver().is_none() && mu.iter().all(|mu| *mu == 0.0) {
        solve_normal_rows(&W, &q, &mut r, options)
    } else {
        let W = Delassus::dense(contacts.len(), W)?;
        ContactProblem::new(W, q, mu).map(|problem| solvers::solve(&problem, &mut r, options))
    }?;
    store(contact, &r, unknowns);
    Ok(Some(report))
}

/// Matrix-free: products with W, each a solution with the matrix of the step; `None` if no contact can move.
fn solve_matrix_free(
    system: &mut System,
    contact: &mut ContactStep,
    sides: &RigidSides,
    options: &Options,
    closing: &dyn Fn(&Contact) -> Local,
) -> Result<Option<SolveReport>, ProblemError> {
    let mut own = system.own_blocks(contact.results().0, sides);
    if drop_immovable(contact, 3, |c, i| own[c][i][i]) {
        own = system.own_blocks(contact.results().0, sides);
    }
    let (contacts, reactions) = contact.results();
    if contacts.is_empty() {
        return Ok(None);
    }
    let q: Vec<f64> = contacts.iter().flat_map(closing).collect();
    let mut r: Vec<f64> = reactions.iter().flat_map(|r| r.impulse).collect();
    let mu: Vec<f64> = contacts.iter().map(|c| c.law.mu()).collect();
    let product = &mut |r: &[f64], u: &mut [f64]| system.product(contacts, sides, r, u);
    let mut problem = MatrixFree { product, diagonal: &own, q: &q, mu: &mu };
    let report = solvers::solve_matrix_free(&mut problem, &mut r, options)?;
    store(contact, &r, 3);
    Ok(Some(report))
}

/// Stores reactions with `unknowns` components each.
fn store(contact: &mut ContactStep, r: &[f64], unknowns: usize) {
    let (_, reactions) = contact.problem();
    for (reaction, r) in reactions.iter_mut().zip(r.chunks_exact(unknowns)) {
        *reaction = Reaction::default();
        reaction.impulse[..unknowns].copy_from_slice(r);
    }
}

/// Reduces frictionless contacts to one unknown each, with the same bits: rows (n, t1, t2).
fn solve_normal_rows(
    W: &[f64],
    q: &[f64],
    r: &mut [f64],
    options: &Options,
) -> Result<SolveReport, ProblemError> {
    let rows = q.len();
    let normal = |values: &[f64]| values.iter().step_by(3).copied().collect::<Vec<f64>>();
    let W: Vec<f64> = W.chunks_exact(rows).step_by(3).flat_map(normal).collect();
    let mut pressed = normal(r);
    let report = solvers::solve_frictionless(&W, &normal(q), &mut pressed, options)?;
    r.fill(0.0);
    for (r, pressed) in r.chunks_exact_mut(3).zip(pressed) {
        r[0] = pressed;
    }
    Ok(report)
}

/// Closing velocity required by the law. In quasi-static steps nothing rebounds, and penetration is removed.
pub(super) fn closing(step: &Step, contact: &Contact, sides: &RigidSides, v: &[Vec3]) -> [f64; 3] {
    let [normal, t1, t2] = closing_velocity(contact, sides, v, step.h);
    let inside = if step.options.statics.is_some() { contact.gap.min(0.0) / step.h } else { 0.0 };
    [normal + inside, t1, t2]
}

/// Drops the contacts without compliance along their normal; returns whether there were any. Each has that many
/// `unknowns`, and `own` is its own entry of W along each.
fn drop_immovable(contact: &mut ContactStep, unknowns: usize, own: impl Fn(usize, usize) -> f64) -> bool {
    let (contacts, reactions) = contact.problem();
    let trace = |c: usize| (0..unknowns).map(|i| own(c, i)).sum::<f64>();
    let largest = (0..contacts.len()).map(trace).fold(0.0, f64::max);
    // With normal unknowns only, the largest contact is the reference.
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
