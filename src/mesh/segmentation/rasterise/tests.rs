//! Volumes of voxels against those of the surfaces that they fill.
#![allow(clippy::unwrap_used)] // tests may panic

use super::*;
use crate::mechanics::rigid::{Rotation, Shape, triangulated};

fn surface(shape: &Shape, place: Vec3, turn: Rotation) -> ClosedSurface {
    let (points, triangles) = triangulated(shape);
    ClosedSurface { points: points.iter().map(|x| turn * x + place).collect(), triangles }
}

fn ball(radius: f64, place: Vec3) -> ClosedSurface {
    surface(&Shape::Ball { radius }, place, Rotation::identity())
}

fn brick(half: Vec3, place: Vec3) -> ClosedSurface {
    surface(&Shape::Box { half }, place, Rotation::identity())
}

fn filled(surfaces: &[ClosedSurface], voxel_m: f64) -> Result<Filled, Unfilled> {
    Filling { surfaces, voxel_m, crop: None, most_voxels: 10_000_000 }.labels()
}

fn words(result: Result<Filled, Unfilled>) -> (Option<usize>, String) {
    let Unfilled { surface, error } = result.unwrap_err();
    (surface, error.to_string())
}

#[test]
fn voxels_have_the_volume_of_nested_surfaces_at_any_angle() {
    let turn = Rotation::from_euler_angles(0.3, -0.2, 0.5);
    let limb = Shape::Cylinder { radius: 0.03, half_length: 0.05 };
    let bone = Shape::Cylinder { radius: 0.01, half_length: 0.04 };
    let nest = [surface(&limb, Vec3::zeros(), turn), surface(&bone, Vec3::new(0.002, 0.0, 0.0), turn)];
    let balls = [ball(0.03, Vec3::zeros()), ball(0.012, Vec3::new(0.005, 0.003, -0.002))];
    for surfaces in [nest, balls] {
        let found = filled(&surfaces, 0.001).unwrap();
        let [outer, inner] = [0, 1].map(|i| surfaces[i].volume());
        let counts = found.volume.counts();
        let volumes: Vec<f64> = counts.iter().map(|count| count.volume_m3).collect();
        assert!((volumes[1] / (outer - inner) - 1.0).abs() < 0.01, "{volumes:?}");
        assert!((volumes[2] / inner - 1.0).abs() < 0.005, "{volumes:?}");
        let exact = found.volumes_m3.iter().zip([outer - inner, inner]);
        assert!(exact.clone().all(|((_, volume), exact)| (volume / exact - 1.0).abs() < 1e-9), "{found:?}");
    }
}

#[test]
fn rows_that_meet_faces_edges_and_corners_exactly_are_counted_once() {
    // Voxel centres lie on the faces, edges and corners of the inner box, and on its diagonals.
    let outer = brick(Vec3::repeat(4.0), Vec3::repeat(4.0));
    let inner = brick(Vec3::repeat(1.5), Vec3::repeat(4.0));
    let found = filled(&[outer, inner], 1.0).unwrap();
    assert_eq!(found.volume.dims, [10; 3]);
    assert_eq!(found.volume.origin, Vec3::repeat(-0.5));
    let voxels: Vec<u64> = found.volume.counts().iter().map(|count| count.voxels).collect();
    assert_eq!(voxels, [1000 - 512, 512 - 27, 27]);
    // A box whose faces lie on voxel centres has one layer of each two.
    let outer = brick(Vec3::repeat(4.0), Vec3::repeat(4.0));
    let inner = brick(Vec3::repeat(1.0), Vec3::repeat(3.5));
    let found = filled(&[outer, inner], 1.0).unwrap();
    assert_eq!(found.volume.counts()[2].voxels, 8);
}

#[test]
fn several_shells_and_a_cavity_in_one_surface_are_filled_as_they_are_turned() {
    let join = |a: ClosedSurface, b: ClosedSurface| {
        let first = a.points.len() as u32;
        let moved = b.triangles.iter().map(|triangle| triangle.map(|node| node + first));
        ClosedSurface {
            triangles: a.triangles.iter().copied().chain(moved).collect(),
            points: a.points.iter().chain(&b.points).copied().collect(),
        }
    };
    let apart = join(ball(0.01, Vec3::zeros()), ball(0.01, Vec3::new(0.03, 0.0, 0.0)));
    let mut inwards = ball(0.005, Vec3::zeros());
    inwards.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
    let hollow = join(ball(0.01, Vec3::zeros()), inwards);
    // Overlapping halfway: one body, of less than what both enclose.
    let lens = join(brick(Vec3::repeat(0.01), Vec3::zeros()), brick(Vec3::repeat(0.01), Vec3::repeat(0.01)));
    let union = lens.volume() * 15.0 / 16.0;
    for (surface, volume) in
        [(apart.clone(), apart.volume()), (hollow.clone(), hollow.volume()), (lens, union)]
    {
        let found = filled(&[surface], 0.0005).unwrap();
        let voxels = found.volume.counts()[1].volume_m3;
        assert!((voxels / volume - 1.0).abs() < 0.01, "{voxels} of {volume}");
        assert!((found.volumes_m3[0].1 / volume - 1.0).abs() < 1e-9, "{:?} of {volume}", found.volumes_m3);
    }
}

#[test]
fn a_surface_takes_its_volume_from_those_that_it_lies_in() {
    // Boxes that end between voxels of 1 m: a body with two organs, the second of which reaches out of it by a third.
    let at = |low: [f64; 3], high: [f64; 3]| {
        let [low, high] = [low, high].map(Vec3::from);
        brick((high - low) * 0.5, (low + high) * 0.5)
    };
    let body = at([0.0; 3], [10.0; 3]);
    let organs = [at([1.3; 3], [3.6; 3]), at([5.0, 5.0, 6.0], [8.0, 8.0, 12.0])];
    let found = filled(&[body, organs[0].clone(), organs[1].clone()], 1.0).unwrap();
    let [first, second] = [organs[0].volume(), organs[1].volume()];
    let expected = [1000.0 - first - second * 2.0 / 3.0, first, second];
    for ((_, volume), expected) in found.volumes_m3.iter().zip(expected) {
        assert!((volume / expected - 1.0).abs() < 1e-9, "{volume} of {expected}");
    }
}

#[test]
fn a_crop_is_filled_alone_and_cuts_the_body() {
    let surfaces = [ball(0.03, Vec3::zeros()), ball(0.01, Vec3::new(0.0, 0.0, -0.015))];
    let crop = Crop { center: Vec3::new(0.0, 0.0, 0.02), size_m: Vec3::new(1.0, 1.0, 0.04) };
    let filling = Filling { surfaces: &surfaces, voxel_m: 0.001, crop: Some(&crop), most_voxels: 1_000_000 };
    let found = filling.labels().unwrap();
    assert_eq!(found.volume.dims, [62, 62, 31]);
    let half = found.volume.counts()[1].volume_m3;
    let exact = 0.5 * surfaces[0].volume();
    assert!((half / exact - 1.0).abs() < 0.01, "{half}");
    assert!((found.volumes_m3[0].1 / exact - 1.0).abs() < 1e-3, "{:?} of {exact}", found.volumes_m3);
    assert_eq!(found.volumes_m3[1], (2, 0.0), "below the crop");
    let aside = Crop { center: Vec3::new(1.0, 0.0, 0.0), ..crop };
    let outside = words(Filling { crop: Some(&aside), ..filling }.labels());
    assert!(outside.1.contains("a crop outside of the surfaces"), "{outside:?}");
}

#[test]
fn what_cannot_be_filled_is_refused_before_it_is_allocated() {
    let [outer, inner] = [0.03, 0.01].map(|radius| ball(radius, Vec3::zeros()));
    let in_millimetres = outer.clone().scaled(1000.0);
    for (surfaces, voxel_m, surface, expected) in [
        (vec![in_millimetres.clone()], 1e-3, None, "voxels of 0.001 m"),
        (vec![in_millimetres.scaled(1000.0)], 1.0, None, "a coordinate of 3e4 m"),
        (vec![inner.clone(), outer.clone()], 1e-3, Some(0), "those after it leave nothing"),
        (vec![outer.clone(), inner.clone().scaled(1e-3)], 1e-3, Some(1), "no voxel in it"),
        (vec![outer.clone().scaled(1e-200)], 1e-3, Some(0), "encloses no volume"),
        (vec![outer.clone().scaled(f64::INFINITY)], 1e-3, None, "a coordinate of"),
        (vec![], 1e-3, None, "no surface"),
    ] {
        let found = words(filled(&surfaces, voxel_m));
        assert!(found.0 == surface && found.1.contains(expected), "{expected}: {found:?}");
    }
}
