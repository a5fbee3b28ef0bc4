//! Energies, momenta and impulses of the sides of the impact at one time, in the frame of an observer.

use crate::mechanics::tensor::Vec3;
use crate::plan::{ByPair, Plan};
use crate::scene::document::Role;
use crate::step::{Energy, PairLedger};

/// Reference frame of the energies.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Observer {
    /// Time at which the velocity is given [s].
    pub time: f64,
    /// Velocity at that time [m/s].
    pub velocity: Vec3,
    /// Acceleration a of the frame [m/s²].
    pub acceleration: Vec3,
}

impl Observer {
    /// Velocity V at a time [s] [m/s].
    pub fn velocity_at(&self, time: f64) -> Vec3 {
        self.velocity + self.acceleration * (time - self.time)
    }
}

/// Mechanical state of a group of bodies at one time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// Time of the state [s].
    pub time: f64,
    /// Total mass of the bodies [kg].
    pub mass: f64,
    /// Strain energy of the bodies [J].
    pub strain: f64,
    /// Kinetic energy of the bodies [J].
    pub kinetic: f64,
    /// Linear momentum of the bodies [kg m/s].
    pub momentum: Vec3,
    /// Work of external forces and of the position projection so far [J].
    given: f64,
    /// Contact impulse so far, P [N s].
    pub impulse: Vec3,
    /// ∫P dt so far [N s²].
    impulse_time: Vec3,
}

impl Motion {
    /// State of the bodies of a side.
    pub fn of(side: &Side, time: f64, energy: &Energy) -> Self {
        let impulses = energy.pairs.each().map(|(pair, of)| Vec3::from(of.impulse_n_s) * side.sign(pair));
        let start = Self { time, mass: side.mass, impulse: impulses.sum(), ..Self::default() };
        side.bodies.iter().map(|&b| &energy.bodies[b]).fold(start, |sum, b| Self {
            strain: sum.strain + b.strain_j,
            kinetic: sum.kinetic + b.kinetic_j,
            momentum: sum.momentum + Vec3::from(b.momentum_kg_m_per_s),
            given: sum.given + b.external_work_j + b.projection_j,
            ..sum
        })
    }
    /// The same with ∫P dt, integrated from an earlier state by the trapezoidal rule.
    pub fn after(self, before: &Self) -> Self {
        let mean = 0.5 * (before.impulse + self.impulse);
        Self { impulse_time: before.impulse_time + mean * (self.time - before.time), ..self }
    }
    /// Strain and kinetic energy in a frame [J].
    pub fn energy(&self, frame: &Observer) -> f64 {
        let velocity = frame.velocity_at(self.time);
        self.strain + self.kinetic - velocity.dot(&self.momentum) + 0.5 * self.mass * velocity.norm_squared()
    }
    /// Work since `start` not done through contact, in a frame [J].
    pub fn given_since(&self, start: &Self, frame: &Observer) -> f64 {
        let by_others = self.momentum - start.momentum - self.impulse;
        self.given - frame.velocity_at(self.time).dot(&by_others) - frame.acceleration.dot(&self.impulse_time)
            + self.fall_since(start, frame)
    }
    /// Work of contact in a frame, given `work` in the frame at rest [J].
    pub fn contact_work(&self, work: f64, frame: &Observer) -> f64 {
        work - frame.velocity_at(self.time).dot(&self.impulse) + frame.acceleration.dot(&self.impulse_time)
    }
    /// Change of the kinetic energy since `start` in a frame [J].
    pub fn kinetic_since(&self, start: &Self, frame: &Observer) -> f64 {
        let change = self.momentum - start.momentum;
        self.kinetic - start.kinetic - frame.velocity_at(self.time).dot(&change)
            + self.fall_since(start, frame)
    }
    /// Term F that the free fall of the frame since `start` adds to both [J].
    fn fall_since(&self, start: &Self, frame: &Observer) -> f64 {
        let [now, then] = [self.time, start.time].map(|time| frame.velocity_at(time));
        (now - then).dot(&(0.5 * self.mass * (now + then) - start.momentum))
    }
}

/// The bodies on one side of the impact.
#[derive(Clone, Debug, Default)]
pub(super) struct Side {
    /// Indices of the bodies.
    pub bodies: Vec<usize>,
    /// Sign of each pair's impulse for these bodies: 1 if they are the slave, −1 if the master, else 0.
    pub signs: ByPair<f64>,
    /// Total mass of the bodies [kg].
    pub mass: f64,
}

impl Side {
    /// The bodies with a role.
    pub fn new(plan: &Plan, role: Role) -> Self {
        let bodies: Vec<usize> = (0..plan.bodies.len()).filter(|&b| plan.bodies[b].role == role).collect();
        let mass = bodies.iter().map(|&b| plan.bodies[b].mass).sum();
        let mut side = Self { signs: ByPair::default(), mass, bodies };
        let pairs = plan.contact.as_ref().map(|contact| &contact.pairs);
        side.signs = ByPair::new(pairs, |pair| side.sign_of(bodies_of(plan, pair)));
        side
    }

    /// Sign of the impulse of a pair of slave and master for these bodies.
    pub fn sign_of(&self, (slave, master): (usize, Option<usize>)) -> f64 {
        let side = |body: usize| f64::from(u8::from(self.bodies.contains(&body)));
        side(slave) - master.map_or(0.0, side)
    }

    /// Takes up the pairs of the ledger that are not listed in the plan.
    pub fn take_up_pairs(&mut self, plan: &Plan, energy: &Energy) {
        for (pair, _) in energy.pairs.each() {
            if self.signs.get(pair).is_none() {
                let sign = self.sign_of(bodies_of(plan, pair));
                self.signs.of(pair, || sign);
            }
        }
    }

    fn sign(&self, pair: usize) -> f64 {
        self.signs.get(pair).copied().unwrap_or(0.0)
    }

    /// Sum of a ledger entry over the pairs that touch the side from outside.
    pub fn of_its_pairs(&self, energy: &Energy, line: fn(&PairLedger) -> f64) -> f64 {
        let touching = energy.pairs.each().filter(|(pair, _)| self.sign(*pair) != 0.0);
        touching.map(|(_, pair)| line(pair)).sum()
    }
}

/// Slave and master body of a pair, by its number; a plane is no body.
fn bodies_of(plan: &Plan, pair: usize) -> (usize, Option<usize>) {
    plan.contact.as_ref().map(|contact| contact.bodies_of(&contact.pairs.get(pair))).unwrap_or_default()
}
