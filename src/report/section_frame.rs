//! What the picture of a section shows: plane, scale and size.

use super::instant::{Body, Instant};
use super::section::{Corner, Plane};
use super::section_impact::Impact;
use crate::mechanics::tensor::Vec3;
use serde_json::Value;

/// Size of the picture, where its ruler ends at the left, and where the names of the layers begin at the right [px].
pub(super) const SIZE: [f64; 2] = [840.0, 430.0];
pub(super) const LEFT: f64 = 52.0;
pub(super) const NAMES: f64 = 660.0;
/// Half of the height of the picture: in radii of the projectile, and at least [m].
const AROUND: f64 = 2.3;
const LEAST: f64 = 0.03;

/// Plane and scale of the picture.
pub(super) struct Frame {
    /// Plane of the section.
    pub plane: Plane,
    /// Pixels to a metre.
    pub scale: f64,
    /// The surface at rest at the point of impact, upwards in the picture [m].
    pub skin: f64,
}

impl Frame {
    /// Around the impact, along the outward normal of the surface at rest there and across the longest side of the tissue;
    /// `None` without a moving projectile.
    pub fn of(instant: &Instant, tissues: &[&Body], scene: &Value) -> Option<Self> {
        let direction = direction(scene)?;
        let (low, high) = bounds(projectile(instant).into_iter())?;
        let radius = 0.5 * (high - low).max();
        let centre = 0.5 * (low + high);
        let impact = Impact::of(tissues, centre, direction)?;
        let up = impact.outward;
        // Across the longest side of the tissue; one along the normal or the path counts less.
        let (low, high) = bounds(tissues.iter().flat_map(|body| body.rest.iter().copied()))?;
        let sides = high - low;
        let across = |k: usize| sides[k] * (1.0 - up[k].abs().max(direction[k].abs()).powi(2)).max(0.0);
        let axis = (0..3).max_by(|&a, &b| across(a).total_cmp(&across(b))).filter(|&k| across(k) > 0.0)?;
        let normal = Vec3::ith(axis, 1.0);
        let normal = (normal - up * up[axis]).normalize();
        // Not through the nodes that often lie in the plane of symmetry.
        let aside = (centre - impact.at).dot(&normal) + 0.004 * sides[axis];
        let half = LEAST.max(AROUND * radius);
        let skin = 0.3 * half;
        let plane = Plane {
            origin: (impact.at + normal * aside - up * skin).into(),
            normal: normal.into(),
            right: up.cross(&normal).into(),
            up: up.into(),
        };
        Some(Self { plane, scale: 0.5 * SIZE[1] / half, skin })
    }

    /// Place in the picture [px] of a place in the plane [m].
    pub fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [0.5 * (LEFT + NAMES) + self.scale * x, 0.5 * SIZE[1] - self.scale * y]
    }

    /// Whether some of a polygon may lie in the picture.
    pub fn sees(&self, polygon: &[Corner]) -> bool {
        let at: Vec<[f64; 2]> = polygon.iter().map(|(at, _)| self.pixel(*at)).collect();
        let (from, to) = ([LEFT, 0.0], [NAMES, SIZE[1]]);
        (0..2).all(|k| at.iter().any(|p| p[k] > from[k]) && at.iter().any(|p| p[k] < to[k]))
    }
}

/// All points of the projectile; of a rigid one the corners of its triangles.
fn projectile(instant: &Instant) -> Vec<[f64; 3]> {
    let meshed = instant.bodies.iter().filter(|body| body.role == "projectile");
    let points: Vec<[f64; 3]> = meshed.flat_map(|body| body.positions.iter().copied()).collect();
    if points.is_empty() { instant.rigid.iter().flatten().copied().collect() } else { points }
}

/// The direction of the projectile's flight, a unit vector; `None` if it rests.
fn direction(scene: &Value) -> Option<Vec3> {
    let bodies = scene["bodies"].as_array()?;
    let velocity = bodies.iter().find(|body| body["role"] == "projectile")?["velocity_m_per_s"].as_array()?;
    let velocity: Vec<f64> = velocity.iter().filter_map(Value::as_f64).collect();
    Vec3::from(<[f64; 3]>::try_from(velocity).ok()?).try_normalize(0.0)
}

fn bounds(points: impl Iterator<Item = [f64; 3]>) -> Option<(Vec3, Vec3)> {
    points.map(Vec3::from).fold(None, |bounds, p| {
        let (low, high) = bounds.unwrap_or((p, p));
        Some((low.inf(&p), high.sup(&p)))
    })
}

#[cfg(test)]
mod tests {
    use super::super::section::Section;
    use super::*;
    use crate::mesh::{CellKind, Cells};
    use serde_json::json;

    #[test]
    fn depths_are_along_the_normal_of_the_surface_in_the_plane_of_the_path() {
        let mut cells = Cells::default();
        cells.push(CellKind::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]);
        let square = [[-0.03, -0.03], [0.03, -0.03], [0.03, 0.03], [-0.03, 0.03]];
        let rest: Vec<[f64; 3]> =
            [0.0, 0.02].into_iter().flat_map(|z| square.map(|[x, y]| [x, y, z])).collect();
        let block = Body { cells, part_of: vec![0], positions: rest.clone(), rest, ..Body::default() };
        let ball = [[-0.014, -0.006, 0.02], [-0.002, 0.006, 0.032], [-0.008, 0.0, 0.026]];
        let instant = Instant { rigid: vec![ball], ..Instant::default() };
        let frame_at = |velocity: Value| {
            let scene = json!({"bodies": [{"role": "projectile", "velocity_m_per_s": velocity}]});
            Frame::of(&instant, &[&block], &scene)
        };
        for (velocity, across) in [([8, 0, -8], Vec3::y()), ([0, 8, -8], Vec3::x())] {
            let frame = frame_at(json!(velocity)).unwrap();
            assert_eq!((Vec3::from(frame.plane.up), Vec3::from(frame.plane.normal)), (Vec3::z(), across));
            let section = Section::of(&block, &frame.plane);
            let depths = section.polygons[0].1.iter().map(|(at, _)| frame.skin - at[1]);
            for depth in depths {
                assert!(depth.abs() < 1e-12 || (depth - 0.02).abs() < 1e-12, "{depth}");
            }
        }
        assert!(frame_at(json!([0, 0, 0])).is_none());
    }
}
