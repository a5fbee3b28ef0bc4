//! The elements that a run computes: all, or those of the sector of a symmetric scene that the others mirror.
//!
//! Stress and deformation are evaluated at their points alone. Invariants are those of all images; what depends on the place
//! of a point, or on the direction of a component, is reflected.

use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;
use crate::mesh::mirror::MirrorPlane;
use crate::plan::{Plan, Sector};
use crate::step::Frame;
use std::iter::once;

/// What is computed of a plan, and the images that complete it.
#[derive(Clone, Copy)]
pub struct Computed<'a> {
    /// Plan of the elements that are computed.
    pub plan: &'a Plan,
    sector: Option<&'a Sector>,
}

impl<'a> Computed<'a> {
    /// What is computed of the plan of a whole scene.
    pub fn of(whole: &'a Plan) -> Self {
        match &whole.sector {
            Some(of) => Self { plan: &of.plan, sector: Some(&of.sector) },
            None => Self { plan: whole, sector: None },
        }
    }

    /// Number of images, what is computed included.
    pub fn images(&self) -> usize {
        self.sector.map_or(1, |sector| sector.images.count())
    }

    /// The planes of symmetry, above which is what is computed; none without a sector.
    pub fn planes(&self) -> &'a [MirrorPlane] {
        self.sector.map_or(&[], |sector| &sector.images.0)
    }

    /// Node of the whole that is a node in an image.
    pub fn node(&self, node: u32, image: usize) -> u32 {
        self.sector.map_or(node, |sector| sector.image_of_node(node, image))
    }

    /// Element of the whole that is an element in an image.
    pub fn element(&self, element: u32, image: usize) -> u32 {
        self.sector.map_or(element, |sector| sector.image_of_element(element, image))
    }

    /// A point in an image [m].
    pub fn place(&self, X: Vec3, image: usize) -> Vec3 {
        self.sector.map_or(X, |sector| sector.images.image_of_point(X, image))
    }

    /// Signs of the components of a vector in an image.
    pub fn signs(&self, image: usize) -> Vec3 {
        let ones = Vec3::repeat(1.0);
        self.sector.map_or(ones, |sector| sector.images.reflected(ones, image))
    }

    /// Number of slots of all images: those of an image follow each other in the order of the plan.
    pub fn slot_count(&self) -> usize {
        self.images() * self.plan.slot_count()
    }

    /// A slot in an image, among those of all images.
    pub fn slot(&self, slot: usize, image: usize) -> usize {
        image * self.plan.slot_count() + slot
    }

    /// The values at all nodes of the whole that are alike in all images, of those computed.
    pub fn unfold(&self, values: &[f64], all: &mut [f64]) {
        match self.sector {
            Some(sector) => all
                .iter_mut()
                .zip(&sector.source)
                .for_each(|(value, (source, _))| *value = values[*source as usize]),
            None => all.copy_from_slice(values),
        }
    }
}

/// Frames of what is computed, from those of the whole, in memory that is used again.
#[derive(Debug, Default)]
pub struct ComputedMotion {
    u: Vec<Vec3>,
    v: Vec<Vec3>,
    v_after: Vec<Vec3>,
    history: Vec<Vec<Row>>,
}

impl ComputedMotion {
    /// The motion of what is computed of a frame at a look time, with the energies and contacts of the whole.
    pub fn frame<'f>(&'f mut self, frame: &Frame<'f>) -> Frame<'f> {
        let Computed { plan, sector: Some(sector) } = Computed::of(frame.plan) else { return *frame };
        let motions =
            once((frame.u, &mut self.u)).chain([(frame.v, &mut self.v), (frame.v_after, &mut self.v_after)]);
        for (all, own) in motions {
            own.clear();
            let nodes = if all.is_empty() { 0..0 } else { 0..plan.node_count() as u32 };
            own.extend(nodes.map(|node| all[sector.image_of_node(node, 0) as usize]));
        }
        if frame.history.is_empty() {
            self.history.clear();
        } else {
            if self.history.is_empty() {
                self.history = plan.room_for_history();
            }
            sector.fold_history(frame.history, &mut self.history);
        }
        Frame { plan, u: &self.u, v: &self.v, v_after: &self.v_after, history: &self.history, ..*frame }
    }
}
