//! Artificial ends of the model: where a limb is truncated, waves are reflected that would pass in the real limb.

use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::scene::document::Role;
use crate::scene::exposed_faces::{CUTS, is_generated_limb};

/// Truncated ends of the tissue, and the speed of waves towards them.
///
/// Known for limb segments from the generator; a mesh from a file does not mark its faces as cuts.
#[derive(Clone, Debug, PartialEq)]
pub struct ArtificialEnds {
    /// Reference positions of the nodes at the ends [m].
    nodes: Vec<Vec3>,
    /// Largest speed of dilatational waves in the undeformed body, √((K + 4/3 G)/ρ) [m/s]. Along stretched fibres waves
    /// are faster.
    wave_speed: f64,
}

impl ArtificialEnds {
    /// Ends of the scene's tissue; `None` if none is known.
    pub fn of(scene: &Scene, plan: &Plan) -> Option<Self> {
        let (mut nodes, mut wave_speed) = (Vec::new(), 0.0f64);
        for (index, (document, body)) in scene.document.bodies.iter().zip(&scene.bodies).enumerate() {
            if document.role != Role::Tissue || !is_generated_limb(document) {
                continue;
            }
            let ends = CUTS.iter().filter_map(|set| body.mesh.node_sets.get(*set)).flatten();
            nodes.extend(ends.map(|&node| body.mesh.nodes[node as usize]));
            let blocks = plan.blocks.iter().filter(|b| b.body == index);
            wave_speed = blocks.map(|b| b.parameters.wave_speed()).fold(wave_speed, f64::max);
        }
        (!nodes.is_empty() && wave_speed > 0.0).then_some(Self { nodes, wave_speed })
    }

    /// Earliest time [s] at which a wave that left `place` [m] at time `start` [s] can have returned there.
    pub fn earliest_return(&self, place: Vec3, start: f64) -> f64 {
        let nearest = self.nodes.iter().map(|x| (x - place).norm()).fold(f64::INFINITY, f64::min);
        start + 2.0 * nearest / self.wave_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_goes_to_the_nearest_end_and_back() {
        let ends = ArtificialEnds {
            nodes: vec![Vec3::new(0.0, 0.1, 0.0), Vec3::new(0.0, -0.2, 0.0)],
            wave_speed: 1500.0,
        };
        let time = ends.earliest_return(Vec3::zeros(), 1e-5);
        assert!((time - (1e-5 + 0.2 / 1500.0)).abs() < 1e-15);
    }
}
