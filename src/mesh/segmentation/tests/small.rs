//! Labels of a few elements across.

use super::{options, part};
use crate::mechanics::tensor::Vec3;
use crate::mesh::segmentation::{LabelUse, LabelVolume, Options, mesh};
use std::collections::BTreeMap;

/// Balls of label 2 in a cube of `count`³ voxels of label 1.
fn balls(balls: &[(Vec3, f64)], voxel: f64, count: usize) -> LabelVolume {
    let at = |n: usize| Vec3::new((n % count) as f64, (n / count % count) as f64, (n / count / count) as f64);
    let is_in = |x: Vec3| balls.iter().any(|(centre, radius)| (x - centre).norm() < *radius);
    LabelVolume {
        dims: [count; 3],
        labels: (0..count.pow(3)).map(|n| if is_in(at(n) * voxel) { 2 } else { 1 }).collect(),
        values: (0..3).collect(),
        names: BTreeMap::new(),
        origin: Vec3::zeros(),
        steps: [0, 1, 2].map(|k| Vec3::ith(k, voxel)),
        notes: Vec::new(),
    }
}

/// Deviation of the volume of the balls from that of their voxels [%], by the notes of the mesh.
fn deviation(scan: &LabelVolume, usage: LabelUse, size_m: f64, thin_size_m: Option<f64>) -> f64 {
    let labels = vec![(1, part("flesh")), (2, usage)];
    let mesh = mesh(scan, &Options { labels, size_m, thin_size_m, ..options() }).unwrap();
    let note = mesh.notes.iter().find_map(|note| note.strip_prefix("ball: ")).unwrap();
    let percent = note.split(", ").nth(1).unwrap().split(' ').next().unwrap();
    percent.parse().unwrap()
}

#[test]
fn a_ball_of_three_elements_keeps_its_volume_wherever_it_lies() {
    let mut random = 1_u64;
    let mut next = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as f64 / f64::from(1_u32 << 31)
    };
    for (voxel, count, size, thin) in
        [(0.00172, 12, 0.00344, None), (0.001, 20, 0.0035, None), (0.001, 20, 0.0035, Some(0.00175))]
    {
        let mut found: Vec<f64> = Vec::new();
        for i in 0..24 {
            let middle = 0.5 * (count - 1) as f64 * voxel;
            let centre = Vec3::from_fn(|_, _| middle + size * (next() - 0.5));
            let usage = if i % 2 == 0 { part("ball") } else { LabelUse::Hole("ball".into()) };
            found.push(deviation(&balls(&[(centre, 0.005)], voxel, count), usage, size, thin));
        }
        assert!(found.iter().all(|percent| percent.abs() < 1.0), "{size} {thin:?}: {found:?}");
    }
}
