//! The interface that every law's document implements.

use crate::mechanics::material::Material;
use crate::scene::memories::Rules;
use crate::scene::problem::Pointer;
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;

/// A constitutive law in a scene document.
pub trait LawDocument {
    /// The law; `None` where its parameters are inadmissible, which the checks report.
    fn to_material(&self) -> Option<Material>;
    /// Checks the parameters, except the range of validity.
    fn check(&self, here: &Pointer, out: &mut Findings);
    /// Range of validity given in the document.
    fn valid_to(&self) -> Option<ValidityDocument>;
    /// Multiplies every stiffness except the volumetric one.
    fn scale_stiffness(&mut self, factor: f64);
    /// Multiplies the bulk modulus of a split law; a coupled law has none of its own.
    fn scale_bulk_modulus(&mut self, _factor: f64) {}
    /// Whether all dependence on J alone is in U(J), so that an element may average it.
    fn is_split(&self) -> bool {
        true
    }
    /// What internal variables of the law need of steps and elements, where it has any. Energy-conserving steps do not support them;
    /// preload and quasi-static steps without real time have the elastic response.
    fn rules(&self) -> Rules {
        Rules {
            name: "internal variables",
            without_explicit_steps: None,
            needs_pressure_of_element: false,
            damages: false,
            depends_on_rate: true,
        }
    }
    /// Number of fibre families, including invalid ones.
    fn family_count(&self) -> usize {
        0
    }
}
