//! What the sides of the impact have at one time, in the frame of whoever looks.

use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::scene::document::Role;
use crate::step::{Energy, PairLedger};

/// The frame that energies are told in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Observer {
    /// A time [s].
    pub time: f64,
    /// Velocity at that time [m/s].
    pub velocity: Vec3,
    /// Acceleration, a [m/s²].
    pub acceleration: Vec3,
}

impl Observer {
    /// Velocity at a time [s], V [m/s].
    pub fn velocity_at(&self, time: f64) -> Vec3 {
        self.velocity + self.acceleration * (time - self.time)
    }
}

/// What bodies have at one time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// The time [s].
    pub time: f64,
    /// Mass [kg].
    pub mass: f64,
    /// Strain energy [J].
    pub strain: f64,
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Momentum [kg m/s].
    pub momentum: Vec3,
    /// Work of external forces and of the position projection so far [J].
    given: f64,
    /// Impulse that contact has given so far, P [N s].
    pub impulse: Vec3,
    /// ∫P dt so far [N s²].
    impulse_time: Vec3,
}

impl Motion {
    /// Of bodies, with what the impulse on the slave of each pair is to them: 1, −1 where they are the master, else 0.
    pub fn of(side: &Side, time: f64, energy: &Energy) -> Self {
        let impulses =
            side.signs.iter().zip(&energy.pairs).map(|(sign, pair)| Vec3::from(pair.impulse_n_s) * *sign);
        let start = Self { time, mass: side.mass, impulse: impulses.sum(), ..Self::default() };
        side.bodies.iter().map(|&b| &energy.bodies[b]).fold(start, |sum, b| Self {
            strain: sum.strain + b.strain_j,
            kinetic: sum.kinetic + b.kinetic_j,
            momentum: sum.momentum + Vec3::from(b.momentum_kg_m_per_s),
            given: sum.given + b.external_work_j + b.projection_j,
            ..sum
        })
    }
    /// With ∫P dt, by the trapezoidal rule from an earlier time on.
    pub fn after(self, before: &Self) -> Self {
        let mean = 0.5 * (before.impulse + self.impulse);
        Self { impulse_time: before.impulse_time + mean * (self.time - before.time), ..self }
    }
    /// Work since `start` that did not come through contact, in a frame [J].
    pub fn given_since(&self, start: &Self, frame: &Observer) -> f64 {
        let by_others = self.momentum - start.momentum - self.impulse;
        self.given - frame.velocity_at(self.time).dot(&by_others) - frame.acceleration.dot(&self.impulse_time)
            + self.fall_since(start, frame)
    }
    /// Work of contact, which is `work` for who rests, in a frame [J].
    pub fn contact_work(&self, work: f64, frame: &Observer) -> f64 {
        work - frame.velocity_at(self.time).dot(&self.impulse) + frame.acceleration.dot(&self.impulse_time)
    }
    /// Change of the kinetic energy since `start` in a frame [J].
    pub fn kinetic_since(&self, start: &Self, frame: &Observer) -> f64 {
        let change = self.momentum - start.momentum;
        self.kinetic - start.kinetic - frame.velocity_at(self.time).dot(&change)
            + self.fall_since(start, frame)
    }
    /// What the fall of the frame itself since `start` adds to both, F [J].
    fn fall_since(&self, start: &Self, frame: &Observer) -> f64 {
        let [now, then] = [self.time, start.time].map(|time| frame.velocity_at(time));
        (now - then).dot(&(0.5 * self.mass * (now + then) - start.momentum))
    }
}

/// Bodies that are one side of the impact.
#[derive(Clone, Debug, Default)]
pub(super) struct Side {
    /// The bodies.
    pub bodies: Vec<usize>,
    /// What the impulse on the slave of each pair is to them: 1, −1 where they are the master, else 0.
    pub signs: Vec<f64>,
    /// Their mass [kg].
    pub mass: f64,
}

impl Side {
    /// The bodies in a role.
    pub fn new(plan: &Plan, role: Role) -> Self {
        let bodies: Vec<usize> = (0..plan.bodies.len()).filter(|&b| plan.bodies[b].role == role).collect();
        let side = |body: usize| f64::from(u8::from(bodies.contains(&body)));
        let sign = |&(slave, master): &(usize, Option<usize>)| side(slave) - master.map_or(0.0, side);
        Self {
            signs: pair_bodies(plan).iter().map(sign).collect(),
            mass: bodies.iter().map(|&b| plan.bodies[b].mass).sum(),
            bodies,
        }
    }
}

impl Side {
    /// The sum of a line of the ledger over the pairs that touch it from outside.
    pub fn of_its_pairs(&self, energy: &Energy, line: fn(&PairLedger) -> f64) -> f64 {
        let touching = self.signs.iter().zip(&energy.pairs).filter(|(sign, _)| **sign != 0.0);
        touching.map(|(_, pair)| line(pair)).sum()
    }
}

/// Slave and master of each pair; a plane is no body.
pub(super) fn pair_bodies(plan: &Plan) -> &[(usize, Option<usize>)] {
    plan.contact.as_ref().map_or(&[][..], |contact| &contact.pair_bodies)
}
