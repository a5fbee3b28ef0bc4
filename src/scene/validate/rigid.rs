//! Checks of a rigid body: shape, mass, inertia, and no members that need a mesh.

use super::Findings;
use super::bodies::MOST_DENSITY;
use super::motion::USUAL_SPEED;
use crate::mechanics::rigid::Shape;
use crate::scene::document::{BodyDocument, RigidDocument, Role, ShapeDocument};
use crate::scene::problem::{Pointer, Problem};

/// Smallest and largest usual thickness of a rigid body [m].
const USUAL_SIZE: [f64; 2] = [1e-4, 5.0];
/// Usual densities, from cork to gold [kg/m³].
const USUAL_DENSITY: [f64; 2] = [100.0, 25_000.0];
/// Upper bound of the mass of a body [kg]: a large ship.
const MOST_MASS: f64 = 1e9;
/// Relative amount by which a moment of inertia may exceed the sum of the others, for rounding in the document.
const ROUNDING: f64 = 1e-6;

/// Fraction of a homogeneous body's moment of inertia below which a value is a mistake.
const LEAST_INERTIA: f64 = 1e-4;

/// Checks body number `index` with its rigid description `rigid`.
pub fn check(index: usize, body: &BodyDocument, rigid: &RigidDocument, out: &mut Findings) {
    let here = Pointer::root().key("bodies").index(index);
    check_absent(body, &here, out);
    out.require(body.role != Role::Tissue, || {
        Problem::error("rigid_tissue", &here.key("role"), "a rigid body absorbs nothing and has no stress")
            .value("tissue")
            .limit("projectile or other, for a rigid body")
            .remedy("give the tissue a mesh, or this body another role")
    });
    let here = here.key("rigid");
    check_shape(&rigid.shape, &here.key("shape"), out);
    if let Some(rotation) = &rigid.rotation {
        out.direction(&here.key("rotation").key("axis"), "the axis of the rotation", rotation.axis);
    }
    check_mass(rigid, &here, out);
    if let Some(inertia) = rigid.inertia_kg_m2 {
        let place = here.key("inertia_kg_m2");
        check_inertia(inertia, &place, out);
    }
    // The shape of a file is checked once it has been read.
    if let Some(shape) = rigid.shape.shape() {
        check_of_shape(index, body, rigid, &shape, out);
    }
}

/// Checks what depends on the shape of body number `index`.
pub fn check_of_shape(
    index: usize,
    body: &BodyDocument,
    rigid: &RigidDocument,
    shape: &Shape,
    out: &mut Findings,
) {
    let here = Pointer::root().key("bodies").index(index);
    let spin = body.spin_rad_per_s.iter().map(|w| w * w).sum::<f64>().sqrt();
    let rim = spin * shape.outer_radius();
    out.require(!(rim > USUAL_SPEED), || {
        let message =
            format!("the rim of the body would move at {rim:.3e} m/s, beyond the strength of any material");
        Problem::error("impossible_spin", &here.key("spin_rad_per_s"), message)
            .value(spin)
            .limit(format!("a rim slower than {USUAL_SPEED} m/s (steel bursts at less than 1000)"))
            .remedy("give the spin in radians per second: 60 turns a minute are 6.28 rad/s")
    });
    let here = here.key("rigid");
    if !(shape.size() > 0.0) {
        return;
    }
    out.usual(&here.key("shape"), "the thickness", shape.size(), USUAL_SIZE, "give lengths in metres");
    if let (Some(inertia), Some(mass)) = (rigid.inertia_kg_m2, rigid.mass(shape).filter(|mass| *mass > 0.0)) {
        check_inertia_of_shape(inertia, mass, shape, &here.key("inertia_kg_m2"), out);
    }
}

/// Refuses members that only apply to a mesh.
fn check_absent(body: &BodyDocument, here: &Pointer, out: &mut Findings) {
    let members = [
        ("mesh", body.mesh.is_some()),
        ("parts", !body.parts.is_empty()),
        ("placement", body.placement.is_some()),
        ("refinement", !body.refinement.is_empty()),
        ("sets", !body.sets.is_empty()),
        ("initial_deformation", body.initial_deformation.is_some()),
        ("fixed", !body.fixed.is_empty()),
        ("prescribed", !body.prescribed.is_empty()),
        ("face_loads", !body.face_loads.is_empty()),
    ];
    for (name, is_present) in members {
        out.require(!is_present, || {
            Problem::error(
                "not_for_rigid",
                &here.key(name),
                "a rigid body has no mesh, and no members that refer to one",
            )
            .limit("absent beside \"rigid\"")
            .remedy(format!("remove {name:?}, or remove \"rigid\" for a deformable body"))
        });
    }
}

fn check_shape(shape: &ShapeDocument, here: &Pointer, out: &mut Findings) {
    let lengths: Vec<(Pointer, f64)> = match *shape {
        ShapeDocument::Ball { radius_m } => vec![(here.key("radius_m"), radius_m)],
        ShapeDocument::Box { half_extents_m } => {
            let at = |i: usize| here.key("half_extents_m").index(i);
            (0..3).map(|i| (at(i), half_extents_m[i])).collect()
        }
        ShapeDocument::Cylinder { radius_m, half_length_m, .. }
        | ShapeDocument::Capsule { radius_m, half_length_m, .. } => {
            vec![(here.key("radius_m"), radius_m), (here.key("half_length_m"), half_length_m)]
        }
        ShapeDocument::Stl { scale, .. } => {
            out.positive(&here.key("scale"), "the scale", scale, "0.001 converts millimetres to metres");
            Vec::new()
        }
    };
    for (pointer, length) in &lengths {
        out.positive(pointer, "a length", *length, "give it in metres: 15 mm is 0.015");
    }
    if let Some(axis) = shape.axis() {
        out.direction(&here.key("axis"), "the axis", axis);
    }
}

fn check_mass(rigid: &RigidDocument, here: &Pointer, out: &mut Findings) {
    out.require(rigid.mass_kg.is_some() != rigid.density_kg_per_m3.is_some(), || {
        let both = rigid.mass_kg.is_some();
        let what = if both { "both mass and density are given" } else { "neither mass nor density is given" };
        Problem::error("mass_or_density", &here.key("mass_kg"), what)
            .limit("one of mass_kg and density_kg_per_m3")
            .remedy(if both { "keep one of them" } else { "add one of them: steel has 7850 kg/m³" })
    });
    if let Some(mass) = rigid.mass_kg {
        out.positive(&here.key("mass_kg"), "the mass", mass, "give it in kg: 10 g is 0.01");
        out.at_most(&here.key("mass_kg"), "the mass", mass, MOST_MASS, "give it in kg: 10 g is 0.01");
    }
    if let Some(density) = rigid.density_kg_per_m3 {
        let place = here.key("density_kg_per_m3");
        let remedy = "give it in kg/m³: water has 1000, steel 7850";
        out.positive(&place, "the density", density, remedy);
        out.at_most(&place, "the density", density, MOST_DENSITY, remedy);
        if density > 0.0 {
            out.usual(&place, "the density", density, USUAL_DENSITY, remedy);
        }
    }
}

/// No mass lies outside the shape, so a moment of inertia is at most m R²; below 1e-4 of that of a homogeneous body it is
/// taken for a mistake.
fn check_inertia_of_shape(inertia: [f64; 3], mass: f64, shape: &Shape, here: &Pointer, out: &mut Findings) {
    let (most, homogeneous) = (mass * shape.outer_radius().powi(2), shape.inertia_per_mass() * mass);
    for (i, moment) in inertia.into_iter().enumerate() {
        let least = LEAST_INERTIA * homogeneous[i];
        out.require(!(moment > most * (1.0 + ROUNDING) || moment < least), || {
            let message = "no body of this mass fits into the shape with this moment of inertia";
            Problem::error("impossible_inertia", &here.index(i), message)
                .value(moment)
                .limit(format!(
                    "{least:.3e} to {most:.3e} kg m²; a homogeneous body has {:.3e}",
                    homogeneous[i]
                ))
                .remedy("give it in kg m², or omit it for a homogeneous body")
        });
    }
}

/// Moments of inertia are positive, and none is larger than the sum of the others.
fn check_inertia(inertia: [f64; 3], here: &Pointer, out: &mut Findings) {
    for (i, moment) in inertia.into_iter().enumerate() {
        out.positive(&here.index(i), "a moment of inertia", moment, "omit it for a homogeneous body");
    }
    let sum: f64 = inertia.iter().sum();
    for (i, moment) in inertia.into_iter().enumerate() {
        out.require(!(moment > (sum - moment) * (1.0 + ROUNDING)), || {
            Problem::error("impossible_inertia", &here.index(i), "no body has these moments of inertia")
                .value(moment)
                .limit(format!("at most the sum of the other two, {}", sum - moment))
                .remedy("check the moments, or omit them for a homogeneous body")
        });
    }
}
