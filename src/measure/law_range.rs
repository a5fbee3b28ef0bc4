//! Checks, part by part, whether the laws stay within the deformations for which they are valid: at the look times, which
//! include the field times.

mod rates;
#[cfg(test)]
mod tests;

pub use rates::PartRates;

use super::computed::Computed;
use crate::mechanics::force::{
    ElementBlock, ErosionLimits, Formulation, PointBatch, PointInput, PointScalar,
};
use crate::mechanics::lanes::Row;
use crate::mechanics::material::{Deformations, Validity};
use crate::mesh::cell::CellPoints;
use crate::plan::Plan;
use crate::step::Frame;
use rates::Reached;
use std::ops::Range;

/// Damage beyond which a point counts as failed [-].
const TORN: f64 = 0.5;

/// A sum over points, and its maximum over time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Largest {
    now: f64,
    /// Largest value of the sum so far.
    pub largest: f64,
}

impl Largest {
    fn end(&mut self) {
        self.largest = self.largest.max(self.now);
    }
}

/// Reference volume outside of a range, and when it first was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outside {
    volume: Largest,
    /// First look time with any volume outside [s].
    pub since: Option<f64>,
}

impl Outside {
    /// Largest volume so far [m³].
    pub fn volume(&self) -> f64 {
        self.volume.largest
    }
    fn end(&mut self, time: f64) {
        self.volume.end();
        if self.volume.now > 0.0 {
            self.since.get_or_insert(time);
        }
    }
}

/// Range of deformation of one part of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct PartRange {
    /// Name of the body, as in the scene.
    pub body: String,
    /// Name of the part, as in the scene.
    pub part: String,
    /// Name of its set of the library, if it is one.
    pub set: Option<String>,
    /// Range of validity of its law.
    pub validity: Validity,
    /// Its reference volume [m³].
    pub volume: f64,
    /// Volume beyond the fitted range of the law.
    pub left: Outside,
    /// Volume beyond the limit of the law.
    pub beyond: Outside,
    /// Least and largest principal stretch so far [-].
    pub stretch: [f64; 2],
    /// Least and largest J so far [-].
    pub jacobian: [f64; 2],
    /// Its strain rates, beside those of the tests of its law.
    pub rates: PartRates,
    /// Volume whose stress has softened.
    pub softened: Outside,
    /// Volume that has lost more than half of its stress.
    pub torn: Outside,
    /// Strain energy beyond the limit of the law, maximum over the look times so far [J].
    pub energy_beyond: Largest,
    /// Strain energy beyond the limits declared for the law, maximum over the look times so far [J].
    pub energy_beyond_declared: Largest,
    /// Whether any of its one-point elements has inverted.
    pub has_turned_over: bool,
    /// Stretch at which its elements are eroded, of their mean deformation, if that is no larger than the limit of the law: then results are
    /// withheld by the mean, too.
    erodes_at: Option<f64>,
    /// Index of the body in [`LawRanges`].
    in_body: usize,
    /// Images of each point, itself included, all of which count [-].
    images: f64,
}

/// Strain energy of one body [J].
#[derive(Clone, Copy, Debug, Default)]
struct BodyRange {
    all: Largest,
    beyond: Largest,
    beyond_declared: Largest,
}

impl BodyRange {
    /// The largest of an energy, as a fraction of the largest strain energy [-].
    fn fraction(&self, energy: &Largest) -> f64 {
        energy.largest / self.all.largest.max(f64::MIN_POSITIVE)
    }
}

impl PartRange {
    /// Ranges of a part before any volume is added; `in_body` is the index of its body in [`LawRanges`].
    fn at_rest(body: String, part: String, validity: Validity, in_body: usize) -> Self {
        Self {
            body,
            part,
            set: None,
            validity,
            volume: 0.0,
            left: Outside::default(),
            beyond: Outside::default(),
            stretch: [1.0; 2],
            jacobian: [1.0; 2],
            rates: PartRates::of(validity.strain_rate),
            softened: Outside::default(),
            torn: Outside::default(),
            energy_beyond: Largest::default(),
            energy_beyond_declared: Largest::default(),
            has_turned_over: false,
            erodes_at: None,
            in_body,
            images: 1.0,
        }
    }
    /// Volumes outside each of the limits.
    fn volumes(&mut self) -> [&mut Outside; 4] {
        [&mut self.left, &mut self.beyond, &mut self.softened, &mut self.torn]
    }
    /// Accumulates the points in some lanes of a batch.
    fn accumulate(&mut self, body: &mut BodyRange, lanes: Range<usize>, points: &PointBatch) {
        for lane in lanes.clone() {
            for q in 0..points.count {
                body.all.now += self.images * points.volume[q][lane] * points.psi[q][lane];
            }
        }
        let of = |scalar: &PointScalar| Extremes::new(&scalar[..points.count], lanes.clone());
        if of(&points.damage).largest > 0.0 {
            self.accumulate_damage(lanes.clone(), points);
        }
        // Stretch and excess are monotonic, also in floating-point numbers: where the extremes of all points are within
        // the ranges, each point is.
        let [least, largest, J] =
            [&points.least_principal_strain, &points.principal_strain, &points.jacobian].map(of);
        let range = Deformations {
            stretch: [stretch(least.least), stretch(largest.largest)],
            jacobian: [J.least, J.largest],
        };
        let has_nan = least.has_nan || largest.has_nan || J.has_nan;
        if !has_nan && self.is_within_all(&range) {
            self.extend(&range);
        } else {
            self.accumulate_deformation(body, lanes, points);
        }
    }

    /// Accumulates softening, point by point.
    fn accumulate_damage(&mut self, lanes: Range<usize>, points: &PointBatch) {
        for lane in lanes {
            for q in 0..points.count {
                let (damage, volume) = (points.damage[q][lane], self.images * points.volume[q][lane]);
                if damage > 0.0 {
                    self.softened.volume.now += volume;
                }
                if damage > TORN {
                    self.torn.volume.now += volume;
                }
            }
        }
    }

    /// Compares the deformation with each range, point by point.
    fn accumulate_deformation(&mut self, body: &mut BodyRange, lanes: Range<usize>, points: &PointBatch) {
        let (Validity { fitted, limit, .. }, declared) = (self.validity, self.validity.declared_limit());
        for lane in lanes {
            let mean = self.erodes_at.map(|limit| (stretch(points.mean_strain[lane]), limit));
            // What the next step erodes is not the tissue's any more.
            if mean.is_some_and(|(mean, limit)| mean > limit) {
                continue;
            }
            for q in 0..points.count {
                let strains = [points.least_principal_strain[q][lane], points.principal_strain[q][lane]];
                let of_point =
                    Deformations { stretch: strains.map(stretch), jacobian: [points.jacobian[q][lane]; 2] };
                self.extend(&of_point);
                let volume = self.images * points.volume[q][lane];
                let energy = volume * points.psi[q][lane];
                let exceeds =
                    |range: Deformations, stretch: [f64; 2]| range.excess(stretch, of_point.jacobian) > 1.0;
                if exceeds(fitted, of_point.stretch) {
                    self.left.volume.now += volume;
                }
                if exceeds(limit, of_point.stretch) {
                    self.beyond.volume.now += volume;
                    self.energy_beyond.now += energy;
                    body.beyond.now += energy;
                }
                let [least, largest] = of_point.stretch;
                if exceeds(declared, [least, mean.map_or(largest, |(mean, _)| mean)]) {
                    self.energy_beyond_declared.now += energy;
                    body.beyond_declared.now += energy;
                }
            }
        }
    }

    /// Whether deformations exceed none of the ranges.
    fn is_within_all(&self, found: &Deformations) -> bool {
        let Validity { fitted, limit, .. } = self.validity;
        let ranges = [fitted, limit, self.validity.declared_limit()];
        ranges.iter().all(|range| range.excess(found.stretch, found.jacobian) <= 1.0)
    }

    /// Extends the range of deformation so far.
    fn extend(&mut self, Deformations { stretch, jacobian }: &Deformations) {
        self.stretch = [self.stretch[0].min(stretch[0]), self.stretch[1].max(stretch[1])];
        self.jacobian = [self.jacobian[0].min(jacobian[0]), self.jacobian[1].max(jacobian[1])];
    }

    /// Whether a limit that was declared for its law was exceeded at a point.
    pub fn exceeds_declared(&self) -> bool {
        self.validity.declared_limit().excess(self.stretch, self.jacobian) > 1.0
    }

    /// Largest fraction of the part's volume that was outside [-].
    pub fn fraction(&self, outside: &Outside) -> f64 {
        self.fraction_of(outside.volume())
    }

    /// A volume [m³] as a fraction of the part's [-].
    pub fn fraction_of(&self, volume: f64) -> f64 {
        if self.volume > 0.0 { volume / self.volume } else { 0.0 }
    }
}

/// Principal stretch of a principal Green–Lagrange strain [-].
fn stretch(strain: f64) -> f64 {
    (1.0 + 2.0 * strain).max(0.0).sqrt()
}

/// Extremes of a scalar at several points.
struct Extremes {
    least: f64,
    largest: f64,
    has_nan: bool,
}

impl Extremes {
    /// Extremes of the values in some lanes of rows.
    fn new(rows: &[Row], lanes: Range<usize>) -> Self {
        let nothing = Self { least: f64::INFINITY, largest: f64::NEG_INFINITY, has_nan: false };
        rows.iter().flat_map(|row| &row.0[lanes.clone()]).fold(nothing, |found, &x| Self {
            least: found.least.min(x),
            largest: found.largest.max(x),
            has_nan: found.has_nan | x.is_nan(),
        })
    }
}

/// Ranges of deformation of all parts of all bodies.
#[derive(Clone, Debug, Default)]
pub struct LawRanges {
    /// All parts, body by body.
    pub parts: Vec<PartRange>,
    /// The bodies that own them.
    bodies: Vec<BodyRange>,
    /// Part index of each slot of what is computed; irrelevant for padding.
    part_of: Vec<u32>,
    /// Rates that the points of each slot have had; empty where the plan compares none.
    reached: Vec<Reached>,
}

impl LawRanges {
    /// Empty ranges for the parts of the plan of a whole scene.
    pub fn new(whole: &Plan) -> Self {
        let computed = Computed::of(whole);
        let (plan, images) = (computed.plan, computed.images() as f64);
        let bodies = vec![BodyRange::default(); plan.bodies.len()];
        let slots = plan.slot_count();
        let reached = vec![Reached::default(); if plan.compares_rates() { slots } else { 0 }];
        let mut ranges = Self { parts: Vec::new(), bodies, part_of: vec![0; slots], reached };
        for block in &plan.blocks {
            let body = &plan.bodies[block.body];
            for (slot, element) in block.elements.iter().enumerate() {
                let element = (element - body.elements.start) as usize;
                let part_index = body.part_of[element] as usize;
                let name = &body.parts[part_index];
                let is_it = |part: &PartRange| part.part == *name && part.body == body.name;
                let known = ranges.parts.iter().position(is_it);
                let index = known.unwrap_or_else(|| {
                    let validity = body.validity[part_index];
                    let is_sooner = |at: &f64| *at <= validity.limit.stretch[1];
                    let stretch = |at: ErosionLimits| at.stretch;
                    let erodes_at = block.parameters.erosion.map(stretch).filter(is_sooner);
                    let part = PartRange::at_rest(body.name.clone(), name.clone(), validity, block.body);
                    let set = body.sets[part_index].clone();
                    ranges.parts.push(PartRange { set, erodes_at, images, ..part });
                    ranges.parts.len() - 1
                });
                ranges.parts[index].volume += images * block.point_volumes(slot).iter().sum::<f64>();
                ranges.part_of[block.first_slot + slot] = index as u32;
            }
        }
        ranges
    }

    /// Whether strain rates are compared.
    pub fn have_rates(&self) -> bool {
        !self.reached.is_empty()
    }

    /// Begins a pass over all points.
    pub fn begin(&mut self) {
        for part in &mut self.parts {
            for outside in part.volumes() {
                outside.volume.now = 0.0;
            }
            (part.energy_beyond.now, part.energy_beyond_declared.now) = (0.0, 0.0);
        }
        for body in &mut self.bodies {
            (body.all.now, body.beyond.now, body.beyond_declared.now) = (0.0, 0.0, 0.0);
        }
    }

    /// Accumulates the quadrature points of a batch of elements, with their slots among all slots.
    pub fn accumulate(&mut self, slots: Range<usize>, points: &PointBatch) {
        // Elements of one part mostly follow each other.
        let mut reached = self.reached.get_mut(slots.clone());
        let mut end = 0;
        for run in self.part_of[slots].chunk_by(|a, b| a == b) {
            let lanes = end..end + run.len();
            end = lanes.end;
            let part = &mut self.parts[run[0] as usize];
            if let Some(reached) = &mut reached {
                part.rates.accumulate(reached, lanes.clone(), points, part.images);
            }
            part.accumulate(&mut self.bodies[part.in_body], lanes, points);
        }
    }

    /// Evaluates all points of a frame of what is computed.
    pub fn look(&mut self, frame: &Frame) {
        self.begin();
        for block in &frame.plan.blocks {
            let input = PointInput { with_stress: false, with_rate: self.have_rates(), ..frame.points() };
            block.for_each_moved_batch(input, &mut |slots, points| {
                self.accumulate(block.first_slot + slots.start..block.first_slot + slots.end, points);
            });
        }
        self.end(frame);
    }

    /// One-point elements are evaluated at their centre only: those inverted at a point of the 2×2×2 rule count as
    /// beyond any limit.
    fn add_turned_over(&mut self, frame: &Frame) {
        let is_reduced = |block: &&ElementBlock| block.parameters.formulation == Formulation::Reduced;
        for block in frame.plan.blocks.iter().filter(is_reduced) {
            let body = &frame.plan.bodies[block.body];
            let elements = block.elements.iter().enumerate();
            for (slot, element) in elements.filter(|(_, element)| !frame.erosion.contains(**element)) {
                let cell = body.cells.get((element - body.elements.start) as usize);
                let at_rest = cell.points(&frame.plan.X);
                let now = CellPoints::new(cell.nodes, |node| frame.position_in(block.body, node));
                let part = &mut self.parts[self.part_of[block.first_slot + slot] as usize];
                let table = cell.kind.table();
                for &(xi, _) in table.quadrature {
                    let rest = (table.jacobian)(&at_rest, xi).determinant();
                    let J = (table.jacobian)(&now, xi).determinant() / rest;
                    if J <= 0.0 {
                        part.jacobian[0] = part.jacobian[0].min(J);
                        part.has_turned_over = true;
                        part.beyond.volume.now += part.images * rest;
                    }
                }
            }
        }
    }

    /// Ends the pass over the points of a frame of what is computed.
    pub fn end(&mut self, frame: &Frame) {
        self.add_turned_over(frame);
        let time = frame.time;
        for part in &mut self.parts {
            for outside in part.volumes() {
                outside.end(time);
            }
            part.energy_beyond.end();
            part.energy_beyond_declared.end();
        }
        for body in &mut self.bodies {
            body.all.end();
            body.beyond.end();
            body.beyond_declared.end();
        }
    }

    /// Volume of some bodies beyond the limits of their laws, of one part or of all [m³]: the sum of the largest volumes so far.
    pub fn volume_beyond(&self, bodies: &[usize], part: Option<&str>) -> f64 {
        let is_counted =
            |of: &&PartRange| bodies.contains(&of.in_body) && part.is_none_or(|part| part == of.part);
        self.parts.iter().filter(is_counted).map(|of| of.beyond.volume()).sum()
    }

    /// The part with most strain energy beyond the limit of its law, if any; a part with inverted elements comes first, then those
    /// whose limit was declared.
    pub fn worst(&self) -> Option<&PartRange> {
        let beyond = self.parts.iter().filter(|part| part.beyond.since.is_some());
        let energies = |part: &PartRange| [part.energy_beyond_declared.largest, part.energy_beyond.largest];
        beyond.max_by(|a, b| {
            let ([a_declared, a_all], [b_declared, b_all]) = (energies(a), energies(b));
            let by_energy = a_declared.total_cmp(&b_declared).then(a_all.total_cmp(&b_all));
            a.has_turned_over.cmp(&b.has_turned_over).then(by_energy)
        })
    }

    /// The part with most strain energy beyond a limit that is usual for its law, where none is declared.
    pub fn worst_undeclared(&self) -> Option<&PartRange> {
        let beyond = self.parts.iter().filter(|part| part.beyond.since.is_some() && !part.exceeds_declared());
        beyond.max_by(|a, b| a.energy_beyond.largest.total_cmp(&b.energy_beyond.largest))
    }

    /// Largest strain energy of a part beyond its limits, as a fraction of the peak of its body [-].
    pub fn fraction_of(&self, part: &PartRange) -> f64 {
        self.bodies[part.in_body].fraction(&part.energy_beyond)
    }

    /// Largest fraction of a body's peak strain energy that was beyond the limits of the laws [-]; 1 if elements have
    /// inverted, since their energy is meaningless.
    pub fn fraction_beyond(&self) -> f64 {
        self.largest_fraction(|body| &body.beyond)
    }

    /// The same beyond the limits that were declared for the laws.
    pub fn fraction_beyond_declared(&self) -> f64 {
        self.largest_fraction(|body| &body.beyond_declared)
    }

    fn largest_fraction(&self, energy: impl Fn(&BodyRange) -> &Largest) -> f64 {
        if self.parts.iter().any(|part| part.has_turned_over) {
            return 1.0;
        }
        self.bodies.iter().map(|body| body.fraction(energy(body))).fold(0.0, f64::max)
    }
}
