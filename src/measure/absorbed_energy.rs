//! Energy absorbed by the tissue, computed both ways: from its own state, and from the work of the reactions on it; and what the
//! projectile has lost in contact.
//!
//! All are told in an inertial frame of the tissue's own, so that they are the same for whoever looks: that of whoever holds it, or of
//! the plane that it touches, and along axes where nobody does, that in which its centre of mass rested when it was first touched. In a frame
//! that moves with V, bodies with the momentum p that contact has given the impulse P,
//!
//! ```text
//! ΔK' = ΔK − V·Δp      W'_contact = W_contact − V·P      W'_ext = W_ext − V·(Δp − P)
//! ```

use crate::mechanics::tensor::Vec3;
use crate::plan::{Holder, Plan};
use crate::scene::document::Role;
use crate::step::Energy;

/// What the tissue has absorbed at one time, as changes since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Absorbed {
    /// Time [s].
    pub time: f64,
    /// Change of strain energy [J].
    pub strain: f64,
    /// Change of kinetic energy [J].
    pub kinetic: f64,
    /// Dissipated by viscosity, by erosion and by the time integrator [J].
    pub dissipated: f64,
    /// Work of external forces and of the position projection, which is not absorbed from the impact [J].
    pub not_from_contact: f64,
    /// Work of the contact reactions on the tissue [J].
    pub work: f64,
}

impl Absorbed {
    /// Strain + kinetic + dissipated − what did not come through contact [J].
    pub fn by_state(&self) -> f64 {
        self.strain + self.kinetic + self.dissipated - self.not_from_contact
    }
    /// What the tissue could give back: strain + kinetic [J].
    pub fn recoverable(&self) -> f64 {
        self.strain + self.kinetic
    }
}

/// What bodies have at one time.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// Strain energy [J].
    strain: f64,
    /// Kinetic energy [J].
    kinetic: f64,
    /// Momentum [kg m/s].
    momentum: Vec3,
    /// Work of external forces and of the position projection so far [J].
    given: f64,
    /// Impulse that contact has given so far [N s].
    impulse: Vec3,
}

impl Motion {
    /// Of bodies, with what the impulse on the slave of each pair is to them: 1, −1 where they are the master, else 0.
    fn of(bodies: &[usize], signs: &[f64], energy: &Energy) -> Self {
        let impulses =
            signs.iter().zip(&energy.pairs).map(|(sign, pair)| Vec3::from(pair.impulse_n_s) * *sign);
        let start = Self { impulse: impulses.sum(), ..Self::default() };
        bodies.iter().map(|&b| &energy.bodies[b]).fold(start, |sum, b| Self {
            strain: sum.strain + b.strain_j,
            kinetic: sum.kinetic + b.kinetic_j,
            momentum: sum.momentum + Vec3::from(b.momentum_kg_m_per_s),
            given: sum.given + b.external_work_j + b.projection_j,
            ..sum
        })
    }
    /// Work since `start` that did not come through contact, in a frame that moves with `velocity` [J].
    fn given_since(&self, start: &Self, velocity: &Vec3) -> f64 {
        self.given - velocity.dot(&(self.momentum - start.momentum - self.impulse))
    }
    /// Change of the kinetic energy since `start` in a frame that moves with `velocity` [J].
    fn kinetic_since(&self, start: &Self, velocity: &Vec3) -> f64 {
        self.kinetic - start.kinetic - velocity.dot(&(self.momentum - start.momentum))
    }
}

/// Accumulates the energy of the bodies in the role of the tissue, and the loss of those in the role of the projectile.
#[derive(Clone, Debug)]
pub struct AbsorbedEnergy {
    tissue: Vec<usize>,
    projectile: Vec<usize>,
    /// Who holds the tissue.
    pub holder: Holder,
    /// What the impulse on the slave of each pair is to the tissue and to the projectile: 1, −1 where it is the master, else 0.
    signs: [Vec<f64>; 2],
    /// Mass of the tissue [kg].
    mass: f64,
    /// Of the frame, V [m/s].
    velocity: Vec3,
    /// Of tissue and projectile at the start.
    start: Option<[Motion; 2]>,
    /// At the latest step.
    pub now: Absorbed,
    /// Where `by_state` was largest.
    pub peak: Absorbed,
    /// Strain + kinetic energy that the projectile has lost, and work that gravity and other loads have done on it [J].
    pub projectile_loss: f64,
    /// Largest |by state − by work| so far [J].
    pub disagreement: f64,
}

impl AbsorbedEnergy {
    /// `None` when the plan has no tissue.
    pub fn new(plan: &Plan) -> Option<Self> {
        let with = |role| (0..plan.bodies.len()).filter(|&b| plan.bodies[b].role == role).collect::<Vec<_>>();
        let tissue = with(Role::Tissue);
        let of_pairs = plan.contact.as_ref().map_or(&[][..], |contact| &contact.pair_bodies);
        let is_tissue = |body: usize| tissue.contains(&body);
        let on_plane = of_pairs.iter().any(|&(slave, master)| master.is_none() && is_tissue(slave));
        let projectile = with(Role::Projectile);
        let signs = [&tissue, &projectile].map(|bodies| {
            let side = |body: usize| f64::from(u8::from(bodies.contains(&body)));
            of_pairs.iter().map(|&(slave, master)| side(slave) - master.map_or(0.0, side)).collect()
        });
        let own = Self {
            holder: Holder::new(plan, is_tissue, on_plane),
            signs,
            mass: tissue.iter().map(|&b| plan.bodies[b].mass).sum(),
            ..Self::of_bodies(tissue.clone(), projectile)
        };
        (!tissue.is_empty()).then_some(own)
    }

    /// Of bodies by number.
    fn of_bodies(tissue: Vec<usize>, projectile: Vec<usize>) -> Self {
        Self {
            tissue,
            projectile,
            holder: Holder::default(),
            signs: Default::default(),
            mass: 0.0,
            velocity: Vec3::zeros(),
            start: None,
            now: Absorbed::default(),
            peak: Absorbed::default(),
            projectile_loss: 0.0,
            disagreement: 0.0,
        }
    }

    /// Velocity of the frame that energies are told in [m/s].
    pub fn velocity(&self) -> Vec3 {
        self.velocity
    }

    /// Whether the projectile's loss can be told.
    pub fn has_projectile(&self) -> bool {
        !self.projectile.is_empty()
    }

    /// Takes in the ledger of one step, and the velocity of the holder along each axis [m/s].
    pub fn accumulate(&mut self, time: f64, energy: &Energy, held: [Option<f64>; 3]) {
        let sum = |part: fn(&crate::step::BodyEnergy) -> f64| -> f64 {
            self.tissue.iter().map(|&b| part(&energy.bodies[b])).sum()
        };
        let [of_tissue, of_projectile] = &self.signs;
        let tissue = Motion::of(&self.tissue, of_tissue, energy);
        let projectile = Motion::of(&self.projectile, of_projectile, energy);
        if self.start.is_none() || tissue.impulse == Vec3::zeros() {
            let rest = |axis: usize| if self.mass > 0.0 { tissue.momentum[axis] / self.mass } else { 0.0 };
            self.velocity = Vec3::from_fn(|axis, _| held[axis].unwrap_or_else(|| rest(axis)));
        }
        let [tissue_start, projectile_start] = *self.start.get_or_insert([tissue, projectile]);
        self.now = Absorbed {
            time,
            strain: tissue.strain - tissue_start.strain,
            kinetic: tissue.kinetic_since(&tissue_start, &self.velocity),
            dissipated: sum(|b| b.viscous_j + b.eroded_j + b.algorithmic_j),
            not_from_contact: tissue.given_since(&tissue_start, &self.velocity),
            work: sum(|b| b.contact_work_j) - self.velocity.dot(&tissue.impulse),
        };
        if self.now.by_state() > self.peak.by_state() {
            self.peak = self.now;
        }
        self.projectile_loss = projectile_start.strain
            - projectile.strain
            - projectile.kinetic_since(&projectile_start, &self.velocity)
            + projectile.given_since(&projectile_start, &self.velocity);
        self.disagreement = self.disagreement.max((self.now.by_state() - self.now.work).abs());
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;
    use crate::step::BodyEnergy;

    fn energy(tissue: BodyEnergy, projectile: BodyEnergy) -> Energy {
        Energy { bodies: vec![projectile, tissue], ..Energy::default() }
    }

    #[test]
    fn both_ways_agree_when_the_ledger_is_closed() {
        let mut measure = AbsorbedEnergy::of_bodies(vec![1], vec![0]);
        let start = BodyEnergy { strain_j: 1.0, ..BodyEnergy::default() };
        measure.accumulate(
            0.0,
            &energy(start, BodyEnergy { kinetic_j: 10.0, ..BodyEnergy::default() }),
            [None; 3],
        );
        assert_eq!(measure.now, Absorbed::default());
        let middle = BodyEnergy {
            strain_j: 4.0,
            hourglass_j: 0.5,
            algorithmic_j: 0.0,
            kinetic_j: 1.0,
            viscous_j: 0.5,
            contact_work_j: 4.2,
            external_work_j: 0.2,
            projection_j: 0.1,
            ..BodyEnergy::default()
        };
        measure.accumulate(
            1.0,
            &energy(middle, BodyEnergy { kinetic_j: 5.5, ..BodyEnergy::default() }),
            [None; 3],
        );
        let end = BodyEnergy { strain_j: 2.0, viscous_j: 0.6, contact_work_j: 1.6, ..BodyEnergy::default() };
        measure.accumulate(
            2.0,
            &energy(end, BodyEnergy { kinetic_j: 7.0, ..BodyEnergy::default() }),
            [None; 3],
        );
        assert!((measure.peak.by_state() - 4.2).abs() < 1e-12 && measure.peak.time == 1.0);
        assert!((measure.peak.recoverable() - 4.0).abs() < 1e-12);
        assert!((measure.now.by_state() - 1.6).abs() < 1e-12);
        assert!(measure.disagreement < 1e-12);
        assert!((measure.projectile_loss - 3.0).abs() < 1e-12);
    }

    #[test]
    fn what_gravity_gives_a_projectile_is_not_gained() {
        let mut measure = AbsorbedEnergy::of_bodies(vec![1], vec![0]);
        let falls = |kinetic_j: f64, external_work_j: f64| BodyEnergy {
            kinetic_j,
            external_work_j,
            ..BodyEnergy::default()
        };
        for projectile in [falls(0.0, 0.0), falls(2.0, 2.0)] {
            measure.accumulate(0.0, &energy(BodyEnergy::default(), projectile), [None; 3]);
        }
        assert_eq!(measure.projectile_loss, 0.0);
        measure.accumulate(0.0, &energy(BodyEnergy::default(), falls(0.5, 2.0)), [None; 3]);
        assert_eq!(measure.projectile_loss, 1.5);
    }

    #[test]
    fn a_leak_is_seen() {
        let mut measure = AbsorbedEnergy::of_bodies(vec![1], vec![]);
        measure.accumulate(0.0, &energy(BodyEnergy::default(), BodyEnergy::default()), [None; 3]);
        let leak = BodyEnergy { strain_j: 3.0, contact_work_j: 2.0, ..BodyEnergy::default() };
        measure.accumulate(1.0, &energy(leak, BodyEnergy::default()), [None; 3]);
        assert!((measure.disagreement - 1.0).abs() < 1e-12);
        assert!(!measure.has_projectile());
    }
}
