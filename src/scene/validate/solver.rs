//! What the solver is told: each thing is put back once.

use super::Findings;
use crate::scene::document::SceneDocument;
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
}
