//! Initial critical time steps of all elements: the element with the smallest one, and how many are close to it.

use super::body::PlanBody;
use crate::mechanics::force::{AssembledRows, ElementBlock, ElementForces, ForceInput, Threads};
use crate::mechanics::tensor::Vec3;
use serde::{Deserialize, Serialize};

/// Multiples of the smallest critical time step within which elements are counted.
const WITHIN: [f64; 3] = [1.1, 2.0, 4.0];

/// The initial critical time step, and the element that determines it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct StableStepReport {
    /// Smallest critical time step of an element [s], without safety factor; the scene's `max_step_s` when there is no
    /// element.
    pub smallest_s: f64,
    /// Name of the body of that element.
    pub body: String,
    /// Name of the part of that element.
    pub part: String,
    /// Its index in the body, from 0.
    pub element: u32,
    /// Safety factor: fraction of the critical time step that is used [-].
    pub safety_factor: f64,
    /// Whether the scene's `max_step_s` is shorter and limits the step.
    pub limited_by_scene: bool,
    /// Numbers of elements with a critical time step near the smallest.
    pub distribution: Vec<ElementsWithin>,
}

/// Elements whose critical time step is near the smallest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct ElementsWithin {
    /// Upper bound of their critical time step, as a multiple of the smallest [-].
    pub times_smallest: f64,
    /// Number of these elements.
    pub elements: usize,
    /// Fraction of all elements, 0 … 1.
    pub fraction: f64,
}

/// Initial critical time step of every element [s], without safety factor; by block and slot.
#[derive(Clone, Debug)]
pub(super) struct StableSteps(Vec<Vec<f64>>);

impl StableSteps {
    /// Critical time steps at the initial displacements `u` [m], nodes × 3, with these [`ForceInput::fractions`]; `forces` are the
    /// buffers of the blocks.
    pub fn new(
        blocks: &[ElementBlock],
        u: &[Vec3],
        fractions: &[Vec<AssembledRows>],
        forces: &mut ElementForces,
    ) -> Self {
        let input = ForceInput { fractions, ..ForceInput::at(u) };
        forces.evaluate(&Threads::ONE, blocks, &input);
        let at_rest = vec![Vec3::zeros(); u.len()];
        forces.add_viscous(&Threads::ONE, blocks, &input, &at_rest);
        // Slots beyond the elements are padding of the last batch.
        let steps = |(i, block): (usize, &ElementBlock)| {
            forces.stable_steps(i).take(block.elements.len()).collect::<Vec<f64>>()
        };
        Self(blocks.iter().enumerate().map(steps).collect())
    }

    /// Smallest critical time step [s].
    pub fn smallest(&self) -> f64 {
        self.0.iter().flatten().copied().fold(f64::INFINITY, f64::min)
    }

    /// Smallest critical time step of a block [s].
    pub fn smallest_of(&self, block: usize) -> f64 {
        self.0[block].iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Largest of the smallest critical time steps of the bodies [s]: a bound on the steps of a run while that body is
    /// undeformed.
    pub fn largest_of_bodies(&self, blocks: &[ElementBlock]) -> f64 {
        let of_body = |body: usize| {
            let blocks = blocks.iter().enumerate().filter(|(_, block)| block.body == body);
            blocks.map(|(i, _)| self.smallest_of(i)).fold(f64::INFINITY, f64::min)
        };
        blocks.iter().map(|block| of_body(block.body)).fold(0.0, f64::max)
    }

    /// The report: critical element, and numbers of elements near it.
    pub fn report(
        &self,
        blocks: &[ElementBlock],
        bodies: &[PlanBody],
        (safety, max_step): (f64, f64),
    ) -> StableStepReport {
        let smallest = self.smallest();
        let all = || self.0.iter().flatten();
        let within = |times: f64| {
            let elements = all().filter(|step| **step <= times * smallest).count();
            let fraction = elements as f64 / all().count().max(1) as f64;
            ElementsWithin { times_smallest: times, elements, fraction }
        };
        // The element with the smallest step, in terms of the document.
        let slots = self
            .0
            .iter()
            .zip(blocks)
            .flat_map(|(steps, block)| steps.iter().zip(&block.elements).map(move |s| (s, block)));
        let first = slots.min_by(|((a, _), _), ((b, _), _)| a.total_cmp(b));
        let (body, part, element) = first.map_or_else(Default::default, |((_, element), block)| {
            let body = &bodies[block.body];
            let local = element - body.elements.start;
            let part = body.parts[body.part_of[local as usize] as usize].clone();
            (body.name.clone(), part, local)
        });
        StableStepReport {
            // Without elements, the step is that of the scene.
            smallest_s: if smallest.is_finite() { smallest } else { max_step },
            body,
            part,
            element,
            safety_factor: safety,
            limited_by_scene: max_step < safety * smallest,
            distribution: WITHIN.map(within).into(),
        }
    }
}
