//! Which kinds of cells can be computed: the one place that knows.

use super::problem::{Pointer, Problem};
use crate::mesh::{CellKind, Mesh};

/// Whether there is a finite element for cells of a kind.
pub fn has_element(kind: CellKind) -> bool {
    matches!(kind, CellKind::Hex8)
}

/// What cannot be computed of a mesh, with the number of cells of each kind; `None` where all of it can.
pub fn without_element(mesh: &Mesh) -> Option<String> {
    let counts = mesh.cells.counts();
    let without = counts.iter().filter(|(kind, _)| !has_element(*kind));
    let list: Vec<String> =
        without.map(|(kind, count)| format!("{} ({count})", kind.table().title)).collect();
    (!list.is_empty())
        .then(|| format!("only eight-node hexahedra are computed, but the mesh has {}", list.join(", ")))
}

/// Refuses a mesh of which not all can be computed.
pub(super) fn refusal(mesh: &Mesh, here: &Pointer) -> Option<Problem> {
    let remedy = if mesh.cells.counts().iter().any(|(kind, _)| has_element(*kind)) {
        "mesh with hexahedra of first order, or choose the parts that have them alone by \"parts\""
    } else {
        "mesh with hexahedra of first order"
    };
    without_element(mesh)
        .map(|message| Problem::error("bad_mesh", here, message).limit("eight-node hexahedra").remedy(remedy))
}
