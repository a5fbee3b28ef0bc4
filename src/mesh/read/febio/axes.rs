//! Material axes of the elements of FEBio files: `<ElementData>` of type `fiber` or `mat_axis` in `<MeshData>` (FEBio User Manual,
//! "MeshData Section").

use super::lists::{self, Kind};
use crate::mechanics::tensor::Vec3;
use crate::mesh::MeshError;
use crate::mesh::read::cursor::shown;
use crate::mesh::read::xml::Xml;
use roxmltree::Node;
use std::collections::{BTreeMap, HashMap};

/// Sine of the angle between two directions below which they are parallel.
const PARALLEL: f64 = 1e-9;

/// Cosine of the angle between a fibre and y from which FEBio completes its axes with z.
const ALONG_Y: f64 = 0.999;

/// The type of element data of axes; `None` for other data.
fn kind<'s>(node: &Node<'s, 's>) -> Option<&'s str> {
    // `var` in version 2.5.
    let named = node.attribute("type").or_else(|| node.attribute("var"));
    named.filter(|kind| node.has_tag_name("ElementData") && ["fiber", "mat_axis"].contains(kind))
}

/// Whether an element of `<MeshData>` has material axes in it.
pub(crate) fn is_axes(node: Node) -> bool {
    // Of any lifetime: only the answer leaves.
    kind(&node).is_some()
}

/// Axes e1, e2, e3 of all cells, in their order, x, y, z where the file has none; and whether it has any for each. Both are empty where it has
/// none at all.
///
/// # Errors
/// `Malformed` for an element that is not in its set, and axes without a direction; `Unsupported` for a set that is not there.
pub(super) fn axes<'s>(xml: &'s Xml, mesh: Node<'s, 's>) -> Result<(Vec<[Vec3; 3]>, Vec<bool>), MeshError> {
    let sections = xml.root().children().filter(|node| node.has_tag_name("MeshData"));
    let data: Vec<(Node, &str)> = sections
        .flat_map(|section| section.children())
        .filter_map(|node| Some((node, kind(&node)?)))
        .collect();
    if data.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let cell_of = cells(xml, mesh)?;
    let mut axes = vec![[Vec3::x(), Vec3::y(), Vec3::z()]; cell_of.len()];
    let mut has_axes = vec![false; cell_of.len()];
    let mut sets: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    for (node, kind) in data {
        let name = xml.attribute(node, "elem_set")?;
        if !sets.contains_key(name) {
            sets.insert(name, members(xml, mesh, node, name)?);
        }
        let members = sets.get(name).map(Vec::as_slice).unwrap_or_default();
        for item in node.children().filter(Node::is_element) {
            let local: usize = xml.number(item, "lid")?;
            let member = local.checked_sub(1).and_then(|index| members.get(index));
            let cell = member.and_then(|tag| cell_of.get(tag)).copied().ok_or_else(|| {
                let count = members.len();
                xml.error(
                    item,
                    format!("lid {local} is no volume element of its set, which has {count} elements"),
                )
            })?;
            axes[cell] = if kind == "fiber" { along(xml, item)? } else { frame(xml, item)? };
            has_axes[cell] = true;
        }
    }
    Ok((axes, has_axes))
}

/// Index of each cell by its number in the file.
fn cells<'s>(xml: &'s Xml, mesh: Node<'s, 's>) -> Result<HashMap<u64, usize>, MeshError> {
    let mut cells = HashMap::new();
    for section in mesh.children().filter(|node| node.has_tag_name("Elements")) {
        if let Kind::Cell(_) = Kind::of(xml.attribute(section, "type")?) {
            for element in section.children().filter(Node::is_element) {
                let next = cells.len();
                cells.insert(xml.number(element, "id")?, next);
            }
        }
    }
    Ok(cells)
}

/// Numbers of the elements of the set of some data, in its order: an `<ElementSet>`, or the `<Elements>` of that name.
fn members<'s>(
    xml: &'s Xml,
    mesh: Node<'s, 's>,
    data: Node<'s, 's>,
    name: &str,
) -> Result<Vec<u64>, MeshError> {
    let named = |tag: &'static str| {
        mesh.children().filter(move |node| {
            node.has_tag_name(tag) && node.attribute("name").map(str::trim) == Some(name.trim())
        })
    };
    if let Some(set) = named("ElementSet").next() {
        return lists::members(xml, set);
    }
    let elements = named("Elements").flat_map(|section| section.children()).filter(Node::is_element);
    let found = elements.map(|element| xml.number(element, "id")).collect::<Result<Vec<u64>, _>>()?;
    if found.is_empty() {
        let message = format!("there is no element set {}", shown(name.as_bytes()));
        return Err(xml.error(data, message));
    }
    Ok(found)
}

/// The direction in the text of an element.
fn direction<'s>(xml: &'s Xml, node: Node<'s, 's>) -> Result<Vec3, MeshError> {
    let text = node.text().unwrap_or_default();
    let numbers: Option<Vec<f64>> = text.split(',').map(|field| field.trim().parse().ok()).collect();
    let vector = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()).map(Vec3::from);
    vector
        .and_then(|vector| vector.try_normalize(0.0))
        .filter(|unit| unit.iter().all(|x| x.is_finite()))
        .ok_or_else(|| {
            let message =
                format!("expected a direction of three numbers, found {}", shown(text.trim().as_bytes()));
            xml.error(node, message)
        })
}

/// Axes with e1 along a fibre, and the others as FEBio completes them.
fn along<'s>(xml: &'s Xml, item: Node<'s, 's>) -> Result<[Vec3; 3], MeshError> {
    let e1 = direction(xml, item)?;
    let aside = if e1.y.abs() > ALONG_Y { Vec3::z() } else { Vec3::y() };
    let e3 = e1.cross(&aside).normalize();
    Ok([e1, e3.cross(&e1), e3])
}

/// Axes with e1 along a, and e2 in the plane of a and d.
fn frame<'s>(xml: &'s Xml, item: Node<'s, 's>) -> Result<[Vec3; 3], MeshError> {
    let e1 = direction(xml, xml.child(item, "a")?)?;
    let d = direction(xml, xml.child(item, "d")?)?;
    let e3 = e1.cross(&d).try_normalize(PARALLEL);
    let e3 = e3.ok_or_else(|| xml.error(item, "a and d are parallel: they span no plane"))?;
    Ok([e1, e3.cross(&e1), e3])
}
