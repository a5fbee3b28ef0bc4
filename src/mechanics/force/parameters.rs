//! What blocks of elements are made from: elements, law, formulation.

use crate::element::{ElementKind, OfElement, ReferenceGeometry};
use crate::material::{FIBRE_EXPONENT_LIMIT, Law, Material, Memories};
use crate::tensor::{Mat3, Vec3};

/// [`FIBRE_EXPONENT_LIMIT`] in single precision, where e⁸⁸ is the largest number [-].
const SINGLE_EXPONENT_LIMIT: f64 = 60.0;

/// How the energy of an element is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// The points of the element for everything.
    Full,
    /// The same, and one mean dilatation for the volumetric energy of a split law; coupled laws are integrated fully.
    MeanDilatation,
    /// One point, and a pressure averaged over the volumes around the nodes, for a split law (`nodal_pressure.rs`).
    NodalPressure,
    /// One point at the mean gradient, and a stabilisation of the hourglass modes ([`crate::element::Hourglass`]).
    Reduced,
}

impl Formulation {
    /// Whether an element has it.
    pub const fn is_of(self, kind: ElementKind) -> bool {
        match self {
            Self::Full => true,
            // At one point the mean is the point's own.
            Self::MeanDilatation => kind.point_count() > 1,
            Self::NodalPressure => kind.has_nodal_pressure(),
            Self::Reduced => kind.has_one_point(),
        }
    }
}

/// Elements that no block can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BlockError {
    /// The kind of the elements does not support the formulation.
    #[error("elements of kind {0:?} have no formulation {1:?}")]
    Formulation(ElementKind, Formulation),
    /// The elements are of several kinds, or lack nodes of their kind.
    #[error("the elements of a block are of one kind, with all its nodes")]
    Kinds,
}

/// Law, formulation, density and viscosity of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockParameters {
    /// Constitutive law of every element of the block.
    pub material: Material,
    /// How it is integrated.
    pub formulation: Formulation,
    /// Whether internal forces are evaluated in single precision, where [`BlockParameters::has_single_precision`] says so.
    pub single_precision: bool,
    /// Density at rest ρ [kg/m³].
    pub density: f64,
    /// Linear bulk viscosity b1 [-].
    pub linear_viscosity: f64,
    /// Quadratic bulk viscosity b2 [-].
    pub quadratic_viscosity: f64,
    /// Shear viscosity η of the material [Pa s].
    pub shear_viscosity: f64,
    /// Relaxation and softening of the isochoric stress.
    pub memory: Memories,
    /// Limits beyond which its elements are deleted; `None`: never.
    pub erosion: Option<ErosionLimits>,
}

/// Largest ratio of bulk to shear modulus in single precision [-]. J is rounded to 6e-8 of a strain, and K multiplies that: at this
/// ratio it is 3e-4 of the shear stress of that strain.
pub const MOST_SINGLE_RATIO: f64 = 5e3;

impl BlockParameters {
    /// An elastic block: no viscosity, no memory, no erosion.
    #[cfg(test)]
    pub(crate) const fn elastic(material: Material, formulation: Formulation, density: f64) -> Self {
        Self {
            material,
            formulation,
            single_precision: false,
            density,
            linear_viscosity: 0.0,
            quadratic_viscosity: 0.0,
            shear_viscosity: 0.0,
            memory: Memories::NONE,
            erosion: None,
        }
    }
    /// Whether stress depends on rate or history, bulk viscosity apart: forces of [`ElementForces::add_viscous`](super::ElementForces::add_viscous).
    pub fn is_viscous(&self) -> bool {
        self.shear_viscosity > 0.0 || self.has_memory()
    }
    /// Whether stress depends on history, bulk viscosity apart.
    pub fn has_memory(&self) -> bool {
        self.history_len() > 0
    }
    /// Numbers that a point remembers: those of the law, then those of each memory.
    pub fn history_len(&self) -> usize {
        self.material.history_len() + self.memory.history_len()
    }
    /// What makes stress depend on history, for reports.
    pub fn history_titles(&self) -> Vec<String> {
        let of_law = Some(self.material.history_len()).filter(|count| *count > 0);
        let of_law = of_law.map(|count| format!("internal variables ({count})"));
        of_law.into_iter().chain(self.memory.titles()).collect()
    }
    /// Whether the forces of an element depend on the displacements of its own nodes only.
    pub fn is_local(&self) -> bool {
        self.formulation != Formulation::NodalPressure
    }
    /// Whether an element has one mean dilatation and one pressure for all of its points.
    pub fn has_mean_dilatation(&self) -> bool {
        self.formulation == Formulation::MeanDilatation && self.material.volumetric().is_some()
    }
    /// Whether single precision is accurate enough for a law: one with a U(J) whose bulk modulus is at most
    /// [`MOST_SINGLE_RATIO`] times its shear modulus.
    pub fn is_accurate_in_single(material: &Material) -> bool {
        let (G, K) = material.moduli_at_rest();
        material.volumetric().is_some() && K <= MOST_SINGLE_RATIO * G
    }
    /// Whether internal forces of elements of a kind are evaluated in single precision: hexahedra with a mean dilatation.
    pub fn has_single_precision(&self, kind: ElementKind) -> bool {
        self.single_precision && self.has_mean_dilatation() && kind.has_single_precision()
    }
    /// Exponent of an energy up to which elements of a kind follow it [-].
    pub fn exponent_limit(&self, kind: ElementKind) -> f64 {
        if self.has_single_precision(kind) { SINGLE_EXPONENT_LIMIT } else { FIBRE_EXPONENT_LIMIT }
    }
    /// Whether compression has a viscous pressure.
    pub fn has_bulk_viscosity(&self) -> bool {
        self.linear_viscosity > 0.0 || self.quadratic_viscosity > 0.0
    }
    /// As [`BlockParameters::wave_speed`], along fibres that all lie in its direction [m/s]: nothing small is faster.
    pub fn fastest_wave(&self) -> f64 {
        self.wave_speed().hypot((self.material.fibre_modulus_at_rest() / self.density).sqrt())
    }
    /// Speed of dilatational waves at rest, √((K + 4/3 G)/ρ) [m/s]; fibres apart.
    pub fn wave_speed(&self) -> f64 {
        let (G, K) = self.material.moduli_at_rest();
        ((K + 4.0 / 3.0 * G) / self.density).sqrt()
    }
}

/// Limits beyond which the elements of a part are deleted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErosionLimits {
    /// Largest principal stretch of F̄ [-]; infinite without this limit.
    pub stretch: f64,
    /// Least mean volume ratio [-]; 0 without this limit.
    pub volume_ratio: f64,
    /// Largest mean damage [-]; 1 without this limit.
    pub damage: f64,
}

/// One element to put into a block.
#[derive(Clone, Debug)]
pub struct BlockInput {
    /// Global number of the element.
    pub element: u32,
    /// Global numbers of its nodes, in the order of the kind.
    pub nodes: OfElement<u32>,
    /// Their reference positions X [m].
    pub corners: OfElement<Vec3>,
    /// Its material axes, columns e1, e2, e3 in reference axes.
    pub axes: Mat3,
    /// Its kind and reference geometry.
    pub geometry: ReferenceGeometry,
}

#[cfg(test)]
impl BlockInput {
    /// An element by itself, in its own axes.
    pub(crate) fn alone(corners: &[Vec3], geometry: ReferenceGeometry) -> Self {
        let nodes = (0..corners.len() as u32).collect();
        Self { element: 0, nodes, corners: OfElement::from_slice(corners), axes: Mat3::identity(), geometry }
    }
}
