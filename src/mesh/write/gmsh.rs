//! Gmsh `.msh` files: parts as physical volumes, node sets as physical groups of points.
//!
//! Reading such a file reproduces the nodes (to the last bit), elements, parts and node sets. The format has no material
//! axes and notes.

use crate::mesh::cell::MOST_NODES;
use crate::mesh::{Cell, CellKind, Mesh};

/// Version of the format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// Version 2.2, which most programs read.
    V2_2,
    /// Version 4.1, the current one.
    V4_1,
}

/// Encoding of numbers in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Decimal text, human-readable.
    Ascii,
    /// Binary, least significant byte first.
    LittleEndian,
    /// Binary, most significant byte first.
    BigEndian,
}

/// Gmsh's element type of a point.
const POINT: i32 = 15;

/// The mesh as a `.msh` file.
pub fn write_gmsh(mesh: &Mesh, version: Version, encoding: Encoding) -> Vec<u8> {
    let mut out = Output { bytes: Vec::new(), encoding };
    let number = match version {
        Version::V2_2 => "2.2",
        Version::V4_1 => "4.1",
    };
    out.text(&format!("$MeshFormat\n{number} {} 8\n", u8::from(encoding != Encoding::Ascii)));
    if encoding != Encoding::Ascii {
        out.int(1);
        out.end_line();
    }
    out.text("$EndMeshFormat\n");
    write_names(&mut out, mesh);
    match version {
        Version::V2_2 => write_version_2(&mut out, mesh),
        Version::V4_1 => write_version_4(&mut out, mesh),
    }
    out.bytes
}

/// Names of the physical groups: parts are numbered from 1, followed by node sets.
fn write_names(out: &mut Output, mesh: &Mesh) {
    let clean = |name: &str| name.replace(['"', '\n', '\r'], "_");
    out.text(&format!("$PhysicalNames\n{}\n", mesh.parts.len() + mesh.node_sets.len()));
    for (i, name) in mesh.node_sets.keys().enumerate() {
        out.text(&format!("0 {} \"{}\"\n", mesh.parts.len() + 1 + i, clean(name)));
    }
    for (i, name) in mesh.parts.iter().enumerate() {
        out.text(&format!("3 {} \"{}\"\n", i + 1, clean(name)));
    }
    out.text("$EndPhysicalNames\n");
}

/// Physical group and members of each node set.
fn grouped_sets(mesh: &Mesh) -> impl Iterator<Item = (i32, &[u32])> {
    (tag(mesh.parts.len() as u32)..).zip(mesh.node_sets.values().map(Vec::as_slice))
}

/// Gmsh counts from one, in a signed integer. Meshes of more than 2³¹ nodes do not fit into memory.
fn tag(index: u32) -> i32 {
    index.cast_signed() + 1
}

/// Nodes and elements of version 2.2. Each element has two tags, its physical group and its geometrical entity.
fn write_version_2(out: &mut Output, mesh: &Mesh) {
    out.text(&format!("$Nodes\n{}\n", mesh.nodes.len()));
    for (a, x) in (0..).zip(&mesh.nodes) {
        out.int(tag(a));
        out.doubles(x.as_slice());
        out.end_item();
    }
    out.end_section("Nodes");

    let points: usize = mesh.node_sets.values().map(Vec::len).sum();
    out.text(&format!("$Elements\n{}\n", points + mesh.cells.len()));
    let mut number = 0;
    let mut element = |kind: i32, group: i32, nodes: &[u32]| {
        number += 1;
        // In binary, each element is a block of its own: kind, one element, two tags.
        match out.encoding {
            Encoding::Ascii => out.ints(&[number, kind, 2]),
            _ => out.ints(&[kind, 1, 2, number]),
        }
        out.ints(&[group, group]);
        for &a in nodes {
            out.int(tag(a));
        }
        out.end_item();
    };
    for (group, set) in grouped_sets(mesh) {
        for &a in set {
            element(POINT, group, &[a]);
        }
    }
    for (cell, &part) in mesh.cells.iter().zip(&mesh.part_of) {
        let number = i32::from(cell.kind.table().gmsh.number);
        element(number, tag(part), &gmsh_nodes(cell)[..cell.nodes.len()]);
    }
    out.end_section("Elements");
}

/// Entities, nodes and elements of version 4.1. Each part is a volume, each node set a point, with the same tag as its
/// physical group; all nodes belong to the first volume.
fn write_version_4(out: &mut Output, mesh: &Mesh) {
    out.text("$Entities\n");
    out.sizes(&[mesh.node_sets.len() as u64, 0, 0, mesh.parts.len() as u64]);
    out.end_item();
    for (group, _) in grouped_sets(mesh) {
        out.int(group);
        out.doubles(&[0.0; 3]);
        out.size(1);
        out.int(group);
        out.end_item();
    }
    let bounds = mesh.bounding_box().unwrap_or_default();
    for part in (0..mesh.parts.len() as u32).map(tag) {
        out.int(part);
        out.doubles(bounds[0].as_slice());
        out.doubles(bounds[1].as_slice());
        out.size(1);
        out.int(part);
        out.size(0);
        out.end_item();
    }
    out.end_section("Entities");

    let nodes = mesh.nodes.len() as u64;
    out.text("$Nodes\n");
    out.header(1, nodes);
    out.block(3, 1, 0, nodes);
    for tag in 1..=nodes {
        out.size(tag);
        out.end_item();
    }
    for x in &mesh.nodes {
        out.doubles(x.as_slice());
        out.end_item();
    }
    out.end_section("Nodes");
    write_elements_4(out, mesh);
}

/// Elements of version 4.1: a block for each node set, and one for each run of cells of the same part and kind, which
/// preserves their order.
fn write_elements_4(out: &mut Output, mesh: &Mesh) {
    let points: usize = mesh.node_sets.values().map(Vec::len).sum();
    let runs = runs(mesh);
    out.text("$Elements\n");
    out.header(mesh.node_sets.len() + runs.len(), (points + mesh.cells.len()) as u64);
    let mut number = 0;
    let mut element = |out: &mut Output, nodes: &[u32]| {
        number += 1;
        out.size(number);
        for &a in nodes {
            out.size(u64::from(a) + 1);
        }
        out.end_item();
    };
    for (group, set) in grouped_sets(mesh) {
        out.block(0, group, POINT, set.len() as u64);
        for &a in set {
            element(out, &[a]);
        }
    }
    let mut cells = mesh.cells.iter();
    for (part, kind, count) in runs {
        out.block(3, tag(part), i32::from(kind.table().gmsh.number), count as u64);
        for cell in cells.by_ref().take(count) {
            element(out, &gmsh_nodes(cell)[..cell.nodes.len()]);
        }
    }
    out.end_section("Elements");
}

/// Part, kind and length of each run of consecutive cells with the same part and kind.
fn runs(mesh: &Mesh) -> Vec<(u32, CellKind, usize)> {
    let mut runs: Vec<(u32, CellKind, usize)> = Vec::new();
    for (cell, &part) in mesh.cells.iter().zip(&mesh.part_of) {
        match runs.last_mut() {
            Some((last, kind, count)) if (*last, *kind) == (part, cell.kind) => *count += 1,
            _ => runs.push((part, cell.kind, 1)),
        }
    }
    runs
}

/// Nodes of a cell in Gmsh's order, as many as it has.
fn gmsh_nodes(cell: Cell) -> [u32; MOST_NODES] {
    let mut nodes = [0; MOST_NODES];
    for (&place, &node) in cell.kind.table().gmsh.order.iter().zip(cell.nodes) {
        nodes[place] = node;
    }
    nodes
}

/// The file being written.
struct Output {
    bytes: Vec<u8>,
    encoding: Encoding,
}

impl Output {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    /// Writes a C `int`.
    fn int(&mut self, value: i32) {
        match self.encoding {
            Encoding::Ascii => self.text(&format!("{value} ")),
            Encoding::LittleEndian => self.bytes.extend(value.to_le_bytes()),
            Encoding::BigEndian => self.bytes.extend(value.to_be_bytes()),
        }
    }

    /// Writes a C `size_t` of eight bytes.
    fn size(&mut self, value: u64) {
        match self.encoding {
            Encoding::Ascii => self.text(&format!("{value} ")),
            Encoding::LittleEndian => self.bytes.extend(value.to_le_bytes()),
            Encoding::BigEndian => self.bytes.extend(value.to_be_bytes()),
        }
    }

    /// Writes a C `double`; the text is the shortest that reads back to the same bits.
    fn double(&mut self, value: f64) {
        match self.encoding {
            Encoding::Ascii => self.text(&format!("{value:e} ")),
            Encoding::LittleEndian => self.bytes.extend(value.to_le_bytes()),
            Encoding::BigEndian => self.bytes.extend(value.to_be_bytes()),
        }
    }

    fn ints(&mut self, values: &[i32]) {
        for &value in values {
            self.int(value);
        }
    }

    fn sizes(&mut self, values: &[u64]) {
        for &value in values {
            self.size(value);
        }
    }

    fn doubles(&mut self, values: &[f64]) {
        for &value in values {
            self.double(value);
        }
    }

    /// Writes the numbers of blocks and items, and the smallest and largest tag (version 4.1).
    fn header(&mut self, blocks: usize, items: u64) {
        self.sizes(&[blocks as u64, items, 1, items]);
        self.end_item();
    }

    /// Writes dimension and tag of the entity of a block, the type of its items, and their number (version 4.1).
    fn block(&mut self, dimension: i32, entity: i32, what: i32, items: u64) {
        self.ints(&[dimension, entity, what]);
        self.size(items);
        self.end_item();
    }

    /// Ends an item of text with a line break; binary has none.
    fn end_item(&mut self) {
        if self.encoding == Encoding::Ascii {
            self.end_line();
        }
    }

    fn end_line(&mut self) {
        self.text("\n");
    }

    fn end_section(&mut self, name: &str) {
        if self.encoding != Encoding::Ascii {
            self.end_line();
        }
        self.text(&format!("$End{name}\n"));
    }
}
