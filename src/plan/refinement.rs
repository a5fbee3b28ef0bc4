//! Report of local refinement.

use super::Plan;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Report of a locally refined body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RefinementReport {
    /// Name of the body.
    pub body: String,
    /// Number of elements before refinement.
    pub elements_before: usize,
    /// Number of these that were split.
    pub elements_split: usize,
    /// Number of elements after refinement.
    pub elements: usize,
    /// Number of hanging nodes between coarse and fine elements, which follow others.
    pub hanging_nodes: usize,
}

impl RefinementReport {
    /// Reports of all locally refined bodies of a plan.
    pub(super) fn of(plan: &Plan, scene: &Scene) -> Vec<Self> {
        let of_body = |(body, scene_body): (&super::PlanBody, &crate::scene::SceneBody)| {
            let [elements_before, elements_split] = scene_body.refined?;
            let hanging_nodes = scene_body.mesh.hanging.len();
            let elements = body.elements.len();
            Some(Self { body: body.name.clone(), elements_before, elements_split, elements, hanging_nodes })
        };
        plan.bodies.iter().zip(&scene.bodies).filter_map(of_body).collect()
    }

    /// The report in one line.
    pub fn in_words(&self) -> String {
        let Self { body, elements_before, elements_split, elements, hanging_nodes } = self;
        format!(
            "{body}: {elements_split} of {elements_before} hex8 locally refined, {elements} now; {hanging_nodes} hanging nodes between \
             coarse and fine elements"
        )
    }
}
