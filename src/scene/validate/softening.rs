//! Checks of the softening of a part.

use super::Findings;
use crate::mesh::Mesh;
use crate::scene::document::{BodyDocument, PartDocument, SofteningDocument};
use crate::scene::problem::{Pointer, Problem};

/// Strain energies that make no one ask for the unit [J/m³].
const USUAL_ONSETS: [f64; 2] = [1e2, 1e8];
/// Fracture energies that make no one ask for the unit [J/m²].
const USUAL_ENERGIES: [f64; 2] = [1.0, 1e6];

/// Checks what the document says; `here` is the place of the softening.
pub(super) fn check(part: &PartDocument, softening: &SofteningDocument, here: &Pointer, out: &mut Findings) {
    out.require(part.material.is_split(), || {
        Problem::error(
            "coupled_law_with_softening",
            here,
            "softening acts on the isochoric stress, which this law does not separate",
        )
        .limit("a split law")
        .remedy("choose a split law: neo_hookean in place of coupled_neo_hookean")
    });
    let fields = [
        ("onset_j_per_m3", softening.onset_j_per_m3, "the strain energy at the onset", USUAL_ONSETS),
        (
            "fracture_energy_j_per_m2",
            softening.fracture_energy_j_per_m2,
            "the fracture energy",
            USUAL_ENERGIES,
        ),
    ];
    for (name, value, what, usual) in fields {
        let (here, remedy) =
            (here.key(name), "skin has some 3.6e6 J/m³ at its strength, and 2e3 to 3e4 J/m²");
        out.positive(&here, what, value, remedy);
        if value > 0.0 {
            out.usual(&here, what, value, usual, remedy);
        }
    }
}

/// Warns where elements are too large for the onset, see [`Softening::largest_size`](crate::mechanics::material::Softening::largest_size).
pub(in crate::scene) fn check_mesh(
    index: usize,
    body: &BodyDocument,
    mesh: &Mesh,
    part_entry: &[u32],
    out: &mut Findings,
) {
    let here = Pointer::root().key("bodies").index(index).key("parts");
    for (i, softening) in body.parts.iter().enumerate().filter_map(|(i, part)| Some((i, part.softening?))) {
        let size = |e: usize| mesh.element_volume_m3(e).cbrt();
        let of_part = part_entry.iter().enumerate().filter(|(_, entry)| **entry as usize == i);
        let largest = of_part.map(|(e, _)| size(e)).fold(0.0, f64::max);
        let admissible = softening.law().largest_size();
        out.require(!(largest > admissible), || {
            let message = "elements of this part store more energy at the onset than a tear across them \
                           consumes: they soften at a lower strain energy, so that the fracture energy stays";
            Problem::warning("early_softening", &here.index(i).key("softening"), message)
                .value(largest)
                .limit(format!("elements of at most {admissible:.3e} m (cube root of their volume)"))
                .remedy("refine the part, if only around the impact (\"refinement\")")
        });
    }
}
