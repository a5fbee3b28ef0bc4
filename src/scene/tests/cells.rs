//! Meshes of other cells than hexahedra.

use super::*;

/// Gmsh 2.2: a unit cube of part "cube", with tetrahedra of part "tip" and a wedge of part "ramp" next to it, or without
/// the cube.
fn mesh(with_cube: bool) -> Vec<u8> {
    let cube = if with_cube { "9 5 2 1 1 1 2 3 4 5 6 7 8\n" } else { "" };
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n3 1 \"cube\"\n3 2 \"tip\"\n3 3 \"ramp\"\n\
         $EndPhysicalNames\n$Nodes\n11\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n\
         9 0 0 2\n10 2 0 0\n11 2 1 0\n$EndNodes\n$Elements\n{}\n{cube}\
         1 4 2 2 2 5 6 7 9\n2 4 2 2 2 5 7 8 9\n3 6 2 3 3 2 6 10 3 7 11\n$EndElements\n",
        3 + u32::from(with_cube)
    )
    .into_bytes()
}

/// Problems of a scene whose bodies have such files.
fn problems(document: &Value) -> Vec<Problem> {
    let files = Files(vec![("mixed.msh", mesh(true)), ("tips.msh", mesh(false))]);
    match load(document.to_string().as_bytes(), &files, &Budget::COMMAND_LINE) {
        Ok(loaded) => loaded.warnings,
        Err(Problems(found)) => found,
    }
}

/// A scene whose first body is the mixed mesh, one part of every kind.
fn mixed() -> Value {
    let mut document = with("/bodies/0/mesh", json!({"file": {"name": "mixed.msh"}}));
    set(&mut document, "/bodies/0/parts/0/part", json!("*"));
    document
}

fn of_code<'a>(found: &'a [Problem], code: &str) -> Vec<(&'a str, &'a str)> {
    found.iter().filter(|p| p.code == code).map(|p| (p.pointer.as_str(), p.message.as_str())).collect()
}

#[test]
fn every_kind_has_its_default_formulation_and_those_that_it_has_not_are_refused() {
    let found = problems(&mixed());
    assert!(
        of_code(&found, "formulation_of_element").is_empty() && of_code(&found, "bad_mesh").is_empty(),
        "{found:#?}"
    );
    for formulation in ["reduced", "mean_dilatation_single"] {
        let mut document = mixed();
        set(&mut document, "/bodies/0/parts/0/formulation", json!(formulation));
        let found = problems(&document);
        let refused = of_code(&found, "formulation_of_element");
        assert_eq!(refused.len(), 2, "{found:#?}");
        for (place, message) in refused {
            assert_eq!(place, "/bodies/0/parts/0/formulation");
            let is_named = message.contains("tetrahedron of 4 nodes") || message.contains("prism of 6 nodes");
            assert!(is_named, "{message}");
        }
    }
}

#[test]
fn what_averaged_pressure_has_not_is_refused_all_at_once() {
    let mut document = mixed();
    set(&mut document, "/integrator", json!({"kind": "implicit", "step_s": 1e-5, "energy_momentum": true}));
    set(&mut document, "/bodies/0/parts/0/erosion", json!({"stretch": 2.0}));
    set(
        &mut document,
        "/bodies/0/parts/0/softening",
        json!({"onset_j_per_m3": 1e5, "fracture_energy_j_per_m2": 1e3}),
    );
    let found = problems(&document);
    let places: Vec<&str> = of_code(&found, "averaged_pressure").iter().map(|(place, _)| *place).collect();
    assert_eq!(
        places,
        ["/bodies/0/parts/0/softening", "/bodies/0/parts/0/erosion", "/integrator/energy_momentum"],
        "{found:#?}"
    );
    // Other implicit steps they have.
    set(&mut document, "/integrator/energy_momentum", json!(false));
    assert_eq!(of_code(&problems(&document), "averaged_pressure").len(), 2);
    // Fully integrated their pressure is their own.
    set(&mut document, "/bodies/0/parts/0/formulation", json!("full"));
    assert!(of_code(&problems(&document), "averaged_pressure").is_empty());
}
