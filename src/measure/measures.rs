//! All measures of a run together.

use super::absorbed_energy::AbsorbedEnergy;
use super::artificial_end::ArtificialEnds;
use super::contact_patch::PatchGeometry;
use super::deflection::Deflection;
use super::fields::Fields;
use super::hourglass_energy::HourglassEnergy;
use super::impact_force::{ImpactForce, PairSample, resultant_force};
use super::law_range::LawRanges;
use super::penetration::Penetration;
use super::stress_depth::StressDepth;
use super::summary::{ErrorBars, Summary};
use super::wave_reach::{Source, WaveSpeed};
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::step::{Energy, Frame, Outcome, Recorder, RecorderError};

/// One contact pair.
pub struct PairMeasures {
    /// Name of the pair.
    pub name: String,
    /// Names of the slave's body and of the master's body or plane.
    pub between: [String; 2],
    /// Whether both are the same.
    pub of_itself: bool,
    /// Whether one of them is the tissue, and the other is not.
    pub on_tissue: bool,
    /// Which of `between` the impulse is told for: the tissue, or else the slave. Which side is the slave depends on the mesh,
    /// so a sign by the slave would change with refinement.
    pub told_for: usize,
    /// Whether both sides are rigid: they touch in points, without a patch.
    pub is_of_points: bool,
    /// Forces.
    pub force: ImpactForce,
    /// Where it first touched the tissue, and how far its patch has spread; `None` before.
    pub source: Option<Source>,
    /// Velocity of the frame of its tissue [m/s].
    tissue_flight: Vec3,
    /// How fast its two sides fly at each other [m/s].
    pub approach: f64,
    geometry: PatchGeometry,
}

/// Everything measured so far. Ignores the settling before the clock starts (negative times).
#[derive(Default)]
pub struct Measures {
    /// One for each contact pair of the plan.
    pub pairs: Vec<PairMeasures>,
    /// The tissue's energy; `None` without tissue.
    pub absorbed: Option<AbsorbedEnergy>,
    /// The tissue's stresses; `None` without tissue.
    pub stress: Option<StressDepth>,
    /// The stabilisation's share in the strain energy.
    pub hourglass: HourglassEnergy,
    /// How far the laws were stretched.
    pub laws: LawRanges,
    /// How fast waves run in the tissue; `None` where nothing follows of it.
    wave_speed: Option<WaveSpeed>,
    /// The skin's deflection.
    pub deflection: Deflection,
    /// What lies inside what.
    pub penetration: Penetration,
    /// Fields at the latest field time; `None` when the plan asks for none.
    pub fields: Option<Fields>,
    /// The ledger at the latest step.
    pub energy: Energy,
    /// Largest error of the balance so far [-].
    pub largest_balance_error: f64,
    /// Time and number of the latest step.
    pub time: f64,
    /// Steps so far.
    pub step: u64,
    /// Ends of the model that send waves back; `None` when none is known.
    pub artificial_ends: Option<ArtificialEnds>,
    /// What validation warned of.
    pub scene_warnings: Vec<String>,
    /// Where the numbers' error bars come from.
    pub error_bars: ErrorBars,
    /// The final summary, once the run has ended.
    pub summary: Option<Summary>,
}

impl Measures {
    /// Not started.
    pub fn new() -> Self {
        Self::default()
    }

    /// Warns when a wave may have come back from such an end.
    #[must_use]
    pub fn with_artificial_ends(self, artificial_ends: Option<ArtificialEnds>) -> Self {
        Self { artificial_ends, ..self }
    }

    /// Says in the summary too what validation warned of.
    #[must_use]
    pub fn with_scene_warnings(self, scene_warnings: Vec<String>) -> Self {
        Self { scene_warnings, ..self }
    }

    /// Gives the numbers error bars.
    #[must_use]
    pub fn with_error_bars(self, error_bars: ErrorBars) -> Self {
        Self { error_bars, ..self }
    }

    /// Takes in a frame's stresses.
    fn accumulate_points(&mut self, frame: &Frame) {
        let reach = self.wave_speed.as_ref().map(|speed| speed.reach(&self.pairs, frame));
        let (stress, fields, laws) = (&mut self.stress, &mut self.fields, &mut self.laws);
        laws.begin();
        if let Some(stress) = stress {
            stress.begin(frame.time, reach);
        }
        if let Some(fields) = fields {
            fields.clear();
        }
        for block in &frame.plan.blocks {
            block.for_each_moved_batch((frame.u, frame.v), &mut |slots, points| {
                let among_all = block.first_slot + slots.start..block.first_slot + slots.end;
                laws.accumulate(among_all.clone(), points);
                if let Some(stress) = stress {
                    let position =
                        |lane: usize, q: usize| block.point_position(slots.start + lane, q, &frame.plan.X);
                    let body = &frame.plan.bodies[block.body];
                    let nodes = |lane: usize| {
                        let element = block.elements[slots.start + lane] - body.elements.start;
                        body.hexes[element as usize].map(|node| frame.plan.X[node as usize])
                    };
                    stress.accumulate(block.body, among_all, points, position, nodes);
                }
                if let Some(fields) = fields {
                    fields.accumulate(&block.elements[slots], points);
                }
            });
        }
        laws.end(frame);
        if let Some(stress) = stress {
            stress.end();
        }
        if let Some(fields) = fields {
            fields.average();
        }
    }

    /// The summary of the run so far.
    pub fn running_summary(&self, plan: &Plan) -> Summary {
        Summary::compose(self, plan, None)
    }
}

impl Recorder for Measures {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        let boxed = |error| RecorderError(Box::new(error));
        *self = Self {
            pairs: pairs_of(plan),
            absorbed: AbsorbedEnergy::new(plan),
            stress: StressDepth::new(plan).map_err(boxed)?,
            laws: LawRanges::new(plan),
            wave_speed: WaveSpeed::new(plan),
            deflection: Deflection::new(plan),
            fields: Fields::new(plan),
            artificial_ends: self.artificial_ends.take(),
            scene_warnings: std::mem::take(&mut self.scene_warnings),
            error_bars: std::mem::take(&mut self.error_bars),
            ..Self::default()
        };
        Ok(())
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let time = frame.time;
        if time < 0.0 {
            return Ok(());
        }
        for (index, pair) in self.pairs.iter_mut().enumerate() {
            let sample = PairSample {
                time,
                impulse: Vec3::from(frame.energy.pairs[index].impulse_n_s),
                force: resultant_force(frame, index as u32),
                patch: pair.geometry.eval(frame, index as u32),
            };
            pair.force.accumulate(sample);
            if pair.on_tissue && sample.patch.nodes > 0 {
                let centre = sample.patch.centre - pair.tissue_flight * time;
                Source::widen(&mut pair.source, centre, 0.5 * sample.patch.axes[0]);
            }
        }
        if let Some(absorbed) = &mut self.absorbed {
            let held = absorbed.holder.velocity(&frame.plan.loads, time);
            absorbed.accumulate(time, frame.energy, held);
        }
        self.hourglass.accumulate(frame.energy, frame.plan.rounding_energy);
        self.deflection.accumulate(frame);
        self.energy.copy_from(frame.energy);
        self.largest_balance_error = self.largest_balance_error.max(frame.energy.balance_error);
        (self.time, self.step) = (time, frame.step);
        if frame.is_look_time {
            self.penetration.accumulate(frame, |pair| self.pairs[pair].force.contact_span.is_some());
        }
        if frame.is_field_time {
            self.accumulate_points(frame);
        } else if frame.is_look_time {
            self.laws.look(frame);
        }
        Ok(())
    }

    fn finish(&mut self, plan: &Plan, outcome: &Outcome) -> Result<(), RecorderError> {
        self.summary = Some(Summary::compose(self, plan, Some(outcome)));
        Ok(())
    }
}

/// The pairs of a plan.
fn pairs_of(plan: &Plan) -> Vec<PairMeasures> {
    let Some(contact) = &plan.contact else { return Vec::new() };
    let tissue = |body: usize| plan.bodies[body].role == crate::scene::document::Role::Tissue;
    let pairs = contact.pairs.iter().zip(&contact.pair_bodies);
    let flight = |body: Option<usize>| body.map_or_else(Vec3::zeros, |b| plan.bodies[b].flight_velocity);
    let tissue_of = |slave: usize, master: Option<usize>| if tissue(slave) { Some(slave) } else { master };
    pairs
        .map(|(pair, &(slave, master))| PairMeasures {
            source: None,
            tissue_flight: flight(tissue_of(slave, master)),
            approach: (flight(Some(slave)) - flight(master)).norm(),
            name: pair.name.clone(),
            between: [
                plan.bodies[slave].name.clone(),
                master.map_or_else(|| "plane".to_owned(), |m| plan.bodies[m].name.clone()),
            ],
            of_itself: master == Some(slave),
            on_tissue: master != Some(slave) && (tissue(slave) || master.is_some_and(tissue)),
            told_for: usize::from(!tissue(slave) && master.is_some_and(tissue)),
            is_of_points: plan.bodies[slave].rigid.is_some(),
            force: ImpactForce::new(plan.measures.force_average),
            geometry: PatchGeometry::new(slave, &contact.surfaces[pair.slave]),
        })
        .collect()
}
