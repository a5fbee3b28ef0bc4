//! Semantic checks of a scene: one file per subject. All problems are collected; none ends the search.
//!
//! Checks that need the document alone come first, then those that need a body's mesh, then those that need the whole
//! scene.

pub mod accuracy;
pub mod bodies;
pub mod contact;
pub mod estimate;
pub mod findings;
pub mod loads;
pub mod measures;
pub mod meshes;
pub mod motion;
pub mod names;
pub mod overlap;
pub mod prony;
pub mod refinement;
pub mod rigid;
pub mod rigid_on_mesh;
pub mod softening;
pub mod solver;
pub mod timing;

pub use findings::Findings;

use super::budget::Budget;
use super::document::SceneDocument;

/// Checks that need the document alone.
pub fn check_document(document: &SceneDocument, budget: &Budget) -> Findings {
    let mut out = Findings::default();
    names::check(document, budget, &mut out);
    for (i, body) in document.bodies.iter().enumerate() {
        match &body.rigid {
            Some(rigid) => rigid::check(i, body, rigid, &mut out),
            None => bodies::check(i, body, &mut out),
        }
        motion::check(i, body, &mut out);
    }
    contact::check(document, &mut out);
    timing::check(document, budget, &mut out);
    loads::check(document, &mut out);
    solver::check(document, &mut out);
    accuracy::check(document, &mut out);
    measures::check(document, &mut out);
    refinement::check(document, &mut out);
    out
}
