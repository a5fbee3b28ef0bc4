//! Local refinement, as far as the document alone tells.

use super::Findings;
use crate::mechanics::contact::Discretisation;
use crate::scene::document::{Around, BodyDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Checks all refinements of the document.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    for (i, body) in document.bodies.iter().enumerate().filter(|(_, body)| !body.refinement.is_empty()) {
        let here = Pointer::root().key("bodies").index(i).key("refinement");
        check_body(body, &here, out);
        out.require(document.contact.discretisation.method() != Discretisation::Mortar, || {
            Problem::error("refinement_with_mortar", &here, "mortar contact knows no nodes that hang")
                .value("mortar")
                .limit("another contact.discretisation with a locally refined mesh")
                .remedy("take contact.discretisation out, or refine the whole mesh")
        });
    }
}

fn check_body(body: &BodyDocument, here: &Pointer, out: &mut Findings) {
    out.require(body.parts.iter().all(|part| part.erosion.is_none()), || {
        Problem::error(
            "refinement_with_erosion",
            here,
            "what erosion lays bare between coarse and fine elements has no faces",
        )
        .limit("no erosion of a body that is locally refined")
        .remedy("refine the whole mesh, or take erosion out")
    });
    for (i, refinement) in body.refinement.iter().enumerate() {
        let here = here.index(i);
        out.positive(
            &here.key("size_m"),
            "the size of elements",
            refinement.size_m,
            "tissue is resolved by 0.5 to 5 mm",
        );
        let remedy = "elements that touch the place are refined at 0";
        out.not_negative(&here.key("within_m"), "the distance", refinement.within_m, remedy);
        if let Around::PointM(point) = &refinement.around {
            out.require(point.iter().all(|x| x.is_finite()), || {
                Problem::error(
                    "not_finite",
                    &here.key("around").key("point_m"),
                    "a coordinate is no finite number",
                )
                .limit("three finite numbers")
                .remedy("give the place in metres")
            });
        }
    }
}
