//! Deflection of the tissue's skin.

use crate::mechanics::tensor::{Mat3, Vec3};
use crate::plan::Plan;
use crate::scene::document::Role;
use crate::step::Frame;
use std::collections::BTreeSet;

/// Largest displacement of a node of the tissue's skin from its initial position in the scene; for an unsupported
/// tissue, from the rigid motion of its skin, which is no deflection. Where elements are eroded, what they lay bare counts with the skin that is
/// left.
#[derive(Clone, Debug, Default)]
pub struct Deflection {
    /// Sorted nodes of the tissue's surface.
    nodes: Vec<u32>,
    /// Number of eroded elements when the nodes were listed: detached fragments do not count.
    gone: usize,
    /// Whether a node of the tissue is fixed along an axis, or has a prescribed motion.
    is_held: bool,
    /// Largest ‖u‖ so far [m].
    pub largest: f64,
    /// Time of the largest ‖u‖ [s].
    pub time: f64,
    /// Reference position of that node [m].
    pub position: Vec3,
    /// Largest product of the largest deflection at a time and its rate, d ḋ, so far [m²/s].
    pub largest_rate: f64,
    /// Time of that product [s].
    pub largest_rate_time: f64,
    /// Time [s] and largest ‖u‖ [m] of the latest step.
    latest: Option<(f64, f64)>,
}

impl Deflection {
    /// Deflection of the surface from which the plan measures depth.
    pub fn new(plan: &Plan) -> Self {
        let mut nodes: Vec<u32> = plan.measures.tissue_skin.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let holds = |node: &u32| (0..3).any(|axis| plan.holds(*node as usize, axis));
        let bodies = plan
            .bodies
            .iter()
            .filter(|body| body.nodes.clone().any(|node| nodes.binary_search(&node).is_ok()));
        let is_held = bodies.into_iter().any(|body| body.nodes.clone().any(|node| holds(&node)));
        Self { nodes, is_held, ..Self::default() }
    }

    /// Drops nodes without intact elements, and adds those of the tissue that eroded elements lay bare.
    fn follow_erosion(&mut self, frame: &Frame) {
        let plan = frame.plan;
        let intact = plan.bodies.iter().flat_map(|body| body.intact(frame.erosion));
        let held: BTreeSet<u32> = intact.flat_map(|cell| cell.nodes).copied().collect();
        let bared = frame.erosion.elements().iter().flat_map(|&element| {
            let body = &plan.bodies[plan.body_of_element(element)];
            let cell = body.cells.nodes((element - body.elements.start) as usize);
            if body.role == Role::Tissue { cell } else { &[] }
        });
        self.nodes.extend(bared);
        self.nodes.retain(|node| held.contains(node));
        self.nodes.sort_unstable();
        self.nodes.dedup();
    }

    /// Accumulates the displacements of one step.
    pub fn accumulate(&mut self, frame: &Frame) {
        let gone = frame.erosion.elements().len();
        if gone != self.gone {
            self.gone = gone;
            self.follow_erosion(frame);
        }
        let mut now = 0.0_f64;
        // Relative to the start: a body that starts rotated or stretched is not deflected yet.
        let places =
            |&node: &u32| [frame.plan.start_of(node), frame.plan.X[node as usize] + frame.u[node as usize]];
        // Largest displacement, relative to the fitted rigid motion of unsupported bodies.
        let has_moved = self.nodes.iter().map(places).any(|[from, to]| from != to);
        let rigid = (has_moved && !self.is_held).then(|| RigidMotion::fitted(self.nodes.iter().map(places)));
        for node in &self.nodes {
            let [from, to] = places(node);
            let u = (to - rigid.as_ref().map_or(from, |rigid| rigid.apply(&from))).norm();
            now = now.max(u);
            if u > self.largest {
                (self.largest, self.time) = (u, frame.time);
                self.position = frame.plan.X[*node as usize];
            }
        }
        if let Some((time, before)) = self.latest
            && frame.time > time
        {
            // d ḋ = (d²)˙ / 2 over the step.
            let product = 0.5 * (now * now - before * before) / (frame.time - time);
            if product > self.largest_rate {
                (self.largest_rate, self.largest_rate_time) = (product, frame.time);
            }
        }
        self.latest = Some((frame.time, now));
    }
}

/// A motion that preserves all distances.
struct RigidMotion {
    rotation: Mat3,
    /// Centres before and after [m].
    centres: [Vec3; 2],
}

impl RigidMotion {
    /// The rigid motion that fits the current positions best in the least-squares sense (Kabsch): with `A = Σ (x −
    /// x̄)(X − X̄)ᵀ = U S Vᵀ`, `R = U diag(1, 1, det U det V) Vᵀ`.
    fn fitted(places: impl Iterator<Item = [Vec3; 2]> + Clone) -> Self {
        let count = places.clone().count().max(1) as f64;
        let centres =
            places.clone().fold([Vec3::zeros(); 2], |[a, b], [from, to]| [a + from / count, b + to / count]);
        let spread = places
            .fold(Mat3::zeros(), |sum, [from, to]| sum + (to - centres[1]) * (from - centres[0]).transpose());
        let svd = spread.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
            return Self { rotation: Mat3::identity(), centres };
        };
        // Singular values are in descending order: the least certain axis absorbs a reflection.
        let sign = (u.determinant() * v_t.determinant()).signum();
        Self { rotation: u * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, sign)) * v_t, centres }
    }
    /// Image of a point [m].
    fn apply(&self, from: &Vec3) -> Vec3 {
        self.centres[1] + self.rotation * (from - self.centres[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn a_rigid_motion_is_found() {
        let turned = Rotation3::from_scaled_axis(Vec3::new(0.3, -2.0, 0.7));
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.3, 0.1, 1.0]].map(Vec3::from);
        let to = |x: &Vec3| turned * x + Vec3::new(5.0, -1.0, 2.0);
        for flat in [false, true] {
            let points = &points[..points.len() - usize::from(flat)];
            let motion = RigidMotion::fitted(points.iter().map(|x| [*x, to(x)]));
            assert!(points.iter().all(|x| (motion.apply(x) - to(x)).norm() < 1e-14));
        }
    }

    #[test]
    fn the_same_deflection_is_left_however_it_is_turned() {
        let points: Vec<Vec3> =
            (0..27).map(|i| Vec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9))).collect();
        let left = |turned: Rotation3<f64>| {
            let bulge = |x: &Vec3| x * (1.0 + 0.1 * x.x * x.y);
            let pairs = points.iter().map(|x| [*x, turned * bulge(x)]);
            let motion = RigidMotion::fitted(pairs.clone());
            pairs.map(|[from, to]| (to - motion.apply(&from)).norm()).fold(0.0, f64::max)
        };
        let (still, turned) =
            (left(Rotation3::identity()), left(Rotation3::from_scaled_axis(Vec3::new(1.0, 2.0, -0.5))));
        assert!(still > 0.1 && (still - turned).abs() < 1e-13, "{still}, {turned}");
    }
}
