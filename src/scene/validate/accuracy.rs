//! What an accuracy asks for: a fraction, numbers, a time.

use super::Findings;
use crate::scene::document::{ErrorBarsDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Checks it.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    let Some(accuracy) = &document.accuracy else { return };
    let here = Pointer::root().key("accuracy");
    out.require(accuracy.relative > 0.0 && accuracy.relative <= 1.0, || {
        Problem::error("out_of_range", &here.key("relative"), "this is no accuracy")
            .value(accuracy.relative)
            .limit("> 0 and <= 1")
            .remedy("5 % is 0.05")
    });
    out.require(!accuracy.of.is_empty(), || {
        Problem::error("too_few_items", &here.key("of"), "the accuracy is asked of no number")
            .value("[]")
            .limit("at least one")
            .remedy("leave it out to ask it of peak force, impulse and energy given to the tissue")
    });
    out.positive(
        &here.key("time_budget_s"),
        "the time",
        accuracy.time_budget_s,
        "give it in seconds, such as 30",
    );
    let bars = document.solver.error_bars;
    out.require(bars == ErrorBarsDocument::TwoLevels, || {
        let place = Pointer::root().key("solver").key("error_bars");
        Problem::error(
            "contradiction",
            &place,
            "an accuracy has error bars of its own: from all of its meshes",
        )
        .value(if bars == ErrorBarsDocument::None { "none" } else { "three_levels" })
        .limit("absent where `accuracy` is given")
        .remedy("leave it out, or leave out `accuracy`")
    });
    out.require(document.bodies.iter().any(|body| body.mesh.is_some()), || {
        Problem::error("contradiction", &here, "no body has a mesh that could be refined")
            .value("accuracy")
            .limit("at least one deformable body")
            .remedy("leave it out: rigid bodies have no error of a mesh")
    });
}
