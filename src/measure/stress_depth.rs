//! Depth of significant stress in the tissue, and the peaks of stress, strain and energy density at its quadrature
//! points.
//!
//! Evaluated at the field times and at the end, not at every step: peaks between two field times are missed, so choose
//! the field times closely enough.

use super::element_depth::{ElementDepths, Place};
use super::wave_reach::WaveReach;
use crate::mechanics::force::PointBatch;
use crate::mechanics::tensor::Vec3;
use crate::mesh::cell::CellPoints;
use crate::mesh::distance::DepthField;
use crate::plan::Plan;
use crate::scene::document::Role;
use std::ops::Range;

/// Depth and volume in which one threshold is exceeded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exceedance {
    /// Threshold of the von Mises stress [Pa].
    pub threshold: f64,
    /// Largest reference distance to the skin of a quadrature point above the threshold, at any field time so far [m].
    pub depth: f64,
    /// Distance from there to the next deeper point, which is below the threshold [m]: the resolution of the depth.
    pub depth_gap: f64,
    /// Time at which that depth was reached [s].
    pub depth_time: f64,
    /// Reference volume above the threshold at the latest field time [m³].
    pub volume: f64,
    /// Largest such volume at any field time so far [m³].
    pub largest_volume: f64,
    /// Largest volume represented by one of the points above the threshold, at any field time so far [m³].
    pub largest_point: f64,
    /// Volume above the threshold that no wave can have reached at the latest field time [m³]: a mesh artefact,
    /// excluded everywhere else.
    numerical: f64,
    /// Largest such volume at any field time so far [m³].
    pub largest_numerical: f64,
    /// Time of that volume, and how far a wave can have travelled by then [s, m].
    pub numerical_at: (f64, f64),
    /// Bit set of the ends of the tissue adjacent to its elements, see [`StressDepth::ends`].
    pub reached: u32,
    /// The same for each part, in the order of [`StressDepth::parts`].
    pub layers: Vec<Layer>,
}

/// Depth and volume of one part in which a threshold is exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Least and largest reference depth of its elements with points above the threshold, at any field time so far [m].
    pub depth: [f64; 2],
    /// Its reference volume above the threshold at the latest field time [m³].
    pub volume: f64,
    /// Largest such volume at any field time so far [m³].
    pub largest_volume: f64,
}

impl Layer {
    const NOTHING: Self = Self { depth: [f64::INFINITY, 0.0], volume: 0.0, largest_volume: 0.0 };
}

/// The volume in which a measure exceeds a threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dose {
    /// Threshold, in the unit of the measure.
    pub threshold: f64,
    /// Reference volume above it at the latest field time [m³].
    volume: f64,
    /// Largest such volume at any field time so far [m³].
    pub largest_volume: f64,
    /// Largest volume represented by one of the points above the threshold, at any field time so far [m³].
    pub largest_point: f64,
}

impl Dose {
    fn of(thresholds: &[f64]) -> Vec<Self> {
        thresholds.iter().map(|&threshold| Self { threshold, ..Self::default() }).collect()
    }
}

/// A maximum with its place and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Maximum so far; the value at rest until something exceeds it.
    pub value: f64,
    /// Reference position of the point [m].
    pub position: Vec3,
    /// Time of the maximum [s].
    pub time: f64,
}

impl Default for Peak {
    fn default() -> Self {
        Self { value: 0.0, position: Vec3::zeros(), time: 0.0 }
    }
}

impl Peak {
    /// Replaces the maximum if the value is larger.
    fn raise(&mut self, value: f64, position: impl Fn() -> Vec3, time: f64) {
        if value > self.value {
            *self = Self { value, position: position(), time };
        }
    }
}

/// Accumulates the stress measures over the quadrature points of the tissue.
pub struct StressDepth {
    /// Distances to the skin; `None` without a skin, which leaves depth undefined.
    depths: Option<ElementDepths>,
    /// Indices of the tissue bodies.
    bodies: Vec<usize>,
    /// Latest field time [s].
    pub time: f64,
    /// Region that waves can have reached at this field time; `None` if unknown.
    reach: Option<WaveReach>,
    /// Names of the tissue's ends, at most 32.
    pub ends: Vec<String>,
    /// For each slot the bit set of the ends adjacent to its element; empty if the tissue has no ends.
    at_ends: Vec<u32>,
    /// Names of the tissue's parts.
    pub parts: Vec<String>,
    /// For each slot the index of its part; empty if the tissue has no parts.
    part_of: Vec<u32>,
    /// Doses of strain energy density [J/m³].
    pub energy_doses: Vec<Dose>,
    /// Doses of the largest principal strain [-].
    pub strain_doses: Vec<Dose>,
    /// Number of field times so far.
    pub samples: u32,
    /// One entry for each threshold, ascending.
    pub exceedances: Vec<Exceedance>,
    /// Largest von Mises stress [Pa].
    pub von_mises: Peak,
    /// Largest principal Green–Lagrange strain [-].
    pub principal_strain: Peak,
    /// Largest strain energy density [J/m³].
    pub energy_density: Peak,
}

impl StressDepth {
    /// `None` when the plan has no tissue.
    ///
    /// # Errors
    /// When the skin is not a surface that a distance can be taken to.
    pub fn new(plan: &Plan) -> Result<Option<Self>, crate::mesh::MeshError> {
        let bodies: Vec<_> =
            (0..plan.bodies.len()).filter(|&b| plan.bodies[b].role == Role::Tissue).collect();
        if bodies.is_empty() {
            return Ok(None);
        }
        let faces = &plan.measures.tissue_skin;
        let skin = if faces.is_empty() { None } else { Some(DepthField::new(faces, &plan.X)?) };
        let (parts, part_of) = parts_of(plan, &bodies);
        let mut measure = Self::of(skin, bodies, plan.slot_count(), &plan.measures.stress_thresholds);
        measure.exceedances.iter_mut().for_each(|e| e.layers = vec![Layer::NOTHING; parts.len()]);
        Ok(Some(Self {
            ends: plan.measures.tissue_ends.iter().map(|end| end.name.clone()).collect(),
            at_ends: at_ends(plan),
            parts,
            part_of,
            energy_doses: Dose::of(&plan.measures.energy_density_thresholds),
            strain_doses: Dose::of(&plan.measures.strain_thresholds),
            ..measure
        }))
    }

    /// Assembles the measure from its components.
    fn of(skin: Option<DepthField>, bodies: Vec<usize>, slots: usize, thresholds: &[f64]) -> Self {
        let exceedances =
            thresholds.iter().map(|&threshold| Exceedance { threshold, ..Exceedance::default() });
        Self {
            depths: skin.map(|skin| ElementDepths::new(skin, slots)),
            bodies,
            time: 0.0,
            reach: None,
            ends: Vec::new(),
            at_ends: Vec::new(),
            parts: Vec::new(),
            part_of: Vec::new(),
            energy_doses: Vec::new(),
            strain_doses: Vec::new(),
            samples: 0,
            exceedances: exceedances.collect(),
            von_mises: Peak::default(),
            principal_strain: Peak::default(),
            energy_density: Peak::default(),
        }
    }

    /// Names of the tissue ends adjacent to the region above a threshold.
    pub fn reached(&self, exceedance: &Exceedance) -> Vec<String> {
        let named = self.ends.iter().enumerate().take(32);
        named.filter(|(bit, _)| exceedance.reached >> bit & 1 == 1).map(|(_, name)| name.clone()).collect()
    }

    /// Whether the tissue has a skin, so that depth is defined.
    pub fn has_skin(&self) -> bool {
        self.depths.is_some()
    }

    /// Begins a pass over all points at a time [s], given the region that waves can have reached, if known.
    pub fn begin(&mut self, time: f64, reach: Option<WaveReach>) {
        (self.time, self.reach) = (time, reach);
        self.samples += 1;
        for exceedance in &mut self.exceedances {
            (exceedance.volume, exceedance.numerical) = (0.0, 0.0);
            exceedance.layers.iter_mut().for_each(|layer| layer.volume = 0.0);
        }
        self.energy_doses.iter_mut().chain(&mut self.strain_doses).for_each(|dose| dose.volume = 0.0);
    }

    /// Accumulates the quadrature points of a batch of elements of a body, with their slots among all slots and their
    /// places: `position(lane, index in the element)` and `nodes(lane)`. Elements that have not moved may be omitted.
    pub fn accumulate(
        &mut self,
        body: usize,
        slots: Range<usize>,
        points: &PointBatch,
        position: impl Fn(usize, usize) -> Vec3,
        nodes: impl Fn(usize) -> CellPoints,
    ) {
        if !self.bodies.contains(&body) {
            return;
        }
        for (lane, slot) in slots.enumerate() {
            let place = Place { count: points.count, point: &|q| position(lane, q), nodes: &|| nodes(lane) };
            for q in 0..points.count {
                let [stress, strain, psi, volume] =
                    [&points.von_mises, &points.principal_strain, &points.psi, &points.volume]
                        .map(|field| field[q][lane]);
                // Most points raise no peak and exceed no threshold: their positions are not needed.
                if !self.tells_anything(stress, strain, psi) {
                    continue;
                }
                let X = position(lane, q);
                // Stress beyond the reach of waves is counted separately.
                if self
                    .reach
                    .as_ref()
                    .is_some_and(|reach| !reach.holds(&X, (points.count as f64 * volume).cbrt()))
                {
                    let above = self.exceedances.iter_mut().take_while(|e| stress > e.threshold);
                    above.for_each(|exceedance| exceedance.numerical += volume);
                    continue;
                }
                // Peaks, thresholds and doses.
                self.von_mises.raise(stress, || X, self.time);
                self.principal_strain.raise(strain, || X, self.time);
                self.energy_density.raise(psi, || X, self.time);
                if self.exceedances.first().is_some_and(|lowest| stress > lowest.threshold) {
                    self.accumulate_exceedance((stress, volume), (slot, q), &place);
                }
                accumulate_dose(&mut self.energy_doses, psi, volume);
                accumulate_dose(&mut self.strain_doses, strain, volume);
            }
        }
    }

    /// Whether a point exceeds a threshold or a peak.
    fn tells_anything(&self, stress: f64, strain: f64, psi: f64) -> bool {
        let above = |value: f64, peak: &Peak, doses: &[Dose]| {
            value > peak.value || doses.first().is_some_and(|lowest| value > lowest.threshold)
        };
        stress > self.von_mises.value
            || self.exceedances.first().is_some_and(|lowest| stress > lowest.threshold)
            || above(strain, &self.principal_strain, &self.strain_doses)
            || above(psi, &self.energy_density, &self.energy_doses)
    }

    /// Accumulates one point above the lowest threshold.
    fn accumulate_exceedance(
        &mut self,
        (stress, volume): (f64, f64),
        (slot, q): (usize, usize),
        place: &Place,
    ) {
        let ends = self.at_ends.get(slot).copied().unwrap_or(0);
        let part = self.part_of.get(slot).map(|part| *part as usize);
        let (mut depth, mut edges) = (0.0, [0.0; 2]);
        if let Some(depths) = &mut self.depths {
            (depth, edges) = (depths.point(slot, q, place), depths.edges(slot, place));
        }
        for exceedance in self.exceedances.iter_mut().take_while(|e| stress > e.threshold) {
            exceedance.volume += volume;
            exceedance.reached |= ends;
            exceedance.largest_point = exceedance.largest_point.max(volume);
            if let Some(layer) = part.and_then(|part| exceedance.layers.get_mut(part)) {
                layer.volume += volume;
                layer.depth = [layer.depth[0].min(edges[0]), layer.depth[1].max(edges[1])];
            }
            if let Some(depths) = self.depths.as_mut().filter(|_| depth > exceedance.depth) {
                (exceedance.depth, exceedance.depth_time) = (depth, self.time);
                exceedance.depth_gap = depths.gap_below(slot, depth, place);
            }
        }
    }

    /// Ends the pass and updates the maxima.
    pub fn end(&mut self) {
        for exceedance in &mut self.exceedances {
            exceedance.largest_volume = exceedance.largest_volume.max(exceedance.volume);
            if exceedance.numerical > exceedance.largest_numerical {
                exceedance.largest_numerical = exceedance.numerical;
                let reach = self.reach.as_ref().map_or(0.0, WaveReach::farthest);
                exceedance.numerical_at = (self.time, reach);
            }
            for layer in &mut exceedance.layers {
                layer.largest_volume = layer.largest_volume.max(layer.volume);
            }
        }
        for dose in self.energy_doses.iter_mut().chain(&mut self.strain_doses) {
            dose.largest_volume = dose.largest_volume.max(dose.volume);
        }
    }
}

fn accumulate_dose(doses: &mut [Dose], value: f64, volume: f64) {
    for dose in doses.iter_mut().take_while(|dose| value > dose.threshold) {
        dose.volume += volume;
        dose.largest_point = dose.largest_point.max(volume);
    }
}

/// For each slot of a plan the bit set of the tissue ends at which its element has nodes.
fn at_ends(plan: &Plan) -> Vec<u32> {
    let mut of_node = vec![0u32; plan.node_count()];
    for (bit, end) in plan.measures.tissue_ends.iter().enumerate().take(32) {
        end.nodes.iter().for_each(|node| of_node[*node as usize] |= 1 << bit);
    }
    let mut at_ends = vec![0; plan.slot_count()];
    for block in &plan.blocks {
        for slot in 0..block.elements.len() {
            let nodes = block.nodes_of(slot);
            at_ends[block.first_slot + slot] =
                nodes.iter().fold(0, |bits, node| bits | of_node[*node as usize]);
        }
    }
    at_ends
}

/// Unique part names of some bodies, and for each slot of the plan the index of its part (0 in other bodies, where it
/// is unused).
fn parts_of(plan: &Plan, bodies: &[usize]) -> (Vec<String>, Vec<u32>) {
    let mut names: Vec<String> = Vec::new();
    let mut part_of = vec![0; plan.slot_count()];
    for block in plan.blocks.iter().filter(|block| bodies.contains(&block.body)) {
        let body = &plan.bodies[block.body];
        for (slot, element) in block.elements.iter().enumerate() {
            let name = &body.parts[body.part_of[(element - body.elements.start) as usize] as usize];
            let index = names.iter().position(|known| known == name).unwrap_or_else(|| {
                names.push(name.clone());
                names.len() - 1
            });
            part_of[block.first_slot + slot] = index as u32;
        }
    }
    (names, part_of)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact values
mod tests {
    use super::*;
    use crate::mechanics::element::POINTS;

    /// An element in a slot of its own, all of whose points lie at height z and have the same stress.
    fn feed(measure: &mut StressDepth, body: usize, slot: usize, (z, stress): (f64, f64)) {
        let mut points = PointBatch { count: POINTS, ..PointBatch::default() };
        for q in 0..POINTS {
            (points.volume[q][0], points.von_mises[q][0], points.psi[q][0]) = (0.25, stress, stress);
        }
        let corner = |i: usize| Vec3::new(0.5, 0.5, z - if i < 4 { 0.05 } else { -0.05 });
        let nodes = |_| CellPoints::new(&[0, 1, 2, 3, 4, 5, 6, 7], |i| corner(i as usize));
        measure.accumulate(body, slot..slot + 1, &points, |_, _| Vec3::new(0.5, 0.5, z), nodes);
    }

    #[test]
    fn depth_is_the_deepest_point_above_each_threshold() {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0), Vec3::y()];
        let skin = DepthField::new(&[[0, 1, 2, 3]], &corners).unwrap();
        let mut measure = StressDepth::of(Some(skin), vec![1], 4, &[1.0, 5.0]);
        measure.begin(1.0, None);
        feed(&mut measure, 0, 0, (-9.0, 100.0)); // another body
        feed(&mut measure, 1, 1, (-0.1, 7.0));
        feed(&mut measure, 1, 2, (-0.3, 2.0));
        feed(&mut measure, 1, 3, (-0.8, 0.5));
        measure.end();
        measure.begin(2.0, None);
        feed(&mut measure, 1, 1, (-0.1, 3.0));
        feed(&mut measure, 1, 3, (-0.8, 0.5));
        measure.end();
        let [low, high] = [&measure.exceedances[0], &measure.exceedances[1]];
        assert!((low.depth - 0.3).abs() < 1e-12 && low.depth_time == 1.0);
        assert!((high.depth - 0.1).abs() < 1e-12);
        // Elements from 0.05 above to 0.05 below their points: the next point is in a neighbour, at the same distance
        // again.
        assert!((low.depth_gap - 0.1).abs() < 1e-12 && (high.depth_gap - 0.1).abs() < 1e-12);
        assert_eq!((low.volume, low.largest_volume, high.volume, high.largest_volume), (2.0, 4.0, 0.0, 2.0));
        assert_eq!((low.largest_point, high.largest_point), (0.25, 0.25));
        assert_eq!((measure.von_mises.value, measure.von_mises.time), (7.0, 1.0));
        assert_eq!(measure.energy_density.value, 7.0);
    }

    #[test]
    fn a_depth_is_known_to_the_next_point_below() {
        // A cube from 0 to 1 below the skin; Gauss points at 0.211 and 0.789.
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0), Vec3::y()];
        let skin = DepthField::new(&[[0, 1, 2, 3]], &corners).unwrap();
        let [upper, lower] = [-1.0, 1.0].map(|side: f64| 0.5 + side * 0.5 / 3.0_f64.sqrt());
        let mut measure = StressDepth::of(Some(skin), vec![0], 1, &[1.0, 5.0]);
        measure.exceedances.iter_mut().for_each(|e| e.layers = vec![Layer::NOTHING]);
        measure.part_of = vec![0];
        let mut points = PointBatch { count: POINTS, ..PointBatch::default() };
        for q in 0..POINTS {
            (points.volume[q][0], points.von_mises[q][0]) = (0.125, if q < 4 { 9.0 } else { 2.0 });
        }
        let height = |is_upper: bool| if is_upper { -upper } else { -lower };
        measure.begin(0.0, None);
        measure.accumulate(
            0,
            0..1,
            &points,
            |_, q| Vec3::new(0.5, 0.5, height(q < 4)),
            |_| {
                let corner = |i: u32| corners[i as usize % 4] - Vec3::z() * f64::from(u8::from(i < 4));
                CellPoints::new(&[0, 1, 2, 3, 4, 5, 6, 7], corner)
            },
        );
        measure.end();
        let [low, high] = [&measure.exceedances[0], &measure.exceedances[1]];
        // Above 5 only the upper points, above 1 the lower ones too: from there the next point is as far away, in a
        // neighbour.
        assert!((high.depth - upper).abs() < 1e-12 && (high.depth_gap - (lower - upper)).abs() < 1e-12);
        assert!((low.depth - lower).abs() < 1e-12 && (low.depth_gap - 2.0 * upper).abs() < 1e-12);
        // Layer bounds are the edges of their elements.
        assert!(high.layers[0].depth.iter().zip([0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn what_no_wave_can_have_reached_counts_nowhere() {
        use crate::measure::pair::Source;
        let mut source = None;
        Source::widen(&mut source, Vec3::new(0.5, 0.5, 0.0), 0.3);
        let mut measure = StressDepth::of(None, vec![0], 2, &[1.0]);
        measure.at_ends = vec![0, 1];
        // Elements of 2 m³, hence 1.26 m: stress within 0.3 m plus that is physical, stress beyond is a mesh artefact.
        measure.begin(1.0, source.map(WaveReach::of));
        feed(&mut measure, 0, 0, (-1.5, 2.0));
        feed(&mut measure, 0, 1, (-1.7, 3.0));
        measure.end();
        let found = &measure.exceedances[0];
        assert_eq!((found.largest_volume, found.largest_numerical, found.reached), (2.0, 2.0, 0));
        assert_eq!((measure.von_mises.value, found.numerical_at), (2.0, (1.0, 0.3)));
        // Without a known wave all points count, and regions at an end are reported as such.
        measure.begin(2.0, None);
        feed(&mut measure, 0, 1, (-1.7, 3.0));
        measure.end();
        assert_eq!((measure.exceedances[0].reached, measure.von_mises.value), (1, 3.0));
    }

    #[test]
    fn without_a_skin_there_is_volume_but_no_depth() {
        let mut measure = StressDepth::of(None, vec![0], 1, &[1.0]);
        measure.begin(0.0, None);
        feed(&mut measure, 0, 0, (-1.0, 2.0));
        measure.end();
        assert!(
            !measure.has_skin()
                && measure.exceedances[0].depth == 0.0
                && measure.exceedances[0].volume == 2.0
        );
    }
}
