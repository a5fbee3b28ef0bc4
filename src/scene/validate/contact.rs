//! Checks of contact: pairs, friction, planes.

use super::Findings;
use crate::scene::document::{ContactPairs, SceneDocument};
use crate::scene::problem::{Pointer, Problem, suggest};
use std::collections::BTreeSet;

/// Range of a friction coefficient [-]; rubber on rubber is about 1.
const FRICTION: [f64; 2] = [0.0, 10.0];

/// Checks contact settings, contact pairs and planes.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    for (i, plane) in document.planes.iter().enumerate() {
        out.direction(&Pointer::root().key("planes").index(i).key("normal"), "the normal", plane.normal);
    }
    // Settings that hold for all pairs.
    let here = Pointer::root().key("contact");
    let contact = &document.contact;
    let remedy = "Coulomb's coefficient: 0 is frictionless, rubber on skin about 0.3 to 0.6";
    out.between(&here.key("friction"), "the friction", contact.friction, FRICTION, remedy);
    out.between(
        &here.key("tolerance"),
        "the tolerance",
        contact.tolerance,
        [1e-14, 1e-3],
        "omit it for the default 1e-10",
    );
    out.between(
        &here.key("mass_redistribution"),
        "the redistributed fraction of the mass",
        contact.mass_redistribution,
        [0.0, 0.95],
        "0.75 removes three quarters of the loss, at twice as many steps",
    );
    let ContactPairs::List(pairs) = &contact.pairs else { return };

    // Listed pairs: known names, and sides that can touch.
    let bodies: Vec<&str> = document.bodies.iter().map(|b| b.name.as_str()).collect();
    let planes: Vec<&str> = document.planes.iter().map(|p| p.name.as_str()).collect();
    let mut seen = BTreeSet::new();
    for (i, pair) in pairs.iter().enumerate() {
        let here = here.key("pairs").index(i);
        for (side, name) in pair.between.iter().enumerate() {
            let known = bodies.iter().chain(&planes).copied();
            out.require(known.clone().any(|k| k == name), || {
                let message = format!("no body and no plane is called {name:?}");
                Problem::error("unknown_body", &here.key("between").index(side), message)
                    .value(name.as_str())
                    .limit("a name of a body or a plane")
                    .remedy(suggest(name, known))
            });
        }
        if let Some(friction) = pair.friction {
            out.between(&here.key("friction"), "the friction", friction, FRICTION, remedy);
        }
        out.require(!pair.between.iter().all(|name| planes.contains(&name.as_str())), || {
            Problem::error("planes_only", &here.key("between"), "two fixed planes cannot touch")
                .value(pair.between.to_vec())
                .limit("at least one body")
                .remedy("remove the pair")
        });
        let is_rigid = |name: &str| document.bodies.iter().any(|b| b.name == name && b.rigid.is_some());
        out.require(pair.between[0] != pair.between[1] || !is_rigid(&pair.between[0]), || {
            Problem::error("rigid_self_contact", &here.key("between"), "a rigid body cannot touch itself")
                .value(pair.between.to_vec())
                .limit("two different bodies, or a deformable body")
                .remedy("remove the pair")
        });
        // Each pair once, in either order.
        let mut sides = [pair.between[0].as_str(), pair.between[1].as_str()];
        sides.sort_unstable();
        out.require(seen.insert(sides), || {
            Problem::error("repeated_pair", &here.key("between"), "the pair is listed already")
                .value(pair.between.to_vec())
                .limit("each pair once")
                .remedy("keep one of them")
        });
    }
}
