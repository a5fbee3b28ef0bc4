//! The formulations that a scene may ask of each element.

use super::document::{
    BodyDocument, Formulation as WrittenFormulation, IntegratorDocument, PartDocument, SceneDocument,
};
use super::problem::{Pointer, Problem};
use super::scene_body::SceneBody;
use super::validate::Findings;
use crate::mechanics::element::ElementKind;
use crate::mechanics::force::Formulation;
use crate::mesh::CellKind;

/// Checks that the elements of a body support what the document requests of them.
pub(super) fn check(index: usize, document: &SceneDocument, body: &SceneBody, out: &mut Findings) {
    let parts = Pointer::root().key("bodies").index(index).key("parts");
    for (entry, part) in document.bodies[index].parts.iter().enumerate() {
        check_formulation(part, (entry, body), &parts.index(entry), out);
        if averages_pressure(part, (entry, body)) {
            check_averaged_pressure(part, &parts.index(entry), out);
        }
        let fails = part.erosion.map(|_| "erosion").or(part.softening.as_ref().map(|_| "softening"));
        if let Some(field) = fails.filter(|_| count((entry, body), CellKind::Tet10) > 0) {
            out.push(failing_tetrahedra(&parts.index(entry).key(field)));
        }
    }
    if has_averaged_pressure(&document.bodies[index], body) {
        check_conserving(document, out);
    }
}

/// Whether elements of a body average pressure over nodes.
pub fn has_averaged_pressure(document: &BodyDocument, body: &SceneBody) -> bool {
    document.parts.iter().enumerate().any(|(entry, part)| averages_pressure(part, (entry, body)))
}

/// Whether elements of a part average pressure over nodes.
fn averages_pressure(part: &PartDocument, (entry, body): (usize, &SceneBody)) -> bool {
    let averages = |kind| {
        let formulation = part.element(&body.materials[entry], kind);
        formulation == Formulation::NodalPressure && Formulation::NodalPressure.is_of(kind)
    };
    CellKind::ALL.into_iter().any(|kind| averages(kind.element()) && count((entry, body), kind) > 0)
}

/// Number of cells of a kind in a part.
fn count((entry, body): (usize, &SceneBody), kind: CellKind) -> usize {
    let cells = body.mesh.cells.iter().zip(&body.part_entry);
    cells.filter(|(cell, of)| cell.kind == kind && **of as usize == entry).count()
}

/// Refuses a formulation that elements of the part do not support.
fn check_formulation(
    part: &PartDocument,
    (entry, body): (usize, &SceneBody),
    here: &Pointer,
    out: &mut Findings,
) {
    let Some(written) = part.formulation else { return };
    let has_precision = |element: ElementKind| {
        written != WrittenFormulation::MeanDilatationSingle || element.has_single_precision()
    };
    for (kind, element) in CellKind::ALL.into_iter().map(|kind| (kind, kind.element())) {
        let count = count((entry, body), kind);
        let has_it = has_precision(element) && part.element(&body.materials[entry], element).is_of(element);
        out.require(count == 0 || has_it, || {
            let title = kind.table().title;
            let message = format!(
                "the part has {count} cells of the kind {title}, which do not support this formulation"
            );
            Problem::error("formulation_of_element", &here.key("formulation"), message)
                .value(serde_json::json!(written))
                .limit("a formulation that all elements of the part support")
                .remedy("omit the formulation: each kind of element then has its default")
        });
    }
}

/// Remedy where four-node tetrahedra with averaged nodal pressure lack a feature.
const REMEDY: &str = "mesh the part with wedges or hexahedra, or give it the formulation \"full\", which is too stiff where nearly \
                      incompressible";

/// Nothing keeps the corners of ten-node tetrahedra from folding, where they do not resist any more.
fn failing_tetrahedra(here: &Pointer) -> Problem {
    let message = "ten-node tetrahedra that fail fold between their quadrature points: the time step may fall by orders of magnitude";
    Problem::warning("failing_tetrahedra", here, message)
        .limit("wedges or hexahedra where the tissue fails")
        .remedy("mesh the part with wedges or hexahedra; or limit the run: `--deadline-s`")
}

fn check_averaged_pressure(part: &PartDocument, here: &Pointer, out: &mut Findings) {
    let needing = part
        .rules()
        .filter(|(_, rules)| rules.needs_pressure_of_element)
        .map(|(field, rules)| (field, rules.name));
    for (field, name) in needing.chain(part.erosion.map(|_| ("erosion", "erosion"))) {
        let message = format!(
            "the part has four-node tetrahedra with averaged nodal pressure, which do not support {name}"
        );
        out.push(
            Problem::error("averaged_pressure", &here.key(field), message)
                .limit("elements without nodal averaging of the pressure")
                .remedy(REMEDY),
        );
    }
}

/// Conserving steps correct the forces of each chunk of elements by its energy, which here is not a matter of the chunk alone.
fn check_conserving(document: &SceneDocument, out: &mut Findings) {
    let conserves = matches!(document.integrator, IntegratorDocument::Implicit { energy_momentum: true, .. });
    out.require(!conserves, || {
        let message = "the mesh has four-node tetrahedra with averaged nodal pressure, which do not support energy-conserving steps";
        let place = Pointer::root().key("integrator").key("energy_momentum");
        Problem::error("averaged_pressure", &place, message)
            .limit("`energy_momentum` false, for such elements")
            .remedy(format!("omit `energy_momentum`; or {REMEDY}"))
    });
}
