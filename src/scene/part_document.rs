//! Material and element of a part, in a scene document.

use super::materials::MaterialDocument;
use super::memories::{MemoryDocument, PronyDocument, Rules, SofteningDocument};
use super::named_materials::{WrittenMaterial, not_null};
use crate::mechanics::element::ElementKind;
use crate::mechanics::force;
use crate::mechanics::material::{Law, Material, Memories};
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Material and element of one part of the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartDocument {
    /// Name of the part in the mesh; `*` stands for every part without a separate entry.
    pub part: String,
    /// Density at rest [kg/m³]; a set of the library brings its own.
    #[schemars(with = "Option<f64>", transform = not_null)]
    pub density_kg_per_m3: f64,
    /// The constitutive law, or a set of the library: `{"library": "muscle/zhai_2019_ogden"}`. What the part or the material say beside
    /// the name replaces what the set has.
    #[schemars(with = "WrittenMaterial")]
    pub material: MaterialDocument,
    /// Name of the set of the library that the material is from; not written, as its numbers are.
    #[serde(default, skip_serializing)]
    #[schemars(skip)]
    pub library: Option<String>,
    /// Shear viscosity η [Pa s] of the part (Kelvin–Voigt): adds 2 η dev d to the stress of the law, where d is the rate of
    /// deformation. Ignored in quasi-static runs. Null omits the viscosity of a set of the library.
    #[serde(default, skip_serializing_if = "is_nothing")]
    #[schemars(with = "Option<f64>")]
    pub shear_viscosity_pa_s: f64,
    /// Stress relaxation of a split law. A quasi-static run uses the fully relaxed response, unless its time is real.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prony_series: Option<PronyDocument>,
    /// Softening of a split law beyond a strain energy, as for the onset of damage in skin. Explicit steps only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub softening: Option<SofteningDocument>,
    /// Limits beyond which elements are eroded, as for the rupture of skin. Explicit steps only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<ErosionDocument>,
    /// Element formulation; by default `mean_dilatation` for split laws and `full` for coupled ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formulation: Option<Formulation>,
    /// Material axes of the part; by default those of the mesh, otherwise x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fibre_frame: Option<FibreFrameDocument>,
    /// Factor of the stiffness of each element, the bulk modulus apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_factor: Option<StiffnessFactorDocument>,
}

/// Factors of the stiffness of elements, from an array of the mesh file or a column of its table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessFactorDocument {
    /// Name of the array: one positive number for each element.
    pub array: String,
    /// Ratio of neighbouring factors to which the numbers are rounded, such as 1.05; by default they are used as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rounded_to_ratio: Option<f64>,
}

/// Erosion of a part: stress and strain energy of an element beyond a limit vanish permanently; its mass remains at the
/// nodes. The limits apply to the mean deformation of the element.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErosionDocument {
    /// Largest admissible principal stretch [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stretch: Option<f64>,
    /// Smallest admissible volume, as a fraction of the volume at rest [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_ratio: Option<f64>,
    /// Largest admissible damage of a part with softening [-]: 1 − damage is the remaining fraction of the stress.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damage: Option<f64>,
}

impl ErosionDocument {
    /// The limits in the form of the force evaluation; a limit that is not set is infinite, or zero.
    pub fn limits(&self) -> force::ErosionLimits {
        force::ErosionLimits {
            stretch: self.stretch.unwrap_or(f64::INFINITY),
            volume_ratio: self.volume_ratio.unwrap_or(0.0),
            damage: self.damage.unwrap_or(1.0),
        }
    }
}

impl PartDocument {
    /// A part with a law and a density [kg/m³], and nothing else.
    pub fn new(part: String, density_kg_per_m3: f64, material: MaterialDocument) -> Self {
        Self {
            part,
            density_kg_per_m3,
            material,
            library: None,
            shear_viscosity_pa_s: 0.0,
            prony_series: None,
            softening: None,
            erosion: None,
            formulation: None,
            fibre_frame: None,
            stiffness_factor: None,
        }
    }
    /// Names of the arrays of the mesh that it uses.
    pub fn array_names(&self) -> impl Iterator<Item = &String> {
        let families = match &self.fibre_frame {
            Some(FibreFrameDocument::Arrays { families }) => &families[..],
            _ => &[],
        };
        families.iter().chain(self.stiffness_factor.iter().map(|factor| &factor.array))
    }
    /// The law of elements of another stiffness, the bulk modulus apart; `None` where its parameters are inadmissible.
    pub fn law_of_stiffness(&self, factor: f64) -> Option<Material> {
        let mut scaled = self.clone();
        scaled.material.scale_stiffness(factor);
        scaled.law()
    }
    /// The law under slow loading; `None` where its parameters are inadmissible.
    pub fn law(&self) -> Option<Material> {
        let law = self.material.to_material()?;
        self.memories().try_fold(law, |law, (_, memory)| memory.slow_law(law))
    }
    /// Its memories, with the names of the fields.
    pub fn memories(&self) -> impl Iterator<Item = (&'static str, &dyn MemoryDocument)> {
        let prony = self.prony_series.as_ref().map(|memory| memory as &dyn MemoryDocument);
        let softening = self.softening.as_ref().map(|memory| memory as &dyn MemoryDocument);
        // A new memory is a field above and a line here.
        let all = [("prony_series", prony), ("softening", softening)];
        all.into_iter().filter_map(|(field, memory)| Some((field, memory?)))
    }
    /// The same in the form of the force evaluation.
    pub fn memory(&self) -> Memories {
        let mut all = Memories::NONE;
        self.memories().for_each(|(_, memory)| memory.set(&mut all));
        all
    }
    /// Whether its stress depends on history, with this law.
    pub fn has_history(&self, law: &Material) -> bool {
        law.history_len() > 0 || self.memories().next().is_some()
    }
    /// What its history needs of steps and elements, with the names of the fields: that of the law, then that of each memory.
    pub fn rules(&self) -> impl Iterator<Item = (&'static str, Rules)> {
        let of_law = self.material.rules().map(|rules| ("material", rules));
        of_law.into_iter().chain(self.memories().map(|(field, memory)| (field, memory.rules())))
    }
    /// Whether its stress can be lost for good.
    pub fn can_tear(&self) -> bool {
        self.erosion.is_some() || self.rules().any(|(_, rules)| rules.damages)
    }
    /// Whether its stress depends on the rate of deformation.
    pub fn depends_on_rate(&self) -> bool {
        self.shear_viscosity_pa_s > 0.0 || self.rules().any(|(_, rules)| rules.depends_on_rate)
    }
    /// Whether only explicit steps support it.
    pub fn needs_explicit_steps(&self) -> bool {
        self.erosion.is_some() || self.rules().any(|(_, rules)| rules.without_explicit_steps.is_some())
    }
    /// The requested element formulation; by default mean dilatation for split laws, or averaged nodal pressure in elements of one point,
    /// and full integration for coupled ones.
    pub fn element(&self, material: &Material, kind: ElementKind) -> force::Formulation {
        match self.formulation {
            Some(Formulation::MeanDilatation | Formulation::MeanDilatationSingle) => {
                force::Formulation::MeanDilatation
            }
            Some(Formulation::Reduced) => force::Formulation::Reduced,
            None if material.volumetric().is_some() => {
                let mean = force::Formulation::MeanDilatation;
                if mean.is_of(kind) { mean } else { force::Formulation::NodalPressure }
            }
            Some(Formulation::Full) | None => force::Formulation::Full,
        }
    }
}

/// Element formulation of a part. Each kind of element has quadrature points of its own: eight in a hexahedron, six in a wedge, four in a
/// tetrahedron of ten nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema, ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum Formulation {
    /// All points for the isochoric part, one mean dilatation and one pressure per element.
    MeanDilatation,
    /// The same in single precision: each element's response to the differences of its displacements is rounded to 6e-8; motion, sums
    /// and energies of the whole keep double precision. Hexahedra only; for explicit steps.
    MeanDilatationSingle,
    /// All terms at all points.
    Full,
    /// One point, with a physical hourglass stabilisation whose energy the ledger reports. Hexahedra only.
    Reduced,
}

/// Material axes of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FibreFrameDocument {
    /// The axes stored in the mesh (limb segments have them; an error where there are none).
    // With braces: serde lets unknown fields pass in a tagged unit variant.
    Mesh {},
    /// One frame for the whole part: e1 along `axis`, e2 the part of `plane` normal to it.
    Constant {
        /// Direction of e1; any length.
        axis: [f64; 3],
        /// A direction in the plane of e1 and e2.
        plane: [f64; 3],
    },
    /// Around an axis: e1 along it, e2 circumferential, e3 radial.
    Cylindrical {
        /// A point on the axis [m].
        origin_m: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
    },
    /// A direction for each fibre family of the law, in its order, from arrays of the mesh file or columns of its table. They replace the
    /// directions of the law, which has one family or two.
    Arrays {
        /// Names of arrays of three components; any length.
        families: Vec<String>,
    },
    /// Along a line: e1 along it at its nearest point, e2 circumferential, e3 away from it.
    CentreLine {
        /// Points of the line in their order, joined by straight lines; directions change gradually between them [m].
        points_m: Vec<[f64; 3]>,
    },
    /// From one surface of the part to another: e1 along the gradient of the solution of Laplace's equation in the part, 0 on the one
    /// and 1 on the other, without flux through the rest.
    Laplace {
        /// Where the fibres begin.
        from: SurfaceDocument,
        /// Where the fibres end.
        to: SurfaceDocument,
        /// A direction in the plane of e1 and e2; not needed where all fibres of the law are along e1.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        plane: Option<[f64; 3]>,
    },
}

/// A surface of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum SurfaceDocument {
    /// The nodes of the part in this node set.
    Set(String),
    /// The nodes that it shares with this other part of the mesh.
    Part(String),
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_nothing(value: &f64) -> bool {
    *value == 0.0
}
