//! Commands on mesh files, as a user calls them: `mesh info`, `convert`, `scene from`.
#![allow(clippy::unwrap_used)] // tests say what they expect by panicking, their own functions too

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn run(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_contuse")).args(args).env_remove("RUST_LOG").output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn a_mesh_file_is_inspected_converted_and_begun_with() {
    let folder = tempfile::tempdir().unwrap();
    let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ball_on_block/scene_L0.inp");
    let converted = folder.path().join("mesh.msh");
    let (from, to) = (original.to_str().unwrap(), converted.to_str().unwrap());
    assert_eq!(run(&["convert", from, to, "--binary"]).status.code(), Some(0));
    let info = |file: &str| -> Value {
        let output = run(&["mesh", "info", "--json", file]);
        assert_eq!(output.status.code(), Some(0));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let [mut a, mut b] = [info(from), info(to)];
    assert_eq!(a["elements"], 2336);
    // A Gmsh file has no remarks of the reader of another.
    for answer in [&mut a, &mut b] {
        answer["notes"] = Value::Null;
    }
    assert_eq!(a, b);
    let output = run(&["mesh", "info", to]);
    assert!(text(&output.stdout).contains("Worst elements"), "{}", text(&output.stdout));

    // What a first scene leaves open is named by validation.
    let scene = folder.path().join("scene.json");
    let scene = scene.to_str().unwrap();
    assert_eq!(run(&["scene", "from", to, "-o", scene]).status.code(), Some(0));
    assert_eq!(run(&["scene", "from", to, "-o", scene]).status.code(), Some(2), "it exists");
    let answer = run(&["validate", scene]);
    assert_eq!(answer.status.code(), Some(2));
    for place in ["/end_time_s", "/bodies/1/velocity_m_per_s", "/bodies/1/parts/0/material/library"] {
        assert!(text(&answer.stdout).contains(place), "{place}: {}", text(&answer.stdout));
    }
    for bad in [["convert", from, "mesh.vtk"], ["mesh", "info", "nothing.k"], ["mesh", "info", "Cargo.toml"]]
    {
        assert_eq!(run(&bad).status.code(), Some(2), "{bad:?}");
    }
}

#[test]
fn a_segmentation_of_3d_slicer_is_begun_with_by_the_names_of_its_labels() {
    // A block of muscle about a column of bone along z, in fat.
    let folder = tempfile::tempdir().unwrap();
    let (file, scene) = (folder.path().join("limb.seg.nrrd"), folder.path().join("scene.json"));
    let mut bytes = b"NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: 20 20 6\n\
        space directions: (2,0,0) (0,2,0) (0,0,2)\nkinds: domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n\
        Segment0_LabelValue:=1\nSegment0_Name:=muscle\nSegment1_LabelValue:=2\nSegment1_Name:=bone\nSegment2_LabelValue:=3\nSegment2_Name:=fat\n\n"
        .to_vec();
    let from_middle = |n: i32| (n % 20 - 10).abs().max((n / 20 % 20 - 10).abs());
    bytes.extend((0..2400).map(|n| match from_middle(n) {
        0..=2 => 2_u8,
        3..=6 => 1,
        _ => 3,
    }));
    std::fs::write(&file, bytes).unwrap();
    let output = run(&["mesh", "info", file.to_str().unwrap()]);
    for name in ["muscle", "bone", "fat"] {
        assert!(text(&output.stdout).contains(name), "{name}: {}", text(&output.stdout));
    }
    let output = run(&["scene", "from", file.to_str().unwrap(), "-o", scene.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let document: Value = serde_json::from_slice(&std::fs::read(&scene).unwrap()).unwrap();
    let body = &document["bodies"][0];
    let labels = body["mesh"]["segmentation"]["labels"].as_array().unwrap();
    assert!(labels.iter().any(|label| label["label"] == 2 && label["hole"] == "bone"), "{document}");
    let parts = body["parts"].as_array().unwrap();
    for (part, family) in [("muscle", "muscle/"), ("fat", "fat/")] {
        let own = parts.iter().find(|own| own["part"] == part).unwrap();
        assert!(own["material"]["library"].as_str().unwrap().starts_with(family), "{document}");
    }
    // An image without any label is no segmentation.
    let mut empty = std::fs::read(&file).unwrap();
    let voxels = empty.len() - 2400;
    empty[voxels..].fill(0);
    std::fs::write(&file, empty).unwrap();
    let output = run(&["mesh", "info", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("no label but 0"), "{}", text(&output.stderr));
}

#[test]
fn closed_surfaces_are_inspected_and_begun_with_from_the_outside_to_the_inside() {
    // Boxes around the same centre, in millimetres.
    let folder = tempfile::tempdir().unwrap();
    let [skin, femur] =
        [("skin.stl", [30.0, 30.0, 50.0]), ("femur.stl", [8.0, 8.0, 40.0])].map(|(name, half)| {
            let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { half[k] } else { -half[k] });
            let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
            let vertex = |i: usize| format!("vertex {} {} {}\n", corner(i)[0], corner(i)[1], corner(i)[2]);
            let facet = |nodes: [usize; 3]| {
                format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", nodes.map(vertex).concat())
            };
            let path = folder.path().join(name);
            std::fs::write(&path, format!("solid\n{}endsolid\n", triangles.map(facet).collect::<String>()))
                .unwrap();
            path.to_str().unwrap().to_owned()
        });
    let output = run(&["mesh", "info", &skin]);
    let info = text(&output.stdout);
    assert!(info.contains("12 triangles") && info.contains("volume          3.600000e5"), "{info}");
    let scene = folder.path().join("scene.json");
    let scene = scene.to_str().unwrap();
    assert_eq!(run(&["scene", "from", &femur, &skin, "-o", scene]).status.code(), Some(0));
    let document: Value = serde_json::from_slice(&std::fs::read(scene).unwrap()).unwrap();
    let surfaces = &document["bodies"][0]["mesh"]["segmentation"]["surfaces"];
    assert_eq!((&surfaces[0]["part"], &surfaces[1]["hole"]), (&"skin".into(), &"femur".into()), "{document}");
    // Flat faces along the voxels are met where these end.
    let resolved = std::fs::read_to_string(scene)
        .unwrap()
        .replace("\"size_m\":", "\"voxel_size_m\": 0.001, \"size_m\":");
    std::fs::write(scene, resolved).unwrap();
    let answer = run(&["validate", scene]);
    let found = text(&answer.stdout);
    assert!(found.contains("/end_time_s") && !found.contains("/mesh"), "{found}");
    // The mesh has the volume between the surfaces.
    let full =
        std::fs::read_to_string(scene).unwrap().replace("\"end_time_s\": null", "\"end_time_s\": 0.001");
    std::fs::write(scene, full).unwrap();
    let mesh = folder.path().join("mesh.msh");
    let output = run(&["convert", scene, mesh.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let output = run(&["mesh", "info", "--json", mesh.to_str().unwrap()]);
    let info: Value = serde_json::from_slice(&output.stdout).unwrap();
    let volume = info["quality"]["volume"].as_f64().unwrap();
    let exact = 8e-9 * (30.0 * 30.0 * 50.0 - 8.0 * 8.0 * 40.0);
    assert!((volume / exact - 1.0).abs() < 0.01, "{volume} of {exact}");
    let output = run(&["scene", "from", &skin, "Cargo.toml"]);
    assert!(text(&output.stderr).contains("of several surfaces"), "{}", text(&output.stderr));
}
