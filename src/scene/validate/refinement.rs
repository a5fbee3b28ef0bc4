//! Checks of local refinement that need the document alone.

use super::Findings;
use crate::mechanics::contact::Discretisation;
use crate::scene::document::{Around, BodyDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Checks all local refinements of the document.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    for (i, body) in document.bodies.iter().enumerate().filter(|(_, body)| !body.refinement.is_empty()) {
        let here = Pointer::root().key("bodies").index(i).key("refinement");
        check_body(body, &here, out);
        out.require(document.contact.discretisation != Discretisation::Mortar, || {
            Problem::error("refinement_with_mortar", &here, "mortar contact does not support hanging nodes")
                .value("mortar")
                .limit("another contact.discretisation with a locally refined mesh")
                .remedy("remove contact.discretisation, or refine the whole mesh")
        });
    }
}

fn check_body(body: &BodyDocument, here: &Pointer, out: &mut Findings) {
    out.require(body.parts.iter().all(|part| part.erosion.is_none()), || {
        Problem::error(
            "refinement_with_erosion",
            here,
            "erosion between coarse and fine elements would expose a surface without faces",
        )
        .limit("no erosion of a locally refined body")
        .remedy("refine the whole mesh, or remove the erosion")
    });
    for (i, refinement) in body.refinement.iter().enumerate() {
        let here = here.index(i);
        out.positive(
            &here.key("size_m"),
            "the size of elements",
            refinement.size_m,
            "tissue is resolved by 0.5 to 5 mm",
        );
        let remedy = "0 refines the elements that touch the given place";
        out.not_negative(&here.key("within_m"), "the distance", refinement.within_m, remedy);
        if let Around::PointM(point) = &refinement.around {
            out.require(point.iter().all(|x| x.is_finite()), || {
                Problem::error("not_finite", &here.key("around").key("point_m"), "a coordinate is not finite")
                    .limit("three finite numbers")
                    .remedy("give the coordinates in metres")
            });
        }
    }
}
