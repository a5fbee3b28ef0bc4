//! A document that passed every check, with its meshes in place.

use super::document::{Keep, SceneDocument};
use super::integrator_choice::IntegratorChoice;
use super::scene_body::SceneBody;
use super::source::KeptFiles;
use crate::mesh::MeshError;
use crate::mesh::refine::refined;
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
