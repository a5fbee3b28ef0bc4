//! What of the base the changes need that its document does not say.

use super::misfit::Misfit;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::mesh::surface::skin;
use crate::mesh::triangulated_skin::TriangulatedSkin;
use crate::scene::build::Builder;
use crate::scene::document::SceneDocument;
use crate::scene::exposed_faces::exposed_faces;
use crate::scene::refinement::centre_of_volume;
use crate::scene::validate::Findings;
use crate::scene::{Budget, Loaded, MeshSource, Scene};
use serde_json::json;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// The base as it was loaded, and where its meshes come from.
pub struct BaseFacts<'a> {
    /// Mass of each body [kg].
    pub masses_kg: Vec<f64>,
    base: &'a Scene,
    source: &'a (dyn MeshSource + Sync),
    budget: &'a Budget,
    /// The skin of each body of the base, once it was asked for.
    skins: Vec<OnceLock<Arc<TriangulatedSkin>>>,
}

impl<'a> BaseFacts<'a> {
    /// Of a loaded base.
    pub fn of(base: &'a Loaded, source: &'a (dyn MeshSource + Sync), budget: &'a Budget) -> Self {
        Self {
            masses_kg: base.bodies.iter().map(|body| body.mass_kg).collect(),
            base: &base.scene,
            source,
            budget,
            skins: base.bodies.iter().map(|_| OnceLock::new()).collect(),
        }
    }

    /// The skin of a body of a changed scene, as it starts.
    pub(super) fn skin(&self, scene: &SceneDocument, body: usize) -> Result<Arc<TriangulatedSkin>, Misfit> {
        let of = |mesh: &Mesh| {
            let faces = exposed_faces(scene, body, mesh, &mesh.hanging.skin(skin(&mesh.cells)));
            let positions = mesh.nodes.iter().map(|X| scene.bodies[body].start_position(X)).collect();
            Arc::new(TriangulatedSkin::new(&faces, positions))
        };
        let base = &self.base.document;
        let (now, then) = (&scene.bodies[body], &base.bodies[body]);
        let is_as_it_was = self.has_its_mesh(scene, body)
            && (&now.initial_deformation, &now.fixed) == (&then.initial_deformation, &then.fixed)
            && scene.measures.skin_set == base.measures.skin_set;
        if is_as_it_was {
            let mesh = &self.base.bodies[body].mesh;
            return Ok(self.skins[body].get_or_init(|| of(mesh)).clone());
        }
        Ok(of(self.mesh(scene, body)?.as_ref()))
    }

    /// The centre of a body of a changed scene [m]: that of its mass if it is rigid, that of the volume of its mesh if not.
    pub(super) fn center(&self, scene: &SceneDocument, body: usize) -> Result<Vec3, Misfit> {
        let written = &scene.bodies[body];
        if let Some(rigid) = &written.rigid {
            return Ok(rigid.center_m.into());
        }
        let mesh = self.mesh(scene, body)?;
        Ok(centre_of_volume(written, &mesh))
    }

    /// Whether a body of a changed scene has the mesh that it has in the base, where that was.
    fn has_its_mesh(&self, scene: &SceneDocument, body: usize) -> bool {
        let [now, then] = [scene, &self.base.document].map(|scene| &scene.bodies[body]);
        (&now.mesh, &now.placement) == (&then.mesh, &then.placement)
    }

    /// The mesh of a body of a changed scene, placed: that of the base, or another where the change makes another.
    fn mesh(&self, scene: &SceneDocument, body: usize) -> Result<Cow<'_, Mesh>, Misfit> {
        if self.has_its_mesh(scene, body) {
            return Ok(Cow::Borrowed(&self.base.bodies[body].mesh));
        }
        let (written, mut found) = (&scene.bodies[body], Findings::default());
        let made = Builder::new(self.source, self.budget).body_mesh(body, written, &mut found);
        made.map(Cow::Owned).ok_or_else(|| Misfit {
            field: "target",
            value: json!(written.name),
            message: found.0.first().map_or_else(
                || format!("{} cannot be placed with these numbers", written.name),
                |problem| format!("the mesh of {} cannot be made: {}", written.name, problem.message),
            ),
            limit: "a change that leaves a mesh of sound elements".into(),
            remedy: "vary the other parameters less, or one question at a time".into(),
        })
    }
}
