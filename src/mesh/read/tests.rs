//! Tests of all readers: the same mesh from every format, errors with their place, no panic on any bytes.
#![allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic; exactly is what is meant

use super::*;
use crate::mechanics::tensor::Vec3;
use crate::mesh::generate::block::Block;
use crate::mesh::generate::hollow_ball::HollowBall;
use crate::mesh::generate::limb_segment::LimbSegment;
use crate::mesh::quality::quality;
use crate::mesh::surface::{boundary, boundary_nodes, topology_problems};
use crate::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use crate::mesh::{CellKind, Place};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

const MSH: &[u8] = include_bytes!("../../../scenarios/ball_on_block/scene_L0.msh");
const INP: &[u8] = include_bytes!("../../../scenarios/ball_on_block/scene_L0.inp");

const ALL: [(Version, Encoding); 6] = [
    (Version::V2_2, Encoding::Ascii),
    (Version::V2_2, Encoding::LittleEndian),
    (Version::V2_2, Encoding::BigEndian),
    (Version::V4_1, Encoding::Ascii),
    (Version::V4_1, Encoding::LittleEndian),
    (Version::V4_1, Encoding::BigEndian),
];

/// The mesh without what a file cannot store: axes and notes.
fn bare(mesh: Mesh) -> Mesh {
    Mesh { axes: Vec::new(), notes: Vec::new(), ..mesh }
}

/// Reads files that were cut short, or have a few bytes replaced: they may be refused, and never panic.
pub(super) fn never_panics_on_damage(file: &[u8], format: MeshFormat) {
    let byte = (any::<prop::sample::Index>(), any::<u8>());
    let damage = (prop::collection::vec(byte, 1..6), any::<prop::sample::Index>());
    let mut runner = TestRunner::new(ProptestConfig::with_cases(400));
    let outcome = runner.run(&damage, |(damage, end)| {
        let _ = read_mesh(&file[..end.index(file.len())], format);
        let mut bytes = file.to_vec();
        for (place, value) in damage {
            let i = place.index(bytes.len());
            bytes[i] = value;
        }
        let _ = read_mesh(&bytes, format);
        Ok(())
    });
    outcome.unwrap();
}

fn small() -> Mesh {
    let mut mesh =
        Block::uniform(Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0), [2, 1, 1], "left").generate().unwrap();
    mesh.parts.push("right \"half\"".into());
    mesh.part_of = vec![0, 1];
    mesh
}

#[test]
fn every_encoding_of_gmsh_gives_the_limb_back() {
    let limb = bare(LimbSegment::default().generate().unwrap());
    for (version, encoding) in ALL {
        let bytes = write_gmsh(&limb, version, encoding);
        assert_eq!(MeshFormat::sniff(&bytes), Some(MeshFormat::Gmsh));
        let read = read_mesh(&bytes, MeshFormat::Gmsh).unwrap();
        assert_eq!(read, limb, "{version:?} {encoding:?}");
    }
}

#[test]
fn names_that_would_break_the_format_are_cleaned() {
    let read = read_mesh(&write_gmsh(&small(), Version::V4_1, Encoding::Ascii), MeshFormat::Gmsh).unwrap();
    assert_eq!(read.parts, ["left", "right _half_"]);
}

#[test]
fn ball_on_block_is_the_same_from_both_files() {
    let msh = read_mesh(MSH, MeshFormat::Gmsh).unwrap();
    let inp = read_mesh(INP, MeshFormat::Abaqus).unwrap();
    assert_eq!((msh.nodes.len(), msh.cells.len()), (3183, 2336));
    assert_eq!(msh.nodes, inp.nodes);
    assert_eq!(msh.cells, inp.cells);
    assert_eq!(msh.part_of, inp.part_of);
    assert_eq!(msh.parts, ["physical_1", "physical_2"]);
    assert_eq!(inp.parts, ["BLOCK", "BALL"]);
    assert_eq!(msh.node_sets.keys().collect::<Vec<_>>(), ["physical_3", "physical_4"]);
    assert_eq!(msh.node_sets["physical_3"], inp.node_sets["NTOP"]);
    assert_eq!(msh.node_sets["physical_4"], inp.node_sets["NOUT"]);
    assert_eq!(
        inp.node_sets["STOP"], inp.node_sets["NTOP"],
        "the faces of a surface have the nodes of the set"
    );
    assert_eq!(inp.node_sets["SOUT"], inp.node_sets["NOUT"]);
    assert_eq!(inp.node_sets["NALL"].len(), 3183);
    assert!(msh.notes.is_empty() && inp.notes.is_empty(), "{:?} {:?}", msh.notes, inp.notes);
    assert!(topology_problems(&msh.cells).is_empty());
    assert!(quality(&msh).unwrap().min_scaled_jacobian > 0.7);
}

#[test]
fn the_ball_of_the_file_is_the_ball_of_the_generator() {
    let ball = read_mesh(INP, MeshFormat::Abaqus).unwrap().select_parts(&["BALL"]).unwrap();
    assert_eq!(ball.cells.len(), 768);
    let mut outer_and_inner = ball.node_sets["NOUT"].clone();
    outer_and_inner.extend(
        boundary_nodes(&boundary(&ball.cells)).iter().filter(|a| !ball.node_sets["NOUT"].contains(a)),
    );
    let generated = HollowBall {
        center_m: [0.0, 0.0, 0.05 + 1e-5 + 0.015],
        outer_radius_m: 0.015,
        inner_radius_m: 0.012,
        elements_around: 8,
        elements_through: 2,
    }
    .generate()
    .unwrap();
    assert_eq!(ball.nodes.len(), generated.nodes.len());
    for x in &ball.nodes {
        let nearest = generated.nodes.iter().map(|y| (x - y).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-10, "no node of the generator at {x:?}, the nearest {nearest} m away");
    }
    assert!((ball.volume_m3() / generated.volume_m3() - 1.0).abs() < 1e-8);
}

#[test]
fn formats_are_known_by_name_and_by_their_beginning() {
    assert_eq!(MeshFormat::from_name("a/Scene.MSH"), Some(MeshFormat::Gmsh));
    assert_eq!(MeshFormat::from_name("b.inp"), Some(MeshFormat::Abaqus));
    assert_eq!(MeshFormat::from_name("c.vtu"), Some(MeshFormat::Vtu));
    assert_eq!(MeshFormat::from_name("c.vtp"), None);
    assert_eq!(MeshFormat::from_name("c.mhd"), Some(MeshFormat::MetaImage));
    assert_eq!(MeshFormat::from_name("msh"), None);
    assert_eq!(MeshFormat::sniff(MSH), Some(MeshFormat::Gmsh));
    assert_eq!(MeshFormat::sniff(INP), Some(MeshFormat::Abaqus));
    assert_eq!(MeshFormat::sniff(b"{}"), None);
}

/// Line and message of the error for this text.
pub(super) fn malformed(text: &str, format: MeshFormat) -> (usize, String) {
    match read_mesh(text.as_bytes(), format) {
        Err(MeshError::Malformed { place: Place::Line(line), message }) => (line, message),
        other => panic!("{other:?}"),
    }
}

const TWO_CUBES: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n13\n\
    100 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n\
    9 0 0 2\n10 1 0 2\n11 1 1 2\n12 0 1 2\n999999999 7 7 7\n$EndNodes\n\
    $Elements\n3\n1 5 2 7 1 100 2 3 4 5 6 7 8\n2 5 2 7 1 5 6 7 8 9 10 11 12\n3 3 2 -9 1 100 2 3 4\n$EndElements\n";

#[test]
fn sparse_numbers_unused_nodes_and_unnamed_groups() {
    let mesh = read_mesh(TWO_CUBES.as_bytes(), MeshFormat::Gmsh).unwrap();
    assert_eq!(mesh.nodes.len(), 12);
    assert_eq!(mesh.parts, ["physical_7"]);
    assert_eq!(mesh.node_sets["physical_9"], [0, 1, 2, 3]);
    assert_eq!(mesh.notes, ["1 nodes without a volume element were omitted"]);
    assert!((mesh.volume_m3() - 2.0).abs() < 1e-14);
}

#[test]
fn gmsh_errors_name_the_line() {
    let broken = |from: &str, to: &str| malformed(&TWO_CUBES.replacen(from, to, 1), MeshFormat::Gmsh);
    assert_eq!(broken("3 1 1 0", "3 1 nan 0"), (8, "a coordinate is NaN, not a finite number".into()));
    assert_eq!(broken("3 1 1 0", "3 1 x 0"), (8, "expected a coordinate, found \"x\"".into()));
    assert_eq!(broken("3 1 1 0", "2 1 1 0"), (8, "node 2 is defined twice".into()));
    assert_eq!(broken("5 6 7 8 9", "5 6 7 8 77"), (23, "there is no node 77".into()));
    assert_eq!(broken("1 5 2 7", "1 77 2 7"), (22, "element type 77 is unknown".into()));
    assert_eq!(broken("2 5 2 7 1 5", "1 5 2 7 1 5"), (23, "element 1 is defined twice".into()));
    assert_eq!(broken("3 3 2 -9", "1 3 2 -9"), (24, "element 1 is defined twice".into()));
    assert_eq!(broken("2.2 0 8", "2.2 0").0, 2);
    assert_eq!(broken("$EndNodes", "$EndNode").0, 19);
    let (line, message) = broken("$Nodes\n13", "$Nodes\n4000000000000");
    assert_eq!(line, 6);
    assert!(message.starts_with("4000000000000 nodes are declared, but only"), "{message}");
    let (_, message) = broken("$Elements\n3", "$Elements\n2");
    assert!(message.starts_with("expected $EndElements, found"), "{message}");
    assert_eq!(malformed("solid x", MeshFormat::Gmsh).0, 1);
    let oldest = read_mesh(b"$NOD\n8\n", MeshFormat::Gmsh).unwrap_err().to_string();
    assert!(oldest.contains("Gmsh format version 1"), "{oldest}");
}

#[test]
fn gmsh_refuses_what_it_does_not_understand_by_name() {
    let with = |from: &str, to: &str| read_mesh(TWO_CUBES.replacen(from, to, 1).as_bytes(), MeshFormat::Gmsh);
    let error = with("2 5 2 7 1 5 6 7 8 9 10 11 12", "2 7 2 7 1 5 6 7 8 9").unwrap_err();
    assert_eq!(error, MeshError::UnsupportedElements { kinds: vec!["pyramid of 5 nodes (1)".into()] });
    assert!(error.to_string().contains("tetrahedron of 10 nodes, prism of 6 nodes"), "{error}");
    assert!(matches!(with("2.2 0 8", "4.0 0 8"), Err(MeshError::Unsupported { .. })));
    assert!(matches!(with("2.2 0 8", "2.2 1 4"), Err(MeshError::Unsupported { .. })));
    assert_eq!(read_mesh(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", MeshFormat::Gmsh), Err(MeshError::Empty));
}

#[test]
fn gmsh_names_make_parts_and_sets_and_other_sections_are_noted() {
    let names = "$PhysicalNames\n2\n3 7 \"the tissue\"\n2 9 \"bottom\"\n$EndPhysicalNames\n";
    let data = "$NodeData\n1\n\"T\"\n$EndNodeData\n";
    let text = TWO_CUBES.replacen("$Nodes", &format!("{names}{data}$Nodes"), 1);
    let mesh =
        read_mesh(format!("$Comments\nhello\n$EndComments\n{text}").as_bytes(), MeshFormat::Gmsh).unwrap();
    assert_eq!(mesh.parts, ["the tissue"]);
    assert_eq!(mesh.node_sets["bottom"], [0, 1, 2, 3]);
    assert_eq!(mesh.notes[0], "sections not used: NodeData");
}

const INPUT: &str = "*Heading\n a title, with commas\n** a comment\n*node, nset = All Nodes\n\
    1, 0., 0., 0.\n2, 1.D0,\n 3, 1., 1.\n4, 0., 1., 0.\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n\
    9,0,0,2\n10,1,0,2\n11,1,1,2\n12,0,1,2\n\
    *Element, type=c3d8r,\n elset=Low\n 1, 1,2,3,4,\n 5,6,7,8\n\
    *ELEMENT, TYPE=C3D8RH\n2, 5,6,7,8, 9,10,11,12\n\
    *ELEMENT, TYPE=S4R, ELSET=shell\n31, 9,10,\n11,12\n\
    *ELSET, ELSET=High, GENERATE\n2,2\n*Elset, elset=Both\nLOW, high\n\
    *NSET, NSET=odd, GENERATE\n1, 11, 2\n*NSET, NSET=some\nodd, 2\n\
    *SURFACE, NAME=top, TYPE=ELEMENT\nHigh, S2\n*SURFACE, NAME=odd\n1, s1\n\
    *MATERIAL, NAME=rubber\n*DENSITY\n1000.\n";

#[test]
fn abaqus_sets_surfaces_continuations_and_spellings() {
    let mesh = read_mesh(INPUT.as_bytes(), MeshFormat::Abaqus).unwrap();
    assert_eq!((mesh.nodes.len(), mesh.cells.len()), (12, 2));
    assert!((mesh.volume_m3() - 2.0).abs() < 1e-14);
    assert_eq!(mesh.parts, ["Low", "High"]);
    assert_eq!(mesh.part_of, [0, 1]);
    assert_eq!(mesh.node_sets["All Nodes"].len(), 12);
    assert_eq!(mesh.node_sets["odd"], [0, 2, 4, 6, 8, 10]);
    assert_eq!(mesh.node_sets["some"], [0, 1, 2, 4, 6, 8, 10]);
    assert_eq!(mesh.node_sets["top"], [8, 9, 10, 11]);
    assert_eq!(mesh.node_sets["shell"], [8, 9, 10, 11]);
    assert_eq!(mesh.node_sets["odd_surface"], [0, 1, 2, 3], "a set and a surface of one name are kept apart");
    assert_eq!(mesh.notes, ["keywords not used: *DENSITY (line 39), *MATERIAL (line 38)"]);
}

#[test]
fn a_solid_section_decides_over_the_set_of_the_elements() {
    let text = format!("{INPUT}*SOLID SECTION, ELSET=both, MATERIAL=rubber\n");
    assert_eq!(read_mesh(text.as_bytes(), MeshFormat::Abaqus).unwrap().parts, ["both"]);
    let text = format!("{text}*SOLID SECTION, ELSET=HIGH, MATERIAL=rubber\n");
    assert!(malformed(&text, MeshFormat::Abaqus).1.contains("two solid sections"));
}

#[test]
fn abaqus_errors_name_the_line() {
    let broken = |from: &str, to: &str| malformed(&INPUT.replacen(from, to, 1), MeshFormat::Abaqus);
    assert_eq!(broken("4, 0., 1., 0.", "4, 0., inf, 0.").0, 8);
    assert_eq!(broken("4, 0., 1., 0.", "1, 0., 1., 0."), (8, "node 1 is defined twice".into()));
    assert_eq!(broken("9,10,11,12\n*ELEM", "9,10,11\n*ELEM"), (22, "an element of 8 nodes with 7".into()));
    assert_eq!(broken("2, 5,6,7", "2, 5,6,77"), (22, "there is no node 77".into()));
    assert_eq!(broken("2, 5,6,7", "1, 5,6,7"), (22, "element 1 is defined twice".into()));
    assert_eq!(broken("High, S2", "High, S7").0, 35);
    assert_eq!(broken("High, S2", "Hihg, S2"), (35, "there is no element set Hihg".into()));
    assert_eq!(broken("1, 11, 2", "1, 11, 0").0, 31);
    assert_eq!(broken("odd, 2", "even, 2"), (33, "no set even is defined above this line".into()));
}

#[test]
fn abaqus_refuses_what_it_does_not_understand_by_name() {
    let with = |from: &str, to: &str| read_mesh(INPUT.replacen(from, to, 1).as_bytes(), MeshFormat::Abaqus);
    let error = with("2, 5,6,7", "*ELEMENT, TYPE=C3D20\n2, 5,6,7").unwrap_err();
    assert_eq!(error, MeshError::UnsupportedElements { kinds: vec!["C3D20 (1)".into()] });
    for keyword in
        ["*INCLUDE, INPUT=other.inp", "*NGEN", "*PART\n*PART", "*INSTANCE\n1., 0., 0.", "*NODE, SYSTEM=C"]
    {
        let error = with("*MATERIAL", &format!("{keyword}\n*MATERIAL")).unwrap_err();
        assert!(matches!(error, MeshError::Unsupported { .. }), "{keyword}: {error}");
    }
    assert_eq!(read_mesh(b"*HEADING\n", MeshFormat::Abaqus), Err(MeshError::Empty));
}

/// Nodes of a unit cube, followed by the edge midpoints of the tetrahedron 1 2 4 5: first those in the plane z = 0, then
/// those on the edges from nodes 1, 2 and 4.
pub(super) const NODES: [[f64; 3]; 14] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];

/// A hexahedron, both tetrahedra and a wedge, which overlap: readers do not check that.
pub(super) fn is_one_of_each(mesh: &Mesh) {
    let kinds: Vec<CellKind> = mesh.cells.iter().map(|cell| cell.kind).collect();
    assert_eq!(kinds, [CellKind::Tet10, CellKind::Hex8, CellKind::Wedge6, CellKind::Tet4]);
    for (element, exact) in [1.0 / 6.0, 1.0, 0.5, 1.0 / 6.0].into_iter().enumerate() {
        assert!((mesh.element_volume_m3(element) - exact).abs() < 1e-15, "{element}");
    }
    let x = mesh.cells.points(0, &mesh.nodes);
    for (middle, [a, b]) in x[4..].iter().zip(CellKind::Tet10.table().edges) {
        assert_eq!(*middle, (x[*a] + x[*b]) / 2.0);
    }
}

/// One line per node: its number from 1 and its coordinates.
fn node_lines(separator: &str) -> String {
    let line = |(i, place): (u32, [f64; 3])| {
        let numbers = place.map(|x| x.to_string());
        format!("{i}{separator}{}", numbers.join(separator))
    };
    let lines: Vec<String> = (1..).zip(NODES).map(line).collect();
    lines.join("\n") + "\n"
}

fn gmsh_of_each() -> String {
    let nodes = node_lines(" ");
    // Gmsh lists the midpoint of the last and the third corner before that of the last and the second.
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n14\n{nodes}$EndNodes\n$Elements\n4\n\
         1 11 2 7 1 1 2 4 5 9 10 11 12 14 13\n2 5 2 7 1 1 2 3 4 5 6 7 8\n3 6 2 7 1 1 2 3 5 6 7\n\
         4 4 2 8 1 1 2 4 5\n$EndElements\n"
    )
}

fn abaqus_of_each() -> String {
    let nodes = node_lines(", ");
    format!(
        "*NODE\n{nodes}*ELEMENT, TYPE=C3D10, ELSET=ten\n1, 1, 2, 4, 5, 9, 10, 11, 12,\n13, 14\n\
         *ELEMENT, TYPE=C3D8, ELSET=hex\n2, 1, 2, 3, 4, 5, 6, 7, 8\n\
         *ELEMENT, TYPE=C3D6, ELSET=wedge\n3, 1, 2, 3, 5, 6, 7\n*ELEMENT, TYPE=C3D4H, ELSET=four\n4, 1, 2, 4, 5\n\
         *SURFACE, NAME=ten_slanted\nten, S3\n*SURFACE, NAME=wedge_bottom\nwedge, S1\n\
         *SURFACE, NAME=wedge_side\nwedge, S4\n*SURFACE, NAME=four_left\nfour, S4\n"
    )
}

#[test]
fn gmsh_files_hold_every_kind_in_the_order_of_gmsh() {
    let text = gmsh_of_each();
    let mesh = read_mesh(text.as_bytes(), MeshFormat::Gmsh).unwrap();
    is_one_of_each(&mesh);
    assert_eq!(mesh.part_of, [0, 0, 0, 1]);
}

#[test]
fn abaqus_files_hold_every_kind_with_its_faces() {
    let text = abaqus_of_each();
    let mesh = read_mesh(text.as_bytes(), MeshFormat::Abaqus).unwrap();
    is_one_of_each(&mesh);
    assert_eq!(mesh.parts, ["ten", "hex", "wedge", "four"]);
    assert_eq!(mesh.node_sets["ten_slanted"], [1, 3, 4, 9, 12, 13]);
    assert_eq!(mesh.node_sets["wedge_bottom"], [0, 1, 2]);
    assert_eq!(mesh.node_sets["wedge_side"], [1, 2, 5, 6]);
    assert_eq!(mesh.node_sets["four_left"], [0, 3, 4]);
    let broken = |from: &str, to: &str| malformed(&text.replacen(from, to, 1), MeshFormat::Abaqus).1;
    assert_eq!(broken("four, S4", "four, S5"), "a tetrahedron of 4 nodes has no face S5");
    assert_eq!(broken("3, 1, 2, 3, 5, 6, 7", "3, 1, 2, 3, 5, 6"), "an element of 6 nodes with 5");
}

#[test]
fn short_files_cannot_ask_for_endless_work() {
    let everything = format!("{INPUT}*NSET, NSET=all, GENERATE\n0, 18446744073709551615\n");
    assert!(matches!(
        read_mesh(everything.as_bytes(), MeshFormat::Abaqus),
        Err(MeshError::Unsupported { .. })
    ));
}

#[test]
fn every_truncated_file_is_an_error_or_a_whole_mesh() {
    for (version, encoding) in ALL {
        let bytes = write_gmsh(&small(), version, encoding);
        for end in 0..bytes.len() - 1 {
            if let Ok(mesh) = read_mesh(&bytes[..end], MeshFormat::Gmsh) {
                panic!(
                    "{version:?} {encoding:?} cut at {end} of {} gives {} elements",
                    bytes.len(),
                    mesh.cells.len()
                );
            }
        }
    }
    for end in 0..INPUT.len() {
        let _ = read_mesh(&INPUT.as_bytes()[..end], MeshFormat::Abaqus);
    }
}

/// A unit cube with additional cards, as read.
fn cube_with(cards: &str) -> Result<Mesh, MeshError> {
    let nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n";
    let text = format!("{nodes}*ELEMENT, TYPE=C3D8, ELSET=cube\n1,1,2,3,4,5,6,7,8\n{cards}");
    read_mesh(text.as_bytes(), MeshFormat::Abaqus)
}

#[test]
fn sets_of_sets_cost_no_more_than_the_file() {
    // Each contains the previous one twice, or the two previous ones: 2⁶⁰ entries if written out.
    let chain = |members: &dyn Fn(u32) -> String| -> String {
        let sets =
            (1..60).map(|i| format!("*NSET, NSET=S{i}\n{}\n", members(i))).collect::<Vec<_>>().concat();
        format!("*NSET, NSET=S0\n1, 2\n{sets}")
    };
    let twice = cube_with(&chain(&|i| format!("S{}, S{}", i - 1, i - 1))).unwrap();
    assert_eq!(twice.node_sets["S59"], [0, 1]);
    let both = cube_with(&chain(&|i| format!("S{}, S{}", i - 1, i.saturating_sub(2))));
    assert!(matches!(both, Err(MeshError::Unsupported { .. })), "{both:?}");
    let many = (0..10_001).map(|i| format!("*NSET, NSET=N{i}\n1\n")).collect::<Vec<_>>().concat();
    assert!(matches!(cube_with(&many), Err(MeshError::Unsupported { .. })));
}

#[test]
fn names_in_files_are_names() {
    for name in ["x".repeat(201), "a\u{1b}b".into()] {
        let named = cube_with(&format!("*NSET, NSET=\"{name}\"\n1\n"));
        assert!(matches!(named, Err(MeshError::Unsupported { .. })), "{name:?}: {named:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_files_never_panic(
        which in 0_usize..9, damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let (mut bytes, format) = match ALL.get(which) {
            Some(&(version, encoding)) => (write_gmsh(&small(), version, encoding), MeshFormat::Gmsh),
            None if which == 6 => (gmsh_of_each().into_bytes(), MeshFormat::Gmsh),
            None if which == 7 => (abaqus_of_each().into_bytes(), MeshFormat::Abaqus),
            None => (INPUT.as_bytes().to_vec(), MeshFormat::Abaqus),
        };
        for (place, value) in damage {
            let i = place.index(bytes.len());
            bytes[i] = value;
        }
        let _ = read_mesh(&bytes, format);
    }

    #[test]
    fn any_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        for start in [&b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Elements\n"[..], b"*NODE\n", b""] {
            let bytes = [start, &bytes].concat();
            let _ = read_mesh(&bytes, MeshFormat::Gmsh);
            let _ = read_mesh(&bytes, MeshFormat::Abaqus);
        }
    }
}
