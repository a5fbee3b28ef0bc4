use crate::mesh::read::tests::{NODES, is_one_of_each, malformed, never_panics_on_damage};
use crate::mesh::read::{MeshFormat, read_mesh};
use crate::mesh::{Mesh, MeshError};

/// A file of version 4.0.
fn file() -> String {
    let node = |(tag, [x, y, z]): (u32, [f64; 3])| format!("<node id=\"{tag}\">{x},{y}, {z}</node>\n");
    let nodes: String = (1..).zip(NODES).map(node).collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<febio_spec version=\"4.0\">\n<Module type=\"solid\"/>\n\
         <Material>\n<material id=\"1\"/>\n</Material>\n<Mesh>\n<Nodes name=\"all\">\n{nodes}</Nodes>\n\
         <Elements type=\"tet10\" name=\"muscle\">\n<elem id=\"1\">1,2,4,5,9,10,11,12,13,14</elem>\n</Elements>\n\
         <Elements type=\"hex8\" name=\"bone\">\n<elem id=\"2\">1,2,3,4,5,6,7,8</elem>\n</Elements>\n\
         <Elements type=\"penta6\" name=\"fat\">\n<elem id=\"3\"> 1, 2, 3, 5, 6, 7 </elem>\n</Elements>\n\
         <Elements type=\"TET4\" name=\"muscle\">\n<elem id=\"4\">1,2,4,5</elem>\n</Elements>\n\
         <Elements type=\"tri3\" name=\"skin\">\n<elem id=\"5\">1,2,3</elem>\n</Elements>\n\
         <NodeSet name=\"bottom\">1,2,3,\n4</NodeSet>\n<ElementSet name=\"soft\">4,5</ElementSet>\n\
         <Surface name=\"bottom\">\n<quad4 id=\"1\">5,6,7,8</quad4>\n</Surface>\n<PartList name=\"both\">a,b</PartList>\n\
         </Mesh>\n<MeshDomains/>\n<Loads/>\n</febio_spec>\n"
    )
}

fn read(text: &str) -> Result<Mesh, MeshError> {
    read_mesh(text.as_bytes(), MeshFormat::Febio)
}

fn is_the_mesh(mesh: &Mesh) {
    is_one_of_each(mesh);
    assert_eq!(mesh.parts, ["muscle", "bone", "fat"]);
    assert_eq!(mesh.part_of, [0, 1, 2, 0]);
    assert_eq!(mesh.node_sets["bottom"], [0, 1, 2, 3]);
    assert_eq!(mesh.node_sets["bottom_surface"], [4, 5, 6, 7]);
    assert_eq!(mesh.node_sets["skin"], [0, 1, 2]);
    assert_eq!(mesh.node_sets["soft"], [0, 1, 2, 3, 4]);
}

#[test]
fn meshes_of_each_version() {
    let mesh = read(&file()).unwrap();
    is_the_mesh(&mesh);
    let unread = "PartList (line 45), Material (line 4), MeshDomains (line 47), Loads (line 48)";
    assert_eq!(mesh.notes, [format!("only the mesh is read; not used: {unread}")]);
    // Sets of earlier versions list elements with numbers.
    let old = file()
        .replace("1,2,3,\n4</NodeSet>", "<n id=\"1\"/><n id=\"2\"/><n id=\"3\"/><n id=\"4\"/></NodeSet>")
        .replace("4,5</ElementSet>", "<e id=\"4\"/><e id=\"5\"/></ElementSet>");
    is_the_mesh(&read(&old.replace("version=\"4.0\"", "version=\"3.0\"")).unwrap());
    let geometry = old.replace("Mesh>", "Geometry>").replace("version=\"4.0\"", "version=\"2.5\"");
    is_the_mesh(&read(&geometry).unwrap());
    for version in ["1.2", "2.0", "5.0"] {
        let error = read(&file().replace("4.0", version)).unwrap_err();
        assert!(matches!(error, MeshError::Unsupported { .. }), "{error}");
    }
}

#[test]
fn errors_name_the_line() {
    let broken = |from: &str, to: &str| malformed(&file().replacen(from, to, 1), MeshFormat::Febio);
    let node = "<node id=\"2\">1,0, 0</node>";
    assert_eq!(broken(node, "<node id=\"1\">1,0,0</node>"), (10, "node 1 is defined twice".into()));
    let found = broken(node, "<node id=\"2\">1,NaN,0</node>");
    assert_eq!(found, (10, "expected a finite coordinate, found \"NaN\"".into()));
    assert_eq!(broken(node, "<node id=\"2\">1,0</node>").1, "expected a finite coordinate, found \"\"");
    assert_eq!(broken(node, "<node id=\"2\">1,0,0,0</node>").1, "node 2 has more than three coordinates");
    assert_eq!(broken(node, "<node id=\"-2\">1,0,0</node>").1, "expected a number as id, found \"-2\"");
    assert_eq!(broken(node, "<node>1,0,0</node>").1, "<node> has no attribute id");
    assert_eq!(broken("1,2,3,4,5,6,7,8<", "1,2,3,4,5,6,7,88<"), (28, "there is no node 88".into()));
    assert_eq!(broken("1,2,3,4,5,6,7,8<", "1,2,3,4<"), (28, "a hexahedron of 8 nodes with 4 nodes".into()));
    assert_eq!(broken("elem id=\"2\"", "elem id=\"1\""), (28, "element 1 is defined twice".into()));
    assert_eq!(broken("4,5</ElementSet>", "4,6</ElementSet>"), (41, "there is no element 6".into()));
    assert_eq!(broken("<febio_spec", "<feb").0, 49);
    assert!(broken("<Mesh>", "<Gitter>").1.contains("Gitter"));
}

#[test]
fn what_is_not_understood_is_refused() {
    let with = |from: &str, to: &str| read(&file().replacen(from, to, 1)).unwrap_err();
    let error = with("type=\"hex8\"", "type=\"hex20\"");
    assert_eq!(error, MeshError::UnsupportedElements { kinds: vec!["hex20 (1)".into()] });
    let error = with("<Mesh>", "<Mesh from=\"other.feb\">");
    assert!(matches!(error, MeshError::Unsupported { .. }), "{error}");
    for elsewhere in [
        "<Include>other.feb</Include>\n<Mesh>",
        "<Material from=\"other.feb\"/>\n<Mesh>",
        "<Mesh><Include>other.feb</Include>",
    ] {
        let error = with("<Mesh>", elsewhere).to_string();
        assert!(error.contains("line ") && error.contains("of another file"), "{error}");
    }
}

#[test]
fn short_files_cannot_ask_for_endless_work() {
    let many = format!("<ElementSet name=\"x\">{}1</ElementSet>", "1,".repeat(100_000));
    let error = read(&file().replace("</Mesh>", &format!("{many}</Mesh>"))).unwrap_err();
    assert!(matches!(error, MeshError::Unsupported { .. }), "{error}");
}

#[test]
fn damaged_files_never_panic() {
    never_panics_on_damage(file().as_bytes(), MeshFormat::Febio);
}
