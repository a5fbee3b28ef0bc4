//! Nodes and elements of version 2.2. Counts are lines of text in binary files too, where tags are C `int`s.

use super::contents::Contents;
use super::element_kind::ElementKind;
use crate::mesh::MeshError;
use crate::mesh::read::cursor::{Cursor, Numbers};

/// Reads `$Nodes`: count, then number and three coordinates each.
pub(super) fn read_nodes(cursor: &mut Cursor, contents: &mut Contents) -> Result<(), MeshError> {
    let count: u64 = cursor.parsed("the number of nodes")?;
    cursor.line();
    for _ in 0..cursor.counted(count, 4, 28, "nodes")? {
        let offset = cursor.offset();
        let tag = tag(cursor, "the number of a node")?;
        let mut position = [0.0; 3];
        for x in &mut position {
            *x = cursor.double("a coordinate")?;
        }
        contents.add_node(cursor, tag, position, offset)?;
    }
    Ok(())
}

/// Reads `$Elements`: in text, number, kind, number of tags, tags, nodes each; in binary, blocks of one kind.
pub(super) fn read_elements(cursor: &mut Cursor, contents: &mut Contents) -> Result<(), MeshError> {
    let count: u64 = cursor.parsed("the number of elements")?;
    cursor.line();
    let count = cursor.counted(count, 4, 12, "elements")?;
    if cursor.numbers == Numbers::Text {
        for _ in 0..count {
            let number = tag(cursor, "the number of an element")?;
            let (kind, offset) = kind(cursor)?;
            let tags = tag(cursor, "the number of tags")?;
            read_element(cursor, contents, (number, &kind), tags, offset)?;
        }
        return Ok(());
    }
    let mut read = 0;
    while read < count {
        let (kind, offset) = kind(cursor)?;
        let in_block = tag(cursor, "the number of elements in a block")?;
        let tags = tag(cursor, "the number of tags")?;
        let bytes_each = 4 * (1 + tags + u64::from(kind.nodes));
        let in_block = cursor.counted(in_block, 0, bytes_each, "elements")?;
        if in_block == 0 || in_block > count - read {
            return Err(cursor.error_at(
                offset,
                format!("a block of {in_block} elements where {} are left", count - read),
            ));
        }
        for _ in 0..in_block {
            let offset = cursor.offset();
            let number = tag(cursor, "the number of an element")?;
            read_element(cursor, contents, (number, &kind), tags, offset)?;
        }
        read += in_block;
    }
    Ok(())
}

/// Reads tags and nodes of one element. The first tag is its physical group.
fn read_element(
    cursor: &mut Cursor,
    contents: &mut Contents,
    (number, kind): (u64, &ElementKind),
    tags: u64,
    offset: usize,
) -> Result<(), MeshError> {
    let mut group = 0;
    for i in 0..cursor.counted(tags, 1, 4, "tags")? {
        let value = cursor.int("a tag")?;
        if i == 0 {
            // A negative group only means that the element is reversed.
            group = value.wrapping_abs();
        }
    }
    let mut nodes = [0; 125];
    let nodes = &mut nodes[..usize::from(kind.nodes)];
    for node in nodes.iter_mut() {
        *node = tag(cursor, "the number of a node")?;
    }
    contents.add_element(cursor, (number, kind), &[group], (nodes, offset))
}

/// Reads the kind of the next element; also returns its offset.
fn kind(cursor: &mut Cursor) -> Result<(ElementKind, usize), MeshError> {
    let offset = cursor.offset();
    let number = cursor.int("the kind of an element")?;
    let known = ElementKind::of(number);
    Ok((known.ok_or_else(|| cursor.error_at(offset, format!("element type {number} is unknown")))?, offset))
}

/// Reads a number that must not be negative.
fn tag(cursor: &mut Cursor, what: &str) -> Result<u64, MeshError> {
    let offset = cursor.offset();
    let value = cursor.int(what)?;
    u64::try_from(value).map_err(|_| cursor.error_at(offset, format!("{what} is negative: {value}")))
}
