//! Entities, nodes and elements of version 4.1: numbers in the same order in text and binary.

use super::contents::Contents;
use super::element_kind::ElementKind;
use crate::mesh::MeshError;
use crate::mesh::read::cursor::Cursor;

/// Largest number of physical groups of an entity; prevents a small file from creating endless copies of its elements.
const MAX_GROUPS: usize = 64;

/// Reads `$Entities`: the physical groups of each point, curve, surface and volume.
pub(super) fn read_entities(cursor: &mut Cursor, contents: &mut Contents) -> Result<(), MeshError> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = cursor.size("the number of entities")?;
    }
    for (dimension, count) in (0_u8..).zip(counts) {
        // A point has a position, the others a bounding box and a list of bounding entities.
        let (coordinates, lists) = if dimension == 0 { (3, 1) } else { (6, 2) };
        let words = 1 + coordinates + lists;
        for _ in 0..cursor.counted(count, words, 4 + 8 * (coordinates + lists), "entities")? {
            let tag = cursor.int("the tag of an entity")?;
            for _ in 0..coordinates {
                cursor.double("a coordinate")?;
            }
            let groups = read_tags(cursor, "physical groups")?;
            if dimension > 0 {
                read_tags(cursor, "bounding entities")?;
            }
            if groups.len() > MAX_GROUPS {
                return Err(
                    cursor.error(format!("entity {tag} is in more than {MAX_GROUPS} physical groups"))
                );
            }
            // A negative tag only means that the entity is reversed.
            let groups = groups.into_iter().map(i32::wrapping_abs).collect();
            contents.groups_of_entity.insert((dimension, tag), groups);
        }
    }
    Ok(())
}

/// Reads `$Nodes`: blocks by entity, each with all tags, then all positions.
pub(super) fn read_nodes(cursor: &mut Cursor, contents: &mut Contents) -> Result<(), MeshError> {
    let [blocks, ..] = read_header(cursor)?;
    for _ in 0..cursor.counted(blocks, 4, 20, "blocks of nodes")? {
        let (dimension, _) = read_entity(cursor)?;
        let parametric = cursor.int("whether nodes are parametric")?;
        let count = cursor.size("the number of nodes in a block")?;
        let parameters = if parametric == 0 { 0 } else { dimension };
        let count =
            cursor.counted(count, 4 + u64::from(parameters), 32 + 8 * u64::from(parameters), "nodes")?;
        let mut tags = Vec::with_capacity(count);
        for _ in 0..count {
            let offset = cursor.offset();
            tags.push((cursor.size("the tag of a node")?, offset));
        }
        for (tag, offset) in tags {
            let mut position = [0.0; 3];
            for x in &mut position {
                *x = cursor.double("a coordinate")?;
            }
            for _ in 0..parameters {
                cursor.double("a parametric coordinate")?;
            }
            contents.add_node(cursor, tag, position, offset)?;
        }
    }
    Ok(())
}

/// Reads `$Elements`: blocks by entity and kind.
pub(super) fn read_elements(cursor: &mut Cursor, contents: &mut Contents) -> Result<(), MeshError> {
    let [blocks, ..] = read_header(cursor)?;
    for _ in 0..cursor.counted(blocks, 4, 20, "blocks of elements")? {
        let (dimension, entity) = read_entity(cursor)?;
        let offset = cursor.offset();
        let number = cursor.int("the kind of elements")?;
        let kind = ElementKind::of(number)
            .ok_or_else(|| cursor.error_at(offset, format!("element type {number} is unknown")))?;
        if kind.dimension != dimension {
            return Err(
                cursor.error_at(offset, format!("a {} on an entity of dimension {dimension}", kind.name))
            );
        }
        let count = cursor.size("the number of elements in a block")?;
        let words = 1 + u64::from(kind.nodes);
        let groups = contents.groups_of_entity.get(&(dimension, entity)).cloned().unwrap_or_default();
        for _ in 0..cursor.counted(count, words, 8 * words, "elements")? {
            let tag = cursor.size("the tag of an element")?;
            let offset = cursor.offset();
            let mut nodes = [0; 125];
            let nodes = &mut nodes[..usize::from(kind.nodes)];
            for node in nodes.iter_mut() {
                *node = cursor.size("the tag of a node")?;
            }
            contents.add_element(cursor, (tag, &kind), &groups, (nodes, offset))?;
        }
    }
    Ok(())
}

/// Reads the numbers of blocks and items, and the smallest and largest tag.
fn read_header(cursor: &mut Cursor) -> Result<[u64; 4], MeshError> {
    let mut header = [0; 4];
    for value in &mut header {
        *value = cursor.size("the header of a section")?;
    }
    Ok(header)
}

/// Reads dimension and tag of the entity of a block.
fn read_entity(cursor: &mut Cursor) -> Result<(u8, i32), MeshError> {
    let offset = cursor.offset();
    let dimension = cursor.int("the dimension of an entity")?;
    let dimension = u8::try_from(dimension).ok().filter(|d| *d <= 3);
    let dimension = dimension.ok_or_else(|| cursor.error_at(offset, "an entity has 0 to 3 dimensions"))?;
    Ok((dimension, cursor.int("the tag of an entity")?))
}

/// Reads a counted list of tags.
fn read_tags(cursor: &mut Cursor, what: &str) -> Result<Vec<i32>, MeshError> {
    let count = cursor.size(what)?;
    let count = cursor.counted(count, 1, 4, what)?;
    let mut tags = Vec::with_capacity(count);
    for _ in 0..count {
        tags.push(cursor.int(what)?);
    }
    Ok(tags)
}
