//! The rows of the contacts of one kind, and the operations of a sweep on them.

use super::super::contact_row::{NormalRow, Row, Turning, squared};
use super::super::local::{
    Local, natural_map, natural_map_frictionless, solve_frictionless, solve_isotropic,
};
use super::super::problem::work;
use crate::contact::{ContactLaw, Reaction};
use crate::tensor::Vec3;
use std::ops::Range;

/// The rows of contacts of one kind.
#[derive(Clone, Debug)]
pub(super) struct Rows<T> {
    normal: Vec<NormalRow<T>>,
    full: Vec<Row<T>>,
}

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self { normal: Vec::new(), full: Vec::new() }
    }
}

/// A run of contacts of one pair and one law.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) law: ContactLaw,
    /// Whether a side is a rigid body.
    pub(super) turns: bool,
    /// Range of its contacts in the list.
    pub(super) contacts: Range<usize>,
    /// Range of its rows among those of its kind: normal rows if frictionless, full rows otherwise.
    pub(super) rows: Range<usize>,
}

/// Treatment of friction in a sweep.
#[derive(Clone, Copy, Debug)]
pub(super) enum Friction {
    /// The law of each pair, with a factor on the steps.
    Damped(f64),
    /// As if all contacts were frictionless.
    None,
}

/// Squared sums over contacts, for the scaled residual.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// `D |F|²`; in a sweep `D |change|²`.
    pub(super) change: f64,
    /// Squared norm of the impulses, `D |p|²`.
    pub(super) impulse: f64,
    /// Velocities that may round, `D⁻¹ |v|²`.
    pub(super) rounding: f64,
    /// What the impulses change, `pᵀ W p`; in a sweep 0.
    pub(super) motion: f64,
}

impl<T> Rows<T> {
    pub(super) fn with_capacity(contacts: usize) -> Self {
        Self { normal: Vec::with_capacity(contacts), full: Vec::with_capacity(contacts) }
    }

    pub(super) fn clear(&mut self) {
        self.normal.clear();
        self.full.clear();
    }

    /// Adds the rows of a pair with the unknowns of its law; returns their range.
    pub(super) fn extend<C>(
        &mut self,
        law: ContactLaw,
        contacts: impl Iterator<Item = C>,
        normal: impl Fn(C) -> NormalRow<T>,
        full: impl Fn(C) -> Row<T>,
    ) -> Range<usize> {
        match law {
            ContactLaw::Frictionless => {
                let start = self.normal.len();
                self.normal.extend(contacts.map(normal));
                start..self.normal.len()
            }
            ContactLaw::Coulomb(_) => {
                let start = self.full.len();
                self.full.extend(contacts.map(full));
                start..self.full.len()
            }
        }
    }
}

impl<T: Turning> Rows<T> {
    /// Appends the velocities of a block to `free`, and adds those that close to `closing`.
    pub(super) fn add_free(&self, block: &Block, v: &[Vec3], free: &mut Vec<Local>, closing: &mut f64) {
        match block.law {
            ContactLaw::Frictionless => {
                for row in &self.normal[block.rows.clone()] {
                    let q = row.velocity(v);
                    free.push([q, 0.0, 0.0]);
                    if q < 0.0 && row.w_nn > 0.0 {
                        *closing += q * q / row.d;
                    }
                }
            }
            ContactLaw::Coulomb(mu) => {
                for row in &self.full[block.rows.clone()] {
                    let q = row.velocity(v);
                    free.push(q);
                    if q[0] < 0.0 && row.normal.w_nn > 0.0 {
                        *closing += if mu == 0.0 { q[0] * q[0] } else { squared(q) } / row.normal.d;
                    }
                }
            }
        }
    }

    pub(super) fn sweep(
        &self,
        block: &Block,
        friction: Friction,
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
        sums: &mut Sums,
    ) {
        match block.law {
            ContactLaw::Frictionless => {
                sweep_frictionless(&self.normal[block.rows.clone()], inverse_mass, v, reactions, sums);
            }
            ContactLaw::Coulomb(mu) => {
                let (mu, damping) = match friction {
                    Friction::Damped(damping) if mu > 0.0 => (mu, damping),
                    // Frictionless contacts do not cycle.
                    _ => (0.0, 1.0),
                };
                sweep_coulomb(
                    &self.full[block.rows.clone()],
                    (mu, damping),
                    inverse_mass,
                    v,
                    reactions,
                    sums,
                );
            }
        }
    }

    /// Adds `step` to the impulses of a block, and its effect to the velocities.
    pub(super) fn add(
        &self,
        block: &Block,
        step: &[Local],
        inverse_mass: &[Vec3],
        v: &mut [Vec3],
        reactions: &mut [Reaction],
    ) {
        let add = |reaction: &mut Reaction, step: &Local| {
            reaction.impulse.iter_mut().zip(step).for_each(|(p, step)| *p += step);
        };
        match block.law {
            ContactLaw::Frictionless => {
                let rows = &self.normal[block.rows.clone()];
                for ((row, step), reaction) in rows.iter().zip(step).zip(reactions) {
                    row.push(step[0], inverse_mass, v);
                    add(reaction, step);
                }
            }
            ContactLaw::Coulomb(_) => {
                let rows = &self.full[block.rows.clone()];
                for ((row, step), reaction) in rows.iter().zip(step).zip(reactions) {
                    row.push(*step, inverse_mass, v);
                    add(reaction, step);
                }
            }
        }
    }

    pub(super) fn measure(&self, block: &Block, v: &[Vec3], reactions: &[Reaction], sums: &mut Sums) {
        match block.law {
            ContactLaw::Frictionless => {
                for (row, reaction) in self.normal[block.rows.clone()].iter().zip(reactions) {
                    let (p, u) = (reaction.impulse[0], row.velocity(v));
                    let f = natural_map_frictionless(p, u, 1.0 / row.d);
                    sums.add(row, [p, 0.0, 0.0], [u, 0.0, 0.0], [f, 0.0, 0.0], v);
                }
            }
            ContactLaw::Coulomb(mu) => {
                for (row, reaction) in self.full[block.rows.clone()].iter().zip(reactions) {
                    let (p, u) = (reaction.impulse, row.velocity(v));
                    let f = natural_map(p, u, mu, 1.0 / row.normal.d);
                    sums.add(&row.normal, p, u, f, v);
                }
            }
        }
    }
}

impl Sums {
    /// Adds the residual `f` of a contact with impulse `p` and velocity `u`, unless nothing can move along n; of `motion` the work of the
    /// impulse on it.
    pub(super) fn add<T: Turning>(&mut self, row: &NormalRow<T>, p: Local, u: Local, f: Local, v: &[Vec3]) {
        if row.w_nn == 0.0 {
            return;
        }
        self.change += row.d * squared(f);
        self.impulse += row.d * squared(p);
        self.motion += work(p, u);
        if p[0] > 0.0 || u[0] < 0.0 {
            self.rounding += row.roundable(v).powi(2) / row.d;
        }
    }
}

fn sweep_frictionless<T: Turning>(
    rows: &[NormalRow<T>],
    inverse_mass: &[Vec3],
    v: &mut [Vec3],
    reactions: &mut [Reaction],
    sums: &mut Sums,
) {
    for (row, reaction) in rows.iter().zip(reactions) {
        if row.w_nn == 0.0 {
            continue;
        }
        let old = reaction.impulse[0];
        let new = solve_frictionless(row.w_nn, row.velocity(v) - row.w_nn * old);
        let change = new - old;
        if change.abs() > 0.0 {
            row.push(change, inverse_mass, v);
            reaction.impulse[0] = new;
        }
        sums.change += row.d * (change * change);
        sums.impulse += row.d * (new * new);
    }
}

fn sweep_coulomb<T: Turning>(
    rows: &[Row<T>],
    (mu, damping): (f64, f64),
    inverse_mass: &[Vec3],
    v: &mut [Vec3],
    reactions: &mut [Reaction],
    sums: &mut Sums,
) {
    for (row, reaction) in rows.iter().zip(reactions) {
        let NormalRow { d, w_nn, isotropic, .. } = row.normal;
        if w_nn == 0.0 {
            continue;
        }
        // Local solution with the other impulses held.
        let (old, u) = (reaction.impulse, row.velocity(v));
        let new = if isotropic {
            solve_isotropic(d, [0, 1, 2].map(|i| u[i] - d * old[i]), mu)
        } else {
            let W = &row.W;
            let q = [0, 1, 2].map(|i| u[i] - (W[i][0] * old[0] + W[i][1] * old[1] + W[i][2] * old[2]));
            row.operator.solve(q, mu)
        };
        // The cone is convex, so the damped impulse stays in it.
        let new = if damping < 1.0 { [0, 1, 2].map(|i| old[i] + damping * (new[i] - old[i])) } else { new };
        let change = [0, 1, 2].map(|i| new[i] - old[i]);
        if squared(change) > 0.0 {
            row.push(change, inverse_mass, v);
            reaction.impulse = new;
        }
        sums.change += d * squared(change);
        sums.impulse += d * squared(new);
    }
}
