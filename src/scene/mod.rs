//! The scene: what the user asks for, in the user's terms.
//!
//! `document` is the input (JSON); a [`Scene`] is a document that passed every check, with its meshes in place. [`load()`]
//! makes one from the other in five stages and collects all problems:
//!
//! 1. `json`: bytes → JSON value; repeated keys.
//! 2. `structure`: against the schema generated from the document's types; what is broken is repaired in a copy, in which
//!    `named_materials` then puts the sets of the library in the place of their names.
//! 3. `validate`: what the document alone shows.
//! 4. `build`: the meshes, in their places, with material axes; then what only they show.
//! 5. `validate::overlap`, `integrator_choice` and `validate::estimate`: what only the whole scene shows, explicit or implicit
//!    steps where that is left open, and what the run will cost.

pub mod accuracy_document;
mod axis;
pub mod budget;
pub mod build;
mod checked_scene;
mod choice;
pub mod cost;
mod deformation;
pub mod document;
pub mod element_values;
pub mod elements;
pub mod exposed_faces;
pub mod febio;
mod file_problem;
pub mod first_impact;
pub mod first_scene;
pub mod first_surfaces;
pub mod frames;
mod generator_problem;
pub mod geometry;
mod implied_accuracy;
pub mod integrator_choice;
pub mod integrator_document;
pub mod json;
pub mod load;
pub mod loads_document;
pub mod material_fit;
pub mod material_question;
pub mod materials;
pub mod measures_document;
pub mod memories;
pub mod mesh_document;
mod misfit;
mod motion;
pub mod named_materials;
pub mod part_document;
pub mod problem;
mod read;
pub mod refinement;
pub mod refinement_document;
mod refusal;
pub mod rigid_document;
pub mod rigid_surface;
mod scene_body;
pub mod schema;
pub mod segmentation_document;
pub mod segmentation_source;
pub mod solver_document;
pub mod source;
mod structure;
pub mod summary;
#[cfg(test)]
mod tests;
pub mod validate;
pub mod validity_document;

pub use budget::Budget;
pub use checked_scene::Scene;
pub use integrator_choice::{IntegratorChoice, SteppingEstimate};
pub use load::{Loaded, load, load_document, load_file, load_parsed, on_meshes_of, with_motion};
pub use problem::{Problem, Problems, Severity};
pub use scene_body::{RigidSceneBody, SceneBody};
pub use schema::scene_schema;
pub use source::{FolderSource, KeptFiles, MeshBytes, MeshSource, MeshSourceError, NoFiles};
