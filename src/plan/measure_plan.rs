//! Inputs of the measures.

use crate::scene::document::{ForceFilter, PersonDocument};

/// Artificial end of the modelled tissue: held nodes, cuts, faces that are not skin. Waves that reach it would be
/// transmitted or reflected differently in reality.
#[derive(Clone, Debug, PartialEq)]
pub struct TissueEnd {
    /// Name of the node set or the cut, for messages.
    pub name: String,
    /// Global numbers of its nodes, ascending.
    pub nodes: Vec<u32>,
}

/// Averaging of the peak force of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ForceAverage {
    /// Over a fraction of the duration of contact, but at least some steps.
    #[default]
    OfContact,
    /// Over this time [s].
    Window(f64),
    /// Filtered instead of averaged.
    Filter(ForceFilter),
}

/// Inputs of the measures.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurePlan {
    /// Thresholds of von Mises stress [Pa], ascending.
    pub stress_thresholds: Vec<f64>,
    /// Thresholds of strain energy density [J/m³], ascending.
    pub energy_density_thresholds: Vec<f64>,
    /// Thresholds of the largest principal strain [-], ascending.
    pub strain_thresholds: Vec<f64>,
    /// Volume for which the strain and the stress exceeded in it are reported [m³].
    pub exceeded_in_volume: f64,
    /// The person who is hit, and where.
    pub person: Option<PersonDocument>,
    /// Averaging of the peak force.
    pub force_average: ForceAverage,
    /// Artificial ends of the modelled tissue.
    pub tissue_ends: Vec<TissueEnd>,
    /// Whether the tissue starts undeformed and at rest in its own frame, and nothing but contact can deform it.
    pub moved_by_contact_alone: bool,
    /// Skin of the tissue from which depth is measured: faces with global nodes; empty if there is no tissue.
    pub tissue_skin: Vec<[u32; 4]>,
}
