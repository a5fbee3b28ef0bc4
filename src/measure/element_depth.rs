//! Depth of the tissue's quadrature points and elements below its skin, evaluated on demand.

use crate::mechanics::element::POINTS;
use crate::mechanics::tensor::Vec3;
use crate::mesh::cell::CellPoints;
use crate::mesh::distance::DepthField;

/// Points whose depths differ by less than this fraction of their element's extent are on one level.
const ONE_LEVEL: f64 = 0.1;

/// Position of an element in the reference configuration [m].
pub struct Place<'a> {
    /// Number of its quadrature points.
    pub count: usize,
    /// Position of a quadrature point.
    pub point: &'a dyn Fn(usize) -> Vec3,
    /// Positions of the nodes.
    pub nodes: &'a dyn Fn() -> CellPoints,
}

/// Reference depths, cached on first use.
pub struct ElementDepths {
    skin: DepthField,
    /// Depths of the quadrature points, [`POINTS`] per slot [m]; NaN until evaluated.
    points: Vec<f64>,
    /// Smallest and largest nodal depth of each slot's element [m]; NaN until evaluated.
    edges: Vec<[f64; 2]>,
}

impl ElementDepths {
    /// An empty cache below a skin, for a number of element slots.
    pub fn new(skin: DepthField, slots: usize) -> Self {
        Self { skin, points: vec![f64::NAN; POINTS * slots], edges: vec![[f64::NAN; 2]; slots] }
    }

    /// Depth of a quadrature point of the element in a slot [m].
    pub fn point(&mut self, slot: usize, q: usize, place: &Place) -> f64 {
        let known = &mut self.points[POINTS * slot + q];
        if known.is_nan() {
            *known = self.skin.depth(&(place.point)(q));
        }
        *known
    }

    /// Smallest and largest nodal depth of the element in a slot [m].
    pub fn edges(&mut self, slot: usize, place: &Place) -> [f64; 2] {
        let known = &mut self.edges[slot];
        if known[0].is_nan() {
            let nodes = (place.nodes)();
            let depths = nodes.iter().map(|X| self.skin.depth(X));
            *known = depths.fold([f64::INFINITY, 0.0], |[least, most], d| [least.min(d), most.max(d)]);
        }
        *known
    }

    /// Distance from a quadrature point of that element at a depth [m] to the next one below [m]: in the element, or,
    /// for its lowest points, in a neighbour of the same size.
    pub fn gap_below(&mut self, slot: usize, depth: f64, place: &Place) -> f64 {
        let [top, bottom] = self.edges(slot, place);
        let same_level = depth + ONE_LEVEL * (bottom - top);
        let below = (0..place.count).map(|q| self.point(slot, q, place)).filter(|other| *other > same_level);
        let next = below.fold(f64::INFINITY, f64::min);
        if next.is_finite() { next - depth } else { 2.0 * (bottom - depth).max(0.0) }
    }
}
