//! One mesh in every format: the scene has the same nodes, cells, parts and sets, to the last bit.

use super::*;
use crate::mechanics::tensor::Vec3;
use crate::mesh::generate::block::Block;
use crate::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use crate::mesh::{Cell, CellKind, Mesh};
use std::fmt::{Display, Write as _};

/// A cube of each kind, apart from each other, as parts `part_1` to `part_4`, with the node set `low` of the first.
fn mesh() -> Mesh {
    let size = Vec3::new(0.1, 0.1, 0.3);
    let cube = |x: f64| Block::uniform(Vec3::new(x, 0.0, 0.0), size, [1, 1, 2], "cube");
    let hexes = cube(0.0).generate().unwrap();
    let kinds = [
        hexes.clone(),
        cube(1.0 / 3.0).generate().unwrap().split_to_wedges(),
        cube(0.7).generate().unwrap().split_to_tetrahedra(),
        cube(1.1).generate().unwrap().split_to_tetrahedra().to_quadratic_tetrahedra(),
    ];
    let mut all = Mesh::default();
    for (part, mesh) in (0..).zip(kinds) {
        let first = all.nodes.len() as u32;
        all.nodes.extend(&mesh.nodes);
        all.cells.extend(mesh.cells.map(|node| node + first).iter());
        all.part_of.extend(mesh.part_of.iter().map(|_| part));
        all.parts.push(format!("part_{}", part + 1));
    }
    // No decimal of a few digits is one of these.
    all.nodes.iter_mut().for_each(|x| *x *= std::f64::consts::FRAC_1_SQRT_2);
    all.node_sets.insert("low".into(), hexes.node_sets["z_min"].clone());
    all
}

fn lines(lines: impl Iterator<Item = String>) -> String {
    lines.fold(String::new(), |mut text, line| {
        let _ = writeln!(text, "{line}");
        text
    })
}

/// Items with a separator between them.
fn list<T: Display>(items: impl IntoIterator<Item = T>, separator: &str) -> String {
    items.into_iter().map(|item| item.to_string()).collect::<Vec<_>>().join(separator)
}

/// The cells of a part with their numbers from 1.
fn of_part(mesh: &Mesh, part: u32) -> impl Iterator<Item = (usize, Cell<'_>)> {
    mesh.cells
        .iter()
        .enumerate()
        .filter(move |(e, _)| mesh.part_of[*e] == part)
        .map(|(e, cell)| (e + 1, cell))
}

/// A scene with a mesh in a file, with these further fields of its body and its part.
fn scene_of(mesh: &Mesh, body: &Value, part: &Value) -> (Value, Files) {
    let files = Files(vec![("mesh.msh", write_gmsh(mesh, Version::V4_1, Encoding::Ascii))]);
    let mut scene = json!({
        "name": "block", "end_time_s": 1e-3,
        "bodies": [{
            "name": "block", "mesh": {"file": {"name": "mesh.msh"}},
            "parts": [{"part": "*", "density_kg_per_m3": 1000,
                       "material": {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 5e6}}],
        }],
    });
    let document = &mut scene["bodies"][0];
    for (key, value) in body.as_object().unwrap() {
        document[key] = value.clone();
    }
    for (key, value) in part.as_object().unwrap() {
        document["parts"][0][key] = value.clone();
    }
    (scene, files)
}

#[test]
fn hanging_nodes_of_a_file_follow_and_are_not_split_eroded_or_in_mortar_contact() {
    use crate::mesh::local_refinement::refined_in;
    use crate::mesh::refinement_region::{Place, Region};
    let block =
        Block::uniform(Vec3::zeros(), Vec3::new(0.4, 0.4, 0.2), [4, 4, 2], "block").generate().unwrap();
    let places = Place::on_all(&block, &[Vec3::new(0.2, 0.2, 0.2)]);
    let region = Region { places, within: 0.01, size: 0.05 };
    let (fine, _) = refined_in(&block, &[region], 10_000).unwrap();
    let nothing = json!({});
    let (scene, files) = scene_of(&fine, &nothing, &nothing);
    let loaded = load(scene.to_string().as_bytes(), &files, &Budget::COMMAND_LINE).unwrap();
    let mesh = &loaded.scene.bodies[0].mesh;
    assert_eq!(mesh.hanging.len(), fine.hanging.len());
    assert!(mesh.notes.iter().any(|note| note.contains("nodes hang")), "{:?}", mesh.notes);
    let refused = |scene: &Value, files: &Files| {
        let problems = load(scene.to_string().as_bytes(), files, &Budget::COMMAND_LINE).unwrap_err();
        problems.first_error().unwrap().code.to_string()
    };
    let around =
        json!({"refinement": [{"around": {"point_m": [0.0, 0.0, 0.0]}, "within_m": 0.01, "size_m": 0.05}]});
    let (scene, files) = scene_of(&fine, &around, &nothing);
    assert_eq!(refused(&scene, &files), "refinement_of_hanging");
    let (scene, files) = scene_of(&fine, &nothing, &json!({"erosion": {"stretch": 2.0}}));
    assert_eq!(refused(&scene, &files), "hanging_with_erosion");
    let (mut scene, files) = scene_of(&fine, &nothing, &nothing);
    scene["contact"] = json!({"discretisation": "mortar"});
    assert_eq!(refused(&scene, &files), "hanging_with_mortar");
    // Nodes that hang elsewhere.
    let mut cracked = fine.clone();
    let (node, on) = fine.hanging.each().find(|(_, on)| on.len() == 4).unwrap();
    cracked.nodes[node as usize] = (fine.nodes[node as usize] + fine.nodes[on[0] as usize]) / 2.0;
    let (scene, files) = scene_of(&cracked, &nothing, &nothing);
    assert_eq!(refused(&scene, &files), "cracks");
    // Only hexahedra are split.
    let (scene, files) = scene_of(&block.split_to_wedges(), &around, &nothing);
    let loaded = load(scene.to_string().as_bytes(), &files, &Budget::COMMAND_LINE).unwrap();
    let warning = loaded.warnings.iter().find(|problem| problem.code == "refinement_without_effect").unwrap();
    assert!(warning.message.contains("only hexahedra are"), "{warning}");
}

/// Numbers of nodes from 1.
fn numbers(nodes: &[u32]) -> Vec<u32> {
    nodes.iter().map(|node| node + 1).collect()
}

fn abaqus(mesh: &Mesh) -> String {
    let nodes =
        lines(mesh.nodes.iter().enumerate().map(|(i, x)| format!("{}, {}", i + 1, list(x.iter(), ", "))));
    let mut text = format!("*NODE\n{nodes}");
    for (part, name) in (0..).zip(&mesh.parts) {
        let kind = of_part(mesh, part).next().unwrap().1.kind;
        let cells = of_part(mesh, part).map(|(e, cell)| format!("{e}, {}", list(numbers(cell.nodes), ", ")));
        let _ = write!(text, "*ELEMENT, TYPE={}, ELSET={name}\n{}", kind.table().abaqus.name, lines(cells));
    }
    text + &format!("*NSET, NSET=low\n{}\n", list(numbers(&mesh.node_sets["low"]), ", "))
}

fn lsdyna(mesh: &Mesh) -> String {
    let nodes =
        lines(mesh.nodes.iter().enumerate().map(|(i, x)| format!("{},{}", i + 1, list(x.iter(), ","))));
    let parts = lines((1..).zip(&mesh.parts).map(|(pid, name)| format!("{name}\n{pid},1,1")));
    let cell = |(e, cell): (usize, Cell)| {
        let n = numbers(cell.nodes);
        let nodes = match cell.kind {
            CellKind::Wedge6 => vec![n[0], n[1], n[2], n[2], n[3], n[4], n[5], n[5]],
            CellKind::Tet4 => vec![n[0], n[1], n[2], n[3], n[3], n[3], n[3], n[3]],
            _ => n,
        };
        format!("{},{}\n{}", e + 1, mesh.part_of[e] + 1, list(nodes, ","))
    };
    let cells = lines(mesh.cells.iter().enumerate().map(cell));
    let low = list(numbers(&mesh.node_sets["low"]), ",");
    format!(
        "*KEYWORD\n*PART\n{parts}*NODE\n{nodes}*ELEMENT_SOLID\n{cells}*SET_NODE_LIST_TITLE\nlow\n1\n{low}\n*END\n"
    )
}

fn febio(mesh: &Mesh) -> String {
    let nodes = mesh.nodes.iter().enumerate();
    let nodes = lines(nodes.map(|(i, x)| format!("<node id=\"{}\">{}</node>", i + 1, list(x.iter(), ","))));
    let mut elements = String::new();
    for (part, name) in (0..).zip(&mesh.parts) {
        let kind = match of_part(mesh, part).next().unwrap().1.kind {
            CellKind::Wedge6 => "penta6",
            kind => kind.table().name,
        };
        let cell =
            |(e, cell): (usize, Cell)| format!("<elem id=\"{e}\">{}</elem>", list(numbers(cell.nodes), ","));
        let cells = lines(of_part(mesh, part).map(cell));
        let _ = write!(elements, "<Elements type=\"{kind}\" name=\"{name}\">\n{cells}</Elements>\n");
    }
    let low = list(numbers(&mesh.node_sets["low"]), ",");
    format!(
        "<febio_spec version=\"4.0\"><Mesh><Nodes>\n{nodes}</Nodes>\n{elements}<NodeSet name=\"low\">{low}</NodeSet>\n\
         </Mesh></febio_spec>\n"
    )
}

fn nastran(mesh: &Mesh) -> String {
    let nodes = mesh.nodes.iter().enumerate();
    let nodes = lines(nodes.map(|(i, x)| format!("GRID,{},,{}", i + 1, list(x.iter(), ","))));
    let cell = |(e, cell): (usize, Cell)| {
        let name = match cell.kind {
            CellKind::Hex8 => "CHEXA",
            CellKind::Wedge6 => "CPENTA",
            _ => "CTETRA",
        };
        let fields = [vec![e as u32 + 1, mesh.part_of[e] + 1], numbers(cell.nodes)].concat();
        format!("{name},{}", list(fields.chunks(8).map(|line| list(line, ",")), "\n,"))
    };
    format!("BEGIN BULK\n{nodes}{}ENDDATA\n", lines(mesh.cells.iter().enumerate().map(cell)))
}

/// Points, connectivity, ends, types, parts and marks of the set, as words.
fn grid(mesh: &Mesh) -> [String; 6] {
    let in_order = |cell: Cell| {
        let mut nodes = vec![0; cell.nodes.len()];
        cell.kind.table().vtk.order.iter().zip(cell.nodes).for_each(|(&place, &node)| nodes[place] = node);
        nodes
    };
    let ends = mesh.cells.iter().scan(0, |end, cell| {
        *end += cell.nodes.len();
        Some(*end)
    });
    let low = &mesh.node_sets["low"];
    let marks = (0..mesh.nodes.len() as u32).map(|node| u8::from(low.contains(&node)));
    [
        list(mesh.nodes.iter().flat_map(|x| x.iter()), " "),
        list(mesh.cells.iter().flat_map(in_order), " "),
        list(ends, " "),
        list(mesh.cells.iter().map(|cell| cell.kind.table().vtk.number), " "),
        list(mesh.part_of.iter().map(|part| part + 1), " "),
        list(marks, " "),
    ]
}

fn vtk(mesh: &Mesh) -> String {
    let [points, connectivity, ends, types, parts, low] = grid(mesh);
    let (nodes, cells, entries) = (mesh.nodes.len(), mesh.cells.len(), mesh.cells.connectivity().len());
    format!(
        "# vtk DataFile Version 5.1\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {nodes} double\n{points}\n\
         CELLS {} {entries}\nOFFSETS vtktypeint64\n0 {ends}\nCONNECTIVITY vtktypeint64\n{connectivity}\n\
         CELL_TYPES {cells}\n{types}\nCELL_DATA {cells}\nSCALARS part int 1\nLOOKUP_TABLE default\n{parts}\n\
         POINT_DATA {nodes}\nSCALARS low int 1\nLOOKUP_TABLE default\n{low}\n",
        cells + 1
    )
}

fn vtu(mesh: &Mesh) -> String {
    let [points, connectivity, ends, types, parts, low] = grid(mesh);
    let array = |kind: &str, attributes: &str, words: String| {
        format!("<DataArray type=\"{kind}\" {attributes} format=\"ascii\">{words}</DataArray>\n")
    };
    let points = array("Float64", "NumberOfComponents=\"3\"", points);
    let cells = [("connectivity", connectivity), ("offsets", ends), ("types", types)];
    let cells: String =
        cells.into_iter().map(|(name, words)| array("Int64", &format!("Name=\"{name}\""), words)).collect();
    format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n\
         <PointData>{}</PointData><CellData>{}</CellData><Points>{points}</Points><Cells>{cells}</Cells>\n\
         </Piece></UnstructuredGrid></VTKFile>\n",
        mesh.nodes.len(),
        mesh.cells.len(),
        array("Int8", "Name=\"low\"", low),
        array("Int32", "Name=\"part\"", parts)
    )
}

/// A scene with a body for each part of the mesh file.
fn scene(file: &str) -> Value {
    let rubber = json!({"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 5e6});
    let body = |i: u32| {
        let part = format!("part_{i}");
        json!({
            "name": part,
            "mesh": {"file": {"name": file, "parts": [part]}},
            "parts": [{"part": part, "density_kg_per_m3": 1000, "material": rubber}],
        })
    };
    json!({"name": "kinds", "end_time_s": 0.001, "bodies": (1..=4).map(body).collect::<Vec<_>>()})
}

#[test]
fn every_format_gives_the_same_bodies() {
    let mesh = mesh();
    let text = |text: String| text.into_bytes();
    let files = Files(vec![
        ("mesh.msh", write_gmsh(&mesh, Version::V4_1, Encoding::Ascii)),
        ("mesh.inp", text(abaqus(&mesh))),
        ("mesh.vtk", text(vtk(&mesh))),
        ("mesh.vtu", text(vtu(&mesh))),
        ("mesh.k", text(lsdyna(&mesh))),
        ("mesh.feb", text(febio(&mesh))),
        ("mesh.bdf", text(nastran(&mesh))),
    ]);
    for (name, _) in &files.0 {
        let document = scene(name).to_string();
        let loaded = load(document.as_bytes(), &files, &Budget::COMMAND_LINE);
        let loaded = loaded.unwrap_or_else(|problems| panic!("{name}: {problems:#?}"));
        for (i, body) in loaded.scene.bodies.iter().enumerate() {
            let mut expected = mesh.select_parts(&[&format!("part_{}", i + 1)]).unwrap();
            // Nastran has no sets.
            if *name == "mesh.bdf" {
                expected.node_sets.clear();
            }
            assert_eq!(body.mesh, expected, "{name}");
        }
    }
}

#[test]
fn included_files_are_part_of_the_content() {
    let folder = tempfile::tempdir().unwrap();
    let whole = lsdyna(&mesh());
    let start = whole.find("*NODE\n").unwrap();
    let end = whole.find("*ELEMENT_SOLID").unwrap();
    let main = format!("{}*INCLUDE\nnodes.k\n{}", &whole[..start], &whole[end..]);
    std::fs::write(folder.path().join("mesh.k"), main).unwrap();
    let load_with = |nodes: &str| {
        std::fs::write(folder.path().join("nodes.k"), nodes).unwrap();
        let document = scene("mesh.k").to_string();
        load(document.as_bytes(), &FolderSource::new(folder.path()), &Budget::COMMAND_LINE)
    };
    let loaded = load_with(&whole[start..end]).unwrap();
    assert_eq!(loaded.scene.bodies[0].mesh, mesh().select_parts(&["part_1"]).unwrap());
    assert_eq!(loaded.scene.mesh_files.keys().collect::<Vec<_>>(), ["mesh.k", "nodes.k"]);
    let other = load_with(&format!("{}$ a comment\n", &whole[start..end])).unwrap();
    assert_ne!(loaded.scene.content_hash, other.scene.content_hash);
    let Problems(found) = load_with("*NODE\n1,x\n").unwrap_err();
    assert!(found[0].message.contains("line 2 of nodes.k"), "{found:#?}");
}
