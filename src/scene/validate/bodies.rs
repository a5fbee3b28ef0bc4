//! Checks of the parts of a body that need the document alone: density, material, element, fibre frame, placement.

use super::Findings;
use crate::mechanics::force::{BlockParameters, MOST_SINGLE_RATIO};
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::scene::document::{
    BodyDocument, ErosionDocument, FibreFrameDocument, Formulation, PartDocument, PlacementDocument,
};
use crate::scene::memories;
use crate::scene::problem::{Pointer, Problem};
use std::collections::BTreeSet;

/// Upper bound of any density [kg/m³]: osmium has 22 600.
pub const MOST_DENSITY: f64 = 1e6;

/// Upper bound of the viscosity of tissue or rubber [Pa s].
const MOST_VISCOSITY: f64 = 1e4;

/// Admissible limits of erosion, which an element at rest satisfies [-].
const STRETCHES: [f64; 2] = [1.001, 1e3];
const VOLUME_RATIOS: [f64; 2] = [1e-3, 0.999];
/// Admissible limits of damage [-]; a thousandth of the stress always remains.
const DAMAGES: [f64; 2] = [0.01, 0.998];
/// Admissible ratios of neighbouring stiffness factors [-].
const RATIOS: [f64; 2] = [1.001, 2.0];
/// Most points of a centre line.
const MOST_POINTS: usize = 10_000;

/// Checks body number `index`.
pub fn check(index: usize, body: &BodyDocument, out: &mut Findings) {
    let here = Pointer::root().key("bodies").index(index);
    out.require(body.mesh.is_some(), || {
        Problem::error("missing_field", &here.key("mesh"), "\"mesh\" is missing")
            .limit("\"mesh\" (and \"parts\") for a deformable body, or \"rigid\"")
            .remedy("add \"mesh\", the source of the mesh; or \"rigid\" for a rigid body")
    });
    if let Some(placement) = &body.placement {
        check_placement(placement, &here.key("placement"), out);
    }
    let mut names = BTreeSet::new();
    for (i, part) in body.parts.iter().enumerate() {
        let here = here.key("parts").index(i);
        out.require(names.insert(part.part.as_str()), || {
            Problem::error("repeated_part", &here.key("part"), "the part has a material already")
                .value(part.part.as_str())
                .limit("one entry per part")
                .remedy("keep one of the entries")
        });
        check_part(part, &here, out);
    }
    out.require(!body.parts.is_empty(), || {
        Problem::error("no_parts", &here.key("parts"), "the body has no material")
            .value(Vec::<f64>::new())
            .limit("an entry for every part of the mesh")
            .remedy("add an entry; the part \"*\" stands for all parts")
    });
}

/// Checks the memories of a body against the sizes of its elements.
pub(in crate::scene) fn check_memories(
    index: usize,
    body: &BodyDocument,
    mesh: &Mesh,
    part_entry: &[u32],
    out: &mut Findings,
) {
    let here = Pointer::root().key("bodies").index(index).key("parts");
    for (i, part) in body.parts.iter().enumerate().filter(|(_, part)| part.memories().next().is_some()) {
        let of_part = part_entry.iter().enumerate().filter(|(_, entry)| **entry as usize == i);
        let largest = of_part.map(|(e, _)| mesh.element_volume_m3(e).cbrt()).fold(0.0, f64::max);
        for (field, memory) in part.memories() {
            memory.check_size(largest, &here.index(i).key(field), out);
        }
    }
}

/// Limits of erosion must be satisfied at rest.
fn check_erosion(part: &PartDocument, erosion: &ErosionDocument, here: &Pointer, out: &mut Findings) {
    let has_limit = [erosion.stretch, erosion.volume_ratio, erosion.damage].iter().any(Option::is_some);
    out.require(has_limit, || {
        Problem::error("erosion_without_limit", here, "the erosion has no limit")
            .limit("a stretch, a volume_ratio or a damage")
            .remedy("skin ruptures at a stretch of 1.5 to 2.5; omit the entry for a part that does not erode")
    });
    let remedy = "1 is undeformed; skin ruptures at 1.5 to 2.5";
    if let Some(stretch) = erosion.stretch {
        out.between(&here.key("stretch"), "the stretch", stretch, STRETCHES, remedy);
    }
    if let Some(ratio) = erosion.volume_ratio {
        let remedy = "1 is the volume at rest; 0.2 erodes elements crushed to a fifth of it";
        out.between(&here.key("volume_ratio"), "the volume ratio", ratio, VOLUME_RATIOS, remedy);
    }
    if let Some(damage) = erosion.damage {
        let here = here.key("damage");
        out.between(
            &here,
            "the damage",
            damage,
            DAMAGES,
            "0.995 erodes elements that have lost nearly all of their stress",
        );
        out.require(part.softening.is_some(), || {
            Problem::error(
                "damage_without_softening",
                &here,
                "the part has no softening, so its damage stays 0",
            )
            .value(damage)
            .limit("a part with softening")
            .remedy("give the part \"softening\", or another limit")
        });
    }
}

/// Damage leaves a thousandth of the stress, which a law that stiffens makes a tension again where the tear opens.
fn check_softening(part: &PartDocument, here: &Pointer, out: &mut Findings) {
    let law = part.material.law_name();
    let erodes = part.erosion.as_ref().is_some_and(|erosion| erosion.damage.is_some());
    if part.softening.is_some() && !erodes && !["neo_hookean", "mooney_rivlin"].contains(&law) {
        let (here, words) = (
            here.key("softening"),
            format!("{law} stiffens with stretch: torn elements bear tension again, and dissipate too much"),
        );
        out.push(
            Problem::warning("softening_without_erosion", &here, words)
                .limit("torn elements are deleted")
                .remedy("add \"erosion\": {\"damage\": 0.995} to the part"),
        );
    }
}

fn check_part(part: &PartDocument, here: &Pointer, out: &mut Findings) {
    // Density and viscosity.
    let density = here.key("density_kg_per_m3");
    out.positive(&density, "a density", part.density_kg_per_m3, "tissue and rubber have about 1000 kg/m³");
    out.at_most(&density, "the density", part.density_kg_per_m3, MOST_DENSITY, "give it in kg/m³");
    if part.density_kg_per_m3 > 0.0 {
        let remedy = "give it in kg/m³: water has 1000, steel 7850";
        out.usual(&density, "the density", part.density_kg_per_m3, [100.0, 25_000.0], remedy);
    }
    let viscosity = here.key("shear_viscosity_pa_s");
    let remedy = "soft tissue has 0.1 to 30 Pa s; 0 for none";
    out.not_negative(&viscosity, "a viscosity", part.shear_viscosity_pa_s, remedy);
    out.at_most(&viscosity, "the viscosity", part.shear_viscosity_pa_s, MOST_VISCOSITY, remedy);
    check_softening(part, here, out);
    // What stress remembers, erosion, and the law itself.
    for (field, memory) in part.memories() {
        memories::check(memory, part.material.is_split(), &here.key(field), out);
    }
    if let Some(erosion) = &part.erosion {
        check_erosion(part, erosion, &here.key("erosion"), out);
    }
    part.material.check(&here.key("material"), out);
    // A mean dilatation needs a separate U(J).
    let coupled = !part.material.is_split();
    let mean = match part.formulation {
        Some(Formulation::MeanDilatation) => Some("mean_dilatation"),
        Some(Formulation::MeanDilatationSingle) => Some("mean_dilatation_single"),
        _ => None,
    };
    out.require(!(coupled && mean.is_some()), || {
        Problem::error(
            "coupled_law_with_mean_dilatation",
            &here.key("formulation"),
            "mean dilatation averages U(J), but this law has no separate U(J)",
        )
        .value(mean.unwrap_or_default())
        .limit("full or reduced, for a coupled law")
        .remedy("choose \"full\", or a split law")
    });
    check_single_precision(part, &here.key("formulation"), out);
    // Values and fibres that differ between elements.
    if let Some(ratio) = part.stiffness_factor.as_ref().and_then(|factor| factor.rounded_to_ratio) {
        let place = here.key("stiffness_factor").key("rounded_to_ratio");
        out.between(&place, "the ratio", ratio, RATIOS, "1.05 changes a factor by at most 2.5 %");
    }
    if let Some(frame) = &part.fibre_frame {
        check_frame(frame, &here.key("fibre_frame"), out);
        out.require(part.material.family_count() > 0, || {
            Problem::warning("unused_fibre_frame", &here.key("fibre_frame"), "the law has no fibres")
                .limit("a law with fibres")
                .remedy("omit the frame, or choose a law with fibres")
        });
    }
}

/// Single precision loses the shear stress of nearly incompressible laws in the rounding of the pressure.
fn check_single_precision(part: &PartDocument, here: &Pointer, out: &mut Findings) {
    let is_single = part.formulation == Some(Formulation::MeanDilatationSingle);
    let Some(material) = part.material.to_material().filter(|_| is_single && part.material.is_split()) else {
        return;
    };
    let (G, K) = material.moduli_at_rest();
    out.require(BlockParameters::is_accurate_in_single(&material), || {
        Problem::error(
            "incompressible_in_single_precision",
            here,
            format!("the bulk modulus is {:.0} times the shear modulus: rounding errors of the pressure corrupt the shear stress", K / G),
        )
        .value("mean_dilatation_single")
        .limit(format!("a bulk modulus of at most {MOST_SINGLE_RATIO} times the shear modulus"))
        .remedy("choose \"mean_dilatation\", or a lower bulk modulus")
    });
}

fn check_frame(frame: &FibreFrameDocument, here: &Pointer, out: &mut Findings) {
    match frame {
        FibreFrameDocument::Mesh {} | FibreFrameDocument::Arrays { .. } => {}
        FibreFrameDocument::CentreLine { points_m } => check_line(points_m, &here.key("points_m"), out),
        FibreFrameDocument::Laplace { plane, .. } => {
            if let Some(plane) = plane {
                out.direction(&here.key("plane"), "the second direction", *plane);
            }
        }
        FibreFrameDocument::Constant { axis, plane } => {
            out.direction(&here.key("axis"), "the fibre axis", *axis);
            out.direction(&here.key("plane"), "the second direction", *plane);
            out.require(crate::scene::frames::constant_frame(*axis, *plane).is_some(), || {
                Problem::error("parallel_directions", &here.key("plane"), "the two directions are parallel")
                    .value(plane.to_vec())
                    .limit("not parallel to axis")
                    .remedy("give another direction in the plane of the fibres")
            });
        }
        FibreFrameDocument::Cylindrical { axis, .. } => {
            out.direction(&here.key("axis"), "the axis of the cylinder", *axis);
        }
    }
}

/// Consecutive points of a line must differ, and it must not turn back.
fn check_line(points: &[[f64; 3]], here: &Pointer, out: &mut Findings) {
    out.require((2..=MOST_POINTS).contains(&points.len()), || {
        Problem::error("out_of_range", here, "this is not a line")
            .value(points.len())
            .limit(format!("2 to {MOST_POINTS} points"))
            .remedy("give points along the fibres, in order")
    });
    let way = |i: usize| (Vec3::from(points[i + 1]) - Vec3::from(points[i])).try_normalize(0.0);
    let ways: Vec<Option<Vec3>> = (1..points.len()).map(|i| way(i - 1)).collect();
    for (i, way) in ways.iter().enumerate() {
        let turns_back = i > 0 && matches!((ways[i - 1], way), (Some(a), Some(b)) if (a + b).norm() < 1e-6);
        out.require(way.is_some() && !turns_back, || {
            let what =
                if turns_back { "the line turns back here" } else { "this point coincides with the next" };
            Problem::error("no_direction", &here.index(i), what)
                .value(points[i].to_vec())
                .limit("distinct consecutive points, on a line that does not turn back")
                .remedy("remove the point, or correct it")
        });
    }
}

fn check_placement(placement: &PlacementDocument, here: &Pointer, out: &mut Findings) {
    out.positive(&here.key("scale"), "the scale", placement.scale, "0.001 converts millimetres to metres");
    if let Some(rotation) = &placement.rotation {
        out.direction(&here.key("rotation").key("axis"), "the axis of the rotation", rotation.axis);
    }
}
