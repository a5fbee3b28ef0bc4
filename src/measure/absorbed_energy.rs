//! Energy absorbed by the tissue, computed in two ways: from its own state, and from the work of the contact reactions
//! on it; and the energy lost by the projectile.
//!
//! All energies refer to an inertial frame attached to the tissue, so that they do not depend on the observer: the
//! frame of its support, or of a plane that it touches before or when anything else does; along unsupported axes, the
//! frame in which its centre of mass rested when it was first touched. In a frame that moves with V, for bodies with
//! momentum p that have received the contact impulse P,
//!
//! ```text
//! ΔK' = ΔK − V·Δp      W'_contact = W_contact − V·P      W'_ext = W_ext − V·(Δp − P)
//! ```
//!
//! If only projectiles can touch an unsupported tissue, its frame falls freely: gravity, which accelerates all of it
//! alike, is not part of the impact, but would contribute to the work of a reaction on the falling body. In a frame
//! with the velocity V₀ + a t, with the mass M,
//!
//! ```text
//! ΔK' = ΔK − V·Δp + F      W'_contact = W_contact − V·P + a·∫P dt      W'_ext = W_ext − V·(Δp − P) − a·∫P dt + F
//! F = (V − V₀)·(½ M (V + V₀) − p₀)
//! ```

mod motion;

use crate::mechanics::tensor::Vec3;
use crate::plan::{ContactPlan, Holder, Plan};
use crate::scene::document::Role;
use crate::step::Energy;
use motion::{Motion, Observer, Side};

/// Energy absorbed by the tissue at one time, as changes since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Absorbed {
    /// Time of this state [s].
    pub time: f64,
    /// Change of strain energy [J].
    pub strain: f64,
    /// Change of kinetic energy [J].
    pub kinetic: f64,
    /// Energy dissipated by viscosity, by erosion and by the time integrator [J].
    pub dissipated: f64,
    /// Work of external forces and of the position projection, which is not absorbed from the impact [J].
    pub not_from_contact: f64,
    /// Work of the contact reactions on the tissue [J].
    pub work: f64,
    /// Numerical contact dissipation of the pairs that touch the tissue from outside [J].
    pub contact_loss: f64,
}

impl Absorbed {
    /// Absorbed energy by state: strain + kinetic + dissipated − work not from contact [J].
    pub fn by_state(&self) -> f64 {
        self.strain + self.kinetic + self.dissipated - self.not_from_contact
    }
    /// Energy given by the impact: the absorbed energy, plus the loss at contact nodes that a continuum would have
    /// passed on [J].
    pub fn given(&self) -> f64 {
        self.by_state() + self.contact_loss
    }
    /// Recoverable energy: strain + kinetic [J].
    pub fn recoverable(&self) -> f64 {
        self.strain + self.kinetic
    }
}

/// Accumulates the energy of the bodies in the role of the tissue, and the loss of those in the role of the projectile.
#[derive(Clone, Debug)]
pub struct AbsorbedEnergy {
    tissue: Side,
    projectile: Side,
    /// Support of the tissue.
    pub holder: Holder,
    /// Pairs of the tissue with planes.
    planes: Vec<usize>,
    /// Reference frame; after the first touch, the one of that time.
    frame: Observer,
    /// Whether the motion of the projectile is prescribed.
    is_driven: bool,
    /// Whether free projectiles alone can supply energy: there are no bodies but these and the tissue, and no loads but gravity.
    is_supplied_by_projectiles: bool,
    /// Most energy that they can have given so far [J], see [`Self::supplied`].
    most_supplied: f64,
    /// Whether the tissue has been touched.
    is_touched: bool,
    /// States of tissue and projectile at the start and at the latest step.
    motions: Option<[[Motion; 2]; 2]>,
    /// Absorbed energy at the latest step.
    pub now: Absorbed,
    /// Absorbed energy when `by_state` was largest.
    pub peak: Absorbed,
    /// Strain + kinetic energy lost by the projectile, plus the work of gravity and other loads on it [J].
    pub projectile_loss: f64,
    /// Largest |by state − by work| so far [J].
    pub disagreement: f64,
}

impl AbsorbedEnergy {
    /// `None` when the plan has no tissue.
    pub fn new(plan: &Plan) -> Option<Self> {
        let sides = [Role::Tissue, Role::Projectile].map(|role| Side::new(plan, role));
        let [tissue, projectile] = &sides;
        let pairs = || plan.contact.iter().flat_map(ContactPlan::each_bodies);
        let is_on_plane =
            |&(slave, master): &(usize, Option<usize>)| master.is_none() && tissue.bodies.contains(&slave);
        let planes = pairs().filter(|(_, sides)| is_on_plane(sides)).map(|(pair, _)| pair).collect();
        // A plane supports a body that has come to rest on it, not one that moves freely.
        let holder = plan.supports(|body| tissue.bodies.contains(&body), false);
        let is_projectile = |body: usize| projectile.bodies.contains(&body);
        let by_projectiles_only = pairs().all(|(_, sides)| {
            tissue.sign_of(sides) == 0.0 || is_projectile(sides.0) || sides.1.is_some_and(is_projectile)
        });
        let is_steady = plan.loads.gravity.is_none();
        let gravity = plan.gravity.filter(|_| by_projectiles_only && is_steady).unwrap_or_else(Vec3::zeros);
        let held = holder.velocity(&plan.loads, 0.0);
        let acceleration = Vec3::from_fn(|axis, _| if held[axis].is_none() { gravity[axis] } else { 0.0 });
        let frame = Observer { acceleration, ..Observer::default() };
        let (loads, count) = (&plan.loads, tissue.bodies.len() + projectile.bodies.len());
        let is_loaded =
            !(loads.prescribed.is_empty() && loads.pressures.is_empty() && loads.forces.is_empty());
        let is_supplied_by_projectiles =
            !projectile.bodies.is_empty() && count == plan.bodies.len() && !is_loaded;
        let any = !tissue.bodies.is_empty();
        let is_driven = plan.loads.prescribed.iter().any(|p| is_projectile(plan.body_of_node(p.node)));
        any.then(|| Self { holder, planes, frame, is_driven, is_supplied_by_projectiles, ..Self::of(sides) })
    }

    /// For tissue and projectile, in the frame at rest.
    fn of([tissue, projectile]: [Side; 2]) -> Self {
        Self {
            tissue,
            projectile,
            holder: Holder::default(),
            planes: Vec::new(),
            frame: Observer::default(),
            is_driven: false,
            is_supplied_by_projectiles: false,
            most_supplied: 0.0,
            is_touched: false,
            motions: None,
            now: Absorbed::default(),
            peak: Absorbed::default(),
            projectile_loss: 0.0,
            disagreement: 0.0,
        }
    }

    /// Velocity of the reference frame when the tissue was first touched [m/s].
    pub fn velocity(&self) -> Vec3 {
        self.frame.velocity
    }

    /// Strain and kinetic energy of the tissue at the start, in its frame then [J]: what they can have lost at most.
    pub fn at_start(&self) -> [f64; 2] {
        self.motions.map_or([0.0; 2], |[[start, _], _]| {
            [start.strain, (start.energy(&self.frame) - start.strain).max(0.0)]
        })
    }

    /// Whether there is a projectile that moves by itself, so that its loss is defined: prescribed motion does work on it.
    pub fn has_free_projectile(&self) -> bool {
        !self.projectile.bodies.is_empty() && !self.is_driven
    }

    /// Most energy that the impact can have given to the tissue so far [J]: the energy of the projectiles at the start, and the work of
    /// gravity on them. `None` where anything else can do work on the tissue, such as a plane in a moving frame.
    pub fn supplied(&self) -> Option<f64> {
        let is_known = self.is_supplied_by_projectiles
            && (self.planes.is_empty() || self.frame.velocity == Vec3::zeros());
        (is_known && self.most_supplied > 0.0).then_some(self.most_supplied)
    }

    /// Takes up the pairs of the ledger that are not listed in the plan.
    pub fn take_up_pairs(&mut self, plan: &Plan, energy: &Energy) {
        self.tissue.take_up_pairs(plan, energy);
        self.projectile.take_up_pairs(plan, energy);
    }

    /// Accumulates the ledger of one step, and the velocity of the support along each axis [m/s].
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
        let given = projectile.given_since(&start[1], &self.frame);
        let supplied = start[1].energy(&self.frame) + given;
        self.most_supplied = self.most_supplied.max(supplied);
        self.projectile_loss =
            start[1].strain - projectile.strain - projectile.kinetic_since(&start[1], &self.frame) + given;
        self.disagreement = self.disagreement.max((self.now.by_state() - self.now.work).abs());
    }

    /// Follows the support of the tissue, or the tissue itself, until it is touched.
    fn choose_frame(&mut self, tissue: &Motion, energy: &Energy, held: [Option<f64>; 3], is_first: bool) {
        let is_untouched = tissue.impulse == Vec3::zeros();
        if is_first || is_untouched {
            let rest =
                |axis: usize| if tissue.mass > 0.0 { tissue.momentum[axis] / tissue.mass } else { 0.0 };
            let velocity = Vec3::from_fn(|axis, _| held[axis].unwrap_or_else(|| rest(axis)));
            self.frame = Observer { time: tissue.time, velocity, ..self.frame };
        }
        if !is_untouched && !std::mem::replace(&mut self.is_touched, true) {
            let is_pressed = |pair: &usize| {
                energy.pairs.get(*pair).is_some_and(|of| of.impulse_n_s.iter().any(|p| *p != 0.0))
            };
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
    use crate::plan::ByPair;
    use crate::step::{BodyEnergy, PairLedger};

    /// A measure with the tissue as the second body and, optionally, a projectile as the first.
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
        // The projectile began with 10 J; where others may supply energy, nothing is known.
        assert_eq!(measure.supplied(), None);
        measure.is_supplied_by_projectiles = true;
        assert_eq!(measure.supplied(), Some(10.0));
        (measure.planes, measure.frame.velocity) = (vec![0], Vec3::x());
        assert_eq!(measure.supplied(), None);
        assert!((measure.peak.recoverable() - 4.0).abs() < 1e-12);
        measure.frame.velocity = Vec3::zeros();
        assert_eq!(measure.at_start(), [1.0, 0.0]);
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

    /// 2 kg falling under 10 m/s² and held up by 20 N from 1 s to 2 s: in the falling frame they are accelerated to 10
    /// m/s. Likewise the 1 kg of the projectile is slowed from 30 m/s to 10 m/s.
    #[test]
    fn a_tissue_that_falls_absorbs_what_it_would_without_gravity() {
        let mut measure = measure(true);
        measure.tissue.mass = 2.0;
        measure.tissue.signs.of(0, || 1.0);
        measure.projectile.mass = 1.0;
        measure.projectile.signs.of(0, || -1.0);
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
            let mut pairs = ByPair::default();
            pairs.of(0, || PairLedger { impulse_n_s: [0.0, 0.0, impulse], ..PairLedger::default() });
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
        assert!(!measure.has_free_projectile());
    }
}
