//! Material axes and laws of the elements of a body.

use super::document::{BodyDocument, MeshDocument, PartDocument, StiffnessFactorDocument};
use super::frames::{NoAxes, axes_of};
use super::problem::{Pointer, Problem, suggest};
use super::validate::Findings;
use crate::mechanics::material::Material;
use crate::mechanics::tensor::Mat3;
use crate::mesh::{ElementField, Mesh};
use std::collections::BTreeMap;

/// Largest number of elements listed in a problem.
const LISTED: usize = 20;
/// Largest number of different stiffness factors in a part: elements of one stiffness are computed together.
const MOST_FACTORS: usize = 64;
/// Factors of stiffness beyond which a number is a mistake [-].
const FACTORS: [f64; 2] = [1e-3, 1e3];

/// Material axes of all elements, empty when no law of the body has fibres; `None` when problems were found.
pub(super) fn body_axes(
    index: usize,
    body: &BodyDocument,
    mesh: &Mesh,
    part_entry: &[u32],
    out: &mut Findings,
) -> Option<Vec<Mat3>> {
    if body.parts.iter().all(|part| part.material.family_count() == 0) {
        return Some(Vec::new());
    }
    let parts = Pointer::root().key("bodies").index(index).key("parts");
    let (mut axes, mut complete) = (vec![Mat3::identity(); mesh.cells.len()], true);
    for (entry, part) in body.parts.iter().enumerate() {
        let elements = elements_of(entry, part_entry);
        // Without a law that can be made, or without fibres, axes mean nothing.
        let law = part.law()?;
        let frame = part.fibre_frame.as_ref().filter(|_| law.family_count() > 0);
        if elements.is_empty() {
            continue;
        }
        let is_generated = matches!(body.mesh, Some(MeshDocument::Generator(_)));
        let is_unknown = law.family_count() > 0 && frame.is_none() && mesh.axes.is_empty() && !is_generated;
        out.require(!is_unknown, || default_frame(part, &parts.index(entry).key("fibre_frame")));
        match axes_of(frame, &law, mesh, &elements) {
            Ok(found) => elements.into_iter().zip(found).for_each(|(element, frame)| axes[element] = frame),
            Err(reason) => {
                complete = false;
                out.0.extend(frame_problem(&reason, part, mesh, &parts.index(entry).key("fibre_frame")));
            }
        }
    }
    complete.then_some(axes)
}

/// Fibres of a mesh from a file, about whose directions neither it nor the scene says anything.
fn default_frame(part: &PartDocument, here: &Pointer) -> Problem {
    let message = format!(
        "the law of part {:?} has fibres, but neither the mesh nor the scene has material axes: those of the law are taken for x, y, z",
        part.part
    );
    Problem::warning("default_fibre_frame", here, message)
        .limit("material axes of the tissue")
        .remedy("give the part a `fibre_frame`; x, y, z are {\"kind\": \"constant\", \"axis\": [1, 0, 0], \"plane\": [0, 1, 0]}")
}

fn elements_of(entry: usize, part_entry: &[u32]) -> Vec<usize> {
    (0..part_entry.len()).filter(|element| part_entry[*element] as usize == entry).collect()
}

/// "element 7", or "12 elements (1, 2, …)".
fn named(elements: &[usize]) -> String {
    let listed: Vec<String> = elements.iter().take(LISTED).map(usize::to_string).collect();
    let more = if elements.len() > LISTED { ", …" } else { "" };
    match elements {
        [element] => format!("element {element}"),
        _ => format!("{} elements ({}{more})", elements.len(), listed.join(", ")),
    }
}

/// `None` for what the checks of the document report.
fn frame_problem(reason: &NoAxes, part: &PartDocument, mesh: &Mesh, here: &Pointer) -> Option<Problem> {
    let family = |family: usize| part.array_names().nth(family).map_or("", |name| name.as_str());
    let problem = match reason {
        // Axes that the mesh, or a constant or cylindrical frame, should have given.
        NoAxes::Degenerate => return None,
        NoAxes::MeshHasNone => Problem::error("mesh_without_axes", here, "the mesh carries no material axes")
            .value("mesh")
            .limit("a mesh with axes (a limb segment has them)")
            .remedy("choose another kind of frame: constant, cylindrical, centre_line, laplace, arrays"),
        NoAxes::OnAxis(elements) => {
            let message = format!("{} on the axis, where no direction is radial", named(elements));
            Problem::error("element_on_axis", here, message)
                .value(elements.iter().take(LISTED).copied().collect::<Vec<usize>>())
                .limit("an axis outside the elements of the part, for fibres around it")
                .remedy("move the axis, or choose a constant frame")
        }
        // Directions from arrays of the file or the table.
        NoAxes::NoArray { family: number, scalars } => no_array(
            mesh,
            family(*number),
            (*scalars, "three components"),
            &here.key("families").index(*number),
        ),
        NoAxes::Families { of_law } => {
            let message = "the arrays are not the fibre families of the law";
            Problem::error("families_of_law", &here.key("families"), message)
                .value(part.array_names().cloned().collect::<Vec<_>>())
                .limit(format!("an array for each family of a law that has one, or two in different directions; it has {of_law}"))
                .remedy("name as many arrays as the law has families, or choose a law of one or two")
        }
        NoAxes::NoDirection { family: number, elements } => {
            let name = family(*number);
            let message = format!("the array {name:?} has no direction in {} of the part", named(elements));
            Problem::error("no_direction", &here.key("families").index(*number), message)
                .value(elements.iter().take(LISTED).copied().collect::<Vec<usize>>())
                .limit("a vector of finite length > 0 in every element of the part")
                .remedy(
                    "fill these elements in the file or the table; numbers are those of `contuse mesh info`",
                )
        }
        // Fibres between two surfaces, by Laplace's equation.
        NoAxes::Surface { at_end, reason } => {
            let key = if *at_end { "to" } else { "from" };
            let known = mesh.node_sets.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            Problem::error(
                "no_surface",
                &here.key(key),
                format!("no fibres run between these surfaces: {reason}"),
            )
            .limit("two surfaces of the part, without common nodes")
            .remedy(format!(
                "name a set ({known}) or an adjacent part ({}), as {{\"set\": …}} or {{\"part\": …}}",
                mesh.parts.join(", ")
            ))
        }
        NoAxes::Flat(elements) => {
            let message = format!("no fibre runs through {}: the gradient vanishes there", named(elements));
            Problem::error("no_gradient", here, message)
                .value(elements.iter().take(LISTED).copied().collect::<Vec<usize>>())
                .limit("every piece of the part between both surfaces")
                .remedy("move pieces that touch fewer than two of the surfaces to another part, or choose surfaces that bound every piece")
        }
        // The plane of e1 and e2.
        NoAxes::NoPlane(None) => Problem::error(
            "missing_plane",
            &here.key("plane"),
            "the fibres of the law are not all along e1",
        )
        .limit("a direction in the plane of e1 and e2, for such a law")
        .remedy("add \"plane\", such as [0, 0, 1]; or give the law one family along e1: \"angles_deg\": [0]"),
        NoAxes::NoPlane(Some(elements)) => {
            let message = format!("e1 is along this direction in {}", named(elements));
            Problem::error("parallel_directions", &here.key("plane"), message)
                .value(elements.iter().take(LISTED).copied().collect::<Vec<usize>>())
                .limit("not parallel to e1")
                .remedy("give another direction in the plane of the fibres")
        }
    };
    Some(problem)
}

/// There is no array of a name, or it has another number of components.
fn no_array(mesh: &Mesh, name: &str, (other, components): (bool, &str), here: &Pointer) -> Problem {
    let message = if other {
        format!("the element array {name:?} does not have {components}")
    } else {
        format!("the mesh has no element array {name:?} with one or three components")
    };
    let unused = mesh.notes.iter().find(|note| note.starts_with("arrays not used"));
    let known = unused.map_or_else(|| suggest(name, mesh.fields.names()), Clone::clone);
    Problem::error("no_array", here, message)
        .value(name)
        .limit(format!("a cell array of a .vtu or .vtk file, or a column of its table, with {components}"))
        .remedy(format!("write the array into the file, or correct its name: {known}"))
}

/// Laws of the elements of a body.
pub(super) struct Laws {
    /// Laws of the parts, then laws scaled by the stiffness factors of elements.
    pub materials: Vec<Material>,
    /// For every element, the index of its law.
    pub law_of: Vec<u32>,
}

/// The laws of all elements; `None` when problems were found.
pub(super) fn laws(
    index: usize,
    body: &BodyDocument,
    mesh: &Mesh,
    part_entry: &[u32],
    out: &mut Findings,
) -> Option<Laws> {
    let parts = Pointer::root().key("bodies").index(index).key("parts");
    let mut materials = body.parts.iter().map(PartDocument::law).collect::<Option<Vec<_>>>()?;
    let mut law_of = part_entry.to_vec();
    let mut complete = true;
    for (entry, part) in body.parts.iter().enumerate() {
        let Some(requested) = &part.stiffness_factor else { continue };
        let here = parts.index(entry).key("stiffness_factor");
        let elements = elements_of(entry, part_entry);
        let Some(factors) = factors(requested, mesh, &elements, &here, out) else {
            complete = false;
            continue;
        };
        let mut known: BTreeMap<u64, u32> = BTreeMap::new();
        for (element, factor) in elements.into_iter().zip(factors) {
            let law = if let Some(law) = known.get(&factor.to_bits()) {
                *law
            } else {
                materials.push(part.law_of_stiffness(factor)?);
                materials.len() as u32 - 1
            };
            known.insert(factor.to_bits(), law);
            law_of[element] = law;
        }
    }
    complete.then_some(Laws { materials, law_of })
}

/// The factor of each of some elements.
fn factors(
    requested: &StiffnessFactorDocument,
    mesh: &Mesh,
    elements: &[usize],
    here: &Pointer,
    out: &mut Findings,
) -> Option<Vec<f64>> {
    let place = here.key("array");
    let field = mesh.fields.get(&requested.array);
    let Some(ElementField::Scalars(values)) = field else {
        out.push(no_array(mesh, &requested.array, (field.is_some(), "one component"), &place));
        return None;
    };
    let is_factor = |e: &usize| (FACTORS[0]..=FACTORS[1]).contains(&values[*e]);
    let wrong: Vec<usize> = elements.iter().copied().filter(|e| !is_factor(e)).collect();
    if let Some(first) = wrong.first() {
        let message = format!("{} of the part without a stiffness factor", named(&wrong));
        out.push(
            Problem::error("out_of_range", &place, message)
                .value(values[*first])
                .limit(format!("a number from {} to {} in every element of the part", FACTORS[0], FACTORS[1]))
                .remedy("1 leaves the material unchanged; give moduli in the material, and their ratio to these here"),
        );
        return None;
    }
    let step = requested.rounded_to_ratio.map(f64::ln);
    let rounded = |e: &usize| match step {
        Some(step) => ((values[*e].ln() / step).round() * step).exp(),
        None => values[*e],
    };
    let factors: Vec<f64> = elements.iter().map(rounded).collect();
    let mut different: Vec<u64> = factors.iter().map(|factor| factor.to_bits()).collect();
    different.sort_unstable();
    different.dedup();
    out.require(different.len() <= MOST_FACTORS, || {
        let range = elements
            .iter()
            .fold([f64::INFINITY, 0.0_f64], |[low, high], e| [low.min(values[*e]), high.max(values[*e])]);
        // A hundredth more, and the ends rounded inwards.
        let ratio = 1.0 + (1.01 * (range[1] / range[0]).ln() / (MOST_FACTORS - 2) as f64).exp_m1();
        Problem::error("too_many_factors", &place, "the part has too many different stiffness factors")
            .value(different.len())
            .limit(format!("at most {MOST_FACTORS}"))
            .remedy(format!(
                "add \"rounded_to_ratio\": {:.3}, or round the numbers in the file",
                ratio + 5e-4
            ))
    });
    (different.len() <= MOST_FACTORS).then_some(factors)
}
