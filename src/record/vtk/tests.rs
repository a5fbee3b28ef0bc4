use super::*;
use crate::mechanics::tensor::Vec3;
use crate::record::proto::contuse::{ContactForces, PackedArray, PairForces, ReferenceMesh, Stress};
use crate::record::proto::foxglove::{
    KeyValuePair, Point3, Pose, Quaternion, SceneEntity, SceneUpdate, TriangleListPrimitive, Vector3,
};
use crate::record::{RecordError, packed};
use miniz_oxide::inflate::decompress_to_vec_zlib;
use std::collections::BTreeMap;

/// Written files by name, and their order.
#[derive(Debug, Default)]
struct Memory {
    files: BTreeMap<String, Vec<u8>>,
    order: Vec<String>,
}

impl Place for &mut Memory {
    fn put(&mut self, name: &str, content: &[u8]) -> Result<(), RecordError> {
        self.order.push(name.to_owned());
        self.files.insert(name.to_owned(), content.to_vec());
        Ok(())
    }
    fn folder(&self) -> &'static str {
        "a_vtu"
    }
    fn close(self, pvd: &str) -> Result<(), RecordError> {
        self.files.insert("a.pvd".into(), pvd.into());
        Ok(())
    }
    fn discard(self) {
        self.files.clear();
    }
}

fn u32_at(bytes: &[u8], index: usize) -> usize {
    u32::from_le_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap()) as usize
}

/// The data of an encoded array, read by the rules of VTK's file formats.
fn decode(encoded: &[u8]) -> Vec<u8> {
    let [count, size, last] = [0, 1, 2].map(|index| u32_at(encoded, index));
    let (mut at, mut data) = (4 * (3 + count), Vec::new());
    for block in 0..count {
        let end = at + u32_at(encoded, 3 + block);
        let plain = decompress_to_vec_zlib(&encoded[at..end]).unwrap();
        assert_eq!(plain.len(), if block + 1 < count || last == 0 { size } else { last });
        data.extend(plain);
        at = end;
    }
    data
}

/// The data of an array of a `.vtu` file, found by its element as text.
fn data(file: &[u8], name: &str) -> Vec<u8> {
    let begin = file.windows(2).position(|w| w == b"\n_").unwrap() + 2;
    let xml = std::str::from_utf8(&file[..begin]).unwrap();
    let element = xml.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
    let offset = element.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
    decode(&file[begin + offset.parse::<usize>().unwrap()..])
}

fn floats(file: &[u8], name: &str) -> Vec<f32> {
    data(file, name).as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

fn integers(file: &[u8], name: &str) -> Vec<u32> {
    data(file, name).as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect()
}

/// A unit cube with a wedge on top: nodes 4, 5, 6 and 8, 9, 10.
fn tower() -> ReferenceMesh {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let positions = (0..11_usize).map(|i| [corners[i % 4][0], corners[i % 4][1], (i / 4) as f64]);
    ReferenceMesh {
        body: "tower & sons".into(),
        role: "tissue".into(),
        parts: vec!["cube".into(), "roof".into()],
        positions: Some(packed::f64s("position_m", "m", positions)),
        part_of: Some(packed::u32s("part_of", [[0], [1]])),
        cell_types: Some(packed::u8s("cell_types", [12, 13])),
        // The wedge as VTK has it: 4, 5, 6 is the triangle that faces inwards.
        cell_nodes: Some(packed::u32s(
            "cell_nodes",
            [0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 8, 9, 10].map(|n| [n]),
        )),
        ..ReferenceMesh::default()
    }
}

/// The fields of the tower, which is a centimetre higher.
fn stress(time_s: f64, eroded: Option<[u8; 2]>) -> Stress {
    let cauchy = packed::f32s("cauchy_pa", "Pa", [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [7.0; 6]]);
    Stress {
        time_s,
        nodal: vec![
            packed::scalars("von_mises_pa", "Pa", (0..11).map(|i| 100.0 * f64::from(i))),
            packed::vectors("displacement_m", "m", [Vec3::new(0.0, 0.0, 0.01); 11]),
        ],
        element: std::iter::once(cauchy).chain(eroded.map(|gone| packed::u8s("eroded", gone))).collect(),
        ..Stress::default()
    }
}

/// A triangle of a rigid body, turned by a quarter about z.
fn rigid(time_s: f64) -> SceneUpdate {
    let half = 0.5_f64.sqrt();
    let pose = Pose {
        position: Some(Vector3 { x: 10.0, y: 0.0, z: 0.0 }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: half, w: half }),
    };
    let point = |x, y| Point3 { x, y, z: 1.0 };
    let surface = TriangleListPrimitive {
        pose: Some(pose),
        points: vec![point(0.0, 0.0), point(2.0, 0.0), point(0.0, 3.0)],
        indices: vec![0, 1, 2],
        ..TriangleListPrimitive::default()
    };
    let time = KeyValuePair { key: "time_s".into(), value: time_s.to_string() };
    let entity = SceneEntity {
        id: "ball".into(),
        metadata: vec![time],
        triangles: vec![surface],
        ..SceneEntity::default()
    };
    SceneUpdate { entities: vec![entity], ..SceneUpdate::default() }
}

fn forces(time_s: f64, contacts: u32) -> ContactForces {
    let place = |i: u32| [f64::from(i), 0.5, 0.25];
    let pair = PairForces {
        pair: "tower–ball".into(),
        force_n: Some(Vector3 { x: 1.0, y: 2.0, z: 3.0 }),
        peak_pressure_pa: 5e3,
        contacts: vec![
            packed::u32s("node", (0..contacts).map(|i| [10 + i])),
            packed::f32s("position_m", "m", (0..contacts).map(place)),
            packed::u8s("status", (0..contacts).map(|_| 2)),
        ],
        ..PairForces::default()
    };
    ContactForces { time_s, step: 0, pairs: vec![pair] }
}

/// The series of two field times, with a step between them.
fn series() -> Memory {
    let (mut memory, mut assembler) = (Memory::default(), Assembler::default());
    let mut series = Series::new(&mut memory);
    assembler.reference("tower", &tower()).unwrap();
    for (time, contacts, eroded) in [(0.0, 0, [0, 0]), (2.5e-4, 2, [0, 1])] {
        assembler.contact(forces(time, contacts), &mut series).unwrap();
        assembler.rigid("ball", &rigid(time), &mut series).unwrap();
        assembler.stress("tower", &stress(time, Some(eroded)), &mut series).unwrap();
        assembler.contact(forces(time + 1e-6, 1), &mut series).unwrap();
    }
    assembler.finish(&mut series).unwrap();
    assert_eq!(series.times(), 2);
    series.finish().unwrap();
    memory
}

#[test]
fn compressed_blocks_return_the_bytes() {
    let block = 1_usize << 18;
    for length in [0, 1, 5, block - 1, block, block + 1, 2 * block, 2 * block + 7] {
        let data: Vec<u8> = (0..length).map(|i| (i * i % 251) as u8).collect();
        let array = Array::new("a", NumberType::UInt8, 1, &data);
        assert_eq!(decode(array.encoded()), data, "{length}");
        assert_eq!(u32_at(array.encoded(), 0), length.div_ceil(block));
    }
}

#[test]
fn an_element_names_type_and_place() {
    let array = Array::new("a<\"b\"\n", NumberType::Float32, 3, &[0; 12]);
    let name = "a&lt;&quot;b&quot;_";
    let expected = format!(
        "<DataArray type=\"Float32\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"appended\" offset=\"7\"/>"
    );
    assert_eq!(array.element(7), expected);
}

#[test]
fn the_list_has_every_part_at_every_time_and_nothing_between() {
    let memory = series();
    assert_eq!(
        memory.order,
        [
            "0_ball_0000.vtu",
            "1_tower___sons_0000.vtu",
            "2_contact_tower_ball_0000.vtu",
            "0_ball_0001.vtu",
            "1_tower___sons_0001.vtu",
            "2_contact_tower_ball_0001.vtu",
        ]
    );
    let pvd = std::str::from_utf8(&memory.files["a.pvd"]).unwrap();
    let line = "<DataSet timestep=\"2.5e-4\" group=\"\" part=\"1\" name=\"tower &amp; sons\" file=\"a_vtu/1_tower___sons_0001.vtu\"/>";
    assert!(pvd.contains(line), "{pvd}");
    assert_eq!(pvd.matches("<DataSet").count(), 6);
}

#[test]
fn a_body_has_its_nodes_cells_and_fields() {
    let file = &series().files["1_tower___sons_0000.vtu"];
    let points = floats(file, "Points");
    assert_eq!(points.len(), 33);
    assert_eq!(points[30..], [1.0, 1.0, 2.01]);
    assert_eq!(integers(file, "connectivity"), [0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 8, 9, 10]);
    assert_eq!(integers(file, "offsets"), [8, 14]);
    assert_eq!(data(file, "types"), [12, 13]);
    assert_eq!(floats(file, "von_mises_pa")[10..], [1000.0]);
    assert_eq!(floats(file, "cauchy_pa")[..7], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(integers(file, "part"), [0, 1]);
    let text = String::from_utf8_lossy(file);
    assert!(text.contains("Name=\"cauchy_pa\" NumberOfComponents=\"6\""), "{text}");
    assert!(text.contains("<Piece NumberOfPoints=\"11\" NumberOfCells=\"2\">"), "{text}");
    // "cube" and "roof", each with a zero at its end.
    assert!(text.contains(">99 117 98 101 0 114 111 111 102 0</Array>"), "{text}");
}

#[test]
fn eroded_elements_are_omitted() {
    let file = &series().files["1_tower___sons_0001.vtu"];
    assert_eq!(integers(file, "connectivity"), [0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!((integers(file, "part"), integers(file, "element")), (vec![0], vec![0]));
    assert_eq!(floats(file, "cauchy_pa"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(floats(file, "Points").len(), 33, "the nodes stay, so that their numbers do");
}

#[test]
fn rigid_bodies_are_placed_by_their_pose() {
    let memory = series();
    // A quarter turn about z takes (x, y) to (−y, x).
    let points = floats(&memory.files["0_ball_0001.vtu"], "Points");
    for (found, wanted) in points.iter().zip([10.0, 0.0, 1.0, 10.0, 2.0, 1.0, 7.0, 0.0, 1.0]) {
        assert!((found - wanted).abs() < 1e-6, "{points:?}");
    }
    assert_eq!(data(&memory.files["0_ball_0001.vtu"], "types"), [5]);
}

#[test]
fn contacts_are_points_of_field_times() {
    let memory = series();
    let file = &memory.files["2_contact_tower_ball_0001.vtu"];
    assert_eq!(floats(file, "Points"), [0.0, 0.5, 0.25, 1.0, 0.5, 0.25]);
    assert_eq!((integers(file, "node"), data(file, "status")), (vec![10, 11], vec![2, 2]));
    let text = String::from_utf8_lossy(file);
    assert!(text.contains(
        "Name=\"force_n\" NumberOfComponents=\"3\" NumberOfTuples=\"1\" format=\"ascii\">1e0 2e0 3e0<"
    ));
    assert!(text.contains("Name=\"peak_pressure_pa\"") && text.contains(">5e3<"));
    assert!(floats(&memory.files["2_contact_tower_ball_0000.vtu"], "Points").is_empty());
}

/// A change to the messages of a body.
type Change = Box<dyn Fn(&mut ReferenceMesh, &mut Stress)>;

#[test]
fn messages_that_contradict_themselves_are_refused() {
    let refused = |change: &dyn Fn(&mut ReferenceMesh, &mut Stress)| {
        let (mut mesh, mut fields) = (tower(), stress(0.0, Some([0, 1])));
        change(&mut mesh, &mut fields);
        let (mut memory, mut assembler) = (Memory::default(), Assembler::default());
        let done = assembler
            .reference("tower", &mesh)
            .and_then(|()| assembler.stress("tower", &fields, &mut Series::new(&mut memory)));
        assert!(memory.files.is_empty());
        match done {
            Err(RecordError::Unusable { topic, reason }) => format!("{topic}: {reason}"),
            other => panic!("{other:?}"),
        }
    };
    let shorter = |array: &mut PackedArray| array.data.truncate(array.data.len() - 1);
    let cases: [(&str, Change); 10] = [
        ("position_m is missing", Box::new(|mesh, _| mesh.positions = None)),
        (
            "position_m has 11 entries in 263 bytes",
            Box::new(move |mesh, _| shorter(mesh.positions.as_mut().unwrap())),
        ),
        (
            "a cell has node 8 of 8",
            Box::new(|mesh, _| mesh.positions = Some(packed::f64s("", "", [[0.0; 3]; 8]))),
        ),
        ("unknown type 14", Box::new(|mesh, _| mesh.cell_types = Some(packed::u8s("", [12, 14])))),
        ("fewer nodes", Box::new(|mesh, _| mesh.cell_types = Some(packed::u8s("", [12, 12])))),
        ("more nodes", Box::new(|mesh, _| mesh.cell_types = Some(packed::u8s("", [12])))),
        (
            "part_of has 1 entries for 2 cells",
            Box::new(|mesh, _| mesh.part_of = Some(packed::u32s("", [[0]]))),
        ),
        ("von_mises_pa has 11 entries in 43 bytes", Box::new(move |_, fields| shorter(&mut fields.nodal[0]))),
        (
            "eroded has 3 entries for 2 cells",
            Box::new(|_, fields| fields.element[1] = packed::u8s("eroded", [0; 3])),
        ),
        ("displacement_m of the nodes is missing", Box::new(|_, fields| fields.nodal.truncate(1))),
    ];
    for (reason, change) in cases {
        let said = refused(&change);
        assert!(said.contains(reason) && said.contains("/tower"), "{reason}: {said}");
    }
    let mut update = rigid(0.0);
    update.entities[0].triangles[0].indices[2] = 3;
    let refused = Assembler::default().rigid("ball", &update, &mut Series::new(&mut Memory::default()));
    assert!(refused.unwrap_err().to_string().starts_with("/mesh/ball: the triangles"));
    let refused = Assembler::default().take("/energy/x", &[255], &mut Series::new(&mut Memory::default()));
    assert!(refused.is_ok(), "other topics are not read");
    let refused = Assembler::default().take("/stress/x", &[255], &mut Series::new(&mut Memory::default()));
    assert!(matches!(refused, Err(RecordError::Unusable { .. })));
}

#[test]
fn a_series_without_times_says_what_to_do() {
    let mut memory = Memory::default();
    let refused = Series::new(&mut memory).finish().unwrap_err();
    assert!(refused.to_string().contains("record.fields"), "{refused}");
    assert!(memory.files.is_empty());
}

#[test]
fn an_archive_is_headers_and_files_in_blocks() {
    let mut out = Vec::new();
    let mut archive = Archive::new(&mut out, &"long".repeat(20));
    archive.put("a.vtu", &[7; 600]).unwrap();
    let folder = archive.folder().to_owned();
    assert_eq!(folder, "long".repeat(8) + "_vtu");
    assert!(archive.put(&"x".repeat(64), b"").is_err(), "a path of more than a hundred bytes");
    archive.close("<pvd>").unwrap();
    assert_eq!(out.len(), 512 + 1024 + 512 + 512 + 1024);
    assert!(out.starts_with(format!("{folder}/a.vtu\0").as_bytes()));
    assert_eq!(&out[124..136], b"00000001130\0", "600 in octal");
    assert_eq!(&out[257..265], b"ustar\x0000");
    // The sum of the header, with spaces in place of the sum.
    let sum: u32 = out[..512]
        .iter()
        .enumerate()
        .map(|(i, &b)| if (148..156).contains(&i) { 32 } else { b.into() })
        .sum();
    assert_eq!(&out[148..156], format!("{sum:06o}\0 ").as_bytes());
    assert_eq!((out[512 + 599], out[512 + 600]), (7, 0));
    assert_eq!(&out[2048..2053], b"<pvd>");
    assert!(out[2560..].iter().all(|&byte| byte == 0));
}

#[test]
fn a_folder_has_its_name_once_it_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let write = |files: &[&str]| {
        let mut place = Folder::create(&path("a.pvd")).unwrap();
        for name in files {
            place.put(name, b"content").unwrap();
        }
        place
    };
    let place = write(&["0.vtu", "1.vtu"]);
    assert!(matches!(Folder::create(&path("a.pvd")), Err(RecordError::InUse { .. })));
    assert!(!path("a_vtu").exists() && !path("a.pvd").exists());
    place.close("first").unwrap();
    assert!(path("a_vtu/1.vtu").exists());
    // What is discarded, and what a killed run leaves behind, does not touch it.
    write(&["0.vtu"]).discard();
    drop(write(&["2.vtu"]));
    assert_eq!(std::fs::read(path("a.pvd")).unwrap(), b"first");
    assert!(path("a_vtu.partial/2.vtu").exists() && path("a_vtu/1.vtu").exists());
    // A complete one replaces all of it, but deletes nothing of others.
    write(&["0.vtu"]).close("second").unwrap();
    assert!(path("a_vtu/0.vtu").exists() && !path("a_vtu/1.vtu").exists() && !path("a_vtu.partial").exists());
    std::fs::write(path("a_vtu/notes.txt"), "precious").unwrap();
    let refused = write(&["0.vtu"]).close("third").unwrap_err();
    assert!(refused.to_string().contains("a_vtu"), "{refused}");
    assert_eq!(std::fs::read(path("a_vtu/notes.txt")).unwrap(), b"precious");
}

#[test]
fn a_file_that_cannot_be_written_is_named_and_not_left() {
    let folder = tempfile::tempdir().unwrap();
    let mut place = Folder::create(&folder.path().join("a.pvd")).unwrap();
    place.put("0.vtu", b"").unwrap();
    std::fs::remove_dir_all(folder.path().join("a_vtu.partial")).unwrap();
    let refused = place.put("1.vtu", b"").unwrap_err().to_string();
    assert!(refused.contains("a_vtu.partial") && refused.contains("1.vtu"), "{refused}");
}
