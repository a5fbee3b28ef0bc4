//! What local refinement made of the meshes.

use super::Plan;
use crate::scene::Scene;
use serde::Serialize;

/// A locally refined body in figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RefinementReport {
    /// Body.
    pub body: String,
    /// Elements of its mesh before.
    pub elements_before: usize,
    /// How many of them were split.
    pub elements_split: usize,
    /// Elements after.
    pub elements: usize,
    /// Nodes that hang between coarse and fine elements, and follow others.
    pub hanging_nodes: usize,
}

impl RefinementReport {
    /// All of a plan.
    pub(super) fn of(plan: &Plan, scene: &Scene) -> Vec<Self> {
        let of_body = |(body, scene_body): (&super::PlanBody, &crate::scene::SceneBody)| {
            let [elements_before, elements_split] = scene_body.refined?;
            let hanging_nodes = scene_body.mesh.hanging.len();
            let elements = body.elements.len();
            Some(Self { body: body.name.clone(), elements_before, elements_split, elements, hanging_nodes })
        };
        plan.bodies.iter().zip(&scene.bodies).filter_map(of_body).collect()
    }

    /// In words.
    pub fn in_words(&self) -> String {
        let Self { body, elements_before, elements_split, elements, hanging_nodes } = self;
        format!(
            "{body}: {elements_split} of {elements_before} hex8 locally refined, {elements} now; {hanging_nodes} nodes hang between \
             coarse and fine ones and follow these"
        )
    }
}
