//! Which kinds of cells have a finite element; the only place that decides this.

use super::problem::{Pointer, Problem};
use crate::mesh::{CellKind, Mesh};

/// Whether there is a finite element for a kind of cell.
pub fn has_element(kind: CellKind) -> bool {
    matches!(kind, CellKind::Hex8)
}

/// Message about the cells of a mesh without a finite element, with the number of cells of each kind; `None` if there are
/// none.
pub fn without_element(mesh: &Mesh) -> Option<String> {
    let counts = mesh.cells.counts();
    let without = counts.iter().filter(|(kind, _)| !has_element(*kind));
    let list: Vec<String> =
        without.map(|(kind, count)| format!("{} ({count})", kind.table().title)).collect();
    (!list.is_empty()).then(|| {
        format!("only eight-node hexahedra have a finite element here, but the mesh has {}", list.join(", "))
    })
}

/// Refuses a mesh with cells that have no finite element.
pub(super) fn refusal(mesh: &Mesh, here: &Pointer) -> Option<Problem> {
    let remedy = if mesh.cells.counts().iter().any(|(kind, _)| has_element(*kind)) {
        "mesh with hexahedra of first order, or select the parts that consist of these with \"parts\""
    } else {
        "mesh with hexahedra of first order"
    };
    without_element(mesh)
        .map(|message| Problem::error("bad_mesh", here, message).limit("eight-node hexahedra").remedy(remedy))
}
