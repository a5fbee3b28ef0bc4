//! Which kinds of cells have a finite element, and in which formulations; the only place that decides this.

use super::SceneBody;
use super::document::BodyDocument;
use super::problem::{Pointer, Problem};
use super::validate::Findings;
use crate::mechanics::element::ElementKind;
use crate::mesh::{CellKind, Mesh};

/// The finite element of a kind of cell, with the same nodes in the same order; `None` if there is none.
pub fn element_of(kind: CellKind) -> Option<ElementKind> {
    match kind {
        CellKind::Hex8 => Some(ElementKind::Hex8),
        CellKind::Wedge6 => Some(ElementKind::Wedge6),
        CellKind::Tet10 => Some(ElementKind::Tet10),
        CellKind::Tet4 => None,
    }
}

/// The kinds of cells that have a finite element, as in "hexahedron of 8 nodes, prism of 6 nodes".
pub fn kinds_with_element() -> String {
    let kinds = CellKind::ALL.into_iter().filter(|kind| element_of(*kind).is_some());
    kinds.map(|kind| kind.table().title).collect::<Vec<_>>().join(", ")
}

/// Message about the cells of a mesh without a finite element, with the number of cells of each kind; `None` if there are
/// none.
pub fn without_element(mesh: &Mesh) -> Option<String> {
    let counts = mesh.cells.counts();
    let without = counts.iter().filter(|(kind, _)| element_of(*kind).is_none());
    let list: Vec<String> =
        without.map(|(kind, count)| format!("{} ({count})", kind.table().title)).collect();
    (!list.is_empty()).then(|| format!("the mesh has cells without a finite element: {}", list.join(", ")))
}

/// Refuses a mesh with cells that have no finite element.
pub(super) fn refusal(mesh: &Mesh, here: &Pointer) -> Option<Problem> {
    let remedy = if mesh.cells.counts().iter().any(|(kind, _)| element_of(*kind).is_some()) {
        "mesh with hexahedra of first order, or select the parts that have only cells with an element with \"parts\""
    } else {
        "mesh with hexahedra of first order"
    };
    without_element(mesh).map(|message| {
        Problem::error("bad_mesh", here, message).limit(kinds_with_element()).remedy(remedy)
    })
}

/// Refuses formulations that elements of their part have not; once for each part and kind.
pub(super) fn check_formulations(index: usize, document: &BodyDocument, body: &SceneBody, out: &mut Findings) {
    let parts = Pointer::root().key("bodies").index(index).key("parts");
    for (entry, (part, material)) in document.parts.iter().zip(&body.materials).enumerate() {
        let Some(written) = part.formulation else { continue };
        for kind in CellKind::ALL {
            let Some(element) = element_of(kind) else { continue };
            let is_of_part = |e: usize| body.part_entry[e] as usize == entry && body.mesh.cells.kind(e) == kind;
            let count = (0..body.mesh.cells.len()).filter(|e| is_of_part(*e)).count();
            out.require(count == 0 || part.element(material, element).is_of(element), || {
                let title = kind.table().title;
                let message = format!("the part has {count} cells of the kind {title}, which have no such formulation");
                Problem::error("formulation_of_element", &parts.index(entry).key("formulation"), message)
                    .value(serde_json::json!(written))
                    .limit("a formulation that all elements of the part have")
                    .remedy("leave the formulation out: each kind of element then has its default")
            });
        }
    }
}
