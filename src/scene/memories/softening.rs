//! Softening of a part, in a scene document.

use super::{MemoryDocument, Rules};
use crate::mechanics::material::{Memories, Softening};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Strain energies that make no one ask for the unit [J/m³].
const USUAL_ONSETS: [f64; 2] = [1e2, 1e8];
/// Fracture energies that make no one ask for the unit [J/m²].
const USUAL_ENERGIES: [f64; 2] = [1.0, 1e6];

/// Softening of the isochoric stress: beyond the strain energy of the onset the stress is reduced for good, such that tearing a
/// layer of elements apart consumes the fracture energy per area of the crack, whatever the size of the elements, if they are about as
/// high across the crack as wide: the energy of others is the ratio of that height to the cube root of their volume times as large.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SofteningDocument {
    /// Strain energy per volume at rest where softening begins [J/m³]: the area under the curve of nominal stress against strain, up
    /// to the ultimate strength.
    pub onset_j_per_m3: f64,
    /// Fracture energy: work to tear through an area at rest [J/m²].
    pub fracture_energy_j_per_m2: f64,
}

impl SofteningDocument {
    fn law(self) -> Softening {
        Softening { onset: self.onset_j_per_m3, fracture_energy: self.fracture_energy_j_per_m2 }
    }
}

impl MemoryDocument for SofteningDocument {
    fn rules(&self) -> Rules {
        Rules {
            name: "softening",
            without_explicit_steps: Some("softening_without_explicit_steps"),
            needs_pressure_of_element: true,
            damages: true,
            depends_on_rate: false,
        }
    }

    fn code_with_coupled_law(&self) -> &'static str {
        "coupled_law_with_softening"
    }

    fn check(&self, here: &Pointer, out: &mut Findings) {
        let fields = [
            ("onset_j_per_m3", self.onset_j_per_m3, "the strain energy at the onset", USUAL_ONSETS),
            (
                "fracture_energy_j_per_m2",
                self.fracture_energy_j_per_m2,
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

    /// Warns where elements are too large for the onset, see [`Softening::largest_size`].
    fn check_size(&self, largest_m: f64, here: &Pointer, out: &mut Findings) {
        let admissible = self.law().largest_size();
        out.require(!(largest_m > admissible), || {
            let message = "elements of this part store more energy at the onset than a tear across them \
                           consumes: they soften at a lower strain energy, so that the fracture energy stays";
            Problem::warning("early_softening", here, message)
                .value(largest_m)
                .limit(format!("elements of at most {admissible:.3e} m (cube root of their volume)"))
                .remedy("refine the part, if only around the impact (\"refinement\")")
        });
    }

    fn set(&self, memories: &mut Memories) {
        memories.softening = self.law();
    }
}
