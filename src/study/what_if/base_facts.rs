//! Data of the base that changes need but its document does not contain.

use super::misfit::Misfit;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::mesh::surface::boundary;
use crate::mesh::triangulated_surface::TriangulatedSurface;
use crate::scene::build::Builder;
use crate::scene::document::SceneDocument;
use crate::scene::exposed_faces::exposed_faces;
use crate::scene::refinement::centre_of_volume;
use crate::scene::validate::Findings;
use crate::scene::{Budget, Loaded, MeshSource, Scene};
use serde_json::json;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// The loaded base, and the source of its meshes.
pub struct BaseFacts<'a> {
    /// Mass of each body [kg].
    pub masses_kg: Vec<f64>,
    base: &'a Scene,
    source: &'a (dyn MeshSource + Sync),
    budget: &'a Budget,
    /// Boundary surface of each body of the base, computed on first use.
    surfaces: Vec<OnceLock<Arc<TriangulatedSurface>>>,
}

impl<'a> BaseFacts<'a> {
    /// Data of a loaded base.
    pub fn of(base: &'a Loaded, source: &'a (dyn MeshSource + Sync), budget: &'a Budget) -> Self {
        Self {
            masses_kg: base.bodies.iter().map(|body| body.mass_kg).collect(),
            base: &base.scene,
            source,
            budget,
            surfaces: base.bodies.iter().map(|_| OnceLock::new()).collect(),
        }
    }

    /// Boundary surface of a body of a modified scene in its initial position.
    pub(super) fn boundary(
        &self,
        scene: &SceneDocument,
        body: usize,
    ) -> Result<Arc<TriangulatedSurface>, Misfit> {
        let of = |mesh: &Mesh| {
            let faces = exposed_faces(scene, body, mesh, &mesh.hanging.boundary(boundary(&mesh.cells)));
            let positions = mesh.nodes.iter().map(|X| scene.bodies[body].start_position(X)).collect();
            Arc::new(TriangulatedSurface::new(&faces, positions))
        };
        let base = &self.base.document;
        let (now, then) = (&scene.bodies[body], &base.bodies[body]);
        let is_as_it_was = self.has_its_mesh(scene, body)
            && (&now.initial_deformation, &now.fixed) == (&then.initial_deformation, &then.fixed)
            && scene.measures.skin_set == base.measures.skin_set;
        if is_as_it_was {
            let mesh = &self.base.bodies[body].mesh;
            return Ok(self.surfaces[body].get_or_init(|| of(mesh)).clone());
        }
        Ok(of(self.mesh(scene, body)?.as_ref()))
    }

    /// Centre of a body of a modified scene [m]: centre of mass if it is rigid, otherwise centroid of its mesh.
    pub(super) fn center(&self, scene: &SceneDocument, body: usize) -> Result<Vec3, Misfit> {
        let written = &scene.bodies[body];
        if let Some(rigid) = &written.rigid {
            return Ok(rigid.center_m.into());
        }
        let mesh = self.mesh(scene, body)?;
        Ok(centre_of_volume(written, &mesh))
    }

    /// Whether a body of a modified scene has the same mesh in the same place as in the base.
    fn has_its_mesh(&self, scene: &SceneDocument, body: usize) -> bool {
        let [now, then] = [scene, &self.base.document].map(|scene| &scene.bodies[body]);
        (&now.mesh, &now.placement) == (&then.mesh, &then.placement)
    }

    /// Placed mesh of a body of a modified scene: that of the base, unless the change requires another.
    fn mesh(&self, scene: &SceneDocument, body: usize) -> Result<Cow<'_, Mesh>, Misfit> {
        if self.has_its_mesh(scene, body) {
            return Ok(Cow::Borrowed(&self.base.bodies[body].mesh));
        }
        let (written, mut found) = (&scene.bodies[body], Findings::default());
        let made = Builder::new(scene, self.source, self.budget).body_mesh(body, written, &mut found);
        made.map(Cow::Owned).ok_or_else(|| Misfit {
            field: "target",
            value: json!(written.name),
            message: found.0.iter().next().map_or_else(
                || format!("{} cannot be placed with these numbers", written.name),
                |problem| format!("the mesh of {} cannot be made: {}", written.name, problem.message),
            ),
            limit: "a change that leaves a mesh of sound elements".into(),
            remedy: "vary the other parameters less, or one question at a time".into(),
        })
    }
}
