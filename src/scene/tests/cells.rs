//! Meshes with cells that have no finite element.

use super::*;

/// Gmsh 2.2: a unit cube of part "cube", with tetrahedra of part "tip" and a wedge of part "ramp" next to it, or without
/// the cube.
fn mesh(with_cube: bool) -> Vec<u8> {
    let cube = if with_cube { "9 5 2 1 1 1 2 3 4 5 6 7 8\n" } else { "" };
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n3 1 \"cube\"\n3 2 \"tip\"\n3 3 \"ramp\"\n\
         $EndPhysicalNames\n$Nodes\n11\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n\
         9 0 0 2\n10 2 0 0\n11 2 1 0\n$EndNodes\n$Elements\n{}\n{cube}\
         1 4 2 2 2 5 6 7 9\n2 4 2 2 2 5 7 8 9\n3 6 2 3 3 2 10 6 3 11 7\n$EndElements\n",
        3 + u32::from(with_cube)
    )
    .into_bytes()
}

/// Problems of a scene whose bodies have such files.
fn refusals(document: &Value) -> Vec<Problem> {
    let files = Files(vec![("mixed.msh", mesh(true)), ("tips.msh", mesh(false))]);
    let Problems(found) = load(document.to_string().as_bytes(), &files, &Budget::COMMAND_LINE).unwrap_err();
    found.into_iter().filter(|p| p.code == "bad_mesh").collect()
}

#[test]
fn kinds_without_an_element_are_counted_in_every_body_at_once() {
    let mut document = with("/bodies/0/mesh", json!({"file": {"name": "mixed.msh"}}));
    set(&mut document, "/bodies/1/mesh", json!({"file": {"name": "tips.msh", "refine": 1}}));
    let found = refusals(&document);
    let places: Vec<&str> = found.iter().map(|p| p.pointer.as_str()).collect();
    assert_eq!(places, ["/bodies/0/mesh/file/name", "/bodies/1/mesh/file/name"], "{found:#?}");
    for problem in &found {
        assert_eq!(
            problem.message,
            "only eight-node hexahedra have a finite element here, but the mesh has tetrahedron of 4 nodes (2), prism of 6 nodes (1)"
        );
        assert_eq!(problem.limit, "eight-node hexahedra");
    }
    assert!(found[0].remedy.contains("\"parts\"") && !found[1].remedy.contains("\"parts\""), "{found:#?}");
}

#[test]
fn parts_of_hexahedra_alone_can_be_chosen_from_a_mixed_file() {
    let mesh = |part: &str| json!({"file": {"name": "mixed.msh", "parts": [part]}});
    assert_eq!(refusals(&with("/bodies/0/mesh", mesh("cube"))).len(), 0);
    assert_eq!(refusals(&with("/bodies/0/mesh", mesh("tip"))).len(), 1);
}
