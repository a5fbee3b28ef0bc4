//! What a scene asks of the document of any law.

use crate::mechanics::material::Material;
use crate::scene::problem::Pointer;
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;

/// A law in a scene document.
pub trait LawDocument {
    /// The law that is meant; `None` where it cannot be made, which the checks have told.
    fn to_material(&self) -> Option<Material>;
    /// Checks the parameters, the range of the law apart.
    fn check(&self, here: &Pointer, out: &mut Findings);
    /// What the scene says of how far the law may be believed.
    fn valid_to(&self) -> Option<ValidityDocument>;
    /// Multiplies every stiffness but that against a change of volume.
    fn scale_stiffness(&mut self, factor: f64);
    /// Whether all that depends on J alone is in U(J), so that an element may average it.
    fn is_split(&self) -> bool {
        true
    }
    /// Number of fibre families, of those that cannot be made too.
    fn family_count(&self) -> usize {
        0
    }
}
