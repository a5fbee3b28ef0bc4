//! What the measures need to know.

use super::Findings;
use crate::scene::document::{Role, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Most thresholds of stress; each is one more number at every quadrature point.
const MAX_THRESHOLDS: usize = 32;

/// Checks the measures.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    let here = Pointer::root().key("measures");
    let measures = &document.measures;
    let thresholds = here.key("stress_thresholds_pa");
    out.require(measures.stress_thresholds_pa.len() <= MAX_THRESHOLDS, || {
        Problem::error("too_many_items", &thresholds, "there are very many thresholds")
            .value(measures.stress_thresholds_pa.len())
            .limit(format!("at most {MAX_THRESHOLDS}"))
            .remedy("keep those that you will read")
    });
    let mut previous = f64::NEG_INFINITY;
    for (i, &threshold) in measures.stress_thresholds_pa.iter().enumerate() {
        let place = thresholds.index(i);
        out.positive(&place, "a threshold", threshold, "give it in Pa: 10 kPa is 1e4");
        out.require(threshold > previous, || {
            Problem::error("not_ascending", &place, "the threshold is not above the one before")
                .value(threshold)
                .limit(format!("> {previous}"))
                .remedy("sort the thresholds and give each once")
        });
        previous = previous.max(threshold);
    }
    let remedy = "5e-6 s is the default";
    out.positive(&here.key("force_window_s"), "the window", measures.force_window_s, remedy);
    if let Some(set) = &measures.skin_set {
        out.require(document.bodies.iter().any(|b| b.role == Role::Tissue), || {
            Problem::error("no_tissue", &here.key("skin_set"), "no body has the role of tissue")
                .value(set.as_str())
                .limit("a node set of a body whose role is \"tissue\"")
                .remedy("give a body the role \"tissue\", or leave skin_set out")
        });
    }
}
