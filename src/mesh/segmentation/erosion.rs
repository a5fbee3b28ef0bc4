//! The voxels below a layer of given thickness.

use super::grid::{ClassGrid, OUTSIDE};

impl ClassGrid {
    /// This grid with everything within `depth` [m] of the outside made outside; beyond the box, the body continues.
    #[must_use]
    pub fn eroded(&self, depth: f64) -> Self {
        let mut squares: Vec<f32> =
            self.classes.iter().map(|class| if *class == OUTSIDE { 0.0 } else { f32::INFINITY }).collect();
        let [nx, ny, nz] = self.dims;
        let (mut line, mut envelope) = (Vec::new(), Vec::new());
        for (k, stride) in [1, nx, nx * ny].into_iter().enumerate() {
            let length = self.dims[k];
            let starts = (0..nx * ny * nz).filter(|i| i / stride % length == 0);
            for start in starts {
                line.clear();
                line.extend((0..length).map(|i| f64::from(squares[start + i * stride])));
                let found = nearest(&line, self.spacing[k], &mut envelope);
                found.into_iter().enumerate().for_each(|(i, d)| squares[start + i * stride] = d as f32);
            }
        }
        // From the face of the outer voxel, not from its centre.
        let most = (depth + 0.5 * self.spacing.into_iter().fold(f64::INFINITY, f64::min)).powi(2);
        let class = |(class, square): (&u8, &f32)| if f64::from(*square) < most { OUTSIDE } else { *class };
        let classes = self.classes.iter().zip(&squares).map(class).collect();
        Self { classes, ..*self }
    }
}

/// min over j of f_j + (s (i − j))² for every i: the lower envelope of parabolas (Felzenszwalb and Huttenlocher, Theory Comput. 8
/// (2012) 415).
fn nearest(f: &[f64], s: f64, envelope: &mut Vec<(usize, f64)>) -> Vec<f64> {
    envelope.clear();
    let square = |i: usize| (s * i as f64).powi(2);
    for (j, _) in f.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        // Where the parabola of j becomes the lower one.
        loop {
            let Some(&(last, from)) = envelope.last() else {
                envelope.push((j, f64::NEG_INFINITY));
                break;
            };
            let width = 2.0 * s * s * (j - last) as f64;
            let meet = (f[j] + square(j) - f[last] - square(last)) / width;
            if meet > from {
                envelope.push((j, meet));
                break;
            }
            envelope.pop();
        }
    }
    let mut at = 0;
    let value = |i: usize| {
        while envelope.get(at + 1).is_some_and(|(_, from)| *from <= i as f64) {
            at += 1;
        }
        envelope.get(at).map_or(f64::INFINITY, |(j, _)| f[*j] + square(i.abs_diff(*j)))
    };
    (0..f.len()).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_the_outside_goes_and_cut_sides_stay() {
        // A ball of 6 m in voxels of 1 × 1 × 2 m, cut at the low side of z.
        let at =
            |i: usize, j: usize, k: usize| (i as f64 - 7.5).hypot(j as f64 - 7.5).hypot(2.0 * k as f64 + 1.0);
        let each = || (0..8).flat_map(|k| (0..16).flat_map(move |j| (0..16).map(move |i| at(i, j, k))));
        let classes = each().map(|r| u8::from(r < 6.0)).collect();
        let grid =
            ClassGrid { dims: [16, 16, 8], spacing: [1.0, 1.0, 2.0], classes, count: 2, first: [0; 3] };
        for (class, r) in grid.eroded(2.0).classes.iter().zip(each()) {
            assert!(*class == u8::from(r < 4.0) || (r - 4.0).abs() < 1.1, "{class} {r}");
        }
    }
}
