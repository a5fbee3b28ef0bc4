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

/// Each mesh can be made coarser twice, by two in every direction that has more than one element.
fn check_three_levels(document: &SceneDocument, out: &mut Findings) {
    let bodies = Pointer::root().key("bodies");
    for (b, body) in document.bodies.iter().enumerate() {
        let Some(mesh) = &body.mesh else { continue };
        let problem = |message: &str| {
            Problem::error("no_three_levels", &bodies.index(b).key("mesh"), message)
                .value("three_levels")
                .limit("a generated mesh whose numbers of elements are one or divisible by four")
                .remedy("change the numbers of elements, or ask for `solver.error_bars` = \"two_levels\"")
        };
        match mesh.clone() {
            MeshDocument::File(_) => out.require(false, || problem("a mesh from a file is not made coarser")),
            MeshDocument::Generator(mut generator) => {
                let counts = generator.counts_mut();
                let bad = counts.into_iter().map(|count| *count).find(|count| *count > 1 && count % 4 != 0);
                out.require(bad.is_none(), || {
                    let elements = bad.unwrap_or_default();
                    problem(&format!("{elements} elements in a direction cannot be halved twice"))
                });
            }
        }
    }
}
