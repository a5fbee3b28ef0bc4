use crate::mesh::read::tests::{NODES, is_one_of_each, malformed, never_panics_on_damage};
use crate::mesh::read::{MeshFormat, read_mesh};
use crate::mesh::{Mesh, MeshError};

fn file() -> String {
    let node =
        |(tag, [x, y, z]): (u32, [f64; 3])| format!("GRID    {tag:>8}        {x:>8.3}{y:>8.3}{z:>8.3}\n");
    let nodes: String = (1..).zip(NODES).map(node).collect();
    format!(
        "SOL 101\nCEND\nBEGIN BULK\n$ nodes\n{nodes}CTETRA,1,7,1,2,4,5,9,10,+A\n+A,11,12,13,14\n\
         CHEXA          2       7       1       2       3       4       5       6+B      \n\
         +B             7       8\n\
         CPENTA,3,7,1,2,3,5,6,7\nCTETRA*,4,2,1,2\n*,4,5\nCQUAD4,5,9,1,2,3,4,0.0\nPSOLID,7,1\nMAT1,1,1.+6,,0.3\nENDDATA\n"
    )
}

fn read(text: &str) -> Result<Mesh, MeshError> {
    read_mesh(text.as_bytes(), MeshFormat::Nastran)
}

#[test]
fn every_kind_of_element() {
    let mesh = read(&file()).unwrap();
    is_one_of_each(&mesh);
    assert_eq!(mesh.parts, ["part_2", "part_7"]);
    assert_eq!(mesh.part_of, [1, 1, 1, 0]);
    assert_eq!(mesh.node_sets["part_9"], [0, 1, 2, 3]);
    assert_eq!(mesh.notes, ["entries not used: MAT1 (line 28), PSOLID (line 27)"]);
}

#[test]
fn files_without_their_end_are_noted() {
    let text = file().replace("ENDDATA\n", "");
    let notes = read(&text).unwrap().notes;
    assert!(notes.iter().any(|note| note.contains("no ENDDATA")), "{notes:?}");
    let notes = read(text.trim_end()).unwrap().notes;
    assert!(notes.iter().any(|note| note.contains("last line of the file has no line break")), "{notes:?}");
}

#[test]
fn errors_name_the_line() {
    let broken = |from: &str, to: &str| malformed(&file().replacen(from, to, 1), MeshFormat::Nastran);
    let node = "GRID           2           1.000   0.000";
    assert_eq!(
        broken(node, "GRID           1           1.000   0.000"),
        (6, "node 1 is defined twice".into())
    );
    let found = broken(node, "GRID           2             nan   0.000");
    assert_eq!(found, (6, "expected a finite coordinate, found \"nan\"".into()));
    assert_eq!(broken(node, "GRID          -2           1.000   0.000").1, "expected a number, found \"-2\"");
    assert_eq!(
        broken("+B             7       8", "+B             7      88"),
        (21, "there is no node 88".into())
    );
    assert_eq!(
        broken("+B             7       8", "+B             7"),
        (21, "expected a number, found \"\"".into())
    );
    assert_eq!(broken("CPENTA,3", "CPENTA,2"), (23, "element 2 is defined twice".into()));
}

#[test]
fn what_is_not_understood_is_refused() {
    let with = |from: &str, to: &str| read(&file().replacen(from, to, 1)).unwrap_err();
    let added = "CPYRAM,8,7,1,2,3,4,5\nCTETRA,9,7,1,2,4,5,9\nCPENTA,3,7,1,2,3,5,6,7,+\n+,9,10\nCTETRA*";
    let error = with("CPENTA,3,7,1,2,3,5,6,7\nCTETRA*", added);
    let kinds = ["prism of 15 nodes (1)", "pyramid (1)", "tetrahedron of 10 nodes without some of them (1)"];
    assert_eq!(error, MeshError::UnsupportedElements { kinds: kinds.map(str::to_owned).to_vec() });
    for other in ["GRID,99,3,1.,1.,1.", "INCLUDE 'x.bdf'", "GRDSET,,3", "=,*1"] {
        let error = with("PSOLID,7,1", other);
        assert!(
            matches!(&error, MeshError::Unsupported { what, .. } if what.starts_with("line 27: ")),
            "{error}"
        );
    }
}

#[test]
fn damaged_files_never_panic() {
    never_panics_on_damage(file().as_bytes(), MeshFormat::Nastran);
}

#[test]
fn files_in_utf_16_are_refused_with_a_remedy() {
    for (mark, bytes) in
        [([0xff, 0xfe], u16::to_le_bytes as fn(u16) -> [u8; 2]), ([0xfe, 0xff], u16::to_be_bytes)]
    {
        let text = file().encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
        let error = read_mesh(&[&mark[..], &text].concat(), MeshFormat::Nastran).unwrap_err().to_string();
        assert!(error.contains("UTF-16") && error.contains("iconv"), "{error}");
    }
}
