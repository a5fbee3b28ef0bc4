//! Semantic checks of a scene: one file per subject. All problems are collected; none ends the search.
//!
//! Checks that need the document alone come first, then those that need a body's mesh, then those that need the whole
//! scene.

pub mod accuracy;
pub mod approach;
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
pub mod refinement;
pub mod rigid;
pub mod rigid_on_mesh;
pub mod segmentation;
pub mod side;
pub mod solver;
pub mod timing;

pub use findings::Findings;

use super::budget::Budget;
use super::document::{MaterialDocument, SceneDocument};
use super::problem::Pointer;
use std::collections::BTreeSet;

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
    stiff_volumes_that_matter(document, &mut out);
    contact::check(document, &mut out);
    timing::check(document, budget, &mut out);
    loads::check(document, &mut out);
    solver::check(document, &mut out);
    accuracy::check(document, &mut out);
    measures::check(document, &mut out);
    refinement::check(document, &mut out);
    segmentation::check(document, &mut out);
    out
}

/// Reduces the warnings of a stiff volume to one for each material, that of its first part; none where no explicit steps are taken.
fn stiff_volumes_that_matter(document: &SceneDocument, out: &mut Findings) {
    const CODE: &str = "stiff_volume";
    let place_of = |pointer: &str| pointer.rsplit_once('/').map_or("", |(place, _)| place).to_owned();
    let stiff = out.0.iter().filter(|problem| problem.code == CODE);
    let stiff: BTreeSet<String> = stiff.map(|problem| place_of(&problem.pointer)).collect();
    let (mut known, mut kept) = (Vec::<&MaterialDocument>::new(), BTreeSet::new());
    for (i, body) in document.bodies.iter().enumerate().filter(|_| !document.integrator.is_implicit()) {
        let parts = Pointer::root().key("bodies").index(i).key("parts");
        for (k, part) in body.parts.iter().enumerate() {
            let place = parts.index(k).key("material");
            if stiff.contains(place.as_str()) && !known.contains(&&part.material) {
                known.push(&part.material);
                kept.insert(place.as_str().to_owned());
            }
        }
    }
    out.0.retain(|problem| problem.code != CODE || kept.contains(&place_of(&problem.pointer)));
}
