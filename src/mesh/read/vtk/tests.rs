use crate::mesh::read::tests::{NODES, is_one_of_each, malformed};
use crate::mesh::read::{MeshFormat, read_mesh};
use crate::mesh::{Mesh, MeshError};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use proptest::prelude::*;

/// Cells of the file of each kind, in VTK's order, followed by a triangle: types, ends and points.
const TYPES: [u8; 5] = [24, 12, 13, 10, 5];
const ENDS: [u32; 5] = [10, 18, 24, 28, 31];
#[rustfmt::skip]
const POINTS: [u32; 31] = [
    0, 1, 3, 4, 8, 9, 10, 11, 12, 13, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 4, 5, 6, 0, 1, 3, 4, 0, 1, 2,
];
const PARTS: [i32; 5] = [7, 7, 7, -2, 9];
/// Points of the set "bottom".
const BOTTOM: [u8; 14] = [1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

fn is_the_mesh_of_each(mesh: &Mesh) {
    is_one_of_each(mesh);
    assert_eq!(mesh.parts, ["part_-2", "part_7"]);
    assert_eq!(mesh.part_of, [1, 1, 1, 0]);
    assert_eq!(mesh.node_sets["bottom"], [0, 1, 2, 3]);
    assert_eq!(mesh.node_sets["part_9"], [0, 1, 2]);
}

fn words<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

fn coordinates() -> Vec<f64> {
    NODES.into_iter().flatten().collect()
}

/// Cells as up to version 4, each after its number of points.
fn old_list() -> Vec<u32> {
    let starts = std::iter::once(0).chain(ENDS);
    let cell = |(start, end): (u32, u32)| {
        std::iter::once(end - start).chain(POINTS[start as usize..end as usize].iter().copied())
    };
    starts.zip(ENDS).flat_map(cell).collect()
}

/// A legacy file; binary if requested.
fn legacy(version: &str, binary: bool) -> Vec<u8> {
    let mut out = Vec::new();
    let text = |out: &mut Vec<u8>, text: &str| out.extend(text.as_bytes());
    let values = |out: &mut Vec<u8>, words: String, bytes: Vec<u8>| {
        out.extend(if binary { bytes } else { words.into_bytes() });
        out.push(b'\n');
    };
    let ints = |list: &[u32]| list.iter().flat_map(|n| n.to_be_bytes()).collect::<Vec<_>>();
    let longs = |list: &[u32]| list.iter().flat_map(|n| u64::from(*n).to_be_bytes()).collect::<Vec<_>>();

    let encoding = if binary { "BINARY" } else { "ASCII" };
    text(
        &mut out,
        &format!("# vtk DataFile Version {version}\na title\n{encoding}\nDATASET UNSTRUCTURED_GRID\n"),
    );
    text(&mut out, "FIELD FieldData 1\nTIME 1 1 double\n");
    values(&mut out, "0.5".into(), 0.5_f64.to_be_bytes().to_vec());
    text(&mut out, "POINTS 14 double\n");
    values(&mut out, words(coordinates()), coordinates().iter().flat_map(|x| x.to_be_bytes()).collect());
    if version.starts_with('5') {
        let offsets = [&[0], &ENDS[..]].concat();
        text(&mut out, "METADATA\nINFORMATION 0\n\nCELLS 6 31\nOFFSETS vtktypeint64\n");
        values(&mut out, words(&offsets), longs(&offsets));
        text(&mut out, "CONNECTIVITY vtktypeint64\n");
        values(&mut out, words(POINTS), longs(&POINTS));
    } else {
        text(&mut out, "CELLS 5 36\n");
        values(&mut out, words(old_list()), ints(&old_list()));
    }
    text(&mut out, "CELL_TYPES 5\n");
    values(&mut out, words(TYPES), ints(&TYPES.map(u32::from)));
    text(&mut out, "CELL_DATA 5\nSCALARS material int\nLOOKUP_TABLE default\n");
    values(&mut out, words(PARTS), PARTS.iter().flat_map(|n| n.to_be_bytes()).collect());
    text(&mut out, "POINT_DATA 14\nVECTORS u float\n");
    values(&mut out, words([0.0; 42]), vec![0; 4 * 42]);
    text(&mut out, "FIELD FieldData 1\nbottom 1 14 unsigned_char\n");
    values(&mut out, words(BOTTOM), BOTTOM.to_vec());
    out
}

#[test]
fn legacy_files_of_both_layouts_and_encodings() {
    for version in ["2.0", "4.2", "5.1"] {
        for binary in [false, true] {
            let mesh = read_mesh(&legacy(version, binary), MeshFormat::Vtk).unwrap();
            is_the_mesh_of_each(&mesh);
            assert_eq!(mesh.notes, ["arrays not used: u (1)"], "{version} {binary}");
        }
    }
}

/// How the arrays of an XML file are written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Written {
    Text,
    Inline,
    AppendedRaw,
    AppendedBase64,
}

#[derive(Clone, Copy, Debug)]
struct Style {
    written: Written,
    /// Name of the compressor.
    compressor: Option<&'static str>,
    /// Whether headers have 8 bytes.
    long: bool,
    big: bool,
}

impl Style {
    fn header(self, numbers: &[usize]) -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|&n| match (self.long, self.big) {
                (true, true) => (n as u64).to_be_bytes().to_vec(),
                (true, false) => (n as u64).to_le_bytes().to_vec(),
                (false, true) => (n as u32).to_be_bytes().to_vec(),
                (false, false) => (n as u32).to_le_bytes().to_vec(),
            })
            .collect()
    }

    /// Header and data of an array, each a base64 stream of its own where compressed; blocks of 64 bytes.
    fn streams(self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let Some(compressor) = self.compressor else {
            return vec![[self.header(&[bytes.len()]), bytes.to_vec()].concat()];
        };
        let blocks: Vec<Vec<u8>> = bytes
            .chunks(64)
            .map(|block| match compressor {
                "vtkZLibDataCompressor" => miniz_oxide::deflate::compress_to_vec_zlib(block, 6),
                _ => lz4(block),
            })
            .collect();
        let sizes = blocks.iter().map(Vec::len);
        let numbers: Vec<usize> = [blocks.len(), 64, bytes.len() % 64].into_iter().chain(sizes).collect();
        vec![self.header(&numbers), blocks.concat()]
    }

    fn encoded(self, bytes: &[u8]) -> Vec<u8> {
        let streams = self.streams(bytes);
        match self.written {
            Written::AppendedRaw => streams.concat(),
            _ => streams.iter().map(|stream| STANDARD.encode(stream)).collect::<String>().into_bytes(),
        }
    }
}

/// A block of LZ4 with literals only: a token, its extension, and the bytes.
fn lz4(block: &[u8]) -> Vec<u8> {
    let (token, extension) = match block.len() {
        short @ 0..15 => ((short as u8) << 4, vec![]),
        long => (0xf0, vec![(long - 15) as u8]),
    };
    [vec![token], extension, block.to_vec()].concat()
}

/// An XML file; `change` may change its text before the appended data.
fn unstructured(style: Style) -> Vec<u8> {
    let mut appended: Vec<u8> = Vec::new();
    let mut array = |kind: &str, name: &str, components: usize, text: String, bytes: Vec<u8>| {
        let bytes = if style.big { swapped(kind, &bytes) } else { bytes };
        let attributes = format!("type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
        match style.written {
            Written::Text => format!("<DataArray {attributes} format=\"ascii\">\n{text}\n</DataArray>\n"),
            Written::Inline => {
                let digits = String::from_utf8(style.encoded(&bytes)).unwrap();
                format!("<DataArray {attributes} format=\"binary\">\n {digits}\n</DataArray>\n")
            }
            Written::AppendedRaw | Written::AppendedBase64 => {
                let offset = appended.len();
                appended.extend(style.encoded(&bytes));
                format!("<DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        }
    };
    let longs = |list: &[u32]| list.iter().flat_map(|n| u64::from(*n).to_le_bytes()).collect::<Vec<_>>();
    let bytes = |list: &[f64]| list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let parts = PARTS.iter().flat_map(|n| n.to_le_bytes()).collect();
    let x = coordinates();
    let arrays = [
        array("Float64", "Points", 3, words(&x), bytes(&x)),
        array("Int64", "connectivity", 1, words(POINTS), longs(&POINTS)),
        array("Int64", "offsets", 1, words(ENDS), longs(&ENDS)),
        array("UInt8", "types", 1, words(TYPES), TYPES.to_vec()),
        array("Int32", "PartId", 1, words(PARTS), parts),
        array("UInt8", "bottom", 1, words(BOTTOM), BOTTOM.to_vec()),
        array("Float64", "u", 3, words(&x), bytes(&x)),
    ];
    let [points, connectivity, offsets, types, parts, bottom, u] = arrays;
    let order = if style.big { "BigEndian" } else { "LittleEndian" };
    let header = if style.long { "UInt64" } else { "UInt32" };
    let compressor = style.compressor.map_or_else(String::new, |c| format!(" compressor=\"{c}\""));
    let encoding = if style.written == Written::AppendedRaw { "raw" } else { "base64" };
    let tail = if appended.is_empty() {
        Vec::new()
    } else {
        let open = format!("<AppendedData encoding=\"{encoding}\">\n_");
        [open.into_bytes(), appended, b"\n</AppendedData>\n".to_vec()].concat()
    };
    let head = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" \
         header_type=\"{header}\"{compressor}>\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"14\" NumberOfCells=\"5\">\n\
         <PointData>\n{bottom}{u}</PointData>\n<CellData>\n{parts}</CellData>\n<Points>\n{points}</Points>\n\
         <Cells>\n{connectivity}{offsets}{types}</Cells>\n</Piece>\n</UnstructuredGrid>\n"
    );
    [head.into_bytes(), tail, b"</VTKFile>\n".to_vec()].concat()
}

/// Numbers in the other order of bytes.
fn swapped(kind: &str, bytes: &[u8]) -> Vec<u8> {
    let size = kind.chars().filter(char::is_ascii_digit).collect::<String>().parse::<usize>().unwrap() / 8;
    bytes.chunks(size).flat_map(|number| number.iter().rev().copied()).collect()
}

fn styles() -> Vec<Style> {
    let mut styles = Vec::new();
    for written in [Written::Text, Written::Inline, Written::AppendedRaw, Written::AppendedBase64] {
        for compressor in [None, Some("vtkZLibDataCompressor"), Some("vtkLZ4DataCompressor")] {
            for (long, big) in [(false, false), (true, false), (false, true), (true, true)] {
                styles.push(Style { written, compressor, long, big });
            }
        }
    }
    styles
}

/// The XML file with its arrays as text.
fn plain() -> String {
    let style = Style { written: Written::Text, compressor: None, long: true, big: false };
    String::from_utf8(unstructured(style)).unwrap()
}

#[test]
fn xml_files_of_every_encoding() {
    for style in styles() {
        let mesh =
            read_mesh(&unstructured(style), MeshFormat::Vtu).unwrap_or_else(|e| panic!("{style:?}: {e}"));
        is_the_mesh_of_each(&mesh);
        assert_eq!(mesh.notes, ["arrays not used: u (1)"], "{style:?}");
    }
}

#[test]
fn texts_name_parts() {
    let ascii = String::from_utf8(legacy("4.2", false)).unwrap();
    let names = "FIELD F 1\npart 1 5 string\nbone\nbone\nsoft%20tissue\nbone\nskin\n";
    let named = ascii.replace("SCALARS material", &format!("{names}SCALARS material"));
    let of_legacy = read_mesh(named.as_bytes(), MeshFormat::Vtk).unwrap();

    let bytes = words(b"bone\0bone\0soft tissue\0bone\0skin\0");
    let array = format!("<Array type=\"String\" Name=\"part\" format=\"ascii\">{bytes}</Array>\n");
    let of_xml = read_mesh(
        plain().replace("<CellData>\n", &format!("<CellData>\n{array}")).as_bytes(),
        MeshFormat::Vtu,
    );
    for mesh in [of_legacy, of_xml.unwrap()] {
        assert_eq!(mesh.parts, ["bone", "soft tissue"]);
        assert_eq!(mesh.part_of, [0, 0, 1, 0]);
        assert_eq!(mesh.node_sets["skin"], [0, 1, 2]);
        assert!(mesh.notes[0].contains("PartId") || mesh.notes[0].contains("material"), "{:?}", mesh.notes);
    }
}

#[test]
fn wedges_in_the_order_of_earlier_versions_are_noted() {
    let earlier = plain().replace("0 1 2 4 5 6", "0 2 1 4 6 5");
    let mesh = read_mesh(earlier.as_bytes(), MeshFormat::Vtu).unwrap();
    is_the_mesh_of_each(&mesh);
    assert!(
        mesh.notes[0].starts_with("1 wedges list the triangle that faces outwards first"),
        "{:?}",
        mesh.notes
    );
}

#[test]
fn a_voxel_is_a_hexahedron() {
    let text =
        plain().replace("24 12 13 10 5\n", "24 11 13 10 5\n").replace("0 1 2 3 4 5 6 7", "0 1 3 2 4 5 7 6");
    is_the_mesh_of_each(&read_mesh(text.as_bytes(), MeshFormat::Vtu).unwrap());
}

#[test]
fn errors_in_xml_files_name_the_line() {
    let broken = |from: &str, to: &str| malformed(&plain().replace(from, to), MeshFormat::Vtu);
    let (line, message) = broken("0 1 3 4 8 9", "0 1 3 44 8 9");
    assert_eq!(
        (line, message.as_str()),
        (23, "cell 0 has the point 44; there are 14 points, numbered from 0")
    );
    assert!(broken("0 1 3 4 8 9", "0 1 3 -4 8 9").1.contains("the point -4"));
    assert_eq!(
        broken("0 0 0 1 0 0", "0 0 0 1 nan 0"),
        (19, "point 1 has a coordinate that is not finite".into())
    );
    assert_eq!(broken("0 0 0 1 0 0", "0 0 0 1 x 0"), (20, "expected values of an array, found \"x\"".into()));
    assert_eq!(broken("10 18 24 28 31", "10 18 14 28 31").1, "cell 2 ends at 14, before its start at 18");
    assert!(broken("10 18 24 28 31", "10 18 24 28 30").1.contains("has more"), "one point is left over");
    assert!(broken("24 12 13 10 5\n", "24 12 13 99 5\n").1.contains("cell 3 is of type 99"));
    assert!(broken("24 12 13 10 5\n", "10 12 13 10 5\n").1.contains("a tetrahedron of 4 nodes with 10"));
    assert!(broken("</CellData>", "").1.contains("expected"), "not XML");
    for count in ["4000000000000", "18446744073709551615"] {
        let found = broken("NumberOfPoints=\"14\"", &format!("NumberOfPoints=\"{count}\"")).1;
        assert!(found.contains("are declared, but only"), "{found}");
    }
    assert!(broken("NumberOfCells=\"5\"", "NumberOfCells=\"-5\"").1.contains("expected a number"));
    assert!(broken("<?xml version=\"1.0\"?>", "<!DOCTYPE a [<!ENTITY b \"c\">]>").1.contains("DTD"));
}

#[test]
fn errors_in_legacy_files_name_the_line() {
    let text = String::from_utf8(legacy("4.2", false)).unwrap();
    let broken = |from: &str, to: &str| malformed(&text.replacen(from, to, 1), MeshFormat::Vtk);
    assert_eq!(broken("DataFile", "DateiFile").0, 1);
    assert_eq!(broken("ASCII", "TEXT").0, 3);
    assert_eq!(broken("0 0 0 1 0 0", "0 0 0 1 x 0"), (9, "expected coordinates, found \"x\"".into()));
    assert_eq!(
        broken("10 0 1 3 4 8", "10 0 1 3 44 8"),
        (10, "cell 0 has the point 44; there are 14 points, numbered from 0".into())
    );
    assert!(broken("10 0 1 3 4 8", "99 0 1 3 4 8").1.contains("more points than the list"));
    assert!(broken("10 0 1 3 4 8", "-1 0 1 3 4 8").1.contains("more points than the list"));
    assert_eq!(broken("CELL_DATA 5", "CELL_DATA 6"), (14, "the grid has 5 cells, its data 6".into()));
    assert!(broken("POINTS 14", "POINTS 4000000000000").1.contains("are declared, but only"));
    assert!(broken("CELLS 5 36", "CELLS 5 4000000000000").1.contains("are declared, but only"));
    let of_files = |kind| read_mesh(text.replace("UNSTRUCTURED_GRID", kind).as_bytes(), MeshFormat::Vtk);
    assert!(matches!(of_files("POLYDATA"), Err(MeshError::Unsupported { .. })));
}

#[test]
fn other_volumes_are_counted() {
    let text = plain().replace("24 12 13 10 5\n", "24 25 14 10 5\n");
    let error = read_mesh(text.as_bytes(), MeshFormat::Vtu).unwrap_err();
    let kinds = vec!["hexahedron of 20 nodes (1)".into(), "pyramid of 5 nodes (1)".into()];
    assert_eq!(error, MeshError::UnsupportedElements { kinds });
}

#[test]
fn what_other_files_have_is_refused_with_a_remedy() {
    let with = |from: &str, to: &str| read_mesh(plain().replacen(from, to, 1).as_bytes(), MeshFormat::Vtu);
    for (from, to) in [
        ("type=\"UnstructuredGrid\"", "type=\"PUnstructuredGrid\""),
        ("header_type", "compressor=\"vtkLZMADataCompressor\" header_type"),
        ("</Piece>", "</Piece><Piece/>"),
    ] {
        assert!(matches!(with(from, to), Err(MeshError::Unsupported { .. })), "{to}");
    }
}

#[test]
fn a_truncated_file_is_refused_at_its_last_line() {
    let text = plain();
    let cut = &text[..text.find("<CellData>").unwrap()];
    let last = cut.lines().count() + 1;
    assert_eq!(
        malformed(cut, MeshFormat::Vtu),
        (last, "the file ends within an element: it is truncated".into())
    );
}

/// An appended array of one block with this header, instead of the points.
fn with_points(header: &[u64], block: &[u8]) -> MeshError {
    let style = Style { written: Written::Text, compressor: None, long: true, big: false };
    let text = String::from_utf8(unstructured(style)).unwrap();
    let text = text.replace("header_type", "compressor=\"vtkZLibDataCompressor\" header_type");
    let (before, rest) = text.split_once("<Points>\n").unwrap();
    let (_, after) = rest.split_once("</Points>").unwrap();
    let array = "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/>";
    let text = format!("{before}<Points>{array}</Points>{after}");
    let text = text.replace("</VTKFile>\n", "<AppendedData encoding=\"raw\">_");
    let header: Vec<u8> = header.iter().flat_map(|n| n.to_le_bytes()).collect();
    read_mesh(&[text.as_bytes(), &header, block].concat(), MeshFormat::Vtu).unwrap_err()
}

#[test]
fn bytes_that_grow_without_end_are_refused() {
    // 64 MB of zeros in some 64 kB: more than the block declares.
    let bomb = miniz_oxide::deflate::compress_to_vec_zlib(&vec![0; 64 << 20], 9);
    let size = bomb.len() as u64;
    let message = with_points(&[1, 14 * 24, 0, size], &bomb).to_string();
    assert!(message.contains("block 0 does not decompress to 336 bytes"), "{message}");
    // Sizes that are declared are compared with the limit before anything is allocated.
    for header in [[1, u64::MAX >> 1, 0, size], [u64::MAX >> 1, 1 << 20, 0, size], [1, 1 << 40, 0, size]] {
        let message = with_points(&header, &bomb).to_string();
        assert!(message.contains("save it without compression"), "{message}");
    }
    let message = with_points(&[1 << 50, 0, 0, 0], &bomb).to_string();
    assert!(message.contains("a size in the header exceeds"), "{message}");
    let message = with_points(&[1, 336, 0, 1 << 60], &bomb).to_string();
    assert!(message.contains("at most"), "{message}");
}

#[test]
fn elements_within_elements_do_not_exhaust_the_stack() {
    let deep = "<a>".repeat(300_000) + &"</a>".repeat(300_000);
    let text = plain().replace("<CellData>\n", &format!("<CellData>\n{deep}"));
    let _ = read_mesh(text.as_bytes(), MeshFormat::Vtu);
    let _ = read_mesh("<a>".repeat(300_000).as_bytes(), MeshFormat::Vtu);
}

#[test]
fn every_truncated_file_is_an_error() {
    for binary in [false, true] {
        let bytes = legacy("5.1", binary);
        // Without the last arrays a file is whole, too.
        let whole = bytes.windows(9).position(|w| w == b"CELL_DATA").unwrap();
        for end in 0..whole - 2 {
            let read = read_mesh(&bytes[..end], MeshFormat::Vtk);
            assert!(read.is_err(), "cut at {end} of {}", bytes.len());
        }
    }
    for style in styles() {
        let bytes = unstructured(style);
        for end in (0..bytes.len() - 30).step_by(7) {
            let _ = read_mesh(&bytes[..end], MeshFormat::Vtu);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_files_never_panic(
        which in any::<prop::sample::Index>(),
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut files: Vec<(Vec<u8>, MeshFormat)> =
            styles().into_iter().map(|style| (unstructured(style), MeshFormat::Vtu)).collect();
        files.extend(["3.0", "5.1"].map(|version| (legacy(version, true), MeshFormat::Vtk)));
        files.extend(["3.0", "5.1"].map(|version| (legacy(version, false), MeshFormat::Vtk)));
        let (mut bytes, format) = which.get(&files).clone();
        for (place, value) in damage {
            let i = place.index(bytes.len());
            bytes[i] = value;
        }
        let _ = read_mesh(&bytes, format);
    }
}
