//! Depth of significant stress in the tissue, and the peaks of stress, strain and energy density at its quadrature points.
//!
//! Evaluated at the field times and at the end, not at every step: a peak between two field times is not seen, so ask for
//! field times that are close enough to each other.

use super::fields::PointValues;
use crate::mechanics::force::PointField;
use crate::mechanics::tensor::Vec3;
use crate::mesh::distance::DepthField;
use crate::plan::Plan;
use crate::scene::document::Role;

/// What exceeds one threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exceedance {
    /// Threshold of the von Mises stress [Pa].
    pub threshold: f64,
    /// Largest reference distance to the skin of a quadrature point above the threshold, at any field time so far [m].
    pub depth: f64,
    /// When it was reached [s].
    pub depth_time: f64,
    /// Reference volume above the threshold at the latest field time [m³].
    pub volume: f64,
    /// Largest such volume at any field time so far [m³].
    pub largest_volume: f64,
}

/// A largest value, where and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The value; what it was at rest until something exceeds it.
    pub value: f64,
    /// Reference position of the point [m].
    pub position: Vec3,
    /// Time [s].
    pub time: f64,
}

impl Default for Peak {
    fn default() -> Self {
        Self { value: 0.0, position: Vec3::zeros(), time: 0.0 }
    }
}

impl Peak {
    /// Takes the value if it is larger.
    fn raise(&mut self, value: f64, position: Vec3, time: f64) {
        if value > self.value {
            *self = Self { value, position, time };
        }
    }
}

/// Accumulates over the quadrature points of the tissue.
pub struct StressDepth {
    /// Distance to the skin; without a skin there is no depth.
    skin: Option<DepthField>,
    /// Element ranges of the tissue's bodies.
    elements: Vec<std::ops::Range<u32>>,
    /// Depth of the quadrature points in the order of the visit, NaN until somebody needs it.
    depth: Vec<f64>,
    /// Position in that order.
    next: usize,
    time: f64,
    /// Number of field times so far.
    pub samples: u32,
    /// One for each threshold, ascending.
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
        let tissue = plan.bodies.iter().filter(|b| b.role == Role::Tissue);
        let elements: Vec<_> = tissue.map(|b| b.elements.clone()).collect();
        if elements.is_empty() {
            return Ok(None);
        }
        let faces = &plan.measures.tissue_skin;
        let skin = if faces.is_empty() { None } else { Some(DepthField::new(faces, &plan.X)?) };
        Ok(Some(Self::of(skin, elements, &plan.measures.stress_thresholds)))
    }

    /// From its parts.
    fn of(skin: Option<DepthField>, elements: Vec<std::ops::Range<u32>>, thresholds: &[f64]) -> Self {
        let exceedances =
            thresholds.iter().map(|&threshold| Exceedance { threshold, ..Exceedance::default() });
        Self {
            skin,
            elements,
            depth: Vec::new(),
            next: 0,
            time: 0.0,
            samples: 0,
            exceedances: exceedances.collect(),
            von_mises: Peak::default(),
            principal_strain: Peak::default(),
            energy_density: Peak::default(),
        }
    }

    /// Whether depth can be told.
    pub fn has_skin(&self) -> bool {
        self.skin.is_some()
    }

    /// Begins a sweep over all points at a time [s].
    pub fn begin(&mut self, time: f64) {
        (self.next, self.time) = (0, time);
        self.samples += 1;
        self.exceedances.iter_mut().for_each(|e| e.volume = 0.0);
    }

    /// Takes in one quadrature point of an element (global number); the order of the points is that of every sweep.
    pub fn accumulate(&mut self, element: u32, point: &PointField, values: &PointValues) {
        if !self.elements.iter().any(|range| range.contains(&element)) {
            return;
        }
        let index = self.next;
        self.next += 1;
        if self.depth.len() <= index {
            self.depth.push(f64::NAN);
        }
        let stress = values.von_mises;
        self.von_mises.raise(stress, point.position, self.time);
        self.principal_strain.raise(values.principal_strain, point.position, self.time);
        self.energy_density.raise(point.psi, point.position, self.time);
        if self.exceedances.first().is_none_or(|lowest| stress <= lowest.threshold) {
            return;
        }
        if let (Some(skin), true) = (&self.skin, self.depth[index].is_nan()) {
            self.depth[index] = skin.depth(&point.position);
        }
        for exceedance in self.exceedances.iter_mut().take_while(|e| stress > e.threshold) {
            exceedance.volume += point.volume;
            if self.depth[index] > exceedance.depth {
                (exceedance.depth, exceedance.depth_time) = (self.depth[index], self.time);
            }
        }
    }

    /// Ends the sweep.
    pub fn end(&mut self) {
        for exceedance in &mut self.exceedances {
            exceedance.largest_volume = exceedance.largest_volume.max(exceedance.volume);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp, clippy::single_range_in_vec_init)] // tests may panic; exact values
mod tests {
    use super::*;
    use crate::mechanics::tensor::Mat3;

    fn point(z: f64, stress: f64) -> PointField {
        PointField {
            position: Vec3::new(0.5, 0.5, z),
            volume: 2.0,
            F: Mat3::identity(),
            cauchy: Mat3::from_diagonal(&Vec3::new(stress, 0.0, 0.0)),
            psi: stress,
            J: 1.0,
        }
    }

    fn feed(measure: &mut StressDepth, element: u32, point: &PointField) {
        measure.accumulate(element, point, &PointValues::eval(point));
    }

    #[test]
    fn depth_is_the_deepest_point_above_each_threshold() {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0), Vec3::y()];
        let skin = DepthField::new(&[[0, 1, 2, 3]], &corners).unwrap();
        let mut measure = StressDepth::of(Some(skin), vec![10..20], &[1.0, 5.0]);
        measure.begin(1.0);
        feed(&mut measure, 3, &point(-9.0, 100.0)); // another body
        feed(&mut measure, 10, &point(-0.1, 7.0));
        feed(&mut measure, 11, &point(-0.3, 2.0));
        feed(&mut measure, 12, &point(-0.8, 0.5));
        measure.end();
        measure.begin(2.0);
        feed(&mut measure, 10, &point(-0.1, 3.0));
        feed(&mut measure, 11, &point(-0.3, 0.0));
        feed(&mut measure, 12, &point(-0.8, 0.5));
        measure.end();
        let [low, high] = [measure.exceedances[0], measure.exceedances[1]];
        assert!((low.depth - 0.3).abs() < 1e-12 && low.depth_time == 1.0);
        assert!((high.depth - 0.1).abs() < 1e-12);
        assert_eq!((low.volume, low.largest_volume, high.volume, high.largest_volume), (2.0, 4.0, 0.0, 2.0));
        assert_eq!((measure.von_mises.value, measure.von_mises.time), (7.0, 1.0));
        assert_eq!(measure.energy_density.value, 7.0);
    }

    #[test]
    fn without_a_skin_there_is_volume_but_no_depth() {
        let mut measure = StressDepth::of(None, vec![0..1], &[1.0]);
        measure.begin(0.0);
        feed(&mut measure, 0, &point(-1.0, 2.0));
        measure.end();
        assert!(
            !measure.has_skin()
                && measure.exceedances[0].depth == 0.0
                && measure.exceedances[0].volume == 2.0
        );
    }
}
