//! `contuse study error` as a program: solvers side by side, the geometry apart, pictures as SVG and, if built so, as PNG.

#![allow(clippy::expect_used, clippy::unwrap_used)] // a test may stop at the first surprise

use serde_json::{Value, json};
use std::process::{Command, Output};

fn study_error(arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_contuse"));
    program.args(["study", "error"]).args(arguments).output().expect("the program runs")
}

/// A soft ball that slides onto the floor for a few steps.
fn ball() -> Value {
    json!({
        "name": "drop", "end_time_s": 2e-4,
        "bodies": [{
            "name": "ball",
            "mesh": {"generator": {"kind": "solid_ball", "center_m": [0, 0, 0.0101], "radius_m": 0.01,
                     "elements_around": 2, "elements_through": 1}},
            "velocity_m_per_s": [1, 0, -5],
            "parts": [{"part": "ball", "density_kg_per_m3": 1000,
                "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7}}]
        }],
        "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn solvers_are_compared_the_geometry_is_separated_and_a_picture_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (scene, svg) = (file("scene.json"), file("out.svg"));
    std::fs::write(&scene, ball().to_string()).unwrap();
    let output =
        study_error(&[&scene, "--contact-solvers", "nsgs,newton", "--geometry", "--svg", &svg, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    let row = |name: &str| {
        let rows = study["rows"].as_array().unwrap();
        rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("no {name}: {study}"))
    };
    let impulse = |name: &str| row(name)["values"]["impulse_n_s"].as_f64().unwrap();
    for solver in ["nsgs", "newton"] {
        let by_solver = impulse(&format!("mesh 0, contact by {solver}"));
        assert!((by_solver / impulse("mesh 0") - 1.0).abs() < 1e-6, "{solver}: {by_solver}");
    }
    let geometry = &study["geometry"]["impulse_n_s"];
    let expected = 1.0 - impulse("mesh +1, on the facets") / impulse("mesh +1");
    assert!((geometry["change_by_surface"].as_f64().unwrap() - expected).abs() < 1e-12, "{geometry}");
    assert_eq!(row("mesh +1, on the facets")["elements"], row("mesh +1")["elements"]);
    let svg = std::fs::read_to_string(svg).unwrap();
    assert!(svg.starts_with("<svg width=\"1120\""), "{}", &svg[..80]);
}

#[test]
#[cfg(feature = "png")]
fn picture_is_drawn_as_png() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (scene, png) = (file("scene.json"), file("out.png"));
    std::fs::write(&scene, ball().to_string()).unwrap();
    let output = study_error(&[&scene, "--png", &png]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    // A PNG of twice the size of the SVG: signature, then the width in the header.
    let png = std::fs::read(png).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"), "{:?}", &png[..8]);
    assert_eq!(png[16..20], 2240_u32.to_be_bytes());
}

#[test]
#[cfg(not(feature = "png"))]
fn a_program_without_png_says_so_before_it_runs_anything() {
    let output = study_error(&["scene.json", "--png", "out.png"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("--svg FILE") && said.contains("--features png"), "{said}");
}

#[test]
fn a_solver_that_is_none_is_answered_with_those_that_there_are() {
    let output = study_error(&["scene.json", "--contact-solvers", "lemke"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("[possible values: hybrid, nsgs, newton"), "{said}");
}
