//! Single precision for internal forces, where it is far below the error of any mesh.

use crate::mechanics::force::BlockParameters;
use crate::scene::Scene;
use crate::scene::document::{Formulation, IntegratorDocument};

/// The scene with single precision in the parts whose formulation it leaves open: in explicit steps without a preload, in bodies all of whose
/// laws have a moderate ratio of bulk to shear modulus.
pub(super) fn in_single_precision(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let is_explicit = matches!(scene.document.integrator, IntegratorDocument::Explicit { .. });
    if !is_explicit || scene.document.preload.is_some() {
        return scene;
    }
    for (document, body) in scene.document.bodies.iter_mut().zip(&scene.bodies) {
        let is_moderate = body.materials.iter().all(BlockParameters::is_accurate_in_single);
        let may_be_single = body.mesh.cells.iter().all(|cell| cell.kind.element().has_single_precision());
        let parts = document.parts.iter_mut().filter(|part| part.formulation.is_none());
        for part in parts.filter(|_| is_moderate && may_be_single) {
            part.formulation = Some(Formulation::MeanDilatationSingle);
        }
    }
    scene
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::scene::{Budget, FolderSource, load};

    /// Formulations of the parts of the scene with these changes of its text.
    fn formulations(changes: &[(&str, &str)]) -> Vec<Option<Formulation>> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/flashball_thigh");
        let text = std::fs::read_to_string(format!("{folder}/scene.json")).unwrap();
        let text = changes.iter().fold(text, |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replacen(from, to, 1)
        });
        let scene = load(text.as_bytes(), &FolderSource::new(folder), &Budget::COMMAND_LINE).unwrap().scene;
        let bodies = in_single_precision(&scene).document.bodies;
        bodies.iter().flat_map(|body| &body.parts).map(|part| part.formulation).collect()
    }

    #[test]
    fn parts_of_moderate_moduli_are_in_single_precision() {
        let single = Some(Formulation::MeanDilatationSingle);
        assert_eq!(formulations(&[]), [single; 4]);
        // Fat of 40 kPa with the bulk modulus of water: its body stays in double precision.
        let water = (
            "\"c10_pa\": 20000, \"bulk_modulus_pa\": 50000000",
            "\"c10_pa\": 20000, \"bulk_modulus_pa\": 2200000000",
        );
        assert_eq!(formulations(&[water]), [single, None, None, None]);
    }

    #[test]
    fn what_a_scene_says_of_its_elements_and_steps_stands() {
        let named = ("\"part\": \"fat\"", "\"part\": \"fat\", \"formulation\": \"mean_dilatation\"");
        assert_eq!(formulations(&[named])[2], Some(Formulation::MeanDilatation));
        let implicit =
            ("\"end_time_s\"", "\"integrator\": {\"kind\": \"implicit\", \"step_s\": 1e-6}, \"end_time_s\"");
        assert_eq!(formulations(&[implicit]), [None; 4]);
    }
}
