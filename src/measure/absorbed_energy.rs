//! Energy absorbed by the tissue, computed both ways: from its own state, and from the work of the reactions on it; and what the
//! projectile has lost in contact.
//!
//! All are told in an inertial frame of the tissue's own, so that they are the same for whoever looks: that of whoever holds it, or of
//! a plane that it touches before or when anything else does, and along axes where nobody does, that in which its centre of mass rested when it was first touched. In a frame
//! that moves with V, bodies with the momentum p that contact has given the impulse P,
//!
//! ```text
//! ΔK' = ΔK − V·Δp      W'_contact = W_contact − V·P      W'_ext = W_ext − V·(Δp − P)
//! ```
//!
//! Where nothing but projectiles can touch a tissue that nobody holds, that frame falls with it: gravity, which moves all of it alike, is no
//! part of the impact, but would be as the work of a reaction on what falls meanwhile. In a frame with the velocity V₀ + a t, with the mass M,
//!
//! ```text
//! ΔK' = ΔK − V·Δp + F      W'_contact = W_contact − V·P + a·∫P dt      W'_ext = W_ext − V·(Δp − P) − a·∫P dt + F
//! F = (V − V₀)·(½ M (V + V₀) − p₀)
//! ```

mod motion;

use crate::mechanics::tensor::Vec3;
use crate::plan::{Holder, Plan};
use crate::scene::document::Role;
use crate::step::Energy;
use motion::{Motion, Observer, Side, pair_bodies};

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
    /// Numerical contact dissipation of the pairs that touch it from outside [J].
    pub contact_loss: f64,
}

impl Absorbed {
    /// Strain + kinetic + dissipated − what did not come through contact [J].
    pub fn by_state(&self) -> f64 {
        self.strain + self.kinetic + self.dissipated - self.not_from_contact
    }
    /// What the impact has given it: absorbed, and what contact nodes lost that a continuum would have passed on [J].
    pub fn given(&self) -> f64 {
        self.by_state() + self.contact_loss
    }
    /// What the tissue could give back: strain + kinetic [J].
    pub fn recoverable(&self) -> f64 {
        self.strain + self.kinetic
    }
}

/// Accumulates the energy of the bodies in the role of the tissue, and the loss of those in the role of the projectile.
#[derive(Clone, Debug)]
pub struct AbsorbedEnergy {
    tissue: Side,
    projectile: Side,
    /// Who holds the tissue.
    pub holder: Holder,
    /// Pairs of the tissue with planes.
    planes: Vec<usize>,
    /// The frame; that of the first touch once there was one.
    frame: Observer,
    /// Whether there was one.
    is_touched: bool,
    /// Of tissue and projectile at the start and at the latest step.
    motions: Option<[[Motion; 2]; 2]>,
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
        let sides = [Role::Tissue, Role::Projectile].map(|role| Side::new(plan, role));
        let [tissue, projectile] = &sides;
        let touching = || pair_bodies(plan).iter().zip(&tissue.signs).filter(|(_, sign)| **sign != 0.0);
        let is_on_plane =
            |&(slave, master): &(usize, Option<usize>)| master.is_none() && tissue.bodies.contains(&slave);
        let planes = (0..pair_bodies(plan).len()).filter(|&pair| is_on_plane(&pair_bodies(plan)[pair]));
        let planes = planes.collect();
        // A plane holds what has come to it, and nothing in flight.
        let holder = Holder::new(plan, |body| tissue.bodies.contains(&body), false);
        let is_projectile = |body: usize| projectile.bodies.contains(&body);
        let by_projectiles_only =
            touching().all(|(&(slave, master), _)| is_projectile(slave) || master.is_some_and(is_projectile));
        let is_steady = plan.loads.gravity.is_none();
        let gravity = plan.gravity.filter(|_| by_projectiles_only && is_steady).unwrap_or_else(Vec3::zeros);
        let held = holder.velocity(&plan.loads, 0.0);
        let acceleration = Vec3::from_fn(|axis, _| if held[axis].is_none() { gravity[axis] } else { 0.0 });
        let frame = Observer { acceleration, ..Observer::default() };
        let any = !tissue.bodies.is_empty();
        any.then(|| Self { holder, planes, frame, ..Self::of(sides) })
    }

    /// Of two sides, in the frame of who rests.
    fn of([tissue, projectile]: [Side; 2]) -> Self {
        Self {
            tissue,
            projectile,
            holder: Holder::default(),
            planes: Vec::new(),
            frame: Observer::default(),
            is_touched: false,
            motions: None,
            now: Absorbed::default(),
            peak: Absorbed::default(),
            projectile_loss: 0.0,
            disagreement: 0.0,
        }
    }

    /// Velocity of the frame that energies are told in, when the tissue was first touched [m/s].
    pub fn velocity(&self) -> Vec3 {
        self.frame.velocity
    }

    /// Whether the projectile's loss can be told.
    pub fn has_projectile(&self) -> bool {
        !self.projectile.bodies.is_empty()
    }

    /// Takes in the ledger of one step, and the velocity of the holder along each axis [m/s].
    pub fn accumulate(&mut self, time: f64, energy: &Energy, held: [Option<f64>; 3]) {
        let now = [&self.tissue, &self.projectile].map(|side| Motion::of(side, time, energy));
        let (start, latest) = self.motions.map_or((now, now), |[start, latest]| (start, latest));
        let now = [now[0].after(&latest[0]), now[1].after(&latest[1])];
        let is_first = self.motions.replace([start, now]).is_none();
        let [tissue, projectile] = now;
        self.choose_frame(&tissue, energy, held, is_first);
        let sum = |part: fn(&crate::step::BodyEnergy) -> f64| -> f64 {
            self.tissue.bodies.iter().map(|&b| part(&energy.bodies[b])).sum()
        };
        self.now = Absorbed {
            time,
            strain: tissue.strain - start[0].strain,
            kinetic: tissue.kinetic_since(&start[0], &self.frame),
            dissipated: sum(|b| b.viscous_j + b.eroded_j + b.algorithmic_j),
            not_from_contact: tissue.given_since(&start[0], &self.frame),
            contact_loss: self.tissue.of_its_pairs(energy, |pair| pair.numerical_j),
            work: tissue.contact_work(sum(|b| b.contact_work_j), &self.frame),
        };
        if self.now.by_state() > self.peak.by_state() {
            self.peak = self.now;
        }
        self.projectile_loss =
            start[1].strain - projectile.strain - projectile.kinetic_since(&start[1], &self.frame)
                + projectile.given_since(&start[1], &self.frame);
        self.disagreement = self.disagreement.max((self.now.by_state() - self.now.work).abs());
    }

    /// Follows who holds the tissue, or the tissue itself, until it is touched.
    fn choose_frame(&mut self, tissue: &Motion, energy: &Energy, held: [Option<f64>; 3], is_first: bool) {
        let is_untouched = tissue.impulse == Vec3::zeros();
        if is_first || is_untouched {
            let rest =
                |axis: usize| if tissue.mass > 0.0 { tissue.momentum[axis] / tissue.mass } else { 0.0 };
            let velocity = Vec3::from_fn(|axis, _| held[axis].unwrap_or_else(|| rest(axis)));
            self.frame = Observer { time: tissue.time, velocity, ..self.frame };
        }
        if !is_untouched && !std::mem::replace(&mut self.is_touched, true) {
            let is_pressed = |pair: &usize| Vec3::from(energy.pairs[*pair].impulse_n_s) != Vec3::zeros();
            if self.planes.iter().any(is_pressed) {
                self.frame = Observer::default();
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;
    use crate::step::{BodyEnergy, PairLedger};

    /// Of a tissue, the second body, and a projectile, the first one.
    fn measure(has_projectile: bool) -> AbsorbedEnergy {
        let side = |body: usize| Side { bodies: vec![body], ..Side::default() };
        AbsorbedEnergy::of([side(1), if has_projectile { side(0) } else { Side::default() }])
    }

    fn energy(tissue: BodyEnergy, projectile: BodyEnergy) -> Energy {
        Energy { bodies: vec![projectile, tissue], ..Energy::default() }
    }

    #[test]
    fn both_ways_agree_when_the_ledger_is_closed() {
        let mut measure = measure(true);
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
        let mut measure = measure(true);
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

    /// 2 kg that fall under 10 m/s² and are held up by 20 N from 1 s to 2 s: for who falls along they are pushed to 10 m/s. So is
    /// the 1 kg of the projectile stopped from 30 m/s to 10 m/s.
    #[test]
    fn a_tissue_that_falls_absorbs_what_it_would_without_gravity() {
        let mut measure = measure(true);
        (measure.tissue.mass, measure.tissue.signs) = (2.0, vec![1.0]);
        (measure.projectile.mass, measure.projectile.signs) = (1.0, vec![-1.0]);
        measure.frame.acceleration = -10.0 * Vec3::z();
        let body = |mass: f64, velocity: f64, external_work_j: f64, contact_work_j: f64| BodyEnergy {
            kinetic_j: 0.5 * mass * velocity * velocity,
            momentum_kg_m_per_s: [0.0, 0.0, mass * velocity],
            external_work_j,
            contact_work_j,
            ..BodyEnergy::default()
        };
        for (time, tissue, projectile, impulse) in [
            (0.0, body(2.0, 0.0, 0.0, 0.0), body(1.0, 30.0, 0.0, 0.0), 0.0),
            (1.0, body(2.0, -10.0, 100.0, 0.0), body(1.0, 20.0, -250.0, 0.0), 0.0),
            (2.0, body(2.0, -10.0, 300.0, -200.0), body(1.0, -10.0, -300.0, -100.0), 20.0),
        ] {
            let pairs = vec![PairLedger { impulse_n_s: [0.0, 0.0, impulse], ..PairLedger::default() }];
            measure.accumulate(time, &Energy { pairs, ..energy(tissue, projectile) }, [None; 3]);
            assert_eq!(measure.now.not_from_contact, 0.0);
        }
        assert_eq!((measure.now.by_state(), measure.now.work, measure.disagreement), (100.0, 100.0, 0.0));
        assert_eq!((measure.projectile_loss, measure.velocity().z), (400.0, -10.0));
    }

    #[test]
    fn a_leak_is_seen() {
        let mut measure = measure(false);
        measure.accumulate(0.0, &energy(BodyEnergy::default(), BodyEnergy::default()), [None; 3]);
        let leak = BodyEnergy { strain_j: 3.0, contact_work_j: 2.0, ..BodyEnergy::default() };
        measure.accumulate(1.0, &energy(leak, BodyEnergy::default()), [None; 3]);
        assert!((measure.disagreement - 1.0).abs() < 1e-12);
        assert!(!measure.has_projectile());
    }
}
