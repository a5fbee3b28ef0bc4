//! A hollow ball: a spherical shell on a cubed sphere.

use super::cubed_sphere::{CubeSurface, equiangular};
use super::parameters::{Checks, refuse};
use super::{BALL, faceting_note, node_set};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Mesh, MeshError, ParameterProblem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A spherical shell of one part `ball`, node sets `outer` and `inner`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HollowBall {
    /// Centre of the ball [m].
    #[serde(default)]
    pub center_m: [f64; 3],
    /// Outer radius of the ball [m].
    pub outer_radius_m: f64,
    /// Inner radius of the ball [m].
    pub inner_radius_m: f64,
    /// Elements along a quarter of a great circle, n: 6 n² per layer.
    pub elements_around: u32,
    /// Layers of elements through the wall.
    pub elements_through: u32,
}

impl HollowBall {
    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("center_m", &self.center_m);
        checks.positive_length("outer_radius_m", self.outer_radius_m);
        checks.positive_length("inner_radius_m", self.inner_radius_m);
        checks.require(
            // Nothing fits into a ball of no size: that is said of the outer radius.
            self.inner_radius_m < self.outer_radius_m || self.outer_radius_m <= 0.0,
            "inner_radius_m",
            self.inner_radius_m,
            format!("< outer_radius_m = {}", self.outer_radius_m),
            "give the wall a thickness",
        );
        checks.count("elements_around", self.elements_around, 1);
        checks.count("elements_through", self.elements_through, 1);
        checks.budget(self.element_count());
        checks.into_problems()
    }

    /// Number of elements, 6 n² per layer.
    pub fn element_count(&self) -> u64 {
        let n = u64::from(self.elements_around);
        n.saturating_mul(n).saturating_mul(6).saturating_mul(u64::from(self.elements_through))
    }

    /// For each count, whether even numbers keep elements from extending across the middle of the body.
    pub fn counts_across(&self) -> Vec<bool> {
        vec![true, false]
    }

    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        vec![&mut self.elements_around, &mut self.elements_through]
    }

    /// Generates the mesh; nodes lie on spheres, equiangular on the six faces of the cubed sphere.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("hollow_ball", self.problems())?;
        let surface = CubeSurface::new(self.elements_around);
        let directions: Vec<Vec3> =
            surface.points.iter().map(|&p| equiangular(p, self.elements_around).normalize()).collect();
        let (a_layer, layers) = (directions.len() as u32, self.elements_through);

        // Nodes layer by layer from the inside; elements likewise, with their bottom faces inwards.
        let (center, wall) = (Vec3::from(self.center_m), self.outer_radius_m - self.inner_radius_m);
        let mut mesh = Mesh { parts: vec![BALL.into()], ..Mesh::default() };
        for layer in 0..=layers {
            let radius = if layer == layers {
                self.outer_radius_m
            } else {
                self.inner_radius_m + wall * f64::from(layer) / f64::from(layers)
            };
            mesh.nodes.extend(directions.iter().map(|d| center + d * radius));
        }
        for layer in 0..layers {
            mesh.cells.extend(surface.quads.iter().map(|quad| {
                let [a, b, c, d] = quad.map(|i| layer * a_layer + i);
                [a, b, c, d, a + a_layer, b + a_layer, c + a_layer, d + a_layer]
            }));
        }
        mesh.part_of = vec![0; mesh.cells.len()];
        mesh.node_sets.insert("inner".into(), node_set(0..a_layer));
        mesh.node_sets.insert("outer".into(), node_set(layers * a_layer..(layers + 1) * a_layer));
        mesh.notes.push(faceting_note(BALL, mesh.volume_m3(), self.exact_volume_m3()));
        Ok(mesh)
    }

    /// Exact volume of the shell [m³], 4/3 π (R³ − r³).
    pub fn exact_volume_m3(&self) -> f64 {
        4.0 / 3.0 * PI * (self.outer_radius_m.powi(3) - self.inner_radius_m.powi(3))
    }
}
