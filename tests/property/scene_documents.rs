//! Whatever is written in a scene document, loading it ends with a scene or with problems: it never panics, and it never
//! fails without a reason.

use crate::changes::{changed, changes};
use contuse::scene::{Budget, FolderSource, Problems, load};
use proptest::prelude::*;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Small enough that a mutated count cannot make a test slow.
const BUDGET: Budget = Budget { elements: 3_000, steps: 100_000, ..Budget::SERVICE };

/// The scenarios that ship: their folders and documents.
static SCENES: LazyLock<Vec<(PathBuf, Value)>> = LazyLock::new(|| {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let folders = std::fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<PathBuf> = folders.filter(|path| path.join("scene.json").is_file()).collect();
    folders.sort();
    let document = |folder: &PathBuf| std::fs::read(folder.join("scene.json")).unwrap();
    folders.into_iter().map(|f| (f.clone(), serde_json::from_slice(&document(&f)).unwrap())).collect()
});

/// A failure has at least one error, and every problem says what to do.
fn check(folder: &Path, bytes: &[u8]) -> Result<(), TestCaseError> {
    match load(bytes, &FolderSource::new(folder), &BUDGET) {
        Ok(loaded) => {
            prop_assert!(loaded.warnings.iter().all(|p| !p.is_error()));
            for body in &loaded.scene.bodies {
                prop_assert_eq!(body.part_entry.len(), body.mesh.cells.len());
                prop_assert!(body.axes.is_empty() || body.axes.len() == body.mesh.cells.len());
                prop_assert!(body.mesh.nodes.iter().all(|x| x.iter().all(|c| c.is_finite())));
            }
        }
        Err(problems) => {
            prop_assert!(problems.error_count() > 0, "{problems:?}");
            for problem in &problems.0 {
                prop_assert!(!problem.message.is_empty() && !problem.remedy.is_empty(), "{problem:?}");
                prop_assert!(problem.code != "internal" && problem.code != "schema_broken", "{problem:?}");
            }
            let text = serde_json::to_string(&problems).unwrap();
            prop_assert_eq!(serde_json::from_str::<Problems>(&text).unwrap().0.len(), problems.0.len());
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_changed_scene_loads_or_is_refused_with_reasons(
        scene in any::<prop::sample::Index>(),
        changes in changes(),
    ) {
        let (folder, document) = scene.get(&SCENES);
        check(folder, changed(document, changes).to_string().as_bytes())?;
    }

    #[test]
    fn changed_bytes_load_or_are_refused_with_reasons(
        scene in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        length in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let (folder, document) = scene.get(&SCENES);
        let mut bytes = document.to_string().into_bytes();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if cut {
            bytes.truncate(length.index(bytes.len()));
        }
        check(folder, &bytes)?;
    }
}
