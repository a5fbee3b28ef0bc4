use super::*;
use crate::rigid::Rotation;

const SIZE: f64 = 6.0;
/// Distance of the corners of [`square`] from its middle.
const AROUND: f64 = 3.0 * std::f64::consts::SQRT_2;

/// A square face, its normal along z, beside the axis.
fn square(z: f64) -> Patch {
    let corners = [[-3.0, -2.0], [3.0, -2.0], [3.0, 4.0], [-3.0, 4.0]].map(|[x, y]| Vec3::new(x, y, z));
    Patch { corners, triangle: false }
}

fn turned(rotation: &Rotation, face: &Patch, by: &Vec3) -> Patch {
    Patch { corners: face.corners.map(|c| rotation.inverse_transform_vector(&(c + by))), ..*face }
}

fn found(shape: &Shape, start: &Patch, end: &Patch) -> Vec<FaceTouch> {
    let mut touches = Vec::new();
    touches_of((shape, &mut Vec::new()), SIZE, [start, end], [true; 4], |touch| touches.push(touch));
    touches
}

const SHAPES: [Shape; 4] = [
    Shape::Ball { radius: 0.5 },
    Shape::Box { half: Vec3::new(0.3, 0.4, 0.5) },
    Shape::Cylinder { radius: 0.4, half_length: 0.5 },
    Shape::Capsule { radius: 0.4, half_length: 0.3 },
];

#[test]
fn a_small_shape_is_met_in_the_middle_and_on_an_edge_of_a_face_at_any_speed() {
    for shape in SHAPES {
        for (angle, aside) in [(0.0, 0.0), (0.4, 0.0), (1.1, 0.0), (0.3, 2.0), (0.9, 2.0), (0.0, 2.0)] {
            let rotation = Rotation::from_euler_angles(angle, 0.6 * angle, 0.3);
            let at = |z: f64| turned(&rotation, &square(z), &Vec3::new(0.1, aside, 0.0));
            let outer = shape.outer_radius();
            assert_eq!(found(&shape, &at(-outer - 0.5), &at(-outer - 0.4)), [], "far");
            for far in [1.5, 10.0, 1000.0] {
                let touches = found(&shape, &at(-1.5), &at(-1.5 + far));
                assert!(!touches.is_empty(), "{shape:?} {angle} {aside} {far}");
                let left = |t: &FaceTouch| t.gap + (rotation * t.normal).z * far * t.fraction;
                let first =
                    touches.iter().copied().min_by(|a, b| left(a).total_cmp(&left(b))).unwrap_or(touches[0]);
                let down = rotation * first.normal;
                assert!(down.z < if aside > 0.0 { -0.5 } else { -0.95 }, "{shape:?} {angle} {aside}: {down}");
                let lowest = rotation.inverse_transform_vector(&-Vec3::z());
                let reaches = shape.feet(&lowest).points().iter().map(|p| p.dot(&lowest)).fold(0.0, f64::max);
                // Its lowest point lies in the face by the allowed depth, and by 1.8 times that where two edges
                // cross.
                let depth = first.fraction * far - (1.5 - reaches);
                let allowed = Obstacle::new(&shape, SIZE, AROUND).allowed;
                let most = if aside > 0.0 { f64::INFINITY } else { 2.0 }; // its corner may be beside the face
                assert!((0.9..most).contains(&(depth / allowed)), "{shape:?} {angle} {aside} {far}: {depth}");
            }
        }
    }
}

#[test]
fn a_box_that_lies_flat_in_a_face_stands_on_four_feet_and_a_capsule_on_two() {
    for (shape, feet) in SHAPES.into_iter().zip([1, 4, 2, 2]) {
        let low = match shape {
            Shape::Box { half } => half.z,
            _ => shape.size() * 0.5,
        };
        let touches = found(&shape, &square(-low), &square(-low + 0.1));
        assert_eq!(touches.len(), feet, "{shape:?} {touches:?}");
        for touch in touches {
            assert!((touch.normal + Vec3::z()).norm() < 1e-12);
            let allowed = Obstacle::new(&shape, SIZE, AROUND).allowed;
            assert!((touch.gap - allowed).abs() < 1e-3 * SIZE * RIGID_ALLOWED);
        }
    }
}

#[test]
fn a_box_across_an_edge_is_held_at_both_ends_of_what_lies_on_it() {
    let shape = Shape::Box { half: Vec3::new(0.5, 0.5, 0.5) };
    let face = turned(&Rotation::identity(), &square(-0.5), &Vec3::new(0.0, 2.0, 0.0));
    let closer = turned(&Rotation::identity(), &square(-0.4), &Vec3::new(0.0, 2.0, 0.0));
    let touches = found(&shape, &face, &closer);
    // The edge y = 0, from x = −0.5 to 0.5, and two corners in the face.
    let on_edge: Vec<f64> = touches.iter().filter(|t| t.point.y.abs() < 1e-9).map(|t| t.point.x).collect();
    assert!(on_edge.len() == 2 && (on_edge[0] + on_edge[1]).abs() < 0.01, "{on_edge:?}");
    assert!((on_edge[0] - on_edge[1]).abs() > 0.8);
    assert_eq!(touches.iter().filter(|t| t.point.y > 0.1).count(), 2);
}

#[test]
fn a_sharp_edge_across_an_edge_of_a_face_is_held_up_to_the_allowed_depth_beside_a_node() {
    // An edge of the box, along y, is 20 mm below the face, across its edge along x; the node at its end is outside of the box.
    let shape = Shape::Box { half: Vec3::new(0.3, 0.4, 0.3) };
    let lowest = 0.3 * std::f64::consts::SQRT_2;
    let rotation = Rotation::from_euler_angles(0.0, std::f64::consts::FRAC_PI_4, 0.0);
    let allowed = Obstacle::new(&shape, SIZE, AROUND).allowed;
    for beside in [0.022, 0.03, 0.06, 0.6] {
        let face = turned(&rotation, &square(0.02 - lowest), &Vec3::new(3.0 - beside, 2.0, 0.0));
        assert!(beside > 2.0 * allowed && shape.eval_distance(&face.corners[0]).0 > 0.0, "{beside}");
        let touches = found(&shape, &face, &face);
        let held = touches.iter().find(|t| t.weights[0] + t.weights[1] > 1.0 - 1e-9 && t.gap < 0.0);
        let held = held.unwrap_or_else(|| panic!("{beside}: {touches:?}"));
        assert!((held.weights[1] * SIZE - beside).abs() < 2.0 * allowed, "{beside}: {held:?}");
        assert!((rotation * held.normal).z < -0.9, "{beside}: {held:?}");
    }
}

#[test]
fn a_corner_is_pushed_back_along_the_normal_of_the_face_however_deep_it_is() {
    let shape = Shape::Box { half: Vec3::repeat(1.0) };
    let down = -Vec3::repeat(1.0).normalize();
    let rotation = Rotation::rotation_between(&down, &-Vec3::z()).unwrap_or_default();
    for depth in [0.05, 0.2, 1.0] {
        let at = turned(&rotation, &square(depth - 3.0_f64.sqrt()), &Vec3::zeros());
        let touches = found(&shape, &at, &at);
        let deepest = touches.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).copied();
        let touch = deepest.unwrap_or_else(|| panic!("{depth}"));
        assert!((touch.normal - down).norm() < 1e-9, "{depth}: {}", touch.normal);
        assert!((touch.gap + depth - RIGID_ALLOWED * SIZE).abs() < 1e-9, "{depth}: {}", touch.gap);
    }
}

#[test]
fn the_back_of_a_thin_plate_is_no_obstacle() {
    let mut back = square(-0.55);
    back.corners.swap(1, 3);
    for shape in SHAPES {
        assert_eq!(
            found(&shape, &back, &turned(&Rotation::identity(), &back, &Vec3::new(0.0, 0.0, 0.3))),
            []
        );
    }
}

#[test]
fn a_beam_across_a_warped_face_is_held_by_its_bulge_and_by_no_edge() {
    // A saddle, high along one diagonal; the beam lies along the other one, over which the face bulges.
    let warp = 1.0;
    let mut face = square(0.0);
    for (corner, sign) in face.corners.iter_mut().zip([1.0, -1.0, 1.0, -1.0]) {
        corner.z = sign * warp;
    }
    let beam = Shape::Box { half: Vec3::new(5.0, 0.2, 0.2) };
    let along = face.corners[1] - face.corners[3];
    let rotation = Rotation::from_euler_angles(0.0, 0.0, along.y.atan2(along.x));
    let middle = face.point(&[0.25; 4]);
    for depth in [-1.0, 0.05, 0.1, 0.15] {
        // In the axes of the beam, its lower side this deep below the centre of the face.
        let centre = middle + Vec3::z() * (0.2 - depth);
        let seen = turned(&rotation, &face, &-centre);
        let touches = found(&beam, &seen, &seen);
        if depth < 0.0 {
            assert_eq!(touches, []);
            continue;
        }
        let [touch] = touches[..] else { panic!("{depth}: {touches:?}") };
        assert!(touch.weights.iter().all(|w| (w - 0.25).abs() < 0.05), "{touch:?}");
        let allowed = Obstacle::new(&beam, SIZE, AROUND).allowed;
        assert!((touch.gap - (allowed - depth)).abs() < 0.3 * allowed + 0.1 * depth, "{depth}: {touch:?}");
        assert!((rotation * touch.normal).z < -0.9, "{touch:?}");
    }
}

#[test]
fn a_sharp_edge_across_a_bulge_is_kept_out_along_the_normal_of_the_face_wherever_it_crosses_it() {
    // A saddle, high along one diagonal. The edge of a long box runs along the other one, over which the face bulges, beside its middle,
    // turned out of it, and tilted to one side: the planes of the box are at 45° or less to the face.
    let mut face = square(0.0);
    for (corner, sign) in face.corners.iter_mut().zip([1.0, -1.0, 1.0, -1.0]) {
        corner.z = sign;
    }
    let half = 0.4;
    let shape = Shape::Box { half: Vec3::new(10.0, half, half) };
    let along = face.corners[1] - face.corners[3];
    let lowest = half * std::f64::consts::SQRT_2;
    for (aside, turn, tilt) in [(0.0, 0.0, 0.0), (0.07, 0.1, 0.0), (-0.2, -0.2, 0.0), (0.013, 0.05, 0.3)] {
        let edge_down = Rotation::from_euler_angles(std::f64::consts::FRAC_PI_4 + tilt, 0.0, 0.0);
        let heading = Rotation::from_euler_angles(0.0, 0.0, along.y.atan2(along.x) + turn);
        let rotation = heading * edge_down;
        let allowed = Obstacle::new(&shape, SIZE, AROUND).allowed;
        for depth in [2.5, 4.0, 8.0] {
            // The edge of the box is at this depth, in multiples of what is allowed, beside the middle of the face.
            let edge = heading * Vec3::new(0.0, lowest * tilt.sin(), -lowest * tilt.cos());
            let beside = heading * Vec3::new(0.0, aside, 0.0);
            let centre = face.point(&[0.25; 4]) + beside - Vec3::z() * (depth * allowed) - edge;
            let seen = turned(&rotation, &face, &-centre);
            let touches = found(&shape, &seen, &seen);
            let bulge = touches.iter().find(|t| t.weights.iter().all(|w| *w > 0.01) && t.gap < allowed);
            let bulge = bulge.unwrap_or_else(|| panic!("{aside} {turn} {tilt} {depth}: {touches:?}"));
            assert!((bulge.normal + seen.normal(&bulge.weights)).norm() < 1e-12, "{bulge:?}");
            // Nowhere along the edge of the box is the face nearer to it: both are parallel there.
            let slope = bulge.normal.dot(&Vec3::x());
            assert!(slope.abs() < 0.01, "{aside} {turn} {tilt} {depth}: {slope} {bulge:?}");
        }
    }
}

#[test]
fn nodes_on_a_round_shape_keep_it_out_of_the_faces_between_them() {
    let ball = Shape::Ball { radius: 40.0 };
    // All corners on the ball, however the face is stretched, as long as the bow is within its bound; then half a bow deeper.
    for stretch in [0.5, 1.0, 1.4] {
        let flat = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]];
        let radius = stretch * AROUND;
        let low = |z: f64| Patch {
            corners: flat.map(|[x, y]| Vec3::new(stretch * x, stretch * y, z)),
            triangle: false,
        };
        let on = -(40.0_f64 * 40.0 - radius * radius).sqrt();
        let bow = 40.0 + on;
        assert_eq!(found(&ball, &low(on), &low(on)), []);
        let deep = low(on + 0.5 * bow + 2.0 * RIGID_ALLOWED * SIZE);
        assert!(found(&ball, &low(on), &deep).iter().any(|touch| touch.gap > 0.0), "{stretch}");
    }
}
