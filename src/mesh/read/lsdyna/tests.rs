use super::begins;
use crate::mesh::read::tests::{NODES, is_one_of_each, malformed, never_panics_on_damage};
use crate::mesh::read::{FieldNames, MeshFormat, read_mesh, read_mesh_with};
use crate::mesh::{Mesh, MeshError, Place};

/// A line of numbers, each right-aligned in this many columns.
fn row(width: usize, numbers: &[i64]) -> String {
    numbers.iter().map(|n| format!("{n:>width$}")).collect::<Vec<_>>().concat() + "\n"
}

/// Nodes in fields of this many columns for their numbers, and of this many for coordinates.
fn nodes(width: usize, wide: usize) -> String {
    let line = |(tag, [x, y, z]): (u32, [f64; 3])| {
        format!("{tag:>width$}{x:>wide$.3}{y:>wide$.3}{z:>wide$.3}{:>width$}{:>width$}\n", 0, 0)
    };
    (1..).zip(NODES).map(line).collect()
}

/// Each element on one line, as up to version 970, and the ten-node tetrahedron on two.
fn each(width: usize) -> String {
    let two = row(width, &[1, 7]) + &row(width, &[1, 2, 4, 5, 9, 10, 11, 12, 13, 14]);
    let one = row(width, &[2, 7, 1, 2, 3, 4, 5, 6, 7, 8]);
    let wedge = row(width, &[3, 7, 1, 2, 3, 3, 5, 6, 7, 7]);
    two + &one + &wedge + &row(width, &[4, 8, 1, 2, 4, 5, 5, 5, 5, 5])
}

fn deck() -> String {
    let (nodes, each) = (nodes(8, 16), each(8));
    let sets = "*SET_NODE_LIST_TITLE\nbottom\n$ a comment\n         3\n         1         2         3         4\n\
                *SET_NODE_LIST_GENERATE\n         4\n         1         2         7         8\n\
                *SET_NODE_GENERAL\n         5\nPART               8\nNODE               3\n\
                *SET_NODE_ADD\n         6\n         3         4\n\
                *SET_PART_LIST\n         7\n         8         0\n\
                *SET_SEGMENT_TITLE\n\n         8\n         5         6         7         8       0.0\n";
    format!(
        "$# made by hand\n*KEYWORD\n*TITLE\nall kinds\n*PART\nmuscle\n         7         1         1\n\
         \n         8         1         1\n*NODE\n$#   nid               x\n{nodes}*ELEMENT_SOLID\n{each}\
         *ELEMENT_SHELL\n{}*MAT_ELASTIC\n         1    1000.0     1.0E6\n{sets}*END\nrest\n",
        row(8, &[9, 7, 1, 2, 3, 3])
    )
}

fn is_the_deck(mesh: &Mesh) {
    is_one_of_each(mesh);
    assert_eq!(mesh.parts, ["muscle", "part_8"]);
    assert_eq!(mesh.part_of, [0, 0, 0, 1]);
    assert_eq!(mesh.node_sets["bottom"], [0, 1, 2, 3]);
    assert_eq!(mesh.node_sets["set_4"], [0, 1, 6, 7]);
    assert_eq!(mesh.node_sets["set_5"], [0, 1, 2, 3, 4]);
    assert_eq!(mesh.node_sets["set_6"], [0, 1, 2, 3, 6, 7]);
    assert_eq!(mesh.node_sets["set_7"], [0, 1, 3, 4]);
    assert_eq!(mesh.node_sets["set_8"], [4, 5, 6, 7]);
    assert_eq!(mesh.node_sets["muscle"], [0, 1, 2], "of the shell");
    assert!(mesh.notes[0].starts_with("keywords not used: *MAT_ELASTIC (line "), "{:?}", mesh.notes);
}

fn read(text: &str) -> Result<Mesh, MeshError> {
    read_mesh(text.as_bytes(), MeshFormat::LsDyna)
}

#[test]
fn every_kind_of_element_and_set() {
    is_the_deck(&read(&deck()).unwrap());
    is_the_deck(&read(&deck().replace('\n', "\r\n")).unwrap());
}

#[test]
fn wide_and_separated_fields() {
    let (standard_nodes, standard_each) = (nodes(8, 16), each(8));
    let with = |keyword: &str, sign: &str, nodes: String, each: String| {
        let text = deck().replace(&standard_nodes, &nodes).replace(&standard_each, &each);
        let text = text.replace("*NODE\n", &format!("*node{sign}\n"));
        text.replace("*ELEMENT_SOLID\n", &format!("*Element_Solid{sign}\n")).replace("*KEYWORD\n", keyword)
    };
    is_the_deck(&read(&with("*KEYWORD\n", "+", nodes(20, 20), each(20))).unwrap());
    is_the_deck(&read(&with("*KEYWORD\n", " %", nodes(10, 16), each(10))).unwrap());
    // Long fields in the whole deck, with a way back for the rest.
    let long = with("*KEYWORD LONG=Y\n", "", nodes(20, 20), each(20));
    let short = |name: &str| (format!("{name}\n"), format!("{name}-\n"));
    let names =
        ["*PART", "*ELEMENT_SHELL", "*SET_NODE_LIST_TITLE", "*SET_NODE_LIST_GENERATE", "*SET_NODE_GENERAL"];
    let others = ["*SET_NODE_ADD", "*SET_PART_LIST", "*SET_SEGMENT_TITLE"];
    let long = names
        .iter()
        .chain(&others)
        .map(|name| short(name))
        .fold(long, |text, (from, to)| text.replace(&from, &to));
    is_the_deck(&read(&long).unwrap());
    let commas = |text: &str| {
        let line = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(", ") + "\n";
        text.lines().map(line).collect::<String>()
    };
    is_the_deck(&read(&with("*KEYWORD\n", "", commas(&standard_nodes), commas(&standard_each))).unwrap());
}

#[test]
fn parts_of_one_title_are_distinguished() {
    let text = deck().replace("\n\n         8         1", "\nmuscle\n         8         1");
    assert_eq!(read(&text).unwrap().parts, ["muscle_7", "muscle_8"]);
}

#[test]
fn keyword_files_are_known_by_their_beginning() {
    assert!(begins(deck().as_bytes()) && begins(b"*KEYWORD\n*NODE") && begins(b"$ x\n*NODE\n"));
    assert!(!begins(b"*NODE\n1, 2\n") && !begins(b"*HEADING\n") && !begins(b"$MeshFormat\n2.2"));
}

#[test]
fn errors_name_the_line() {
    let broken = |from: &str, to: &str| malformed(&deck().replacen(from, to, 1), MeshFormat::LsDyna);
    let node = "       2           1.000           0.000";
    let same = broken(node, "       1           1.000           0.000");
    assert_eq!(same, (13, "node 1 is defined twice".into()));
    let found = broken(node, "       2             nan           0.000");
    assert_eq!(found, (13, "expected a finite coordinate, found \"nan\"".into()));
    assert_eq!(
        broken(node, "      -2           1.000           0.000"),
        (13, "expected a number, found \"-2\"".into())
    );
    assert_eq!(
        broken("       2       7       1", "       1       7       1"),
        (29, "element 1 is defined twice".into())
    );
    assert_eq!(
        broken("       2       7       1", "       2       7      77"),
        (29, "there is no node 77".into())
    );
    let wedge = "       3       7       1       2       3       3       5       6       7       7";
    let (line, message) = broken(wedge, "       3       7       1       2       3       3       5");
    assert_eq!((line, message.as_str()), (30, "a solid element has 4, 8 or 10 nodes, not 5"));
    let begun = broken(wedge, "       3       7\n*NODE\n");
    assert_eq!(begun, (30, "element 3 has no nodes".into()));
    assert_eq!(
        broken("         3         4\n*SET_PART", "         3        44\n*SET_PART").1,
        "there is no set of nodes 44"
    );
    assert!(broken("         1         2         7         8", "         2         1").1.contains("pairs"));
    let parameter = broken("         1         2         3         4\n*SET", "        &n\n*SET");
    assert_eq!(parameter, (40, "expected a number, found \"&n\"".into()));
}

#[test]
fn what_is_not_understood_is_refused_with_its_line() {
    let with = |from: &str, to: &str| read(&deck().replacen(from, to, 1)).unwrap_err();
    for keyword in ["ELEMENT_SOLID_TET4TOTET10", "ELEMENT_SOLID_ORTHO", "NODE_TRANSFORM", "INCLUDE_TRANSFORM"]
    {
        let error = with("*MAT_ELASTIC", &format!("*{keyword}"));
        assert!(matches!(error, MeshError::Unsupported { .. }), "{error}");
        assert!(error.to_string().starts_with("line 34: ") && error.to_string().contains(keyword), "{error}");
    }
    assert!(with("PART               8", "BOX                8").to_string().contains("BOX"));
    let pyramid = row(8, &[5, 7, 1, 2, 3, 4, 5, 5, 5, 5]);
    let thick = format!("*ELEMENT_TSHELL\n{pyramid}");
    let error = with("*ELEMENT_SHELL", &format!("{pyramid}{thick}*ELEMENT_SHELL"));
    let kinds = vec!["pyramid of 5 nodes (1)".into(), "thick shell (1)".into()];
    assert_eq!(error, MeshError::UnsupportedElements { kinds });
}

/// The deck with its nodes in another file, as read with these files.
fn with_files(files: &[(&str, String)]) -> Result<Mesh, MeshError> {
    let main =
        deck().replace(&format!("*NODE\n$#   nid               x\n{}", nodes(8, 16)), "*INCLUDE\nnodes.k\n");
    read_mesh_with(main.as_bytes(), MeshFormat::LsDyna, &FieldNames::NONE, &mut |name| {
        let found = files.iter().find(|(known, _)| *known == name);
        found.map(|(_, text)| text.clone().into_bytes()).ok_or_else(|| "it does not exist".to_owned())
    })
}

#[test]
fn included_files_are_read_in_their_place() {
    let all = format!("*KEYWORD\n*NODE\n{}*END\n*NODE\nrubbish\n", nodes(8, 16));
    is_the_deck(&with_files(&[("nodes.k", all.clone())]).unwrap());
    // A name over two lines, in a file that is included itself.
    let more = [("nodes.k", "*INCLUDE\nfolder/ +\nmore.k\n".to_owned()), ("folder/more.k", all.clone())];
    is_the_deck(&with_files(&more).unwrap());
    let broken = all.replacen("1.000", "x.000", 1);
    match with_files(&[("nodes.k", broken)]) {
        Err(MeshError::Malformed { place, message }) => {
            assert_eq!(place, Place::LineOf { file: "nodes.k".into(), line: 4 });
            assert!(message.contains("x.000"), "{message}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn includes_that_do_not_end_are_refused() {
    let refused = |files: &[(&str, String)]| match with_files(files) {
        Err(MeshError::Unsupported { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    assert!(refused(&[]).contains("line 11: the included file \"nodes.k\" is not read: it does not exist"));
    let circle = [("nodes.k", "*INCLUDE\nb.k\n".to_owned()), ("b.k", "*INCLUDE\nnodes.k\n".to_owned())];
    assert!(
        refused(&circle)
            .contains("line 2 of b.k: the included file \"nodes.k\" is this file, or one that includes it")
    );
    let alone =
        [("nodes.k", "*INCLUDE\n./nodes.k\n".to_owned()), ("./nodes.k", "*INCLUDE\n./nodes.k\n".to_owned())];
    assert!(refused(&alone).contains("line 2 of nodes.k: the included file \"./nodes.k\" is this file"));
    let names: Vec<String> = (0..20).map(|i| format!("{i}.k")).collect();
    let mut chain = vec![("nodes.k", "*INCLUDE\n0.k\n".to_owned())];
    chain.extend((0..19).map(|i| (names[i].as_str(), format!("*INCLUDE\n{}.k\n", i + 1))));
    assert!(refused(&chain).contains("deeper than 10"));
    let many = (0..200).map(|_| "*INCLUDE\nb.k\n").collect::<String>();
    assert!(refused(&[("nodes.k", many), ("b.k", String::new())]).contains("more than 100"));
    assert!(matches!(read("*KEYWORD\n*INCLUDE\nx.k\n"), Err(MeshError::Unsupported { .. })));
}

#[test]
fn sets_of_sets_of_sets_have_all_nodes_and_no_circles() {
    let more = |members: &str| {
        format!("*SET_NODE_ADD\n        10\n{members}*SET_NODE_ADD\n        11\n        10\n*END")
    };
    let mesh = read(&deck().replace("*END", &more("         6\n"))).unwrap();
    assert_eq!(mesh.node_sets["set_11"], mesh.node_sets["set_6"]);
    let circle = deck().replace("*END", &more("        11\n"));
    let line = circle.lines().position(|line| line == "        11").unwrap() + 2;
    let found = malformed(&circle, MeshFormat::LsDyna);
    assert!(found.1.contains("is a member of itself") && found.0 >= line - 1, "{found:?} {line}");
}

#[test]
fn notes_name_the_line_of_the_first_of_each_keyword() {
    let text = deck().replace("*END", "*LOAD_BODY_Z\n1\n*LOAD_BODY_Z\n1\n*END");
    let line = |word: &str| text.lines().position(|line| line == word).unwrap() + 1;
    let expected = format!(
        "keywords not used: *LOAD_BODY_Z (2, first in line {}), *MAT_ELASTIC (line {})",
        line("*LOAD_BODY_Z"),
        line("*MAT_ELASTIC")
    );
    assert_eq!(read(&text).unwrap().notes, [expected]);
}

#[test]
fn short_files_cannot_ask_for_endless_work() {
    let range = "*SET_NODE_LIST_GENERATE\n         9\n1, 18446744073709551615\n";
    let error = read(&deck().replace("*END", &format!("{range}*END"))).unwrap_err();
    assert!(matches!(error, MeshError::Unsupported { .. }), "{error}");
    let all = (100..9000)
        .map(|i| format!("*SET_NODE_GENERAL\n{i:>10}\n{}", "ALL\n".repeat(20)))
        .collect::<Vec<_>>()
        .concat();
    let mesh = read(&deck().replace("*END", &format!("{all}*END"))).unwrap();
    assert_eq!(mesh.node_sets["set_100"].len(), 14);
    let parts = "7, 7, 7, 7, 7, 7, 7, 7\n".repeat(4000);
    let sets = (100..300).map(|i| format!("*SET_PART\n{i}\n{parts}")).collect::<Vec<_>>().concat();
    let error = read(&deck().replace("*END", &format!("{sets}*END"))).unwrap_err();
    assert!(matches!(error, MeshError::Unsupported { .. }), "{error}");
}

#[test]
fn damaged_files_never_panic() {
    never_panics_on_damage(deck().as_bytes(), MeshFormat::LsDyna);
}
