//! Bodies made of closed surfaces in each other.

use super::surfaces::stl;
use super::*;
use crate::mechanics::rigid::{Rotation, Shape};
use crate::mechanics::tensor::Vec3;
use crate::mesh::read::stl::read_stl;
use crate::scene::first_surfaces::{Nest, SurfaceFile};

/// A thigh with a layer of fat and a bone, along an axis at an angle, in millimetres.
fn limb() -> [(&'static str, Vec<u8>); 3] {
    let turn = Rotation::from_euler_angles(0.2, 0.1, -0.3);
    let cylinder = |radius: f64, half_length: f64| {
        stl(&[(Shape::Cylinder { radius, half_length }, Vec3::new(0.1, 0.2, 0.3), turn)])
    };
    [
        ("fat.stl", cylinder(0.03, 0.04)),
        ("muscle.stl", cylinder(0.022, 0.034)),
        ("femur.stl", cylinder(0.008, 0.028)),
    ]
}

fn scene() -> Value {
    json!({
        "name": "nest", "end_time_s": 1e-3,
        "bodies": [{
            "name": "thigh", "fixed": [{"set": "femur"}],
            "mesh": {"segmentation": {
                "surfaces": [
                    {"name": "fat.stl", "scale": 0.001, "part": "fat"},
                    {"name": "muscle.stl", "scale": 0.001, "part": "muscle"},
                    {"name": "femur.stl", "scale": 0.001, "hole": "femur"}
                ],
                "size_m": 0.006, "thin_size_m": 0.003
            }},
            "parts": [{"part": "*", "density_kg_per_m3": 1000,
                       "material": {"law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 2e7}}]
        }],
        "planes": [{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}]
    })
}

fn load_nest(document: &Value) -> Result<Loaded, Problems> {
    let mut files = limb().to_vec();
    let mut open = files[1].1.clone();
    open.truncate(open.len() - 50);
    let count = u32::from_le_bytes([open[80], open[81], open[82], open[83]]) - 1;
    open[80..84].copy_from_slice(&count.to_le_bytes());
    files.push(("open.stl", open));
    files.push(("cube.msh", cube(false)));
    load(document.to_string().as_bytes(), &Files(files), &Budget::COMMAND_LINE)
}

#[test]
fn closed_surfaces_in_each_other_become_parts_and_holes_of_their_volumes() {
    let loaded = load_nest(&scene()).unwrap();
    assert_eq!(loaded.warnings, []);
    let mesh = &loaded.scene.bodies[0].mesh;
    assert_eq!(mesh.parts, ["fat", "muscle"]);
    assert_eq!(mesh.node_sets.keys().collect::<Vec<_>>(), ["femur", "outer"]);
    let [fat, muscle, femur] = limb().map(|(_, bytes)| read_stl(&bytes).unwrap().scaled(0.001).volume());
    for (part, exact) in [("fat", fat - muscle), ("muscle", muscle - femur)] {
        let found = mesh.part_volume_m3(part);
        assert!((found / exact - 1.0).abs() < 0.01, "{part}: {found} of {exact}");
    }
    assert_eq!(loaded.scene.mesh_files.keys().collect::<Vec<_>>(), ["fat.stl", "femur.stl", "muscle.stl"]);
    // Made again in other sizes, without the folder.
    let mut finer = scene();
    set(&mut finer, "/bodies/0/mesh/segmentation/size_m", json!(0.012));
    load(finer.to_string().as_bytes(), &loaded.scene.kept_files, &Budget::COMMAND_LINE).unwrap();
}

#[test]
fn a_first_scene_of_surfaces_is_completed_by_what_is_missing() {
    let surfaces = limb().map(|(name, bytes)| SurfaceFile {
        file: name.to_owned(),
        name: name.to_owned(),
        surface: read_stl(&bytes).unwrap(),
    });
    let document = Nest::of(&surfaces).first_scene();
    let found = load_nest(&document).unwrap_err().0;
    let mut codes: Vec<&str> = found.iter().filter(|p| p.is_error()).map(|p| p.pointer.as_str()).collect();
    codes.dedup();
    assert_eq!(codes, ["/end_time_s"]);
}

#[test]
fn what_is_wrong_with_surfaces_is_listed_with_its_place() {
    let at = "/bodies/0/mesh/segmentation";
    let listed = |name: &str| json!({"name": name, "scale": 0.001, "part": "x"});
    for (rest, value, pointer, code, words) in [
        ("/name", json!("limb.nii"), "", "several_variants", "one of name and surfaces"),
        ("/surfaces", json!([]), "", "missing_source", "name a scan"),
        ("/labels", json!([{"label": 1, "part": "a"}]), "/labels", "labels_of_surfaces", "part or hole"),
        ("/voxel_size_m", json!(0), "/voxel_size_m", "not_positive", "half of an element"),
        ("/surfaces/0/scale", json!(-1), "/surfaces/0/scale", "not_positive", "0.001"),
        ("/surfaces/0/hole", json!("bone"), "/surfaces/0", "several_variants", "one of part and hole"),
        ("/surfaces/1/name", json!("open.stl"), "/surfaces/1/name", "bad_mesh", "is open at 3 edges"),
        ("/surfaces/1/name", json!("cube.msh"), "/surfaces/1/name", "bad_mesh", "byte"),
        ("/surfaces/2/name", json!("none.stl"), "/surfaces/2/name", "mesh_not_found", "none.stl"),
        ("/surfaces/0/scale", json!(1), "/surfaces", "bad_scan", "0.001 for millimetres"),
        ("/surfaces/2", listed("fat.stl"), "/surfaces/0", "bad_scan", "from the outside to the inside"),
        ("/voxel_size_m", json!(1e-5), "/surfaces", "bad_scan", "larger voxel_size_m"),
        ("/max_elements", json!(100), "", "bad_scan", "100"),
    ] {
        let mut document = scene();
        set(&mut document, &format!("{at}{rest}"), value);
        let problems = load_nest(&document).unwrap_err();
        let pointer = format!("{at}{pointer}");
        let found = problems.0.iter().find(|p| p.pointer == pointer && p.code == code);
        let found = found.unwrap_or_else(|| panic!("{rest} {code}: {problems}")).to_string();
        assert!(found.contains(words), "{words:?}: {found}");
    }
}

#[test]
fn volumes_are_those_of_the_surfaces_and_not_of_the_voxels() {
    let body = |shape: Shape, place: [f64; 3], turn: Rotation| stl(&[(shape, Vec3::from(place), turn)]);
    let upright = Rotation::identity();
    let brick = |half: [f64; 3]| Shape::Box { half: Vec3::from(half) };
    let turned = Rotation::from_euler_angles(0.2, 0.1, -0.3);
    let cylinder = |radius: f64, half_length: f64| Shape::Cylinder { radius, half_length };
    // The inner boxes end between voxels, and have up to 20 % too much volume in them.
    let cases = [
        [
            body(brick([0.03, 0.03, 0.05]), [0.0; 3], upright),
            body(brick([0.0208, 0.0213, 0.0405]), [0.0007, 0.0, 0.001], upright),
            body(brick([0.0079, 0.0083, 0.03]), [0.0011, 0.0004, -0.0013], upright),
        ],
        [
            body(Shape::Ball { radius: 0.03 }, [0.0; 3], upright),
            body(Shape::Ball { radius: 0.021 }, [0.001, 0.0005, -0.0007], upright),
            body(Shape::Ball { radius: 0.0103 }, [0.002, 0.001, 0.0003], upright),
        ],
        [
            body(cylinder(0.03, 0.04), [0.0; 3], turned),
            body(cylinder(0.0217, 0.0335), [0.0; 3], turned),
            body(cylinder(0.0091, 0.0263), [0.001, 0.0, 0.002], turned),
        ],
    ];
    for (case, [fat, muscle, bone]) in cases.into_iter().enumerate() {
        let exact = [&fat, &muscle, &bone].map(|bytes| read_stl(bytes).unwrap().scaled(0.001).volume());
        let mut document = scene();
        set(
            &mut document,
            "/bodies/0/mesh/segmentation/surfaces/2",
            json!({"name": "bone", "scale": 0.001, "part": "bone"}),
        );
        set(&mut document, "/bodies/0/fixed", json!([{"set": "outer"}]));
        set(&mut document, "/planes/0/point_m", json!([0, 0, -0.1]));
        set(&mut document, "/bodies/0/mesh/segmentation/voxel_size_m", json!(0.002));
        let files = Files(vec![("fat.stl", fat), ("muscle.stl", muscle), ("bone", bone)]);
        let loaded = load(document.to_string().as_bytes(), &files, &Budget::COMMAND_LINE).unwrap();
        let mesh = &loaded.scene.bodies[0].mesh;
        let parts = [("fat", exact[0] - exact[1]), ("muscle", exact[1] - exact[2]), ("bone", exact[2])];
        for (part, exact) in parts {
            let ratio = mesh.part_volume_m3(part) / exact;
            assert!(
                (ratio - 1.0).abs() < 0.01,
                "{case} {part}: {:+.2} %, {:?}",
                100.0 * (ratio - 1.0),
                mesh.notes
            );
        }
        assert_eq!(loaded.warnings, [], "{case}");
    }
}
