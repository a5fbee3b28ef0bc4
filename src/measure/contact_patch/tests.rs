//! Patches of known area and axes.

use super::*;
use crate::mechanics::rigid::Pose;

/// A flat 10 × 10 grid of unit squares, z = 0.
fn grid() -> (Surface, impl Fn(u32) -> Vec3) {
    let node = |i: u32, j: u32| j * 11 + i;
    let faces = (0..10)
        .flat_map(|j| (0..10).map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]))
        .collect();
    (Surface::new((0..121).collect(), faces), |n| Vec3::new(f64::from(n % 11), f64::from(n / 11), 0.0))
}

#[test]
fn tributary_areas_of_a_grid_sum_to_its_area() {
    let (surface, position) = grid();
    let mut geometry = PatchGeometry::of_slave(0, &surface, None);
    geometry.evaluation = 1;
    let mut area = |n| geometry.tributary_area(n, &-Vec3::z(), &position, &Limit::None)[1];
    assert!(
        (area(0) - 0.25).abs() < 1e-14 && (area(5) - 0.5).abs() < 1e-14 && (area(60) - 1.0).abs() < 1e-14
    );
    let total: f64 = (0..121).map(&mut area).sum();
    assert!((total - 100.0).abs() < 1e-12, "{total}");
}

#[test]
fn a_triangle_gives_a_third_to_each_corner() {
    let surface = Surface::new(vec![0, 1, 2], vec![[0, 1, 2, 2]]);
    let position = |n: u32| [Vec3::zeros(), Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0)][n as usize];
    let mut geometry = PatchGeometry::of_slave(0, &surface, None);
    geometry.evaluation = 1;
    for n in 0..3 {
        assert!((geometry.tributary_area(n, &-Vec3::z(), &position, &Limit::None)[1] - 1.0).abs() < 1e-14);
    }
}

#[test]
fn axes_of_a_uniform_ellipse_are_its_diameters() {
    let (a, b, spacing) = (3.0, 1.5, 0.05);
    let mut pressed = Vec::new();
    for i in -80..=80 {
        for j in -80..=80 {
            let (x, y) = (f64::from(i) * spacing, f64::from(j) * spacing);
            if (x / a).powi(2) + (y / b).powi(2) <= 1.0 {
                let position = Vec3::new(x * 0.6 - y * 0.8, x * 0.8 + y * 0.6, 1.0);
                pressed.push(Pressed {
                    position,
                    tributary: [spacing * spacing; 2],
                    weights: [1.0; 2],
                    normal_force: 2.0,
                });
            }
        }
    }
    let patch = patch_of(&pressed, spacing, None);
    assert!((patch.axes[0] / (2.0 * a) - 1.0).abs() < 0.01 && (patch.axes[1] / (2.0 * b) - 1.0).abs() < 0.01);
    assert!((patch.area / (std::f64::consts::PI * a * b) - 1.0).abs() < 0.01);
    assert_eq!(patch.nodes_across, 61);
    assert!((patch.peak_pressure - 2.0 / (spacing * spacing)).abs() < 1e-9);
    assert!((patch.centre - Vec3::new(0.0, 0.0, 1.0)).norm() < 1e-12);
}

#[test]
fn axes_of_a_ring_are_no_longer_than_it_is_wide() {
    let pressed: Vec<Pressed> = (0..360)
        .map(|i| {
            let angle = f64::from(i).to_radians();
            let position = Vec3::new(angle.cos(), angle.sin(), 0.0);
            Pressed { position, tributary: [0.01; 2], weights: [1.0; 2], normal_force: 1.0 }
        })
        .collect();
    let patch = patch_of(&pressed, 0.02, None);
    assert!(patch.axes.iter().all(|axis| (axis - 2.02).abs() < 1e-3), "{:?}", patch.axes);
}

/// The patch of the nodes with whole coordinates in a region, turned by an angle [rad] about an oblique axis, on a rigid master.
fn turned_patch(angle: f64, is_in: impl Fn(i32, i32) -> bool, master: Option<Shape>) -> ContactPatch {
    let axis = nalgebra::Unit::new_normalize(Vec3::new(0.2, 0.3, 1.0));
    let orientation = nalgebra::UnitQuaternion::from_axis_angle(&axis, angle);
    let places = (-20..=20).flat_map(|i| (-20..=20).map(move |j| (i, j))).filter(|(i, j)| is_in(*i, *j));
    let pressed: Vec<Pressed> = places
        .map(|(i, j)| Pressed {
            position: orientation * Vec3::new(f64::from(i), f64::from(j), 0.0),
            tributary: [1.0; 2],
            weights: [1.0; 2],
            normal_force: 1.0,
        })
        .collect();
    let shadow = master.map(|shape| Shadow {
        shape,
        pose: Pose { centre: Vec3::zeros(), orientation },
        normal: orientation * Vec3::z(),
        direction: Vec3::z(),
    });
    patch_of(&pressed, 1.0, shadow.as_ref())
}

#[test]
fn nodes_across_and_axes_do_not_depend_on_how_a_patch_is_turned() {
    for turn in 0..36 {
        let angle = 0.1 + f64::from(turn) * 0.17;
        let check = |is_in: &dyn Fn(i32, i32) -> bool, across: u32, axes: [f64; 2]| {
            let patch = turned_patch(angle, is_in, None);
            assert_eq!(patch.nodes_across, across, "{angle}: {patch:?}");
            let differs = patch.axes.iter().zip(axes).any(|(axis, exact)| (axis - exact).abs() > 1e-6);
            assert!(!differs, "{angle}: {patch:?}, {axes:?}");
        };
        // A square of 5 × 5 nodes, a strip of 3 × 12, and one row.
        check(&|i, j| i.abs() <= 2 && j.abs() <= 2, 5, [5.0; 2]);
        check(&|i, j| i.abs() <= 1 && (-5..=6).contains(&j), 3, [12.0, 3.0]);
        check(&|i, j| i == 0 && j.abs() <= 3, 1, [7.0, 0.0]);
        // A disc of 37 nodes, an octagon of 4√2 between parallel sides, the diagonal ones.
        check(&|i, j| i * i + j * j <= 10, 7, [1.0 + 32.0_f64.sqrt(); 2]);
    }
}

#[test]
fn axes_of_a_patch_on_a_flat_end_are_no_longer_than_it_is_wide() {
    // Seven nodes across, of which the outer ones are beyond the end.
    let end = Shape::Box { half: Vec3::new(2.5, 2.5, 1.0) };
    let patch = turned_patch(0.4, |i, j| i.abs() <= 3 && j.abs() <= 3, Some(end));
    assert!(patch.axes.iter().all(|axis| (axis - 5.0).abs() < 1e-6), "{patch:?}");
    assert_eq!(patch.nodes_across, 7);
}

#[test]
fn a_contact_between_nodes_is_one_nodes_worth_and_what_is_not_covered_does_not_count() {
    let (surface, position) = grid();
    let mut geometry = PatchGeometry::of_slave(0, &surface, None);
    let mut time = 0.0;
    let mut press = |geometry: &mut PatchGeometry, contacts: &[(u32, f64)], limit: &Limit| {
        time += 1.0;
        geometry.touches.clear();
        for &(node, weight) in contacts {
            geometry.add(node, Touch::new((time, -Vec3::z()), weight, 1.0));
        }
        geometry.keep_since(time);
        let pressed = geometry.press(time, &position, limit, &Followers::default());
        pressed.iter().map(Pressed::area).sum::<f64>()
    };
    // In the middle of a face; at a node, and again beside it.
    let middle = [48, 49, 59, 60].map(|node| (node, 0.25));
    assert!((press(&mut geometry, &middle, &Limit::None) - 1.0).abs() < 1e-12);
    assert!((press(&mut geometry, &[(60, 1.0), (60, 0.5), (61, 0.5)], &Limit::None) - 1.5).abs() < 1e-12);
    // A box over 4.5 × 3 faces presses 5 × 4 nodes, and those beyond its edges.
    let pose = Pose { centre: Vec3::new(4.25, 4.5, 1.0), orientation: nalgebra::UnitQuaternion::identity() };
    let shape = Shape::Box { half: Vec3::new(2.25, 1.5, 1.0) };
    let shadow = Shadow { shape, pose, normal: Vec3::z(), direction: Vec3::z() };
    let under: Vec<(u32, f64)> = (1..8).flat_map(|i| (2..8).map(move |j| (j * 11 + i, 1.0))).collect();
    assert!((press(&mut geometry, &under, &Limit::Shadow(shadow)) - 13.5).abs() < 1e-12);
}

#[test]
fn one_node_has_no_extent() {
    let patch = patch_of(
        &[Pressed { position: Vec3::x(), tributary: [2.0; 2], weights: [1.0; 2], normal_force: 1.0 }],
        1.0,
        None,
    );
    assert_eq!((patch.axes, patch.nodes_across, patch.nodes), ([0.0, 0.0], 1, 1));
}

#[test]
fn the_sides_of_a_flat_end_are_no_part_of_it() {
    // The top of a cube and one of its sides, pressed at their common edge along the bisector.
    let surface = Surface::new((0..6).collect(), vec![[0, 1, 2, 3], [1, 4, 5, 2]]);
    let position = |n: u32| {
        let [x, y, z] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, -1], [1, 1, -1]][n as usize];
        Vec3::new(f64::from(x), f64::from(y), f64::from(z))
    };
    let mut geometry = PatchGeometry::of_master(0, &surface);
    let oblique = Vec3::new(-1.0, 0.0, -1.0).normalize();
    let mut area = |limit: &Limit| {
        geometry.evaluation += 1;
        geometry.tributary_area(1, &oblique, &position, limit)[0]
    };
    assert!((area(&Limit::None) - 0.5).abs() < 1e-12);
    assert!((area(&Limit::Front(-Vec3::z())) - 0.25).abs() < 1e-12);
}

#[test]
fn a_node_that_bounces_keeps_its_area_and_its_largest_weight_of_late() {
    let (surface, position) = grid();
    let mut geometry = PatchGeometry::of_slave(0, &surface, None);
    let touch = |time, weight| Touch::new((time, -Vec3::z()), weight, 3.0);
    let at = |geometry: &mut PatchGeometry, time: f64, touches: &[(u32, f64)]| {
        for (node, weight) in touches {
            geometry.add(*node, touch(time, *weight));
        }
        geometry.keep_since(time - 10.0);
        patch_of(&geometry.press(time, &position, &Limit::None, &Followers::default()), 1.0, None)
    };
    let check = |patch: ContactPatch, area: f64, nodes: u32, pressure: f64| {
        assert!((patch.area - area).abs() < 1e-12 && patch.nodes == nodes, "{patch:?}");
        assert!((patch.peak_pressure - pressure).abs() < 1e-12, "{patch:?}");
    };
    check(at(&mut geometry, 1.0, &[(60, 0.75), (60, 0.25), (64, 1.0)]), 2.0, 2, 6.0);
    // Only one of them is pressed, and by half; then none; then by half again, the rest being long ago.
    check(at(&mut geometry, 2.0, &[(60, 0.5)]), 2.0, 1, 6.0);
    check(at(&mut geometry, 3.0, &[]), 2.0, 0, 0.0);
    check(at(&mut geometry, 12.5, &[(60, 0.5)]), 0.5, 1, 6.0);
}

/// Area of the patch of these nodes of the grid, all pressed with full weight.
fn area_of(pressed: impl IntoIterator<Item = u32>) -> f64 {
    let (surface, position) = grid();
    let mut geometry = PatchGeometry::of_slave(0, &surface, None);
    for node in pressed {
        geometry.add(node, Touch::new((1.0, -Vec3::z()), 1.0, 1.0));
    }
    geometry.keep_since(0.0);
    patch_of(&geometry.press(1.0, &position, &Limit::None, &Followers::default()), 1.0, None).area
}

/// The nodes of the grid in a rectangle, given by its columns and rows.
fn block(columns: std::ops::Range<u32>, rows: std::ops::Range<u32>) -> Vec<u32> {
    rows.flat_map(|j| columns.clone().map(move |i| j * 11 + i)).collect()
}

#[test]
fn a_gap_of_two_nodes_is_closed_and_a_wider_one_stays_open() {
    let around = |hole: &[u32]| {
        let ring = block(1..10, 1..10).into_iter().filter(|node| !hole.contains(node));
        area_of(ring.collect::<Vec<_>>())
    };
    assert!((around(&[]) - 81.0).abs() < 1e-12);
    assert!((around(&block(4..6, 4..6)) - 81.0).abs() < 1e-12);
    // Two nodes wide, along all of its length.
    assert!((around(&block(4..6, 2..9)) - 81.0).abs() < 1e-12);
    assert!((around(&block(4..7, 4..7)) - 72.0).abs() < 1e-12);
}

#[test]
fn closing_keeps_the_edge_of_a_patch() {
    assert!((area_of(block(3..7, 3..7)) - 16.0).abs() < 1e-12);
    // A disc keeps its edge, too: all of its nodes, and none more.
    let is_in = |node: &u32| {
        let (x, y) = (f64::from(node % 11) - 5.0, f64::from(node / 11) - 5.0);
        x.hypot(y) <= 3.7
    };
    let disc: Vec<u32> = (0..121).filter(is_in).collect();
    assert!((area_of(disc.clone()) - disc.len() as f64).abs() < 1e-12);
}

#[test]
fn a_border_is_closed_along_itself_alone() {
    // Pressed up to one node from the border: the border is not pressed.
    assert!((area_of(block(1..10, 1..10)) - 81.0).abs() < 1e-12);
    // A gap that reaches the border, as one in a plane of symmetry does, between nodes pressed on it.
    let gap = block(0..2, 4..6);
    let pressed: Vec<u32> = block(0..5, 1..10).into_iter().filter(|node| !gap.contains(node)).collect();
    assert!((area_of(pressed) - 4.5 * 9.0).abs() < 1e-12);
}
