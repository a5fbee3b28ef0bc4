//! How far a wave from the contact can have travelled into the tissue: stress beyond is a mesh artefact.
//!
//! Each step propagates information by one element, whatever the element's size, so long elements are stressed long
//! before any wave can arrive.

use super::pair::PairMeasures;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::step::Frame;

/// The region that waves can have reached at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WaveReach {
    /// Reference position of the first contact of each pair with the tissue, and how far a wave can have travelled from
    /// there [m].
    sources: Vec<(Vec3, f64)>,
    /// Whether waves from one of them can have reached the whole model.
    is_everywhere: bool,
}

impl WaveReach {
    /// The vicinity of one source, before any wave has left it.
    #[cfg(test)]
    pub fn of(source: super::pair::Source) -> Self {
        Self { sources: vec![(source.place, source.spread)], is_everywhere: false }
    }

    /// Whether a wave can have reached a point at `X` [m] in an element of that size [m], both evaluated on demand.
    pub fn holds(&self, X: impl FnOnce() -> Vec3, size: impl Fn() -> f64) -> bool {
        if self.is_everywhere {
            return true;
        }
        let X = X();
        self.sources.iter().any(|(from, reach)| {
            let distance = (X - from).norm();
            distance <= *reach || distance <= reach + size()
        })
    }

    /// Largest distance that waves can have travelled [m].
    pub fn farthest(&self) -> f64 {
        self.sources.iter().map(|(_, reach)| *reach).fold(0.0, f64::max)
    }
}

/// How fast waves run at most, and how far they can.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveSpeed {
    /// Upper bound of the wave speed in the tissue [m/s].
    fastest: f64,
    /// Box around the model at rest [m].
    bounds: [Vec3; 2],
}

impl WaveSpeed {
    /// `None` if loads other than contact can deform the tissue, and in quasi-static runs, which have no waves.
    pub fn new(plan: &Plan) -> Option<Self> {
        let is_tissue = |body: usize| plan.bodies[body].role == crate::scene::document::Role::Tissue;
        let blocks = plan.blocks.iter().filter(|block| is_tissue(block.body));
        let fastest = blocks.map(|block| block.parameters.fastest_wave()).fold(0.0, f64::max);
        let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        let bounds = plan.X.iter().fold(nothing, |[low, high], X| [low.inf(X), high.sup(X)]);
        let says = plan.measures.moved_by_contact_alone && !plan.is_static() && fastest > 0.0;
        says.then_some(Self { fastest, bounds })
    }

    /// The region that waves can have reached in a frame. From its first contact on, a pair emits waves from its whole
    /// patch; one step is added because contact begins within it.
    ///
    /// A wave that compresses the material ahead travels faster than the small-amplitude wave: a plane shock runs at
    /// about c + s u, with u the speed of the material behind it and s < 1 for the volumetric laws here. The impact
    /// speed bounds s u.
    pub fn reach<'a>(&self, pairs: impl Iterator<Item = &'a PairMeasures>, frame: &Frame) -> WaveReach {
        let of = |pair: &PairMeasures| {
            let ([first, _], source) =
                (pair.force.contact_span?, pair.source.as_ref().filter(|_| pair.on_tissue)?);
            let speed = self.fastest + pair.approach;
            Some((source.place, speed * (frame.time - first + frame.mean_step) + source.spread))
        };
        let sources: Vec<(Vec3, f64)> = pairs.filter_map(of).collect();
        // The corner of the box that is farthest from a source is reached last.
        let [low, high] = self.bounds;
        let farthest = |from: &Vec3| (from - low).abs().sup(&(high - from).abs()).norm();
        let is_everywhere = sources.iter().any(|(from, reach)| farthest(from) <= *reach);
        WaveReach { sources, is_everywhere }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_reaches_as_far_as_it_runs_and_an_element_further() {
        let sources = vec![(Vec3::zeros(), 0.02), (Vec3::x(), 0.01)];
        let reach = WaveReach { sources, is_everywhere: false };
        assert!(
            reach.holds(|| Vec3::new(0.0, 0.024, 0.0), || 0.005)
                && !reach.holds(|| Vec3::new(0.0, 0.026, 0.0), || 0.005)
        );
        assert!(
            reach.holds(|| Vec3::new(1.0, 0.0, 0.009), || 0.0) && (reach.farthest() - 0.02).abs() < 1e-15
        );
        assert!(!WaveReach::default().holds(Vec3::zeros, || 1.0), "before contact there is no wave");
    }
}
