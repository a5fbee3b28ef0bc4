//! All measures of a run.

use super::absorbed_energy::AbsorbedEnergy;
use super::artificial_end::ArtificialEnds;
use super::computed::{Computed, ComputedMotion};
use super::deflection::Deflection;
use super::eroded::Eroded;
use super::fields::Fields;
use super::hourglass_energy::HourglassEnergy;
use super::law_range::LawRanges;
use super::pair::{PairMeasures, pairs_of};
use super::penetration::Penetration;
use super::squeeze::Squeeze;
use super::stress_depth::StressDepth;
use super::summary::{ErrorBars, RequestedAccuracy};
use super::wave_reach::WaveSpeed;
use crate::mechanics::force::PointInput;
use crate::mesh::MeshError;
use crate::plan::{ByPair, MOST_LISTED_PAIRS, Plan};
use crate::step::{Energy, Frame};

/// Everything measured so far.
#[derive(Default)]
pub struct Measures {
    /// One entry for each contact pair of the plan, of many bodies for each that has touched.
    pub pairs: ByPair<PairMeasures>,
    /// Absorbed energy; `None` without tissue.
    pub absorbed: Option<AbsorbedEnergy>,
    /// Stresses and strains of the tissue; `None` without tissue.
    pub stress: Option<StressDepth>,
    /// Fraction of the strain energy in the stabilisation.
    pub hourglass: HourglassEnergy,
    /// Deformation of each part compared with the range of its law.
    pub laws: LawRanges,
    /// Motion of the elements whose points are evaluated.
    motion: ComputedMotion,
    /// Wave speed in the tissue; `None` if it allows no conclusion.
    wave_speed: Option<WaveSpeed>,
    /// Deflection of the tissue's surface.
    pub deflection: Deflection,
    /// Eroded elements by part.
    pub eroded: Eroded,
    /// Interpenetration of bodies at the look times.
    pub penetration: Penetration,
    /// Thickness of the tissue between what strikes it and its base.
    pub squeeze: Squeeze,
    /// Fields at the latest field time; `None` if the plan requests none.
    pub fields: Option<Fields>,
    /// Energy ledger at the latest step.
    pub energy: Energy,
    /// Largest error of the balance so far [-].
    pub largest_balance_error: f64,
    /// Time of the latest step [s].
    pub time: f64,
    /// Number of steps so far.
    pub step: u64,
    /// Artificial ends of the model, which reflect waves; `None` if none is known.
    pub artificial_ends: Option<ArtificialEnds>,
    /// Warnings from the validation of the scene.
    pub scene_warnings: Vec<String>,
    /// Source of the error bars.
    pub error_bars: ErrorBars,
    /// Requested accuracy, if any.
    pub accuracy: Option<RequestedAccuracy>,
}

impl Measures {
    /// Empty measures of a run that has not started.
    pub fn new() -> Self {
        Self::default()
    }

    /// Enables the warning that a wave may have returned from an artificial end.
    #[must_use]
    pub fn with_artificial_ends(self, artificial_ends: Option<ArtificialEnds>) -> Self {
        Self { artificial_ends, ..self }
    }

    /// Repeats the warnings of validation in the summary.
    #[must_use]
    pub fn with_scene_warnings(self, scene_warnings: Vec<String>) -> Self {
        Self { scene_warnings, ..self }
    }

    /// Sets the source of the error bars, and the accuracy requested of the numbers.
    #[must_use]
    pub fn with_error_bars(self, error_bars: ErrorBars, accuracy: Option<RequestedAccuracy>) -> Self {
        Self { error_bars, accuracy, ..self }
    }

    /// Pairs in which the tissue is struck: by projectiles, or by bodies that these push onto it, as armour; without either by any
    /// body. What merely supports the tissue does not strike it.
    pub fn strikes(&self) -> impl Iterator<Item = &PairMeasures> {
        self.numbered_strikes().map(|(_, pair)| pair)
    }

    /// The same pairs with their numbers in the plan.
    fn numbered_strikes(&self) -> impl Iterator<Item = (usize, &PairMeasures)> {
        let has_touched = |pair: &&PairMeasures| pair.force.contact_span.is_some();
        let by_projectile = |pair: &&PairMeasures| pair.on_tissue && pair.of_projectile;
        let is_direct = self.pairs.values().filter(by_projectile).any(|pair| has_touched(&pair));
        // Bodies that a projectile has touched, where none has reached the tissue itself.
        let touched = self.pairs.values().filter(|pair| !is_direct && !pair.on_tissue && pair.of_projectile);
        let pushed: Vec<&String> = touched.filter(has_touched).flat_map(|pair| &pair.between).collect();
        let by_pushed = move |pair: &PairMeasures| {
            pair.on_tissue && pushed.contains(&&pair.between[1 - pair.reported_on])
        };
        let any = self.pairs.values().any(|pair| by_projectile(&pair) || by_pushed(pair));
        let is_struck =
            move |pair: &&PairMeasures| by_projectile(pair) || by_pushed(pair) || (!any && pair.on_tissue);
        self.pairs.each().filter(move |(_, pair)| is_struck(pair))
    }

    /// Pairs that results and recordings list, with their numbers in the plan: all, or of more than 64 those that have touched.
    pub fn listed_pairs(&self) -> impl Iterator<Item = (usize, &PairMeasures)> {
        let are_few = self.pairs.len() <= MOST_LISTED_PAIRS;
        self.pairs.each().filter(move |(_, pair)| are_few || pair.force.contact_span.is_some())
    }

    /// Accumulates the point stresses of a frame, given that of what is computed.
    fn accumulate_points(&mut self, frame: &Frame, own: &Frame) {
        let reach = self.wave_speed.as_ref().map(|speed| speed.reach(self.pairs.values(), frame));
        let (stress, fields, laws) = (&mut self.stress, &mut self.fields, &mut self.laws);
        laws.begin();
        if let Some(stress) = stress {
            stress.begin(frame.time, reach);
        }
        if let Some(fields) = fields {
            fields.clear();
        }
        let computed = Computed::of(frame.plan);
        let input = PointInput { with_rate: laws.have_rates(), ..own.points() };
        // One pass over the moved elements serves all three measures.
        for block in &own.plan.blocks {
            block.for_each_moved_batch(input, &mut |slots, points| {
                let [first, end] = [slots.start, slots.end].map(|slot| block.first_slot + slot);
                laws.accumulate(first..end, points);
                if let Some(stress) = stress {
                    for image in 0..computed.images() {
                        let position = |lane: usize, q: usize| {
                            computed.place(block.point_position(slots.start + lane, q, &own.plan.X), image)
                        };
                        let slots = computed.slot(first, image)..computed.slot(end, image);
                        stress.accumulate(block.body, slots, points, position);
                    }
                }
                if let Some(fields) = fields {
                    fields.accumulate(&block.elements[slots], points);
                }
            });
        }
        laws.end(own);
        if let Some(stress) = stress {
            stress.end();
        }
        if let Some(fields) = fields {
            fields.end(&computed);
        }
    }

    /// Prepares all measures before the first step.
    ///
    /// # Errors
    /// If the tissue's surface does not define a depth.
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

    /// Adds the pairs that touch for the first time and are not listed: until the last frame nothing touched in them.
    fn take_up_pairs(&mut self, frame: &Frame) {
        let of_pairs = frame.contacts.iter().zip(frame.reactions).filter(|(_, r)| r.impulse[0] > 0.0);
        for (contact, _) in of_pairs {
            let (pair, steps) = (contact.pair as usize, self.step);
            self.pairs.of(pair, || {
                let mut new = PairMeasures::new(frame.plan, pair);
                if steps > 0 {
                    new.accumulate_nothing(self.time);
                }
                new
            });
        }
    }

    /// Accumulates the frame of a step.
    pub fn accumulate(&mut self, frame: &Frame) {
        let time = frame.time;
        self.take_up_pairs(frame);
        for (index, pair) in self.pairs.each_mut() {
            pair.accumulate(frame, index);
        }
        if let Some(absorbed) = &mut self.absorbed {
            absorbed.take_up_pairs(frame.plan, frame.energy);
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
            let mut motion = std::mem::take(&mut self.motion);
            self.look(frame, &motion.frame(frame));
            self.motion = motion;
        }
    }

    /// Accumulates what is evaluated in whole bodies at a look time, given the frame of what is computed of them.
    fn look(&mut self, frame: &Frame, own: &Frame) {
        let touched =
            |pair: usize| self.pairs.get(pair).is_some_and(|pair| pair.force.contact_span.is_some());
        self.penetration.accumulate([frame, own], touched);
        let strikes: Vec<usize> = self.numbered_strikes().map(|(pair, _)| pair).collect();
        self.squeeze.accumulate(frame, &strikes);
        if frame.is_field_time {
            self.accumulate_points(frame, own);
        } else {
            self.laws.look(own);
        }
    }
}
