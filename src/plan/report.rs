//! Report of a plan: what it kept, what it omitted and why, and its estimated cost.

use super::integrator::{Integrator, SystemSize};
use super::named_materials::NamedMaterialReport;
use super::stable_step::StableStepReport;
use crate::scene::IntegratorChoice;
use crate::scene::document::Keep;
use serde::{Deserialize, Serialize};

/// Report of a plan, in numbers and words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct PlanReport {
    /// Number of nodes of meshes.
    pub nodes: usize,
    /// Number of elements of all bodies.
    pub elements: usize,
    /// Approximate memory of a run [bytes].
    pub memory_bytes: u64,
    /// Memory by component [bytes].
    pub memory: MemoryReport,
    /// Initial time step [s]: the smallest critical time step times the safety factor, or the scene's `max_step_s`.
    pub stable_step_s: f64,
    /// What determines the critical time step.
    pub stable_step: StableStepReport,
    /// Number of steps to the end at that step; a run that crushes elements or stretches fibres shortens the step, and
    /// takes more.
    pub expected_steps: u64,
    /// Run time of these steps on one core [s] if every element is active in every step, from a fixed table of costs,
    /// without recording.
    pub expected_run_time_s: f64,
    /// Element blocks, by kernel; of more than 64 the first.
    pub blocks: Vec<BlockReport>,
    /// Number of all element blocks.
    pub block_count: usize,
    /// Parts whose material is a set of the library.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub named_materials: Vec<NamedMaterialReport>,
    /// Nearly incompressible parts with a bulk modulus below that of water, and the effect to be expected of it, in words; null without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capped_bulk_moduli: Option<String>,
    /// Bodies that are locally refined.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinements: Vec<RefinementReport>,
    /// Rigid bodies with their mass and inertia; of more than 64 the first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_bodies: Vec<RigidReport>,
    /// Contact pairs that are computed, with their surfaces and settings; of more than 64 the first.
    pub pairs: Vec<PairReport>,
    /// Number of all contact pairs that are computed.
    pub pair_count: usize,
    /// Time integration scheme with its parameters and, for implicit steps, the size of the system.
    pub integrator: IntegratorReport,
    /// Integrator, blocks, rigid bodies and pairs in words.
    pub kept: Vec<String>,
    /// What is absent, each with its reason.
    pub omitted: Vec<Omitted>,
    /// What is kept though the scene may not need it, because it was requested.
    pub restored: Vec<Keep>,
}

/// Time integration of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct IntegratorReport {
    /// `explicit`, `implicit` or `quasi_static`.
    pub kind: String,
    /// Intended time step [s].
    pub step_s: f64,
    /// Weight θ of the end of the step [-]; null for explicit and quasi-static steps.
    pub theta: Option<f64>,
    /// Size of the linear systems of implicit steps; null for explicit steps.
    pub systems: Option<SystemSize>,
    /// How the scheme was chosen, where the scene leaves it open (`auto`), with the estimated cost of both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<IntegratorChoice>,
}

impl IntegratorReport {
    pub(super) fn new(integrator: &Integrator, stable_step_s: f64, choice: Option<IntegratorChoice>) -> Self {
        match integrator {
            Integrator::Explicit(_) => {
                Self { kind: "explicit".into(), step_s: stable_step_s, theta: None, systems: None, choice }
            }
            Integrator::Implicit(implicit) => Self {
                kind: if implicit.statics.is_some() { "quasi_static" } else { "implicit" }.into(),
                step_s: implicit.step,
                theta: implicit.statics.is_none().then_some(implicit.theta),
                systems: Some(implicit.systems),
                choice,
            },
        }
    }

    pub(super) fn in_words(&self) -> Option<String> {
        let size = self.systems?;
        let kind =
            self.theta.map_or_else(|| "quasi-static".into(), |theta| format!("implicit (θ = {theta})"));
        Some(format!(
            "{kind} steps of {:.3e} s: {} unknowns, a factor of {:.2} M entries in {:.3} GFLOP",
            self.step_s,
            size.unknowns,
            1e-6 * size.factor_entries as f64,
            1e-9 * size.factor_flops
        ))
    }
}

/// Elements of one body with the same law and formulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct BlockReport {
    /// Name of the body.
    pub body: String,
    /// Names of the parts in this block.
    pub parts: Vec<String>,
    /// Number of elements in this block.
    pub elements: usize,
    /// Their kind, such as `hex8`.
    pub kind: String,
    /// Name of the constitutive law.
    pub law: String,
    /// Number of fibre families that are evaluated.
    pub fibre_families: usize,
    /// Element formulation and integration.
    pub formulation: String,
    /// Shear viscosity [Pa s].
    pub shear_viscosity_pa_s: f64,
    /// What makes its stress depend on the past, such as a Prony series; empty for elastic and viscous materials.
    pub history: Vec<String>,
    /// Whether elements may be eroded.
    pub erodes: bool,
    /// Smallest initial critical time step of its elements, without safety factor [s].
    pub smallest_stable_step_s: f64,
    /// Element-steps per second and core assumed for the run time.
    pub element_steps_per_s: f64,
}

/// A contact pair: its sides, the discretisation, friction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct PairReport {
    /// Names of the sides, slave first.
    pub name: String,
    /// Number of nodes on the slave surface; 0 for a rigid body.
    pub slave_nodes: usize,
    /// Number of faces of the master; null for a plane or a rigid body.
    pub master_faces: Option<usize>,
    /// Names of the rigid shapes among slave and master.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_shapes: Vec<String>,
    /// Coulomb friction μ [-].
    pub friction: f64,
    /// Unknowns per contact: one if frictionless, otherwise three.
    pub unknowns_per_contact: u32,
}

/// Approximate memory of a run by component; recordings of earlier versions lack some.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct MemoryReport {
    /// What a run takes whatever its scene [bytes]: the program, and the buffers of a recording.
    pub program_bytes: u64,
    /// What the start takes and the allocator keeps [bytes].
    pub start_bytes: u64,
    /// Scene [bytes]: meshes, law, part and material axes of each element.
    pub scene_bytes: u64,
    /// Plan [bytes]: positions, masses, connectivity, boundary surfaces, assembly, and the matrix and factor of implicit
    /// steps.
    pub plan_bytes: u64,
    /// Constants of the elements [bytes]: geometry, fibres, node numbers.
    pub elements_bytes: u64,
    /// State [bytes]: displacement, velocity; viscous forces where a part has them; history of the elements: bulk viscosity,
    /// what stress remembers at the points, and nodal displacements and forces of each Prony branch, for its energy.
    pub state_bytes: u64,
    /// Buffers of a step [bytes]: element forces, totals, nodal forces, positions, the bound of the critical time step by the assembled mesh.
    pub step_bytes: u64,
    /// Contact [bytes]: topology, search trees, candidates and reactions.
    pub contact_bytes: u64,
    /// Recorded fields at nodes and elements [bytes].
    pub fields_bytes: u64,
    /// Measures of the tissue [bytes]: the stress over the depth below its surface, values at the points.
    pub measures_bytes: u64,
    /// Copies of frames on their way to the thread of the recording [bytes].
    pub frames_bytes: u64,
    /// Total without the program, divided by the number of elements [bytes].
    pub bytes_per_element: f64,
}

impl MemoryReport {
    /// Sum of all components [bytes].
    pub fn total_bytes(&self) -> u64 {
        self.program_bytes + self.bytes_without_program()
    }

    /// The same without the program [bytes].
    fn bytes_without_program(&self) -> u64 {
        self.start_bytes
            + self.scene_bytes
            + self.plan_bytes
            + self.elements_bytes
            + self.state_bytes
            + self.step_bytes
            + self.contact_bytes
            + self.fields_bytes
            + self.measures_bytes
            + self.frames_bytes
    }

    /// With the bytes of each of so many elements.
    pub(super) fn per_element(self, elements: usize) -> Self {
        Self { bytes_per_element: self.bytes_without_program() as f64 / elements.max(1) as f64, ..self }
    }
}

/// A feature that the plan omits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct Omitted {
    /// Computation that is omitted, such as `inactive elements` or `viscosity pass`.
    pub what: String,
    /// Reason for the omission.
    pub why: String,
    /// The name in `solver.keep` (or for `--keep`) that keeps it; null where it cannot be kept.
    pub switch: Option<Keep>,
}

/// Report of a locally refined body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RefinementReport {
    /// Name of the body.
    pub body: String,
    /// Number of elements before refinement.
    pub elements_before: usize,
    /// Number of these that were split.
    pub elements_split: usize,
    /// Number of elements after refinement.
    pub elements: usize,
    /// Number of hanging nodes between coarse and fine elements, which follow others.
    pub hanging_nodes: usize,
}

impl RefinementReport {
    /// The report in one line.
    pub fn in_words(&self) -> String {
        let Self { body, elements_before, elements_split, elements, hanging_nodes } = self;
        format!(
            "{body}: {elements_split} of {elements_before} hex8 locally refined, {elements} now; {hanging_nodes} hanging nodes between \
             coarse and fine elements"
        )
    }
}

/// Report of a rigid body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RigidReport {
    /// Name of the body.
    pub body: String,
    /// Name of its shape.
    pub shape: String,
    /// Mass of the body [kg].
    pub mass_kg: f64,
    /// Principal moments of inertia [kg m²], about the axes of the shape.
    pub inertia_kg_m2: [f64; 3],
}

impl RigidReport {
    pub(super) fn in_words(&self) -> String {
        format!("{}: rigid {}, {:.4e} kg, six unknowns", self.body, self.shape, self.mass_kg)
    }
}

impl BlockReport {
    pub(super) fn in_words(&self) -> String {
        let Self {
            body,
            elements,
            kind,
            formulation,
            law,
            fibre_families,
            shear_viscosity_pa_s,
            history,
            erodes,
            ..
        } = self;
        let fibres = match fibre_families {
            0 => String::new(),
            1 => " with 1 fibre family".into(),
            n => format!(" with {n} fibre families"),
        };
        let viscous = if *shear_viscosity_pa_s > 0.0 {
            format!(", viscosity {shear_viscosity_pa_s} Pa s")
        } else {
            String::new()
        };
        let history = history.iter().fold(String::new(), |before, of| before + ", " + of);
        let eroding = if *erodes { ", with erosion" } else { "" };
        format!("{body}: {elements} {kind}, {formulation}, {law}{fibres}{viscous}{history}{eroding}")
    }
}

impl PairReport {
    /// The master in words: its number of faces, or its rigid shape.
    pub fn master_in_words(&self) -> String {
        let rigid_master = self.rigid_shapes.get(usize::from(self.slave_nodes == 0));
        match (self.master_faces, rigid_master) {
            (Some(faces), _) => format!("{faces} faces"),
            (None, Some(shape)) => format!("a rigid {shape}"),
            (None, None) => "a plane".into(),
        }
    }

    pub(super) fn in_words(&self) -> String {
        let slave = match self.slave_nodes {
            0 => self.rigid_shapes.first().map_or_else(String::new, |shape| format!("a rigid {shape}")),
            nodes => format!("{nodes} slave nodes"),
        };
        let master = self.master_in_words();
        let unknowns = if self.unknowns_per_contact == 1 { "1 unknown" } else { "3 unknowns" };
        format!(
            "contact {}: {slave} against {master}, friction {}, {unknowns} per contact",
            self.name, self.friction
        )
    }
}
