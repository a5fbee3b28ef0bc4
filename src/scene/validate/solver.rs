//! What the solver is told: each thing is put back once, and three meshes must exist to be compared.

use super::Findings;
use crate::scene::document::{ErrorBarsDocument, MeshDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Checks the list of what is kept. Unknown names are a matter of the structure, and are found there.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    let here = Pointer::root().key("solver").key("keep");
    let keep = &document.solver.keep;
    for (i, name) in keep.iter().enumerate() {
        out.require(!keep[..i].contains(name), || {
            Problem::error("repeated_item", &here.index(i), "this is kept already")
                .value(name.name())
                .limit("each name once")
                .remedy("keep one of them")
        });
    }
    if document.solver.error_bars == ErrorBarsDocument::ThreeLevels {
        check_three_levels(document, out);
    }
}

/// Each mesh can be made coarser twice.
fn check_three_levels(document: &SceneDocument, out: &mut Findings) {
    let bodies = Pointer::root().key("bodies");
    for (b, body) in document.bodies.iter().enumerate() {
        out.require(!matches!(body.mesh, Some(MeshDocument::File(_))), || {
            let place = bodies.index(b).key("mesh");
            Problem::error("no_three_levels", &place, "a mesh from a file is not made coarser")
                .value("three_levels")
                .limit("generated meshes")
                .remedy(
                    "ask for `accuracy`, which makes it finer, or for `solver.error_bars` = \"two_levels\"",
                )
        });
    }
}
