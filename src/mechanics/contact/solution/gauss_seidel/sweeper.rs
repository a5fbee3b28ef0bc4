//! Sweeps over the contacts of a step, or over a group of them.

use super::super::contact_row::{MomentArms, NormalRow, Row};
use super::super::local::Local;
use super::super::problem::work;
use super::conjugate::Conjugate;
use super::extrapolation::Extrapolation;
use super::progress::{Options, Scale, SolveReport, Sweeps};
use super::rows::{Block, Friction, Rows, Sums};
use crate::contact::{Contact, Reaction, RigidSides};
use crate::tensor::Vec3;

/// Sweeps between two checks of progress.
const PATIENCE: usize = 50;
/// The same for conjugate directions: their changes grow and fall on the way.
const CONJUGATE_PATIENCE: usize = 500;
/// Ratio of changes between two checks above which sweeps make no progress.
const STALLED: f64 = 0.9;
/// Sweeps within which the change of a sweep must halve; otherwise they end at an acceptable residual.
const LAST_LOOKS: usize = 250;
/// Factor on the steps of frictional contacts whenever sweeps make no progress, and its least value.
const DAMPING: (f64, f64) = (0.7, 0.05);

/// Contacts prepared for sweeps, with buffers that are kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Sweeper {
    meshes: Rows<()>,
    rigid: Rows<MomentArms>,
    blocks: Vec<Block>,
    conjugate: Conjugate,
    extrapolation: Extrapolation,
    /// Velocities without impulses, if these began at zero.
    free: Vec<Local>,
}

impl Sweeper {
    /// Sweeps until the residual is within the tolerance, or `last` sweeps with friction are done in all.
    pub fn sweep_until(
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
            free: Vec::with_capacity(contacts + rigid_contacts),
            conjugate: Conjugate::with_capacity(if rigid_contacts > 0 {
                contacts + rigid_contacts
            } else {
                0
            }),
        }
    }

    pub fn prepare(&mut self, contacts: &[Contact], rigid: &RigidSides, inverse_mass: &[Vec3], h: f64) {
        self.meshes.clear();
        self.rigid.clear();
        self.blocks.clear();
        self.free.clear();
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

    /// Keeps the free velocities q; returns `Σ D⁻¹ |q|²` of the closing contacts, of frictionless ones without their tangential
    /// velocities.
    pub fn begin(&mut self, v: &[Vec3]) -> f64 {
        let Self { meshes, rigid, blocks, free, .. } = self;
        let mut closing = 0.0;
        for block in blocks.iter() {
            if block.turns {
                rigid.add_free(block, v, free, &mut closing);
            } else {
                meshes.add_free(block, v, free, &mut closing);
            }
        }
        closing
    }

    /// Where a slave is a rigid body: starts from the frictionless normal impulses, which carry most of the load of a
    /// pile of bodies and are found in far fewer sweeps. Returns the number of sweeps.
    pub fn start_without_friction(
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

    /// Squared sums of the natural map of all contacts at the present velocities; their motion only where impulses began at zero.
    pub fn measure(&self, v: &[Vec3], reactions: &[Reaction]) -> Sums {
        let mut sums = Sums::default();
        for block in &self.blocks {
            let reactions = &reactions[block.contacts.clone()];
            if block.turns {
                self.rigid.measure(block, v, reactions, &mut sums);
            } else {
                self.meshes.measure(block, v, reactions, &mut sums);
            }
        }
        sums.motion -= reactions.iter().zip(&self.free).map(|(p, q)| work(p.impulse, *q)).sum::<f64>();
        sums
    }
}
