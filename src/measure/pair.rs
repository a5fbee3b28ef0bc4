//! Measures of one contact pair: its forces and its patch.

use super::contact_patch::{ContactPatch, PatchGeometry};
use super::impact_force::{ImpactForce, PairSample, resultant_force};
use crate::mechanics::contact::{ContactPair, Master};
use crate::mechanics::rigid::Shape;
use crate::mechanics::tensor::Vec3;
use crate::plan::{ByPair, ContactPlan, Plan, PlanBody};
use crate::scene::document::Role;
use crate::step::Frame;

/// Forces and patch of one contact pair.
pub struct PairMeasures {
    /// Name of the pair.
    pub name: String,
    /// Names of slave and master.
    pub between: [String; 2],
    /// Whether exactly one of them is the tissue.
    pub on_tissue: bool,
    /// Whether the other one is the projectile.
    pub of_projectile: bool,
    /// Index into `between` of the body for which the impulse is reported: the tissue, or else the slave. The choice of
    /// slave depends on the mesh, so a sign by the slave would change with refinement.
    pub reported_on: usize,
    /// Whether both sides are rigid: they touch in points, without a patch.
    pub is_of_points: bool,
    /// Force measures of the pair.
    pub force: ImpactForce,
    /// Where it first touched the tissue, and the extent of its patch so far; `None` before.
    pub source: Option<Source>,
    /// Velocity of the reference frame of its tissue [m/s].
    tissue_flight: Vec3,
    /// Approach speed of its two sides [m/s].
    pub approach: f64,
    /// Patch geometry of the slave, and of the master if that is the mesh of another body; made at the first contact, since most pairs of many
    /// bodies never touch.
    geometry: Option<(PatchGeometry, Option<PatchGeometry>)>,
}

impl PairMeasures {
    /// Whether both sides are the same body.
    pub fn is_of_itself(&self) -> bool {
        self.between[0] == self.between[1]
    }

    /// Empty measures of a pair, by its number in the plan.
    pub(super) fn new(plan: &Plan, pair: usize) -> Self {
        let sides = plan.contact.as_ref().map(|contact| contact.bodies_of(&contact.pairs.get(pair)));
        let (slave, master) = sides.unwrap_or_default();
        let tissue = |body: usize| plan.bodies[body].role == Role::Tissue;
        let projectile = |body: usize| plan.bodies[body].role == Role::Projectile;
        let flight = |body: Option<usize>| body.map_or_else(Vec3::zeros, |b| plan.bodies[b].flight_velocity);
        Self {
            source: None,
            tissue_flight: flight(if tissue(slave) { Some(slave) } else { master }),
            approach: (flight(Some(slave)) - flight(master)).norm(),
            name: plan.name_of(pair),
            between: plan.names_of(pair).map(str::to_owned),
            on_tissue: master != Some(slave) && (tissue(slave) || master.is_some_and(tissue)),
            of_projectile: projectile(slave) || master.is_some_and(projectile),
            reported_on: usize::from(!tissue(slave) && master.is_some_and(tissue)),
            is_of_points: plan.bodies[slave].rigid.is_some(),
            force: ImpactForce::new(plan.measures.force_average, approach(plan, slave, master)),
            geometry: None,
        }
    }

    /// Accumulates a time [s] before its first contact.
    pub(super) fn accumulate_nothing(&mut self, time: f64) {
        self.force.accumulate(PairSample { time, ..PairSample::default() });
    }

    fn patch(&mut self, frame: &Frame, index: u32) -> ContactPatch {
        if self.geometry.is_none() && frame.contacts_of(index).next().is_some() {
            self.geometry = geometry_of(frame.plan, index as usize);
        }
        let Some((slave, master)) = &mut self.geometry else { return ContactPatch::default() };
        let window = self.force.touch_window();
        let patch = slave.eval(frame, index, window);
        master.as_mut().map_or(patch, |master| patch.within(&master.eval(frame, index, window)))
    }

    /// Accumulates a frame; `index` is the number of the pair in its plan.
    pub(super) fn accumulate(&mut self, frame: &Frame, index: usize) {
        let time = frame.time;
        let sample = PairSample {
            time,
            impulse: frame.energy.pairs.get(index).map_or_else(Vec3::zeros, |of| Vec3::from(of.impulse_n_s)),
            force: resultant_force(frame, index as u32),
            patch: self.patch(frame, index as u32),
        };
        self.force.accumulate(sample);
        if self.on_tissue && sample.patch.nodes > 0 {
            let centre = sample.patch.centre - self.tissue_flight * time;
            Source::widen(&mut self.source, centre, 0.5 * sample.patch.axes[0]);
        }
    }
}

/// Momentum of the approach of two bodies, `V_slave − V_master` times their reduced mass [kg m/s]; planes and bodies with a held node
/// have infinite mass.
fn approach(plan: &Plan, slave: usize, master: Option<usize>) -> Vec3 {
    let inverse_mass = |body: &PlanBody| {
        let nodes = body.nodes.start as usize..body.nodes.end as usize;
        let is_held = plan.inverse_mass[nodes].contains(&Vec3::zeros());
        if is_held || body.mass <= 0.0 { 0.0 } else { body.mass.recip() }
    };
    let (slave, master) = (&plan.bodies[slave], master.map(|master| &plan.bodies[master]));
    let inverse = inverse_mass(slave) + master.map_or(0.0, inverse_mass);
    let relative = slave.flight_velocity - master.map_or_else(Vec3::zeros, |master| master.flight_velocity);
    if inverse > 0.0 { relative / inverse } else { Vec3::zeros() }
}

/// Reference position of a pair's first contact with the tissue, and how far its patch has extended from there [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Reference position of the first contact [m].
    pub place: Vec3,
    /// Extent of the patch from there [m].
    pub spread: f64,
}

impl Source {
    /// Accumulates a patch: its centre in the reference configuration, and half its long axis [m].
    pub fn widen(this: &mut Option<Self>, centre: Vec3, radius: f64) {
        let source = this.get_or_insert(Self { place: centre, spread: 0.0 });
        source.spread = source.spread.max((centre - source.place).norm() + radius);
    }
}

/// Body index and shape of a rigid master.
fn rigid_shape(plan: &Plan, master: Option<usize>) -> Option<(usize, Shape)> {
    let body = master?;
    let index = plan.bodies[body].rigid?;
    Some((body, plan.rigid.as_ref()?.bodies[index].shape.clone()))
}

/// Faces of a master that is the mesh of another body.
fn master_faces(contact: &ContactPlan, pair: &ContactPair) -> Option<PatchGeometry> {
    let Master::Surface(master) = pair.master else { return None };
    let is_other = master != pair.slave;
    is_other.then(|| PatchGeometry::of_master(contact.surface_body[master], &contact.surfaces[master]))
}

/// Patch geometry of slave and master of a pair of the plan.
fn geometry_of(plan: &Plan, pair: usize) -> Option<(PatchGeometry, Option<PatchGeometry>)> {
    let contact = plan.contact.as_ref()?;
    let pair = contact.pairs.get(pair);
    let (slave, master) = contact.bodies_of(&pair);
    let surface = &contact.surfaces[pair.slave];
    let geometry = PatchGeometry::of_slave(slave, surface, rigid_shape(plan, master));
    Some((geometry, master_faces(contact, &pair)))
}

/// Empty measures of the listed pairs of a plan.
pub(super) fn pairs_of(plan: &Plan) -> ByPair<PairMeasures> {
    let pairs = plan.contact.as_ref().map(|contact| &contact.pairs);
    ByPair::new(pairs, |pair| PairMeasures::new(plan, pair))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_spreads_with_its_patch() {
        let mut source = None;
        Source::widen(&mut source, Vec3::x(), 0.1);
        Source::widen(&mut source, Vec3::x() * 1.5, 0.2);
        Source::widen(&mut source, Vec3::x(), 0.0);
        let source = source.unwrap_or(Source { place: Vec3::zeros(), spread: 0.0 });
        assert!(source.place == Vec3::x() && (source.spread - 0.7).abs() < 1e-15);
    }
}
