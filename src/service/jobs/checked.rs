//! Recently validated scenes, kept loaded: a job that begins soon after its submission need not load its scene again,
//! nor that of its study or question.

use crate::scene::Loaded;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A few scenes, each until its job takes it or newer ones replace it.
#[derive(Debug)]
pub(super) struct Checked {
    most: usize,
    scenes: Mutex<VecDeque<(String, Loaded)>>,
}

impl Checked {
    /// At most this many: each may hold a mesh in memory.
    pub fn new(most: usize) -> Self {
        Self { most, scenes: Mutex::default() }
    }

    /// Keeps the scene of a question.
    pub fn keep(&self, content_hash: &str, loaded: Loaded) {
        let mut scenes = self.scenes();
        scenes.push_back((content_hash.to_owned(), loaded));
        while scenes.len() > self.most {
            scenes.pop_front();
        }
    }

    /// The scene for a digest, which covers both document and meshes.
    pub fn take(&self, content_hash: &str) -> Option<Loaded> {
        let mut scenes = self.scenes();
        let index = scenes.iter().position(|(known, _)| known == content_hash)?;
        scenes.remove(index).map(|(_, loaded)| loaded)
    }

    fn scenes(&self) -> MutexGuard<'_, VecDeque<(String, Loaded)>> {
        self.scenes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Budget, NoFiles, load};

    fn named(name: &str) -> Loaded {
        let scene = include_str!("../../../api/examples/job.request.json");
        let scene = scene.replacen("\"name\": \"", &format!("\"name\": \"{name} "), 1);
        load(scene.as_bytes(), &NoFiles, &Budget::SERVICE).unwrap()
    }

    #[test]
    fn the_last_scenes_are_kept_and_each_is_taken_once() {
        let checked = Checked::new(2);
        let scenes = ["a", "b", "c"].map(named);
        let hashes = scenes.clone().map(|loaded| loaded.scene.content_hash);
        for loaded in scenes {
            checked.keep(&loaded.scene.content_hash.clone(), loaded);
        }
        assert!(checked.take(&hashes[0]).is_none());
        assert_eq!(checked.take(&hashes[1]).unwrap().scene.content_hash, hashes[1]);
        assert!(checked.take(&hashes[1]).is_none());
        assert!(checked.take(&hashes[2]).is_some());
    }
}
