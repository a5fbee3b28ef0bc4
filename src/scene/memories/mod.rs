//! What stress remembers, in a scene document: one file per memory, a field in
//! [`PartDocument`](super::part_document::PartDocument), and a line in its list of memories.

mod prony;
mod softening;

pub use prony::{BranchDocument, Moduli, PronyDocument};
pub use softening::SofteningDocument;

use super::problem::{Pointer, Problem};
use super::validate::Findings;
use crate::mechanics::material::{Material, Memories};

/// What a memory, or the internal variables of a law, need of steps and elements.
pub struct Rules {
    /// Its name in messages.
    pub name: &'static str,
    /// Code of the problem of steps that are not explicit; `None` where implicit ones support it, too.
    pub without_explicit_steps: Option<&'static str>,
    /// Whether it acts on a pressure, which must then be that of one element.
    pub needs_pressure_of_element: bool,
    /// Whether stress is lost for good.
    pub damages: bool,
    /// Whether stress depends on the rate of deformation.
    pub depends_on_rate: bool,
}

/// A memory in a scene document.
pub trait MemoryDocument {
    /// What it needs.
    fn rules(&self) -> Rules;
    /// Code of the problem of a law that does not separate the isochoric stress, on which memories act.
    fn code_with_coupled_law(&self) -> &'static str;
    /// Checks the parameters; `here` is the place of the memory.
    fn check(&self, here: &Pointer, out: &mut Findings);
    /// Checks the size of the largest element of the part, the cube root of its volume [m].
    fn check_size(&self, _largest_m: f64, _here: &Pointer, _out: &mut Findings) {}
    /// Sets the entry of this memory.
    fn set(&self, memories: &mut Memories);
    /// The law of a part with this memory under slow loading; `None` where its parameters are inadmissible.
    fn slow_law(&self, law: Material) -> Option<Material> {
        Some(law)
    }
}

/// Checks a memory and that it acts on a law whose isochoric stress is separate.
pub(in crate::scene) fn check(
    memory: &dyn MemoryDocument,
    is_split: bool,
    here: &Pointer,
    out: &mut Findings,
) {
    out.require(is_split, || {
        let name = memory.rules().name;
        let message = format!("{name} acts on the isochoric stress, which this law does not separate");
        Problem::error(memory.code_with_coupled_law(), here, message)
            .limit("a split law")
            .remedy("choose a split law: neo_hookean in place of coupled_neo_hookean")
    });
    memory.check(here, out);
}
