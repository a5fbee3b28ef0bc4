//! Checks of prescribed displacements, face loads, ramps, preload and quasi-static runs.

use super::Findings;
use super::timing::{check_newton_tolerance, check_smallest_step};
use crate::mesh::Mesh;
use crate::mesh::surface::{boundary, faces_within};
use crate::scene::document::{
    BodyDocument, FaceLoadDocument, IntegratorDocument, PrescribedDocument, RampDocument, SceneDocument,
};
use crate::scene::materials::MOST_MODULUS;
use crate::scene::problem::{Pointer, Problem, suggest};
use std::collections::BTreeMap;

/// Largest number of load steps of a preload.
const MOST_STEPS: u32 = 100_000;

/// Checks that need the document alone.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    let root = Pointer::root();
    // Gravity.
    if let Some(ramp) = &document.gravity_ramp {
        let here = root.key("gravity_ramp");
        check_ramp(ramp, &here, out);
        out.require(document.gravity_m_per_s2.is_some(), || {
            Problem::error("nothing_to_ramp", &here, "there is no gravity to grow")
                .limit("a scene with gravity")
                .remedy("add gravity_m_per_s2, or omit the ramp")
        });
    }
    // Prescribed motion and face loads of each body.
    for (i, body) in document.bodies.iter().enumerate() {
        let here = root.key("bodies").index(i);
        for (k, prescribed) in body.prescribed.iter().enumerate() {
            check_prescribed(document, body, prescribed, (&here, k), out);
        }
        out.require(
            body.face_loads.is_empty() || body.parts.iter().all(|part| part.erosion.is_none()),
            || {
                Problem::error(
                    "face_loads_with_erosion",
                    &here.key("face_loads"),
                    "a load would stay on the faces of eroded elements",
                )
                .limit("no face loads on a body with parts that erode")
                .remedy("omit the loads or the erosion")
            },
        );
        for (k, load) in body.face_loads.iter().enumerate() {
            let (member, loads) = match load {
                FaceLoadDocument::Pressure { pressure_pa, .. } => ("pressure_pa", vec![*pressure_pa]),
                FaceLoadDocument::Traction { traction_pa, .. } => ("traction_pa", traction_pa.to_vec()),
            };
            for value in loads {
                let place = here.key("face_loads").index(k).key(member);
                out.at_most(&place, "the load", value, MOST_MODULUS, "give it in Pa");
            }
            if let Some(ramp) = load.ramp() {
                check_ramp(ramp, &here.key("face_loads").index(k).key("ramp"), out);
            }
        }
    }
    // Static steps: a preload, or a whole quasi-static run.
    check_preload(document, &root, out);
    if document.integrator.is_quasi_static() {
        check_quasi_static(document, &root, out);
    }
}

fn check_ramp(ramp: &RampDocument, here: &Pointer, out: &mut Findings) {
    match ramp {
        RampDocument::Constant {} => {}
        RampDocument::Linear { from_s, to_s } => out.require(to_s > from_s && *from_s >= 0.0, || {
            Problem::error("times_not_ascending", &here.key("to_s"), "the ramp ends before it begins")
                .value(*to_s)
                .limit(format!("> from_s = {from_s} >= 0"))
                .remedy("give the time at which the load is fully applied")
        }),
        RampDocument::Table { times_s, factors } => {
            out.require(!times_s.is_empty() && times_s.len() == factors.len(), || {
                let message = "times and factors differ in number";
                Problem::error("table_lengths", &here.key("factors"), message)
                    .value(factors.len())
                    .limit(format!(
                        "as many as times, of which there are {}, and at least one",
                        times_s.len()
                    ))
                    .remedy("give a factor for each time")
            });
            for (i, pair) in times_s.windows(2).enumerate() {
                out.require(pair[1] > pair[0], || {
                    let place = here.key("times_s").index(i + 1);
                    let message = "the time is not later than the one before";
                    Problem::error("times_not_ascending", &place, message)
                        .value(pair[1])
                        .limit(format!("> {}", pair[0]))
                        .remedy("sort the times and give each once")
                });
            }
        }
    }
}

fn check_prescribed(
    document: &SceneDocument,
    body: &BodyDocument,
    prescribed: &PrescribedDocument,
    (body_place, index): (&Pointer, usize),
    out: &mut Findings,
) {
    let here = body_place.key("prescribed").index(index);
    out.require(!prescribed.axes.is_empty(), || {
        Problem::error("no_axes", &here.key("axes"), "nothing is prescribed")
            .value(Vec::<f64>::new())
            .limit("at least one of x, y, z")
            .remedy("name the axes, or omit \"axes\" for all three")
    });
    for axis in &prescribed.axes {
        let along = body.velocity_m_per_s[*axis as usize];
        out.require(along == 0.0, || {
            let place = body_place.key("velocity_m_per_s").index(*axis as usize);
            let message =
                format!("the displacement along {axis} is prescribed, but the body has a velocity along it");
            Problem::error("prescribed_but_flying", &place, message)
                .value(along)
                .limit("0")
                .remedy(format!("set this velocity to 0, or do not prescribe {axis}"))
        });
    }
    out.require(body.spin_rad_per_s.iter().all(|w| *w == 0.0), || {
        let place = body_place.key("spin_rad_per_s");
        Problem::error("prescribed_but_spinning", &place, "a body with prescribed displacements cannot spin")
            .value(body.spin_rad_per_s.to_vec())
            .limit("[0, 0, 0] for a body with prescribed nodes")
            .remedy("remove the spin or \"prescribed\"")
    });
    if let Some(ramp) = &prescribed.ramp {
        check_ramp(ramp, &here.key("ramp"), out);
    }
    // A displacement that is not zero at the start would be a jump.
    let starts_at = match &prescribed.ramp {
        Some(RampDocument::Constant {}) => 1.0,
        None if !document.integrator.is_quasi_static() => 1.0,
        Some(RampDocument::Table { times_s, factors }) if times_s.first().is_some_and(|t| *t >= 0.0) => {
            factors.first().copied().unwrap_or(0.0)
        }
        _ => 0.0,
    };
    let moves = prescribed.displacement_m.iter().any(|d| *d != 0.0);
    out.require(!moves || starts_at == 0.0 || document.preload.is_some(), || {
        Problem::error("prescribed_jump", &here.key("ramp"), "the nodes would jump at the start")
            .value(starts_at)
            .limit("a factor that starts at 0, or a preload")
            .remedy("give a ramp such as {\"kind\": \"linear\", \"to_s\": …}, or add \"preload\"")
    });
}

fn check_preload(document: &SceneDocument, root: &Pointer, out: &mut Findings) {
    let Some(preload) = &document.preload else { return };
    let here = root.key("preload");
    out.require((1..=MOST_STEPS).contains(&preload.steps), || {
        Problem::error("out_of_range", &here.key("steps"), "the number of load steps is out of its range")
            .value(preload.steps)
            .limit(format!("between 1 and {MOST_STEPS}"))
            .remedy("10 is the default")
    });
    check_newton_tolerance(preload.newton_tolerance, "the forces", &here, out);
    let loaded = |body: &BodyDocument| !body.prescribed.is_empty() || !body.face_loads.is_empty();
    out.require(document.gravity_m_per_s2.is_some() || document.bodies.iter().any(loaded), || {
        Problem::error("nothing_to_preload", &here, "there is no load")
            .limit("gravity, face loads or prescribed displacements")
            .remedy("add a load, or omit \"preload\"")
    });
    out.require(document.dynamic_relaxation.is_none(), || {
        Problem::error(
            "preload_and_dynamic_relaxation",
            &root.key("dynamic_relaxation"),
            "the scene has both a preload and a dynamic relaxation",
        )
        .limit("one of preload and dynamic_relaxation")
        .remedy("keep \"preload\": it finds the equilibrium, with friction")
    });
    out.require(!document.integrator.is_quasi_static(), || {
        let message = "a quasi-static run is a preload itself";
        Problem::error("preload_and_quasi_static", &here, message)
            .limit("absent beside a quasi-static integrator")
            .remedy("omit \"preload\", and give the loads ramps")
    });
    refuse_rigid(document, "a preload does not support rigid bodies", root, out);
}

fn check_quasi_static(document: &SceneDocument, root: &Pointer, out: &mut Findings) {
    let IntegratorDocument::QuasiStatic { step_s, newton_tolerance, smallest_step_s, .. } =
        &document.integrator
    else {
        return;
    };
    let here = root.key("integrator");
    out.positive(&here.key("step_s"), "the load step", *step_s, "a tenth of the run is a good trial");
    out.require(!(*step_s > document.end_time_s), || {
        Problem::error("out_of_range", &here.key("step_s"), "the load step is longer than the run")
            .value(*step_s)
            .limit(format!("<= end_time_s = {}", document.end_time_s))
            .remedy("give a tenth of the run, or less")
    });
    check_newton_tolerance(*newton_tolerance, "the forces", &here, out);
    check_smallest_step(*smallest_step_s, *step_s, &here, out);
    out.require(document.dynamic_relaxation.is_none(), || {
        let message = "a quasi-static run needs no dynamic relaxation";
        Problem::error("dynamic_relaxation_and_quasi_static", &root.key("dynamic_relaxation"), message)
            .limit("absent beside a quasi-static integrator")
            .remedy("omit \"dynamic_relaxation\": gravity grows from 0 by default")
    });
    // Without mass, velocities have no meaning.
    for (i, body) in document.bodies.iter().enumerate() {
        let members = [("velocity_m_per_s", body.velocity_m_per_s), ("spin_rad_per_s", body.spin_rad_per_s)];
        for (name, value) in members {
            out.require(value.iter().all(|v| *v == 0.0), || {
                let place = root.key("bodies").index(i).key(name);
                Problem::error("motion_without_mass", &place, "a quasi-static run has no initial motion")
                    .value(value.to_vec())
                    .limit("[0, 0, 0] in a quasi-static run")
                    .remedy("prescribe a displacement, or step explicitly or implicitly")
            });
        }
    }
    refuse_rigid(document, "quasi-static steps do not support rigid bodies", root, out);
}

fn refuse_rigid(document: &SceneDocument, message: &str, root: &Pointer, out: &mut Findings) {
    for (index, _) in document.bodies.iter().enumerate().filter(|(_, body)| body.rigid.is_some()) {
        let place = root.key("bodies").index(index).key("rigid");
        out.push(
            Problem::error("rigid_without_mass", &place, message)
                .value("rigid")
                .limit("bodies that deform")
                .remedy("use a plane, or give the body a mesh of a stiff material"),
        );
    }
}

/// Checks that need the mesh of body number `index`: sets, faces, and that no node is constrained twice.
pub fn check_mesh(index: usize, body: &BodyDocument, mesh: &Mesh, out: &mut Findings) {
    let here = Pointer::root().key("bodies").index(index);
    let known = || mesh.node_sets.keys().map(String::as_str);
    let mut check_set = |place: &Pointer, set: &str| {
        out.require(set == "*" || mesh.node_sets.contains_key(set), || {
            Problem::error("unknown_set", place, format!("the mesh has no node set {set:?}"))
                .value(set)
                .limit("a node set of the mesh, or \"*\"")
                .remedy(suggest(set, known()))
        });
    };
    for (i, load) in body.face_loads.iter().enumerate() {
        check_set(&here.key("face_loads").index(i).key("set"), load.set());
    }
    for (i, prescribed) in body.prescribed.iter().enumerate() {
        check_set(&here.key("prescribed").index(i).key("set"), &prescribed.set);
    }
    check_faces(body, mesh, &here, out);
    check_twice(body, mesh, &here, out);
}

/// A face load needs a set that contains whole faces.
fn check_faces(body: &BodyDocument, mesh: &Mesh, here: &Pointer, out: &mut Findings) {
    if body.face_loads.is_empty() {
        return;
    }
    let faces = mesh.hanging.boundary(boundary(&mesh.cells));
    for (i, load) in body.face_loads.iter().enumerate() {
        let Some(nodes) = mesh.node_sets.get(load.set()) else { continue };
        out.require(!faces_within(&faces, nodes).is_empty(), || {
            let place = here.key("face_loads").index(i).key("set");
            Problem::error("set_without_faces", &place, "no boundary face has all its corners in this set")
                .value(load.set())
                .limit("a set with all corners of at least one face")
                .remedy("choose the set of a side, or widen the box of the set")
        });
    }
}

/// No component of a node's displacement is both held and prescribed, or prescribed twice.
fn check_twice(body: &BodyDocument, mesh: &Mesh, here: &Pointer, out: &mut Findings) {
    if body.prescribed.is_empty() {
        return;
    }
    let nodes = |set: &str| match mesh.node_sets.get(set) {
        Some(nodes) => nodes.clone(),
        None if set == "*" => (0..mesh.nodes.len() as u32).collect(),
        None => Vec::new(),
    };
    // The displacement components that are already constrained, with the place in the document.
    let mut taken: BTreeMap<(u32, usize), String> = BTreeMap::new();
    for (i, fixed) in body.fixed.iter().enumerate() {
        let place = here.key("fixed").index(i).as_str().to_owned();
        for node in nodes(&fixed.set) {
            taken.extend(fixed.axes.iter().map(|axis| ((node, *axis as usize), place.clone())));
        }
    }
    for (i, prescribed) in body.prescribed.iter().enumerate() {
        let place = here.key("prescribed").index(i);
        let own = nodes(&prescribed.set);
        let places = own.iter().flat_map(|node| prescribed.axes.iter().map(|axis| (*node, *axis as usize)));
        let twice = places.clone().find_map(|at| Some((at.0, taken.get(&at)?.clone())));
        if let Some((node, other)) = twice {
            let message = format!("{other} already constrains node {node} along one of these axes");
            out.push(
                Problem::error("held_twice", &place.key("set"), message)
                    .value(prescribed.set.as_str())
                    .limit("each component of a node held or prescribed once")
                    .remedy("omit the axis in one of them, or use disjoint sets"),
            );
        }
        taken.extend(places.map(|at| (at, place.as_str().to_owned())));
    }
}
