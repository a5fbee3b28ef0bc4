//! Energy absorbed by the tissue, computed both ways: from its own state, and from the work of the reactions on it.

use crate::plan::Plan;
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
    /// Dissipated by bulk viscosity and by the time integrator [J].
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

/// Accumulates the energy of the bodies in the role of the tissue, and the loss of those in the role of the projectile.
#[derive(Clone, Debug)]
pub struct AbsorbedEnergy {
    tissue: Vec<usize>,
    projectile: Vec<usize>,
    /// Strain and kinetic energy of the tissue at the start [J].
    tissue_start: Option<[f64; 2]>,
    /// Strain + kinetic energy of the projectile at the start [J].
    projectile_start: f64,
    /// At the latest step.
    pub now: Absorbed,
    /// Where `by_state` was largest.
    pub peak: Absorbed,
    /// Strain + kinetic energy that the projectile has lost [J].
    pub projectile_loss: f64,
    /// Largest |by state − by work| so far [J].
    pub disagreement: f64,
}

impl AbsorbedEnergy {
    /// `None` when the plan has no tissue.
    pub fn new(plan: &Plan) -> Option<Self> {
        let with = |role| (0..plan.bodies.len()).filter(|&b| plan.bodies[b].role == role).collect::<Vec<_>>();
        let tissue = with(Role::Tissue);
        (!tissue.is_empty()).then(|| Self::of_bodies(tissue, with(Role::Projectile)))
    }

    /// Of bodies by number.
    fn of_bodies(tissue: Vec<usize>, projectile: Vec<usize>) -> Self {
        Self {
            tissue,
            projectile,
            tissue_start: None,
            projectile_start: 0.0,
            now: Absorbed::default(),
            peak: Absorbed::default(),
            projectile_loss: 0.0,
            disagreement: 0.0,
        }
    }

    /// Whether the projectile's loss can be told.
    pub fn has_projectile(&self) -> bool {
        !self.projectile.is_empty()
    }

    /// Takes in the ledger of one step.
    pub fn accumulate(&mut self, time: f64, energy: &Energy) {
        let sum = |bodies: &[usize], part: fn(&crate::step::BodyEnergy) -> f64| -> f64 {
            bodies.iter().map(|&b| part(&energy.bodies[b])).sum()
        };
        let strain = sum(&self.tissue, |b| b.strain_j);
        let kinetic = sum(&self.tissue, |b| b.kinetic_j);
        let projectile = sum(&self.projectile, |b| b.strain_j + b.kinetic_j);
        let [strain_start, kinetic_start] = *self.tissue_start.get_or_insert_with(|| {
            self.projectile_start = projectile;
            [strain, kinetic]
        });
        self.now = Absorbed {
            time,
            strain: strain - strain_start,
            kinetic: kinetic - kinetic_start,
            dissipated: sum(&self.tissue, |b| b.viscous_j + b.algorithmic_j),
            not_from_contact: sum(&self.tissue, |b| b.external_work_j + b.projection_j),
            work: sum(&self.tissue, |b| b.contact_work_j),
        };
        if self.now.by_state() > self.peak.by_state() {
            self.peak = self.now;
        }
        self.projectile_loss = self.projectile_start - projectile;
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
        measure.accumulate(0.0, &energy(start, BodyEnergy { kinetic_j: 10.0, ..BodyEnergy::default() }));
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
        };
        measure.accumulate(1.0, &energy(middle, BodyEnergy { kinetic_j: 5.5, ..BodyEnergy::default() }));
        let end = BodyEnergy { strain_j: 2.0, viscous_j: 0.6, contact_work_j: 1.6, ..BodyEnergy::default() };
        measure.accumulate(2.0, &energy(end, BodyEnergy { kinetic_j: 7.0, ..BodyEnergy::default() }));
        assert!((measure.peak.by_state() - 4.2).abs() < 1e-12 && measure.peak.time == 1.0);
        assert!((measure.peak.recoverable() - 4.0).abs() < 1e-12);
        assert!((measure.now.by_state() - 1.6).abs() < 1e-12);
        assert!(measure.disagreement < 1e-12);
        assert!((measure.projectile_loss - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_leak_is_seen() {
        let mut measure = AbsorbedEnergy::of_bodies(vec![1], vec![]);
        measure.accumulate(0.0, &energy(BodyEnergy::default(), BodyEnergy::default()));
        let leak = BodyEnergy { strain_j: 3.0, contact_work_j: 2.0, ..BodyEnergy::default() };
        measure.accumulate(1.0, &energy(leak, BodyEnergy::default()));
        assert!((measure.disagreement - 1.0).abs() < 1e-12);
        assert!(!measure.has_projectile());
    }
}
