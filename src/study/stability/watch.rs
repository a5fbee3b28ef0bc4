//! Monitors the run of a case.

use crate::measure::computed::ComputedMotion;
use crate::measure::deflection::Deflection;
use crate::measure::penetration::Penetration;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::scene::document::Role;
use crate::step::{Frame, Recorder, RecorderError};
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};

/// Contact is over after no touch for this fraction of its duration [-], and at least this time [s].
const APART: (f64, f64) = (0.25, 5e-4);
/// The same while the projectile continues in its direction: tissue thrown ahead may lose contact for a while.
const APART_ON_ITS_WAY: (f64, f64) = (1.0, 5e-3);

/// Extremes of a run that are not in the summary.
#[derive(Debug)]
pub(super) struct Watch<'a> {
    /// Deflection of the tissue's surface.
    pub deflection: Deflection,
    /// Interpenetration of bodies at the field times.
    pub penetration: Penetration,
    /// Motion of what is computed of symmetric bodies.
    motion: ComputedMotion,
    /// Set once contact has begun and is over.
    contact_is_over: &'a AtomicBool,
    /// The projectile, and its momentum before the first contact [kg m/s].
    projectile: Option<(usize, Vec3)>,
    /// Pairs that have touched so far.
    touched: BTreeSet<usize>,
    /// First and last time with contact [s].
    contact_span: Option<[f64; 2]>,
    /// Deepest penetration of a candidate contact at the start of a step [m], not negative.
    pub deepest: f64,
    initial: f64,
    largest: f64,
    lost: f64,
    scale: f64,
}

impl<'a> Watch<'a> {
    /// A monitor for a run that has not begun.
    pub fn new(contact_is_over: &'a AtomicBool) -> Self {
        Self {
            deflection: Deflection::default(),
            penetration: Penetration::default(),
            motion: ComputedMotion::default(),
            contact_is_over,
            projectile: None,
            touched: BTreeSet::new(),
            contact_span: None,
            deepest: 0.0,
            initial: 0.0,
            largest: 0.0,
            lost: 0.0,
            scale: 0.0,
        }
    }
    /// Largest total energy over the initial total energy [-].
    pub fn growth(&self) -> f64 {
        if self.initial > 0.0 { self.largest / self.initial } else { 1.0 }
    }
    /// Numerical contact dissipation over the energy scale [-].
    pub fn contact_loss(&self) -> f64 {
        if self.scale > 0.0 { self.lost / self.scale } else { 0.0 }
    }
}

impl Recorder for Watch<'_> {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        self.deflection = Deflection::new(plan);
        self.projectile =
            plan.bodies.iter().position(|b| b.role == Role::Projectile).map(|body| (body, Vec3::zeros()));
        self.touched = BTreeSet::new();
        Ok(())
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let depth = frame.contacts.iter().map(|contact| -contact.gap).fold(0.0, f64::max);
        self.deepest = self.deepest.max(depth);
        let energy = frame.energy;
        self.initial = energy.initial_total_j;
        self.largest = self.largest.max(energy.total_j - energy.external_work_j);
        self.lost = energy.numerical_contact_j();
        self.scale = energy.turnover_j;
        self.deflection.accumulate(frame);
        // Pairs in contact.
        let acting = frame.contacts.iter().zip(frame.reactions).filter(|(_, r)| r.impulse[0] > 0.0);
        let is_touching = acting.clone().next().is_some();
        for (contact, _) in acting {
            self.touched.insert(contact.pair as usize);
        }
        if frame.is_look_time {
            let own = self.motion.frame(frame);
            self.penetration.accumulate([frame, &own], |pair| self.touched.contains(&pair));
        }
        // Whether the projectile still moves in its initial direction.
        let goes_on = self.projectile.as_mut().is_some_and(|(body, before)| {
            let momentum = Vec3::from(frame.energy.bodies[*body].momentum_kg_m_per_s);
            if self.contact_span.is_none() {
                *before = momentum;
            }
            momentum.dot(before) > 0.0
        });
        // Contact is over after a sufficient time without touch.
        let apart = if goes_on { APART_ON_ITS_WAY } else { APART };
        if is_touching {
            self.contact_span = Some([self.contact_span.map_or(frame.time, |[first, _]| first), frame.time]);
        }
        if let Some([first, last]) = self.contact_span
            && frame.time - last > (apart.0 * (last - first)).max(apart.1)
        {
            self.contact_is_over.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}
