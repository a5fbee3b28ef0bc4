//! The shells of a surface: what hangs together, and how it is turned.

use crate::mechanics::tensor::Vec3;

/// A part of a surface that hangs together.
pub(super) struct Shell {
    /// A triangle of it.
    pub triangle: usize,
    /// Enclosed volume, in the cube of the unit of the file; negative where it is turned inwards.
    pub volume: f64,
    low: Vec3,
    high: Vec3,
}

impl Shell {
    /// Whether the bounding box of another shell lies in that of this one.
    fn encloses(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] < other.low[k] && other.high[k] < self.high[k])
    }
}

/// The shells of a surface with these points and triangles, which share no point.
pub(super) fn shells(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Shell> {
    // Points that triangles join have one root.
    let mut root: Vec<u32> = (0..points.len() as u32).collect();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|node| root_of(&mut root, node));
        let least = a.min(b).min(c);
        for own in [a, b, c] {
            root[own as usize] = least;
        }
    }
    // Volume and box of each, by its root.
    let mut found = std::collections::BTreeMap::<u32, Shell>::new();
    for (index, triangle) in triangles.iter().enumerate() {
        let corners = triangle.map(|node| points[node as usize]);
        let shell = found.entry(root_of(&mut root, triangle[0])).or_insert_with(|| Shell {
            triangle: index,
            volume: 0.0,
            low: corners[0],
            high: corners[0],
        });
        let [a, b, c] = corners.map(|corner| corner - points[0]);
        shell.volume += a.dot(&b.cross(&c)) / 6.0;
        for corner in corners {
            (shell.low, shell.high) = (shell.low.inf(&corner), shell.high.sup(&corner));
        }
    }
    found.into_values().collect()
}

/// A shell that is turned inwards, and is no cavity: it lies in none that is turned outwards.
pub(super) fn inside_out(shells: &[Shell]) -> Option<&Shell> {
    let outwards = || shells.iter().filter(|shell| shell.volume > 0.0);
    shells.iter().find(|shell| shell.volume < 0.0 && !outwards().any(|outer| outer.encloses(shell)))
}

fn root_of(root: &mut [u32], node: u32) -> u32 {
    let mut top = node;
    while root[top as usize] != top {
        top = root[top as usize];
    }
    // Later searches are short.
    let mut at = node;
    while root[at as usize] != top {
        at = std::mem::replace(&mut root[at as usize], top);
    }
    top
}
