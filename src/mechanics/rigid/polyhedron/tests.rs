use super::*;
use crate::rigid::{Shape, triangulated};

/// A shape's triangles, turned and moved.
fn placed(shape: &Shape, turn: &Rotation, way: &Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (x, triangles) = triangulated(shape);
    (x.iter().map(|x| turn * x + way).collect(), triangles)
}

fn brick() -> Shape {
    Shape::Box { half: Vec3::new(0.3, 0.5, 0.9) }
}

#[test]
fn a_brick_of_triangles_is_the_brick() {
    let (turn, way) = (Rotation::from_euler_angles(0.4, -1.1, 2.3), Vec3::new(10.0, -20.0, 5.0));
    let (x, triangles) = placed(&brick(), &turn, &way);
    let solid = Solid::new(&x, &triangles).unwrap();
    assert!((solid.hull_ratio - 1.0).abs() < 1e-12 && (solid.centre - way).norm() < 1e-12);
    assert!((solid.hull.volume() / brick().volume() - 1.0).abs() < 1e-12);
    assert_eq!((solid.hull.corners().len(), solid.hull.plane_count()), (8, 6));
    assert!((solid.hull.thickness() - 0.6).abs() < 1e-12);
    let mut exact: [f64; 3] = brick().inertia_per_mass().into();
    exact.sort_by(f64::total_cmp);
    assert!((solid.hull.inertia_per_mass() - Vec3::from(exact)).norm() < 1e-12);
    // Distances are those of the brick at every point around it, whatever its principal axes are called.
    for i in 0..500 {
        let at = |k: u32| 2.6 * (f64::from(i * k + 7) * 0.618_034).fract() - 1.3;
        let local = Vec3::new(at(1), at(13), at(57));
        let [exact, found] = [brick().eval_distance(&local), {
            let p = solid.axes.inverse_transform_vector(&(turn * local + way - solid.centre));
            let (distance, normal) = solid.hull.eval_distance(&p);
            (distance, turn.inverse_transform_vector(&(solid.axes * normal)))
        }];
        assert!((exact.0 - found.0).abs() < 1e-12, "{local}: {} instead of {}", found.0, exact.0);
        assert!((exact.1 - found.1).norm() < 1e-9, "{local}");
        // So are those of the cores.
        let core = Shape::Box { half: Vec3::new(0.29, 0.49, 0.89) };
        let p = solid.axes.inverse_transform_vector(&(turn * local + way - solid.centre));
        let (distance, _) = solid.hull.eval_core_distance(&p, 0.01);
        assert!((core.eval_distance(&local).0 - distance).abs() < 1e-12, "{local}: {distance}");
    }
}

#[test]
fn the_distance_to_a_round_surface_leads_to_it() {
    let (x, triangles) =
        placed(&Shape::Capsule { radius: 0.4, half_length: 0.3 }, &Rotation::identity(), &Vec3::zeros());
    let solid = Solid::new(&x, &triangles).unwrap();
    assert!((solid.hull_ratio - 1.0).abs() < 1e-9);
    for i in 0..300 {
        let at = |k: u32| 1.8 * (f64::from(i * k + 7) * 0.618_034).fract() - 0.9;
        let p = Vec3::new(at(1), at(13), at(57));
        let (distance, normal) = solid.hull.eval_distance(&p);
        assert!((normal.norm() - 1.0).abs() < 1e-12);
        let (left, _) = solid.hull.eval_distance(&(p - normal * distance));
        assert!(left.abs() < 1e-9, "{p}: {left}");
        let (core, _) = solid.hull.eval_core_distance(&p, 0.01);
        assert!(core >= distance + 0.01 - 1e-9, "{p}: {core} and {distance}");
        assert!(solid.hull.is_met_by_line(&p, &normal) || distance > 0.0);
    }
}

#[test]
fn the_mass_of_a_body_with_a_notch_is_that_of_the_body_and_its_contact_that_of_the_hull() {
    // Two bricks side by side, apart by a gap of their width.
    let half = Shape::Box { half: Vec3::new(0.1, 0.2, 0.3) };
    let (mut x, mut triangles) = placed(&half, &Rotation::identity(), &Vec3::new(-0.2, 0.0, 0.0));
    let (others, second) = placed(&half, &Rotation::identity(), &Vec3::new(0.2, 0.0, 0.0));
    let first = x.len() as u32;
    x.extend(others);
    triangles.extend(second.iter().map(|t| t.map(|node| node + first)));
    let solid = Solid::new(&x, &triangles).unwrap();
    assert!((solid.hull_ratio - 1.5).abs() < 1e-12);
    assert!((solid.hull.volume() - 2.0 * half.volume()).abs() < 1e-15);
    let own = half.inertia_per_mass();
    let exact = own + Vec3::new(0.0, 0.04, 0.04);
    assert!((solid.hull.inertia_per_mass() - exact).norm() < 1e-12, "{}", solid.hull.inertia_per_mass());
    assert!((solid.hull.eval_distance(&Vec3::zeros()).0 + 0.2).abs() < 1e-12);
}

#[test]
fn flat_surfaces_are_refused() {
    let x = [Vec3::zeros(), Vec3::x(), Vec3::y()];
    let Err(NoHull::Flat(error)) = Solid::new(&x, &[[0, 1, 2], [0, 2, 1]]) else { panic!("it is flat") };
    assert!(error.contains("volume of 0"), "{error}");
    assert!(Solid::new(&[], &[]).is_err());
}
