//! Gmsh `.msh` files, versions 2.2 and 4.1 (Gmsh reference manual, "MSH file format").

mod element_kind;
mod version_2;
mod version_4;

use super::assembly::{Assembly, NodeTag};
use super::cursor::{Cursor, Numbers, shown};
use crate::mesh::{Mesh, MeshError};
use element_kind::ElementKind;
use std::collections::BTreeMap;

/// Reads a `.msh` file.
///
/// # Errors
/// As [`super::read_mesh`].
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let mut cursor = Cursor::new(bytes);
    skip_comments(&mut cursor)?;
    let version = read_format(&mut cursor)?;
    let mut contents = Contents::default();
    let mut skipped: Vec<String> = Vec::new();
    while !cursor.at_end() {
        let start = cursor.offset();
        let line = cursor.filled_line();
        let Some(name) = line.strip_prefix(b"$").and_then(|name| std::str::from_utf8(name).ok()) else {
            return Err(cursor.error_at(start, format!("expected a section, found {}", shown(line))));
        };
        match (name, version) {
            ("PhysicalNames", _) => read_physical_names(&mut cursor, &mut contents)?,
            ("Nodes", Version::Two) => version_2::read_nodes(&mut cursor, &mut contents)?,
            ("Elements", Version::Two) => version_2::read_elements(&mut cursor, &mut contents)?,
            ("Entities", Version::Four) => version_4::read_entities(&mut cursor, &mut contents)?,
            ("Nodes", Version::Four) => version_4::read_nodes(&mut cursor, &mut contents)?,
            ("Elements", Version::Four) => version_4::read_elements(&mut cursor, &mut contents)?,
            ("ParametricNodes", Version::Two) => {
                return Err(MeshError::Unsupported {
                    what: "nodes with parametric coordinates in version 2.2".into(),
                    remedy: "save it without them, or as version 4.1".into(),
                });
            }
            ("PartitionedEntities", _) => {
                return Err(MeshError::Unsupported {
                    what: "a partitioned mesh".into(),
                    remedy: "save it without partitions".into(),
                });
            }
            _ => {
                skipped.push(name.to_owned());
                cursor.skip_section(name)?;
                continue;
            }
        }
        cursor.end_section(name)?;
    }
    if !skipped.is_empty() {
        contents.assembly.notes.push(format!("sections not used: {}", skipped.join(", ")));
    }
    contents.into_mesh(bytes, cursor.numbers)
}

/// The versions that are read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// Moves behind `$MeshFormat`; comments may stand before it.
fn skip_comments(cursor: &mut Cursor) -> Result<(), MeshError> {
    loop {
        let start = cursor.offset();
        match cursor.filled_line() {
            b"$MeshFormat" => return Ok(()),
            b"$Comments" => cursor.skip_section("Comments")?,
            line => {
                return Err(cursor.error_at(start, format!("expected $MeshFormat, found {}", shown(line))));
            }
        }
    }
}

/// Version, encoding and byte order; leaves the cursor behind `$EndMeshFormat`.
fn read_format(cursor: &mut Cursor) -> Result<Version, MeshError> {
    let start = cursor.offset();
    let line = String::from_utf8_lossy(cursor.line()).into_owned();
    let words: Vec<&str> = line.split_whitespace().collect();
    let &[version, encoding, size] = &words[..] else {
        return Err(cursor.error_at(start, "expected version, encoding and data size after $MeshFormat"));
    };
    let version = match version {
        "2.2" | "2" | "2.0" | "2.1" => Version::Two,
        "4.1" => Version::Four,
        other => {
            return Err(MeshError::Unsupported {
                what: format!("Gmsh format version {other}"),
                remedy: "save it as version 4.1 or 2.2".into(),
            });
        }
    };
    match encoding {
        "0" => {}
        "1" if size == "8" => {
            // The number one, written as the machine does, tells the byte order.
            cursor.numbers = Numbers::LittleEndian;
            match cursor.int("the number 1 that tells the byte order")? {
                1 => {}
                swapped if swapped == 1_i32.swap_bytes() => cursor.numbers = Numbers::BigEndian,
                other => return Err(cursor.error(format!("expected the number 1, found {other}"))),
            }
        }
        _ => {
            return Err(MeshError::Unsupported {
                what: format!("encoding {encoding} with data of {size} bytes"),
                remedy: "save it as ASCII, or binary with 8 bytes".into(),
            });
        }
    }
    cursor.end_section("MeshFormat")?;
    Ok(version)
}

/// Dimension and tag, two words, and a name in quotes on each line; text in binary files too.
fn read_physical_names(cursor: &mut Cursor, contents: &mut Contents) -> Result<(), MeshError> {
    let count: u64 = cursor.parsed("the number of physical names")?;
    cursor.line();
    for _ in 0..count {
        let dimension: u8 = cursor.parsed("the dimension of a physical group")?;
        let tag: i32 = cursor.parsed("the tag of a physical group")?;
        let start = cursor.offset();
        let quoted = String::from_utf8_lossy(cursor.line()).into_owned();
        let name = quoted.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        match name {
            Some(name) if !name.is_empty() => contents.names.insert((dimension, tag), name.to_owned()),
            _ => return Err(cursor.error_at(start, format!("expected a name in quotes, found {quoted:?}"))),
        };
    }
    Ok(())
}

/// What was read so far.
#[derive(Default)]
struct Contents {
    assembly: Assembly,
    /// Names of the physical groups by dimension and tag.
    names: BTreeMap<(u8, i32), String>,
    /// Physical groups of each geometrical entity by dimension and tag (version 4).
    groups_of_entity: BTreeMap<(u8, i32), Vec<i32>>,
    /// Physical group of each hexahedron; zero for none.
    group_of_hex: Vec<i32>,
    /// Nodes of the elements in each physical group of points, lines and surfaces.
    boundary: BTreeMap<(u8, i32), Vec<NodeTag>>,
    /// Hexahedra in more than one physical group.
    in_many_groups: usize,
}

impl Contents {
    /// Takes in one element of these physical groups.
    fn add_element(&mut self, kind: &ElementKind, groups: &[i32], nodes: &[u64], offset: usize) {
        if let (true, Ok(hex)) = (kind.is_hex8(), <[u64; 8]>::try_from(nodes)) {
            self.assembly.add_hex(hex, offset);
            self.group_of_hex.push(groups.first().copied().unwrap_or(0));
            self.in_many_groups += usize::from(groups.len() > 1);
            return;
        }
        if kind.dimension == 3 {
            *self.assembly.unsupported.entry(kind.name.to_owned()).or_default() += 1;
            return;
        }
        for &group in groups {
            let nodes = nodes.iter().map(|&tag| NodeTag { tag, offset });
            self.boundary.entry((kind.dimension, group)).or_default().extend(nodes);
        }
    }

    /// Adds a node of the file.
    fn add_node(
        &mut self,
        cursor: &Cursor,
        tag: u64,
        position: [f64; 3],
        offset: usize,
    ) -> Result<(), MeshError> {
        if self.assembly.add_node(tag, position.into()) {
            Ok(())
        } else {
            Err(cursor.error_at(offset, format!("node {tag} is there twice")))
        }
    }

    /// Names groups and hands all to the assembly. Groups without a name are called `physical_1`, those of lines and
    /// points `physical_line_1` and `physical_point_1`, since tags count anew in each dimension.
    fn into_mesh(mut self, bytes: &[u8], numbers: Numbers) -> Result<Mesh, MeshError> {
        let name_of = |dimension: u8, group: i32| match (self.names.get(&(dimension, group)), dimension) {
            (Some(name), _) => name.clone(),
            (None, 0) => format!("physical_point_{group}"),
            (None, 1) => format!("physical_line_{group}"),
            (None, _) if group == 0 => "unnamed".to_owned(),
            (None, _) => format!("physical_{group}"),
        };
        let mut groups = self.group_of_hex.clone();
        groups.sort_unstable();
        groups.dedup();
        let part_of_group: BTreeMap<i32, u32> =
            groups.into_iter().map(|group| (group, self.assembly.part(&name_of(3, group)))).collect();
        self.assembly.part_of = self.group_of_hex.iter().map(|group| part_of_group[group]).collect();
        for ((dimension, group), nodes) in std::mem::take(&mut self.boundary) {
            // Group zero means that an element is in no group.
            if group != 0 {
                self.assembly.node_sets.entry(name_of(dimension, group)).or_default().extend(nodes);
            }
        }
        if self.in_many_groups > 0 {
            self.assembly.notes.push(format!(
                "{} hexahedra are in more than one physical group and belong to the first",
                self.in_many_groups
            ));
        }
        self.assembly.into_mesh(bytes, numbers)
    }
}
