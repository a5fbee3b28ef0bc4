//! The scene: what the user asks for, in the user's terms.
//!
//! `document` is the input (JSON); a [`Scene`] is a document that passed every check, with its meshes in place. [`load()`]
//! makes one from the other in five stages and collects all problems:
//!
//! 1. `json`: bytes → JSON value; repeated keys.
//! 2. `structure`: against the schema generated from the document's types; what is broken is mended in a copy, in which
//!    `named_materials` then puts the sets of the library in the place of their names.
//! 3. `validate`: what the document alone shows.
//! 4. `build`: the meshes, in their places, with material axes; then what only they show.
//! 5. `validate::overlap`, `integrator_choice` and `validate::estimate`: what only the whole scene shows, explicit or implicit
//!    steps where that is left open, and what the run will cost.

pub mod accuracy_document;
pub mod budget;
pub mod build;
mod choice;
pub mod cost;
mod deformation;
pub mod document;
pub mod element_values;
pub mod elements;
pub mod exposed_faces;
mod file_problem;
pub mod first_scene;
pub mod frames;
pub mod integrator_choice;
pub mod integrator_document;
pub mod json;
pub mod load;
pub mod loads_document;
pub mod material_fit;
pub mod material_question;
pub mod materials;
pub mod measures_document;
pub mod mesh_document;
mod misfit;
mod motion;
pub mod named_materials;
pub mod part_document;
pub mod problem;
pub mod prony_document;
mod read;
pub mod recipe;
pub mod refinement;
pub mod refinement_document;
mod refusal;
pub mod rigid_document;
pub mod rigid_surface;
pub mod schema;
pub mod segmentation_document;
pub mod solver_document;
pub mod source;
mod structure;
pub mod summary;
#[cfg(test)]
mod tests;
pub mod validate;
pub mod validity_document;

pub use budget::Budget;
pub use integrator_choice::{IntegratorChoice, SteppingEstimate};
pub use load::{Loaded, load, load_document, load_file, load_parsed, on_meshes_of, with_motion};
pub use problem::{Problem, Problems, Severity};
pub use schema::scene_schema;
pub use source::{FolderSource, KeptFiles, MeshBytes, MeshSource, MeshSourceError, NoFiles};

use crate::mechanics::rigid::{Pose, Shape};
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::refine::refined;
use crate::mesh::{Mesh, MeshError};
use document::{Keep, SceneDocument};
use std::collections::BTreeMap;

/// A validated scene: the document, and the mesh of each body in place (metres, placement applied).
#[derive(Clone, Debug)]
pub struct Scene {
    /// The document, with the integrator that was chosen.
    pub document: SceneDocument,
    /// How the integrator was chosen, where the document leaves it open.
    pub choice: Option<IntegratorChoice>,
    /// One entry for each body of the document.
    pub bodies: Vec<SceneBody>,
    /// Warnings of the validation.
    pub warnings: Vec<String>,
    /// SHA-256 of the document and of every mesh, hexadecimal: identifies the problem.
    pub content_hash: String,
    /// SHA-256 of each mesh file, by its name in the document.
    pub mesh_files: BTreeMap<String, [u8; 32]>,
    /// Its scans and surfaces: a scene of the same bodies in other sizes reads them again.
    pub kept_files: KeptFiles,
}

impl Scene {
    /// Keeps features that the plan would omit, in addition to those that the document keeps. The problem and its content
    /// hash are unchanged.
    pub fn restore(&mut self, things: &[Keep]) {
        let keep = &mut self.document.solver.keep;
        for thing in things {
            if !keep.contains(thing) {
                keep.push(*thing);
            }
        }
    }

    /// Number of elements of all bodies.
    pub fn element_count(&self) -> usize {
        self.bodies.iter().map(|body| body.mesh.cells.len()).sum()
    }

    /// Splits every element of every mesh into eight. New nodes lie on the facets of the given meshes, even where a
    /// generator knows the true surface; document and content hash stay those of the coarser meshes.
    ///
    /// # Errors
    /// `Unrefinable` when a mesh has cells that cannot be split; some bodies may then be split already.
    pub fn split_on_facets(&mut self) -> Result<(), MeshError> {
        fn eightfold<T: Clone>(of_elements: &[T]) -> Vec<T> {
            of_elements.iter().flat_map(|of_element| std::iter::repeat_n(of_element.clone(), 8)).collect()
        }
        for body in self.bodies.iter_mut().filter(|body| body.rigid.is_none()) {
            body.mesh = refined(&body.mesh)?;
            body.part_entry = eightfold(&body.part_entry);
            body.axes = eightfold(&body.axes);
            body.law_of = eightfold(&body.law_of);
        }
        Ok(())
    }
}

/// Properties of a rigid body derived from its document.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidSceneBody {
    /// Geometry, in principal axes.
    pub shape: Shape,
    /// Mass of the body [kg].
    pub mass: f64,
    /// Principal moments of inertia [kg m²].
    pub inertia: Vec3,
    /// Initial position and orientation.
    pub pose: Pose,
}

/// A body of a validated scene.
#[derive(Clone, Debug, Default)]
pub struct SceneBody {
    /// Its properties, if it is rigid.
    pub rigid: Option<RigidSceneBody>,
    /// Mesh in place; empty for a rigid body.
    pub mesh: Mesh,
    /// Number of elements before local refinement, and how many of them were split.
    pub refined: Option<[usize; 2]>,
    /// Law of each entry of the body's `parts`, then the laws of elements whose stiffness differs from that.
    pub materials: Vec<crate::mechanics::material::Material>,
    /// For every element, the index of its law in `materials`.
    pub law_of: Vec<u32>,
    /// For every element, the index of its entry in the body's `parts`.
    pub part_entry: Vec<u32>,
    /// Material axes of every element (columns e1, e2, e3 in reference axes, oblique where arrays give two families); empty when no law of
    /// the body has fibres.
    pub axes: Vec<Mat3>,
}
