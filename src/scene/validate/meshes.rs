//! Checks of the mesh of a body: parts with materials, node sets, and element quality.

use super::Findings;
use crate::mechanics::tensor::Vec3;
use crate::mesh::quality::{Offenders, Quality, quality};
use crate::mesh::surface::topology_problems;
use crate::mesh::{ELEMENTS_OF_A_TASK, Mesh};
use crate::scene::document::{BodyDocument, InitialDeformation, MeasuresDocument, Role};
use crate::scene::problem::{Pointer, Problem, suggest};

/// Largest number of elements listed in a problem.
const LISTED: usize = 20;

/// Smallest and largest usual size of a body [m], from a cell to more than a person.
const USUAL_SIZE: [f64; 2] = [10e-6, 5.0];

/// Sizes [m] beyond which volumes leave the range of `f64`.
const POSSIBLE_SIZE: [f64; 2] = [1e-30, 1e30];

/// For every element, the index of its entry in the body's `parts`; `None` when a part has no entry.
pub fn part_entries(index: usize, body: &BodyDocument, mesh: &Mesh, out: &mut Findings) -> Option<Vec<u32>> {
    let here = Pointer::root().key("bodies").index(index).key("parts");
    let known = || mesh.parts.iter().map(String::as_str);
    let named = |name: &str| body.parts.iter().position(|p| p.part == name);
    // Entries without a part.
    for (i, part) in body.parts.iter().enumerate() {
        out.require(part.part == "*" || known().any(|k| k == part.part), || {
            let message = format!("the mesh has no part {:?}", part.part);
            Problem::error("unknown_part", &here.index(i).key("part"), message)
                .value(part.part.as_str())
                .limit("a part of the mesh, or \"*\"")
                .remedy(suggest(&part.part, known()))
        });
    }
    let entries: Vec<Option<usize>> = known().map(|name| named(name).or_else(|| named("*"))).collect();
    // Parts without an entry.
    for (name, entry) in known().zip(&entries) {
        out.require(entry.is_some() || body.parts.is_empty(), || {
            Problem::error(
                "part_without_material",
                &here,
                format!("the part {name:?} of the mesh has no material"),
            )
            .value(name)
            .limit("an entry for every part of the mesh")
            .remedy(format!("add an entry with \"part\": {name:?}, or one with \"part\": \"*\""))
        });
    }
    if let Some(rest) = named("*") {
        out.require(entries.contains(&Some(rest)), || {
            Problem::warning("idle_part", &here.index(rest), "every part has an entry of its own")
                .value("*")
                .limit("a part without an entry of its own")
                .remedy("remove this entry")
        });
    }
    let entries: Option<Vec<usize>> = entries.into_iter().collect();
    entries.map(|entries| mesh.part_of.iter().map(|&part| entries[part as usize] as u32).collect())
}

/// Adds the node sets that the document defines by boxes.
pub fn add_sets(index: usize, body: &BodyDocument, mesh: &mut Mesh, out: &mut Findings) {
    let here = Pointer::root().key("bodies").index(index).key("sets");
    for (i, set) in body.sets.iter().enumerate() {
        let here = here.index(i);
        let inside = |x: &Vec3| (0..3).all(|k| set.min_m[k] <= x[k] && x[k] <= set.max_m[k]);
        let mut nodes: Vec<u32> = (0..).zip(&mesh.nodes).filter(|(_, x)| inside(x)).map(|(a, _)| a).collect();
        mesh.hanging.complete(&mut nodes);
        out.require(!nodes.is_empty(), || {
            let bounds = mesh.bounding_box().unwrap_or_default().map(|x| [x.x, x.y, x.z]);
            Problem::error("empty_set", &here, format!("no node lies in the box of the set {:?}", set.name))
                .value(serde_json::json!([set.min_m, set.max_m]))
                .limit(format!(
                    "a box with a node of the body, which extends from {:?} and {:?} m",
                    bounds[0], bounds[1]
                ))
                .remedy("give the box a small margin: its corners are compared exactly")
        });
        out.require(!mesh.node_sets.contains_key(&set.name) && set.name != "*", || {
            Problem::error("repeated_name", &here.key("name"), "a node set has this name already")
                .value(set.name.as_str())
                .limit("unique among the node sets of the body, and not \"*\"")
                .remedy("give the set another name")
        });
        mesh.node_sets.entry(set.name.clone()).or_insert(nodes);
    }
}

/// Checks the node sets that the scene names: fixed ones, and the skin of the tissue.
pub fn check_sets(
    index: usize,
    body: &BodyDocument,
    mesh: &Mesh,
    measures: &MeasuresDocument,
    out: &mut Findings,
) {
    let here = Pointer::root().key("bodies").index(index).key("fixed");
    let known = || mesh.node_sets.keys().map(String::as_str);
    let unknown = |place: &Pointer, name: &str, limit: &str| {
        Problem::error("unknown_set", place, format!("the mesh has no node set {name:?}"))
            .value(name)
            .limit(limit)
            .remedy(suggest(name, known()))
    };
    for (i, fixed) in body.fixed.iter().enumerate() {
        out.require(fixed.set == "*" || mesh.node_sets.contains_key(&fixed.set), || {
            unknown(&here.index(i).key("set"), &fixed.set, "a node set of the mesh, or \"*\"")
        });
    }
    if let (Role::Tissue, Some(set)) = (body.role, &measures.skin_set) {
        out.require(mesh.node_sets.contains_key(set), || {
            let place = Pointer::root().key("measures").key("skin_set");
            unknown(&place, set, "a node set of the tissue")
        });
    }
}

/// Checks the elements; returns their quality when they are valid.
pub fn check_elements(index: usize, mesh: &Mesh, out: &mut Findings) -> Option<Quality> {
    let here = Pointer::root().key("bodies").index(index).key("mesh");
    let before = out.0.error_count();
    let (topology, quality) = if mesh.cells.len() <= ELEMENTS_OF_A_TASK {
        (topology_problems(&mesh.cells), quality(mesh))
    } else {
        rayon::join(|| topology_problems(&mesh.cells), || quality(mesh))
    };
    for problem in topology.iter().take(LISTED) {
        out.push(
            Problem::error("bad_topology", &here, problem.to_string())
                .limit("each element once, each face shared by at most two elements on its two sides")
                .remedy("repair the mesh: merge or separate these elements"),
        );
    }
    let Some(quality) = quality else {
        out.push(
            Problem::error("empty_mesh", &here, "the mesh has no elements").limit("at least one element"),
        );
        return None;
    };
    let size = (quality.bounding_box_m[1] - quality.bounding_box_m[0]).max();
    if !(POSSIBLE_SIZE[0]..=POSSIBLE_SIZE[1]).contains(&size) {
        out.push(
            Problem::error(
                "impossible_size",
                &here,
                "the size of the body is outside the range of floating-point volumes",
            )
            .value(size)
            .limit(format!("between {:e} and {:e} m", POSSIBLE_SIZE[0], POSSIBLE_SIZE[1]))
            .remedy("give lengths in metres"),
        );
        return None;
    }
    let remedy = "give lengths in metres; a placement with scale 0.001 converts millimetres to metres";
    out.usual(&here, "the size of the body", size, USUAL_SIZE, remedy);
    report_quality(&quality, &here, out);
    (out.0.error_count() == before).then_some(quality)
}

fn report_quality(quality: &Quality, here: &Pointer, out: &mut Findings) {
    // Elements that cannot be computed, or only with poor accuracy.
    out.require(quality.negative.count == 0, || {
        let message = format!("{} have a Jacobian that is not positive", elements(&quality.negative));
        Problem::error("negative_jacobian", here, message)
            .value(quality.negative.first.iter().take(LISTED).copied().collect::<Vec<u32>>())
            .limit("det ∂x/∂ξ > 0 at every Gauss point")
            .remedy("repair these elements: their nodes are in the wrong order, or they are folded")
    });
    out.require(quality.folded_corners.count == 0, || {
        Problem::warning(
            "folded_corner",
            here,
            format!("{} are folded at a corner", elements(&quality.folded_corners)),
        )
        .value(quality.folded_corners.first.iter().take(LISTED).copied().collect::<Vec<u32>>())
        .limit("a positive Jacobian at every corner")
        .remedy("improve these elements: they are inaccurate and invert early")
    });
    out.require(quality.volume_m3 > 0.0 || quality.negative.count > 0, || {
        Problem::error("no_volume", here, "the mesh has no volume")
            .value(quality.volume_m3)
            .limit("> 0")
            .remedy("give the body a thickness along each axis")
    });
    // Slender elements limit the time step.
    out.require(quality.max_aspect_ratio <= 100.0, || {
        let message = format!("element {} is very slender", quality.slenderest_element);
        Problem::warning("slender_element", here, message)
            .value(quality.max_aspect_ratio)
            .limit("longest/shortest edge <= 100")
            .remedy("the shortest edge sets the time step: use less grading or more even counts")
    });
    // Nodes without mass, and cracks.
    out.require(quality.unused_nodes.count == 0, || {
        let message = format!("{} nodes belong to no element: they have no mass", quality.unused_nodes.count);
        Problem::error("unused_nodes", here, message)
            .value(quality.unused_nodes.first.iter().take(LISTED).copied().collect::<Vec<u32>>())
            .limit("every node in an element")
            .remedy("remove these nodes from the mesh")
    });
    out.require(quality.coincident_nodes.count == 0, || {
        let message = format!(
            "{} nodes coincide with another one: the body has a crack there",
            quality.coincident_nodes.count
        );
        Problem::warning("coincident_nodes", here, message)
            .value(quality.coincident_nodes.first.iter().take(LISTED).copied().collect::<Vec<u32>>())
            .limit("one node at each position")
            .remedy("merge them where the body should be connected")
    });
}

/// A list such as "5 element(s) (3, 4, …)".
fn elements(offenders: &Offenders) -> String {
    let listed: Vec<String> = offenders.first.iter().take(LISTED).map(u32::to_string).collect();
    let more = if offenders.count > listed.len() { ", …" } else { "" };
    format!("{} element(s) ({}{more})", offenders.count, listed.join(", "))
}

/// The inflation of a ball must not move a node through its centre.
pub fn check_deformation(index: usize, body: &BodyDocument, mesh: &Mesh, out: &mut Findings) {
    let Some(InitialDeformation::SphericalInflation { center_m, inner_radius_m, inner_stretch }) =
        &body.initial_deformation
    else {
        return;
    };
    let center = Vec3::from(*center_m);
    let nearest = mesh.nodes.iter().map(|x| (x - center).norm()).fold(f64::INFINITY, f64::min);
    // r³ = R³ + A³ (λ³ − 1)
    let cubed = nearest.powi(3) + inner_radius_m.powi(3) * (inner_stretch.powi(3) - 1.0);
    let place = Pointer::root().key("bodies").index(index).key("initial_deformation").key("inner_stretch");
    out.require(cubed > 0.0 && nearest > 0.0, || {
        let message = format!("a node at {nearest} m from the centre would pass through it");
        Problem::error("inverted", &place, message)
            .value(*inner_stretch)
            .limit("R > 0 and R³ + A³ (λ³ − 1) > 0 for every node")
            .remedy("increase the stretch, or give the true centre and inner radius")
    });
}
