//! Which of two surfaces is the slave: the finer one where they may meet.

use super::closest_point::Patch;
use crate::contact::Surface;
use crate::tensor::Vec3;

/// The slave among two surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slave {
    /// The first of the two.
    First,
    /// The second of the two.
    Second,
}

/// Chooses the slave of two surfaces: the one with the smaller mean face area in the swept patch; the first if equal
/// (so pass the body of lower index first).
///
/// `x` [m]: positions of all nodes at the start; `motion` [m]: displacement of the first surface relative to the
/// second over the time of interest. The swept patch of a surface consists of its faces that are turned towards the
/// other one and overlap the box that the other sweeps; of all its faces if there are none.
pub fn choose_slave(first: &Surface, second: &Surface, x: &[Vec3], motion: &Vec3) -> Slave {
    let a = mean_patch_area(first, second, x, motion);
    let b = mean_patch_area(second, first, x, &-motion);
    // Equal meshes may differ by rounding.
    if b < a * (1.0 - 1e-9) { Slave::Second } else { Slave::First }
}

/// Mean size of the faces of a surface [m], the square root of their area, at the positions `x` [m].
pub fn mean_face_size(surface: &Surface, x: &[Vec3]) -> f64 {
    let mut mean = Mean::default();
    surface.faces.iter().for_each(|face| mean.add(Patch::new(face, x).area().sqrt()));
    mean.value().unwrap_or(0.0)
}

/// Mean area of the faces of `own` that may be met while it moves by `motion` relative to `other`.
fn mean_patch_area(own: &Surface, other: &Surface, x: &[Vec3], motion: &Vec3) -> f64 {
    let Some((low, high)) = bounds(other, x) else { return 0.0 };
    // Relative to `own`, the other one sweeps in the opposite direction.
    let (low, high) = (low.inf(&(low - motion)), high.sup(&(high - motion)));
    let (mut all, mut met) = (Mean::default(), Mean::default());
    for face in &own.faces {
        let patch = Patch::new(face, x);
        let area = patch.area();
        all.add(area);
        let inside = (0..3).all(|i| {
            let low_own = patch.corners.iter().map(|c| c[i]).fold(f64::INFINITY, f64::min);
            let high_own = patch.corners.iter().map(|c| c[i]).fold(f64::NEG_INFINITY, f64::max);
            low_own <= high[i] && high_own >= low[i]
        });
        if inside && patch.normal(&[0.25; 4]).dot(motion) >= 0.0 {
            met.add(area);
        }
    }
    met.value().or(all.value()).unwrap_or(0.0)
}

fn bounds(surface: &Surface, x: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let first = x[*surface.nodes.first()? as usize];
    let nodes = surface.nodes.iter().map(|&n| &x[n as usize]);
    Some(nodes.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A horizontal grid of n × n faces of a unit square at height z, facing up or down.
    fn sheet(n: u32, z: f64, up: bool, x: &mut Vec<Vec3>) -> Surface {
        let base = x.len() as u32;
        for j in 0..=n {
            for i in 0..=n {
                x.push(Vec3::new(f64::from(i) / f64::from(n), f64::from(j) / f64::from(n), z));
            }
        }
        let at = |i: u32, j: u32| base + j * (n + 1) + i;
        let mut faces = Vec::new();
        for j in 0..n {
            for i in 0..n {
                let face = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                faces.push(if up { face } else { [face[0], face[3], face[2], face[1]] });
            }
        }
        Surface::new((base..x.len() as u32).collect(), faces)
    }

    #[test]
    fn the_finer_surface_is_the_slave_and_ties_go_to_the_first() {
        let mut x = Vec::new();
        let fine = sheet(4, 1.0, false, &mut x);
        let coarse = sheet(2, 0.0, true, &mut x);
        let same = sheet(4, 0.0, true, &mut x);
        let down = Vec3::new(0.0, 0.0, -2.0);
        assert_eq!(choose_slave(&fine, &coarse, &x, &down), Slave::First);
        assert_eq!(choose_slave(&coarse, &fine, &x, &-down), Slave::Second);
        assert_eq!(choose_slave(&fine, &same, &x, &down), Slave::First);
        assert_eq!(choose_slave(&same, &fine, &x, &-down), Slave::First);
    }
}
