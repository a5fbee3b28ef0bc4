//! All measures of a run together.

use super::absorbed_energy::AbsorbedEnergy;
use super::artificial_end::ArtificialEnds;
use super::deflection::Deflection;
use super::eroded::Eroded;
use super::fields::Fields;
use super::hourglass_energy::HourglassEnergy;
use super::law_range::LawRanges;
use super::pair::{PairMeasures, pairs_of};
use super::penetration::Penetration;
use super::stress_depth::StressDepth;
use super::summary::{AskedAccuracy, ErrorBars};
use super::wave_reach::WaveSpeed;
use crate::mesh::MeshError;
use crate::plan::Plan;
use crate::step::{Energy, Frame};

/// Everything measured so far.
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
    /// What was given up.
    pub eroded: Eroded,
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
    /// How exact they were asked to be.
    pub accuracy: Option<AskedAccuracy>,
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

    /// Gives the numbers error bars, and an accuracy that they shall have.
    #[must_use]
    pub fn with_error_bars(self, error_bars: ErrorBars, accuracy: Option<AskedAccuracy>) -> Self {
        Self { error_bars, accuracy, ..self }
    }

    /// The pairs in which the tissue is struck: by the projectiles, where there are any, however it rests on others.
    pub fn strikes(&self) -> impl Iterator<Item = &PairMeasures> {
        let any_projectile = self.pairs.iter().any(|pair| pair.on_tissue && pair.of_projectile);
        self.pairs.iter().filter(move |pair| pair.on_tissue && (pair.of_projectile || !any_projectile))
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
            block.for_each_moved_batch(frame.points(), &mut |slots, points| {
                let among_all = block.first_slot + slots.start..block.first_slot + slots.end;
                laws.accumulate(among_all.clone(), points);
                if let Some(stress) = stress {
                    let position =
                        |lane: usize, q: usize| block.point_position(slots.start + lane, q, &frame.plan.X);
                    let body = &frame.plan.bodies[block.body];
                    let nodes = |lane: usize| {
                        let element = block.elements[slots.start + lane] - body.elements.start;
                        body.cells.points(element as usize, &frame.plan.X)
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

    /// Before the first step.
    ///
    /// # Errors
    /// When the tissue's skin has no depth below it.
    pub fn start(&mut self, plan: &Plan) -> Result<(), MeshError> {
        *self = Self {
            pairs: pairs_of(plan),
            absorbed: AbsorbedEnergy::new(plan),
            stress: StressDepth::new(plan)?,
            laws: LawRanges::new(plan),
            wave_speed: WaveSpeed::new(plan),
            deflection: Deflection::new(plan),
            fields: Fields::new(plan),
            artificial_ends: self.artificial_ends.take(),
            scene_warnings: std::mem::take(&mut self.scene_warnings),
            error_bars: std::mem::take(&mut self.error_bars),
            accuracy: self.accuracy.take(),
            ..Self::default()
        };
        Ok(())
    }

    /// Takes in the frame of a step.
    pub fn accumulate(&mut self, frame: &Frame) {
        let time = frame.time;
        for (index, pair) in self.pairs.iter_mut().enumerate() {
            pair.accumulate(frame, index);
        }
        if let Some(absorbed) = &mut self.absorbed {
            let held = absorbed.holder.velocity(&frame.plan.loads, time);
            absorbed.accumulate(time, frame.energy, held);
        }
        self.hourglass.accumulate(frame.energy, frame.plan.rounding_energy);
        self.deflection.accumulate(frame);
        self.eroded.accumulate(frame);
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
    }
}
