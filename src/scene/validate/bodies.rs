//! Checks of the parts of a body that need the document alone: density, material, element, fibre frame, placement.

use super::{Findings, prony, softening};
use crate::scene::document::{
    BodyDocument, ErosionDocument, FibreFrameDocument, Formulation, PartDocument, PlacementDocument,
};
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

/// Limits of erosion must be satisfied at rest.
fn check_erosion(part: &PartDocument, erosion: &ErosionDocument, here: &Pointer, out: &mut Findings) {
    let has_limit = [erosion.stretch, erosion.volume_ratio, erosion.damage].iter().any(Option::is_some);
    out.require(has_limit, || {
        Problem::error("erosion_without_limit", here, "no limit says when an element is eroded")
            .limit("a stretch, a volume_ratio or a damage")
            .remedy("skin tears at a stretch of 1.5 to 2.5; omit the entry where nothing tears")
    });
    let remedy = "1 is no stretch at all; skin tears at 1.5 to 2.5";
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
            Problem::error("damage_without_softening", &here, "stress of this part is never lost")
                .value(damage)
                .limit("a part with softening")
                .remedy("give the part \"softening\", or another limit")
        });
    }
}

fn check_part(part: &PartDocument, here: &Pointer, out: &mut Findings) {
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
    if let Some(series) = &part.prony_series {
        prony::check(&part.material, series, &here.key("prony_series"), out);
    }
    if let Some(softening) = &part.softening {
        softening::check(part, softening, &here.key("softening"), out);
    }
    if let Some(erosion) = &part.erosion {
        check_erosion(part, erosion, &here.key("erosion"), out);
    }
    part.material.check(&here.key("material"), out);
    let coupled = !part.material.is_split();
    out.require(!(coupled && part.formulation == Some(Formulation::MeanDilatation)), || {
        Problem::error(
            "coupled_law_with_mean_dilatation",
            &here.key("formulation"),
            "mean dilatation averages U(J), but this law has no separate U(J)",
        )
        .value("mean_dilatation")
        .limit("full or reduced, for a coupled law")
        .remedy("choose \"full\", or a split law")
    });
    if let Some(frame) = &part.fibre_frame {
        check_frame(frame, &here.key("fibre_frame"), out);
        out.require(part.material.family_count() > 0, || {
            Problem::warning("unused_fibre_frame", &here.key("fibre_frame"), "the law has no fibres")
                .limit("a law with fibres")
                .remedy("omit the frame, or choose a law with fibres")
        });
    }
}

fn check_frame(frame: &FibreFrameDocument, here: &Pointer, out: &mut Findings) {
    match frame {
        FibreFrameDocument::Mesh {} => {}
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

fn check_placement(placement: &PlacementDocument, here: &Pointer, out: &mut Findings) {
    out.positive(&here.key("scale"), "the scale", placement.scale, "0.001 turns millimetres into metres");
    if let Some(rotation) = &placement.rotation {
        out.direction(&here.key("rotation").key("axis"), "the axis of the rotation", rotation.axis);
    }
}
