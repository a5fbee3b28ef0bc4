//! Gmsh `.msh` files, versions 2.2 and 4.1 (Gmsh reference manual, "MSH file format").

mod contents;
mod element_kind;
mod version_2;
mod version_4;

use super::cursor::{Cursor, Numbers, shown};
use crate::mesh::{Mesh, MeshError};
use contents::Contents;

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

/// Versions of the file format that are read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// Moves to the end of the line `$MeshFormat`; comments may precede it.
fn skip_comments(cursor: &mut Cursor) -> Result<(), MeshError> {
    loop {
        let start = cursor.offset();
        match cursor.filled_line() {
            b"$MeshFormat" => return Ok(()),
            b"$Comments" => cursor.skip_section("Comments")?,
            b"$NOD" => {
                return Err(MeshError::Unsupported {
                    what: "Gmsh format version 1".into(),
                    remedy: "save it as version 4.1 or 2.2, as `gmsh FILE -save -format msh41` does".into(),
                });
            }
            line => {
                return Err(cursor.error_at(start, format!("expected $MeshFormat, found {}", shown(line))));
            }
        }
    }
}

/// Reads version, encoding and byte order; moves the cursor past `$EndMeshFormat`.
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
            // The number one, in the byte order of the writing machine, identifies that order.
            cursor.numbers = Numbers::LittleEndian;
            match cursor.int("the number 1 that shows the byte order")? {
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

/// Reads the physical names: dimension and tag, as two words, and a name in quotes on each line; text in binary files too.
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
