//! Depth of significant stress in the tissue, volumes above thresholds and values exceeded in volumes, and the peaks of
//! stress, strain and energy density at its quadrature points.
//!
//! Evaluated at the field times and at the end, not at every step: peaks between two field times are missed, so choose
//! the field times closely enough.

#[cfg(test)]
mod tests;

use super::computed::Computed;
use super::exceeded::{Dose, ExceededIn};
use super::stress_field::{MOST_ENDS, Region, StressField};
use super::tissue_parts::{TissueParts, ends_of_nodes};
use super::wave_reach::WaveReach;
use crate::mechanics::force::PointBatch;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use std::ops::Range;

/// A depth is larger than one before by more than rounding above this ratio [-]: its time is the first at which it is reached.
const DEEPER: f64 = 1.0 + 1e-9;
/// Fraction of the volume of a part in which the 95th percentile of the strain is exceeded [-].
const TAIL: f64 = 0.05;

/// Depth and volume in which one threshold is exceeded.
#[derive(Clone, Debug, PartialEq)]
pub struct Exceedance {
    /// Threshold of the von Mises stress [Pa].
    pub threshold: f64,
    /// Largest depth at which the [`StressField`] exceeds the threshold, at any field time so far [m].
    pub depth: f64,
    /// Time at which that depth was reached [s].
    pub depth_time: f64,
    /// Extent in depth of the edge on which that depth was read [m].
    edge: f64,
    /// The largest depth if every value of the field is lowered and raised by the bound of its error [m].
    depth_bounds: [f64; 2],
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
    /// Bit set of the ends of the tissue adjacent to its elements, or at a vertex of its field: see [`StressDepth::ends`].
    pub reached: u32,
    /// Largest depth at each of them, as in [`Region::ends`], at any field time so far [m]; −∞ where it was not reached.
    depths_at_ends: [f64; MOST_ENDS],
    /// Exceedance in each part, in the order of [`TissueParts::names`].
    pub layers: Vec<Layer>,
}

impl Exceedance {
    fn new(threshold: f64, part_count: usize) -> Self {
        Self {
            threshold,
            depth: 0.0,
            depth_time: 0.0,
            edge: 0.0,
            depth_bounds: [0.0; 2],
            volume: 0.0,
            largest_volume: 0.0,
            largest_point: 0.0,
            numerical: 0.0,
            largest_numerical: 0.0,
            numerical_at: (0.0, 0.0),
            reached: 0,
            depths_at_ends: [f64::NEG_INFINITY; MOST_ENDS],
            layers: vec![Layer { depth: Region::NOWHERE, volume: 0.0, largest_volume: 0.0 }; part_count],
        }
    }

    /// How far the depth is known [m]: its largest difference from its bounds, but no more than the edge on which it was
    /// read, at whose ends the stress is on both sides of the threshold.
    pub fn depth_resolution(&self) -> f64 {
        let [lower, upper] = self.depth_bounds;
        let most = if self.depth > 0.0 { self.edge } else { f64::INFINITY };
        (self.depth - lower).max(upper - self.depth).min(most)
    }

    fn begin(&mut self) {
        (self.volume, self.numerical) = (0.0, 0.0);
        self.layers.iter_mut().for_each(|layer| layer.volume = 0.0);
    }

    /// Adds a point above the threshold, with its reference volume [m³], part and adjacent ends of the tissue.
    fn add(&mut self, volume: f64, part: usize, ends: u32) {
        self.volume += volume;
        self.reached |= ends;
        self.largest_point = self.largest_point.max(volume);
        if let Some(layer) = self.layers.get_mut(part) {
            layer.volume += volume;
        }
    }

    /// Ends a pass at a time [s]; `reach` is how far a wave can have travelled [m].
    fn end(&mut self, time: f64, reach: f64) {
        self.largest_volume = self.largest_volume.max(self.volume);
        if self.numerical > self.largest_numerical {
            self.largest_numerical = self.numerical;
            self.numerical_at = (time, reach);
        }
        for layer in &mut self.layers {
            layer.largest_volume = layer.largest_volume.max(layer.volume);
        }
    }

    /// Accumulates the region of the field above the threshold at a time [s].
    fn add_region(&mut self, region: &Region, time: f64) {
        if region.depth > self.depth * DEEPER {
            (self.depth, self.depth_time, self.edge) = (region.depth, time, region.edge);
        }
        for (end, (depth, now)) in self.depths_at_ends.iter_mut().zip(region.ends).enumerate() {
            *depth = depth.max(now);
            // What cuts the depth off cuts the volume off, too.
            self.reached |= u32::from(now >= 0.0) << end;
        }
        for (bound, now) in self.depth_bounds.iter_mut().zip(region.bounds) {
            *bound = bound.max(now);
        }
        for (layer, [from, to]) in self.layers.iter_mut().zip(&region.layers) {
            layer.depth = [layer.depth[0].min(*from), layer.depth[1].max(*to)];
        }
    }
}

/// Depth and volume of one part in which a threshold is exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Least and largest depth at which the field of the part exceeds the threshold, at any field time so far [m];
    /// [`Region::NOWHERE`] if it does not.
    pub depth: [f64; 2],
    /// Its reference volume above the threshold at the latest field time [m³].
    pub volume: f64,
    /// Largest such volume at any field time so far [m³].
    pub largest_volume: f64,
}

impl Layer {
    /// Whether the threshold is exceeded in the part.
    pub fn is_reached(&self) -> bool {
        self.largest_volume > 0.0 || self.has_depth()
    }

    /// Whether the field of the part exceeds the threshold.
    pub fn has_depth(&self) -> bool {
        self.depth[0] <= self.depth[1]
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
    /// The stress over the depth; `None` without a surface, which leaves depth undefined.
    field: Option<StressField>,
    /// Parts of the tissue.
    pub parts: TissueParts,
    /// Latest field time [s].
    pub time: f64,
    /// Region that waves can have reached at this field time; `None` if unknown.
    reach: Option<WaveReach>,
    /// Names of the tissue's ends, at most 32.
    pub ends: Vec<String>,
    /// For each slot of all images the bit set of the ends adjacent to its element; empty if the tissue has no ends.
    at_ends: Vec<u32>,
    /// Doses of strain energy density [J/m³].
    pub energy_doses: Vec<Dose>,
    /// Doses of the largest principal strain [-].
    pub strain_doses: Vec<Dose>,
    /// Largest principal strain exceeded in the volume that the scene sets [-].
    pub strain_in_volume: ExceededIn,
    /// Von Mises stress exceeded in that volume [Pa].
    pub stress_in_volume: ExceededIn,
    /// 95th percentile by volume of the largest principal strain in each part [-].
    pub strain_percentiles: Vec<ExceededIn>,
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
    /// When no distance can be taken to the surface.
    pub fn new(plan: &Plan) -> Result<Option<Self>, crate::mesh::MeshError> {
        let parts = TissueParts::new(&Computed::of(plan));
        if parts.bodies.is_empty() {
            return Ok(None);
        }
        let (field, requested) = (parts.stress_field(plan)?, &plan.measures);
        Ok(Some(Self {
            ends: requested.tissue_ends.iter().map(|end| end.name.clone()).collect(),
            at_ends: at_ends(plan),
            energy_doses: Dose::of(&requested.energy_density_thresholds),
            strain_doses: Dose::of(&requested.strain_thresholds),
            strain_in_volume: ExceededIn::new(requested.exceeded_in_volume),
            stress_in_volume: ExceededIn::new(requested.exceeded_in_volume),
            ..Self::of(field, parts, &requested.stress_thresholds)
        }))
    }

    /// Assembles the measure from its components.
    fn of(field: Option<StressField>, parts: TissueParts, thresholds: &[f64]) -> Self {
        let exceedance = |threshold: &f64| Exceedance::new(*threshold, parts.names.len());
        Self {
            field,
            time: 0.0,
            reach: None,
            ends: Vec::new(),
            at_ends: Vec::new(),
            energy_doses: Vec::new(),
            strain_doses: Vec::new(),
            strain_in_volume: ExceededIn::default(),
            stress_in_volume: ExceededIn::default(),
            strain_percentiles: parts.volumes.iter().map(|volume| ExceededIn::new(TAIL * volume)).collect(),
            samples: 0,
            exceedances: thresholds.iter().map(exceedance).collect(),
            von_mises: Peak::default(),
            principal_strain: Peak::default(),
            energy_density: Peak::default(),
            parts,
        }
    }

    /// Names of the tissue ends adjacent to the region above a threshold.
    pub fn ends_of(&self, exceedance: &Exceedance) -> Vec<String> {
        self.named(|end| exceedance.reached >> end & 1 == 1)
    }

    /// Those of the ends at which the region is as deep as anywhere, to the extent of the edge on which its depth was read: what is beyond
    /// may be deeper.
    pub fn ends_of_depth(&self, exceedance: &Exceedance) -> Vec<String> {
        let Exceedance { depth, edge, depths_at_ends, .. } = exceedance;
        self.named(|end| *depth > 0.0 && depths_at_ends[end] >= depth - edge)
    }

    fn named(&self, is_it: impl Fn(usize) -> bool) -> Vec<String> {
        let named = self.ends.iter().enumerate().take(MOST_ENDS);
        named.filter(|(end, _)| is_it(*end)).map(|(_, name)| name.clone()).collect()
    }

    /// Largest depth of the tissue [m]; `None` without a surface to measure it from.
    pub fn deepest(&self) -> Option<f64> {
        self.field.as_ref()?.deepest()
    }

    /// Whether the tissue has a surface to measure from, so that depth is defined.
    pub fn has_skin(&self) -> bool {
        self.field.is_some()
    }

    /// All values exceeded in volumes.
    fn exceeded_in_volumes(&mut self) -> impl Iterator<Item = &mut ExceededIn> {
        [&mut self.strain_in_volume, &mut self.stress_in_volume]
            .into_iter()
            .chain(&mut self.strain_percentiles)
    }

    /// Begins a pass over all points at a time [s], given the region that waves can have reached, if known.
    pub fn begin(&mut self, time: f64, reach: Option<WaveReach>) {
        (self.time, self.reach) = (time, reach);
        self.samples += 1;
        self.exceedances.iter_mut().for_each(Exceedance::begin);
        self.energy_doses.iter_mut().chain(&mut self.strain_doses).for_each(Dose::begin);
        self.exceeded_in_volumes().for_each(ExceededIn::begin);
        self.field.iter_mut().for_each(StressField::begin);
    }

    /// Accumulates the quadrature points of a batch of elements of a body, with their slots among those of all images and their
    /// places `position(lane, index in the element)`. Elements that have not moved may be omitted.
    pub fn accumulate(
        &mut self,
        body: usize,
        slots: Range<usize>,
        points: &PointBatch,
        position: impl Fn(usize, usize) -> Vec3,
    ) {
        if !self.parts.bodies.contains(&body) {
            return;
        }
        for (lane, slot) in slots.enumerate() {
            let part = self.parts.of_slot.get(slot).map_or(0, |part| *part as usize);
            for q in 0..points.count {
                let [stress, strain, psi, volume] =
                    [&points.von_mises, &points.principal_strain, &points.psi, &points.volume]
                        .map(|field| field[q][lane]);
                // Stress beyond the reach of waves is counted separately.
                let size = || (points.count as f64 * volume).cbrt();
                if self.reach.as_ref().is_some_and(|reach| !reach.holds(|| position(lane, q), size)) {
                    let above = self.exceedances.iter_mut().take_while(|e| stress > e.threshold);
                    above.for_each(|exceedance| exceedance.numerical += volume);
                    continue;
                }
                // Peaks.
                let place = || position(lane, q);
                self.von_mises.raise(stress, place, self.time);
                self.principal_strain.raise(strain, place, self.time);
                self.energy_density.raise(psi, place, self.time);
                // Thresholds and doses.
                let ends = self.at_ends.get(slot).copied().unwrap_or(0);
                let above = self.exceedances.iter_mut().take_while(|e| stress > e.threshold);
                above.for_each(|exceedance| exceedance.add(volume, part, ends));
                Dose::add(&mut self.energy_doses, psi, volume);
                Dose::add(&mut self.strain_doses, strain, volume);
                // Values exceeded in volumes, and the field.
                self.strain_in_volume.add(strain, volume);
                self.stress_in_volume.add(stress, volume);
                if let Some(percentile) = self.strain_percentiles.get_mut(part) {
                    percentile.add(strain, volume);
                }
                if let Some(field) = &mut self.field {
                    field.add(slot, q, (stress, volume));
                }
            }
        }
    }

    /// Ends the pass and updates the maxima.
    pub fn end(&mut self) {
        let (time, reach) = (self.time, self.reach.as_ref().map_or(0.0, WaveReach::farthest));
        self.exceedances.iter_mut().for_each(|exceedance| exceedance.end(time, reach));
        self.energy_doses.iter_mut().chain(&mut self.strain_doses).for_each(Dose::end);
        self.exceeded_in_volumes().for_each(|exceeded| exceeded.end(time));
        if let Some(field) = &mut self.field {
            field.end();
            for exceedance in &mut self.exceedances {
                exceedance.add_region(&field.region(exceedance.threshold), time);
            }
        }
    }
}

/// For each slot of all images of a plan the bit set of the tissue ends at which its element has nodes.
fn at_ends(plan: &Plan) -> Vec<u32> {
    let (of_node, computed) = (ends_of_nodes(plan), Computed::of(plan));
    let mut at_ends = vec![0; computed.slot_count()];
    for image in 0..computed.images() {
        for block in &computed.plan.blocks {
            for slot in 0..block.elements.len() {
                let nodes = block.nodes_of(slot);
                at_ends[computed.slot(block.first_slot + slot, image)] =
                    nodes.iter().fold(0, |bits, node| bits | of_node[computed.node(*node, image) as usize]);
            }
        }
    }
    at_ends
}
