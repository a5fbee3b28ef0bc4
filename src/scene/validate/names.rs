//! Checks of names: present, printable, unique, and not too many.

use super::Findings;
use crate::mesh::names::{fault, shortened};
use crate::scene::budget::Budget;
use crate::scene::document::SceneDocument;
use crate::scene::problem::{Pointer, Problem};
use std::collections::BTreeMap;

/// Largest number of characters of a description.
const LONGEST_DESCRIPTION: usize = 10_000;

/// Checks one name, which is used in tables, logs and messages.
pub fn check_name(name: &str, here: &Pointer, out: &mut Findings) {
    if let Some(limit) = fault(name) {
        out.push(
            Problem::error("bad_name", here, "a name is too long, or contains unprintable characters")
                .value(shortened(name))
                .limit(limit)
                .remedy("use a few letters and digits, '_' and '-'"),
        );
    }
}

/// Checks the names of bodies and planes (which contact pairs share), and their number.
pub fn check(document: &SceneDocument, budget: &Budget, out: &mut Findings) {
    let bodies = Pointer::root().key("bodies");
    out.require(!document.bodies.is_empty(), || {
        Problem::error("no_bodies", &bodies, "a scene needs a body")
            .value(Vec::<f64>::new())
            .limit("at least one")
            .remedy("add a body with a mesh, parts and a material")
    });
    let count = (document.bodies.len() + document.planes.len()) as u64;
    out.require(count <= budget.bodies, || {
        Problem::error("budget_bodies", &bodies, "the scene has too many bodies and planes")
            .value(count)
            .limit(format!("at most {}", budget.bodies))
            .remedy("omit bodies that cannot be hit")
    });

    check_name(&document.name, &Pointer::root().key("name"), out);
    let length = document.description.chars().count();
    out.require(length <= LONGEST_DESCRIPTION, || {
        Problem::error("too_long", &Pointer::root().key("description"), "the description is too long")
            .value(length)
            .limit(format!("at most {LONGEST_DESCRIPTION} characters"))
            .remedy("keep long texts in another file")
    });
    for (i, body) in document.bodies.iter().enumerate() {
        for (k, set) in body.sets.iter().enumerate() {
            check_name(&set.name, &bodies.index(i).key("sets").index(k).key("name"), out);
        }
    }

    // Names of bodies and planes share one namespace.
    let mut first_use: BTreeMap<&str, Pointer> = BTreeMap::new();
    let planes = Pointer::root().key("planes");
    let named_bodies =
        document.bodies.iter().enumerate().map(|(i, b)| (&b.name, bodies.index(i).key("name")));
    let named_planes =
        document.planes.iter().enumerate().map(|(i, p)| (&p.name, planes.index(i).key("name")));
    for (name, pointer) in named_bodies.chain(named_planes) {
        out.require(!name.trim().is_empty(), || {
            Problem::error("empty_name", &pointer, "a name is empty")
                .value(name.as_str())
                .limit("at least one letter")
                .remedy("give a name; contact pairs and results use it")
        });
        check_name(name, &pointer, out);
        out.require(!name.contains('/'), || {
            Problem::error("bad_name", &pointer, "a name contains a slash")
                .value(shortened(name))
                .limit("no '/': names become topics of the recording")
                .remedy("use letters, digits, '_' and '-'")
        });
        if let Some(before) = first_use.get(name.as_str()) {
            out.push(
                Problem::error("repeated_name", &pointer, format!("{} has this name too", before.as_str()))
                    .value(name.as_str())
                    .limit("unique among bodies and planes")
                    .remedy("rename one of them"),
            );
        } else {
            first_use.insert(name, pointer);
        }
    }
}
