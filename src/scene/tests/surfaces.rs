//! Rigid bodies of triangulated surfaces.

use super::*;
use crate::mechanics::rigid::{Rotation, Shape, triangulated};
use crate::mechanics::tensor::Vec3;

/// Binary STL of shapes at places, in millimetres.
pub(super) fn stl(shapes: &[(Shape, Vec3, Rotation)]) -> Vec<u8> {
    let mut bytes = vec![0; 84];
    let mut count = 0_u32;
    for (shape, place, turn) in shapes {
        let (x, triangles) = triangulated(shape);
        for triangle in triangles {
            bytes.extend([0; 12]);
            let corners = triangle.map(|node| (turn * x[node as usize] + place) * 1e3);
            bytes.extend(corners.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()));
            bytes.extend([0; 2]);
            count += 1;
        }
    }
    bytes[80..84].copy_from_slice(&count.to_le_bytes());
    bytes
}

fn brick() -> (Shape, Vec3, Rotation) {
    let half = Vec3::new(0.02, 0.01, 0.03);
    (Shape::Box { half }, Vec3::new(0.5, -0.2, 0.1), Rotation::from_axis_angle(&Vec3::z_axis(), 0.5))
}

/// The brick falls on the ground.
fn scene() -> Value {
    json!({
        "name": "surface", "end_time_s": 0.1,
        "bodies": [{
            "name": "brick", "velocity_m_per_s": [0, 0, -1],
            "rigid": {"shape": {"kind": "stl", "name": "brick.stl", "scale": 0.001}, "center_m": [0, 0, 0.2], "density_kg_per_m3": 7850}
        }],
        "planes": [{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "integrator": {"kind": "explicit", "max_step_s": 1e-4}
    })
}

fn load_surface(changes: &[(&str, Value)]) -> Result<Loaded, Problems> {
    let mut document = scene();
    for (pointer, value) in changes {
        set(&mut document, pointer, value.clone());
    }
    let upright = Rotation::identity();
    let hammer = [
        (Shape::Box { half: Vec3::new(0.05, 0.015, 0.015) }, Vec3::new(0.0, 0.0, 0.3), upright),
        (Shape::Box { half: Vec3::new(0.01, 0.01, 0.14) }, Vec3::new(0.0, 0.0, 0.14), upright),
    ];
    // The hull of two balls of flat faces, turned against each other.
    let ball = [upright, Rotation::from_euler_angles(0.1, 0.05, 0.02)]
        .map(|turn| (Shape::Ball { radius: 0.02 }, Vec3::zeros(), turn));
    let mut open = stl(&[brick()]);
    open.truncate(open.len() - 50);
    open[80] -= 1;
    let (shape, place, turn) = brick();
    let aside = (shape, place + Vec3::x() * 1e-6, turn);
    let files = Files(vec![
        ("brick.stl", stl(&[brick()])),
        ("hammer.stl", stl(&hammer)),
        ("twice.stl", stl(&[brick(), brick()])),
        ("overlapping.stl", stl(&[brick(), aside])),
        ("ball.stl", stl(&ball)),
        ("open.stl", open),
        ("short.stl", stl(&[brick()])[..300].to_vec()),
        ("cube.msh", cube(false)),
    ]);
    load(document.to_string().as_bytes(), &files, &Budget::COMMAND_LINE)
}

#[test]
fn a_surface_has_the_mass_and_the_place_of_its_body() {
    let loaded = load_surface(&[]).unwrap();
    assert_eq!(loaded.warnings, []);
    assert!(loaded.scene.mesh_files.contains_key("brick.stl"));
    let summary = &loaded.bodies[0];
    assert!((summary.mass_kg / (7850.0 * 8.0 * 6e-6) - 1.0).abs() < 1e-5, "{}", summary.mass_kg);
    // Coordinates of 500 mm in single precision.
    let (s, c) = 0.5_f64.sin_cos();
    let [x, y] = [0.02 * c + 0.01 * s, 0.02 * s + 0.01 * c];
    let exact = [[-x, -y, 0.17], [x, y, 0.23]];
    for (corner, exact) in summary.bounding_box_m.iter().zip(exact) {
        assert!(corner.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-7), "{corner:?}");
    }
    let rigid = loaded.scene.bodies[0].rigid.as_ref().unwrap();
    let mut exact: [f64; 3] = (brick().0.inertia_per_mass() * rigid.mass).into();
    exact.sort_by(f64::total_cmp);
    assert!((rigid.inertia - Vec3::from(exact)).norm() < 1e-5 * exact[2]);
}

#[test]
fn a_hammer_has_its_own_mass_and_its_hull_in_contact_if_that_is_accepted() {
    let name = ("/bodies/0/rigid/shape/name", json!("hammer.stl"));
    let refused = load_surface(std::slice::from_ref(&name)).unwrap_err();
    let problem = refused.0.iter().find(|p| p.code == "not_convex").unwrap_or_else(|| panic!("{refused}"));
    assert_eq!(problem.pointer, "/bodies/0/rigid/shape/convex_hull");
    let accepted = ("/bodies/0/rigid/shape/convex_hull", json!(true));
    let loaded = load_surface(&[name, accepted, ("/bodies/0/rigid/center_m", json!([0, 0, 0.4]))]).unwrap();
    let codes: Vec<&str> = loaded.warnings.iter().map(|p| &*p.code).collect();
    assert_eq!(codes, ["convex_hull"]);
    // Head and handle overlap by 5 mm, which counts twice.
    let exact = 7850.0 * 8.0 * (0.05 * 0.015 * 0.015 + 0.01 * 0.01 * 0.14);
    assert!((loaded.bodies[0].mass_kg / exact - 1.0).abs() < 1e-4, "{}", loaded.bodies[0].mass_kg);
}

#[test]
fn what_is_wrong_with_a_surface_is_listed_with_its_place() {
    let name = |name: &str| ("/bodies/0/rigid/shape/name", json!(name));
    for (change, pointer, code, words) in [
        (name("none.stl"), "/bodies/0/rigid/shape/name", "mesh_not_found", "none.stl"),
        (name("short.stl"), "/bodies/0/rigid/shape/name", "bad_mesh", "announces 12 triangles"),
        (name("open.stl"), "/bodies/0/rigid/shape/name", "bad_mesh", "is open at 3 edges"),
        (name("twice.stl"), "/bodies/0/rigid/shape/name", "bad_mesh", "has a triangle twice"),
        (name("overlapping.stl"), "/bodies/0/rigid/shape/convex_hull", "overlapping_surface", "2.00 times"),
        (name("cube.msh"), "/bodies/0/rigid/shape/name", "bad_mesh", "byte"),
        (name("ball.stl"), "/bodies/0/rigid/shape/name", "too_many_planes", "decimate"),
        (("/bodies/0/rigid/shape/scale", json!(0)), "/bodies/0/rigid/shape/scale", "not_positive", "0.001"),
        (
            ("/bodies/0/spin_rad_per_s", json!([1e6, 0, 0])),
            "/bodies/0/spin_rad_per_s",
            "impossible_spin",
            "rim",
        ),
        (
            ("/bodies/0/rigid/inertia_kg_m2", json!([1.0, 1.0, 1.0])),
            "/bodies/0/rigid/inertia_kg_m2/0",
            "impossible_inertia",
            "homogeneous",
        ),
    ] {
        let problems = load_surface(&[change]).unwrap_err();
        let found = problems.0.iter().find(|p| p.pointer == pointer && p.code == code);
        let found = found.unwrap_or_else(|| panic!("{pointer} {code}: {problems}")).to_string();
        assert!(found.contains(words), "{words:?}: {found}");
    }
    let mut document = scene();
    document["bodies"][0].as_object_mut().unwrap().remove("rigid");
    set(&mut document, "/bodies/0/mesh", json!({"file": {"name": "brick.stl"}}));
    let files = Files(vec![("brick.stl", stl(&[brick()]))]);
    let message =
        load(document.to_string().as_bytes(), &files, &Budget::COMMAND_LINE).unwrap_err().to_string();
    assert!(message.contains("\"kind\": \"stl\"") && message.contains("segmentation"), "{message}");
}
