//! Checks of the solver settings: no feature is kept twice, and three levels need meshes that can be coarsened.

use super::Findings;
use crate::scene::document::{
    ErrorBarsDocument, Formulation, IntegratorDocument, MeshDocument, SceneDocument,
};
use crate::scene::problem::{Pointer, Problem};

/// Checks the list of kept features. Unknown names are errors of structure.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    let here = Pointer::root().key("solver").key("keep");
    let keep = &document.solver.keep;
    for (i, name) in keep.iter().enumerate() {
        out.require(!keep[..i].contains(name), || {
            Problem::error("repeated_item", &here.index(i), "this feature is kept already")
                .value(name.name())
                .limit("each name once")
                .remedy("keep one of them")
        });
    }
    check_precision(document, out);
    if document.solver.error_bars == ErrorBarsDocument::ThreeLevels {
        check_three_levels(document, out);
    }
}

/// Single precision is for explicit steps: the rounding of the forces would keep Newton's method from converging.
fn check_precision(document: &SceneDocument, out: &mut Findings) {
    let is_explicit = matches!(document.integrator, IntegratorDocument::Explicit { .. });
    let bodies = Pointer::root().key("bodies");
    for (b, body) in document.bodies.iter().enumerate() {
        for (p, part) in body.parts.iter().enumerate() {
            let is_single = part.formulation == Some(Formulation::MeanDilatationSingle);
            out.require(!is_single || (is_explicit && document.preload.is_none()), || {
                let place = bodies.index(b).key("parts").index(p).key("formulation");
                Problem::error(
                    "single_precision_in_implicit_steps",
                    &place,
                    "single precision is too coarse for equilibrium iterations",
                )
                .value("mean_dilatation_single")
                .limit("explicit steps without a preload")
                .remedy("choose \"mean_dilatation\", or `integrator.kind` = \"explicit\" and no `preload`")
            });
        }
    }
}

/// Three levels need meshes that can be coarsened twice, hence generated ones.
fn check_three_levels(document: &SceneDocument, out: &mut Findings) {
    let bodies = Pointer::root().key("bodies");
    for (b, body) in document.bodies.iter().enumerate() {
        out.require(!matches!(body.mesh, Some(MeshDocument::File(_))), || {
            let place = bodies.index(b).key("mesh");
            Problem::error("no_three_levels", &place, "a mesh from a file cannot be coarsened")
                .value("three_levels")
                .limit("generated meshes")
                .remedy("use `accuracy`, which refines the mesh, or `solver.error_bars` = \"two_levels\"")
        });
    }
}
