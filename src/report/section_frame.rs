//! What the picture of a section shows: plane, scale and size.

use super::instant::{Body, Instant};
use super::section::{Corner, Plane, dot, minus};
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
    /// The surface above the impact at rest, in the picture [m].
    pub skin: f64,
}

impl Frame {
    /// Around the impact, across the longest side of the tissue; `None` without a moving projectile.
    pub fn of(instant: &Instant, tissue: &Body, scene: &Value) -> Option<Self> {
        let bodies = scene["bodies"].as_array()?;
        let velocity =
            bodies.iter().find(|body| body["role"] == "projectile")?["velocity_m_per_s"].as_array()?;
        let velocity: Vec<f64> = velocity.iter().filter_map(Value::as_f64).collect();
        let velocity: [f64; 3] = velocity.try_into().ok()?;
        let speed = dot(velocity, velocity).sqrt();
        let direction = velocity.map(|v| v / speed);
        let points = projectile(instant);
        let (low, high) = bounds(points.iter().copied())?;
        let centre: [f64; 3] = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
        let radius = (0..3).map(|k| 0.5 * (high[k] - low[k])).fold(0.0, f64::max);
        // Across the longest side of the tissue that does not run along the impact.
        let (low, high) = bounds(tissue.rest.iter().copied())?;
        let length = |k: usize| if direction[k].abs() > 0.7 { 0.0 } else { high[k] - low[k] };
        let axis = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b)))?;
        let normal: [f64; 3] = std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 });
        let along = dot(direction, normal);
        let up: [f64; 3] = std::array::from_fn(|k| along * normal[k] - direction[k]);
        let norm = dot(up, up).sqrt();
        let up = up.map(|x| x / norm);
        let right = [
            up[1] * normal[2] - up[2] * normal[1],
            up[2] * normal[0] - up[0] * normal[2],
            up[0] * normal[1] - up[1] * normal[0],
        ];
        // The node of the surface where the path of the projectile meets the tissue at rest.
        let off = |x: &[f64; 3]| {
            let arm = minus(*x, centre);
            let s = dot(arm, direction);
            (dot(arm, arm) - s * s).max(0.0).sqrt()
        };
        let nearest = tissue.rest.iter().map(off).fold(f64::INFINITY, f64::min);
        let skin = tissue.rest.iter().filter(|x| off(x) < nearest + 0.003);
        let skin = skin.max_by(|a, b| dot(**a, up).total_cmp(&dot(**b, up)))?;
        // Not through the nodes that often lie in the plane of symmetry.
        let mut origin: [f64; 3] = *skin;
        origin[axis] = centre[axis] + 0.004 * (high[axis] - low[axis]);
        let half = LEAST.max(AROUND * radius);
        let shift = 0.3 * half;
        for k in 0..3 {
            origin[k] -= shift * up[k];
        }
        (norm > 0.1 && speed > 0.0).then_some(Self {
            plane: Plane { origin, normal, right, up },
            scale: 0.5 * SIZE[1] / half,
            skin: shift,
        })
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

fn bounds(points: impl Iterator<Item = [f64; 3]>) -> Option<([f64; 3], [f64; 3])> {
    points.fold(None, |bounds, p| {
        let (low, high) = bounds.unwrap_or((p, p));
        Some((std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))))
    })
}
