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
