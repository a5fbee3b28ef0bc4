//! The contact law in an implicit step: the reactions of the contacts that were found, by the solvers of contact problems.

use super::iterate::Step;
use super::system::System;
use crate::mechanics::contact::compliance::closing_velocity;
use crate::mechanics::contact::delassus::Delassus;
use crate::mechanics::contact::problem::{ContactProblem, ProblemError};
use crate::mechanics::contact::solvers::{self, Options, SolveReport};
use crate::mechanics::contact::{Contact, Reaction, RigidSides};
use crate::mechanics::tensor::Vec3;
use crate::step::contact::{ContactStep, no_problem};
use crate::step::failure::FailureCause;
use crate::step::integrator::Phase;

/// Normal compliance below this share of the trace: nothing can move along n.
const IMMOVABLE: f64 = 1e-12;
/// Tolerance of the contact law without mass, as a share of that of the equilibrium, and its least.
const STATIC_CONTACT: f64 = 1e-2;
const TIGHTEST_CONTACT: f64 = 1e-13;

/// Reactions of the contacts, from the velocities without them; contacts whose sides cannot move are dropped. Where nothing rubs
/// each has one unknown.
pub(super) fn solve_contacts(
    step: &Step,
    system: &mut System,
    contact: &mut ContactStep,
    sides: &RigidSides,
    phase: Phase,
    v_free: &[Vec3],
) -> Result<(), (FailureCause, String)> {
    let unknowns = contact.unknowns(phase);
    let mut W = system.delassus(contact.results().0, sides, unknowns);
    if drop_immovable(contact, unknowns, &W) {
        W = system.delassus(contact.results().0, sides, unknowns);
    }
    let (contacts, reactions) = contact.results();
    let closing = |c: &Contact| closing(step, c, sides, v_free).into_iter().take(unknowns);
    let q: Vec<f64> = contacts.iter().flat_map(closing).collect();
    let mut r: Vec<f64> = reactions.iter().flat_map(|r| r.impulse.into_iter().take(unknowns)).collect();
    // Without mass the free motion is long where contact alone holds a body, and what the law misses is a share of it.
    let tolerance = match step.options.statics {
        Some(_) => contact.tolerance().min(STATIC_CONTACT * step.options.tolerance).max(TIGHTEST_CONTACT),
        None => contact.tolerance(),
    };
    let named = contact.named_solver();
    let options = Options { tolerance, method: named.unwrap_or_default(), ..Options::default() };
    let mu: Vec<f64> = contacts.iter().map(|c| contact.friction(c.pair, phase)).collect();
    let report = if unknowns == 1 {
        solvers::solve_frictionless(&W, &q, &mut r, &options)
    } else if named.is_none() && mu.iter().all(|mu| *mu == 0.0) {
        solve_normal_rows(&W, &q, &mut r, &options)
    } else {
        let W = Delassus::dense(contacts.len(), W).map_err(|e| no_problem(e.into()))?;
        ContactProblem::new(W, q, mu).map(|problem| solvers::solve(&problem, &mut r, &options))
    };
    let report = report.map_err(no_problem)?;
    let (_, reactions) = contact.problem();
    for (reaction, r) in reactions.iter_mut().zip(r.chunks_exact(unknowns)) {
        *reaction = Reaction::default();
        reaction.impulse[..unknowns].copy_from_slice(r);
    }
    contact.accept_report(&report)
}

/// As if each contact had one unknown, with the same bits: rows (n, t1, t2) of contacts of which none rubs.
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

/// What the law asks of a contact. Without mass nothing is thrown off, and what is inside comes out.
pub(super) fn closing(step: &Step, contact: &Contact, sides: &RigidSides, v: &[Vec3]) -> [f64; 3] {
    let [normal, t1, t2] = closing_velocity(contact, sides, v, step.h);
    let inside = if step.options.statics.is_some() { contact.gap.min(0.0) / step.h } else { 0.0 };
    [normal + inside, t1, t2]
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
