//! Checks of the required accuracy: fraction, results, time.

use super::Findings;
use crate::scene::document::{ErrorBarsDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Checks the required accuracy, if there is one.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    let Some(accuracy) = &document.accuracy else { return };
    let here = Pointer::root().key("accuracy");
    out.require(accuracy.relative > 0.0 && accuracy.relative <= 1.0, || {
        Problem::error("out_of_range", &here.key("relative"), "the relative accuracy is out of its range")
            .value(accuracy.relative)
            .limit("> 0 and <= 1")
            .remedy("5 % is 0.05")
    });
    out.require(!accuracy.of.is_empty(), || {
        Problem::error("too_few_items", &here.key("of"), "the accuracy applies to no result")
            .value("[]")
            .limit("at least one")
            .remedy("omit it for peak force, impulse and energy given to the tissue")
    });
    out.positive(
        &here.key("time_budget_s"),
        "the time",
        accuracy.time_budget_s,
        "give it in seconds, such as 30",
    );
    let bars = document.solver.error_bars;
    out.require(bars == ErrorBarsDocument::Automatic, || {
        let place = Pointer::root().key("solver").key("error_bars");
        Problem::error(
            "contradiction",
            &place,
            "with a required accuracy the error bars come from all of its meshes",
        )
        .value(serde_json::to_value(bars).unwrap_or_default())
        .limit("absent where `accuracy` is given")
        .remedy("omit it, or omit `accuracy`")
    });
    out.require(document.bodies.iter().any(|body| body.mesh.is_some()), || {
        Problem::error("contradiction", &here, "no body has a mesh that could be refined")
            .value("accuracy")
            .limit("at least one deformable body")
            .remedy("omit it: rigid bodies have no discretisation error")
    });
}
