//! What runs have said before, by content: the same engine, instruction set, scene and meshes give the same bits.

use super::super::error::Quantity;
use crate::blobs::{BlobError, BlobStore, Draft, FolderBlobs, hexadecimal};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufReader};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Entries that a shelf may have; beyond, the oldest go when it is opened. An entry is about a kilobyte.
const MOST_ENTRIES: usize = 100_000;

/// What one run said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Numbers {
    /// As of [`CaseAnswer`](super::CaseAnswer).
    pub ending: String,
    /// Why it has no numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Steps.
    pub steps: u64,
    /// The quantities of interest; empty when it did not finish, or nothing touched.
    pub values: BTreeMap<Quantity, f64>,
    /// Their errors, where they were estimated for this very run.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub errors: BTreeMap<Quantity, f64>,
    /// Those of them that are not resolved.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub unresolved: BTreeSet<Quantity>,
    /// Which ends of the tissue the significant stress reaches: its depth and volume end there because the model does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reaches: Vec<String>,
    /// Largest von Mises stress from each of the asked depths on [Pa].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub von_mises_below_pa: Vec<f64>,
    /// Their errors [Pa], where they were estimated for this very run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub von_mises_below_error_pa: Vec<Option<f64>>,
}

/// Remembers numbers, in memory and, if it has one, on a shelf of blobs.
#[derive(Debug, Default)]
pub struct Cache {
    memory: Mutex<BTreeMap<String, Numbers>>,
    shelf: Option<Shelf>,
}

/// Where numbers outlive the process.
#[derive(Debug)]
struct Shelf {
    blobs: Arc<dyn BlobStore>,
    name: String,
}

impl Cache {
    /// On a shelf, from which the oldest entries go if there are very many.
    ///
    /// # Errors
    /// When the shelf cannot be listed, or cleared.
    pub fn on_shelf(blobs: Arc<dyn BlobStore>, name: &str) -> Result<Self, BlobError> {
        let mut entries = blobs.list(name)?;
        entries.sort_by_key(|entry| entry.kept);
        let surplus = entries.len().saturating_sub(MOST_ENTRIES);
        entries[..surplus].iter().try_for_each(|entry| blobs.delete(&entry.name))?;
        Ok(Self { shelf: Some(Shelf { blobs, name: name.to_owned() }), ..Self::default() })
    }

    /// In a folder, which is made if need be.
    ///
    /// # Errors
    /// When the folder cannot be made or read.
    pub fn in_folder(folder: &Path) -> Result<Self, BlobError> {
        Self::on_shelf(Arc::new(FolderBlobs::open(folder)?), "")
    }

    /// What is known under a key. An entry that cannot be read is none.
    pub(super) fn get(&self, key: &str) -> Option<Numbers> {
        if let Some(numbers) = self.lock().get(key) {
            return Some(numbers.clone());
        }
        let numbers = self.shelf.as_ref()?.read(key)?;
        self.lock().insert(key.to_owned(), numbers.clone());
        Some(numbers)
    }

    /// Remembers. What cannot be written (a full disk) is computed again another time.
    pub(super) fn put(&self, key: &str, numbers: &Numbers) {
        self.lock().insert(key.to_owned(), numbers.clone());
        if let Some(shelf) = &self.shelf
            && let Err(error) = shelf.write(key, numbers)
        {
            tracing::warn!(%error, "a result cannot be kept");
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, Numbers>> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Shelf {
    fn read(&self, key: &str) -> Option<Numbers> {
        let blob = self.blobs.open(&self.name_of(key)).ok()??;
        serde_json::from_reader(BufReader::new(blob)).ok()
    }

    fn write(&self, key: &str, numbers: &Numbers) -> Result<(), BlobError> {
        let mut draft = Draft::new(self.blobs.unnamed()?, u64::MAX);
        draft.append(&serde_json::to_vec(numbers).map_err(io::Error::from)?)?;
        draft.keep(&self.name_of(key)).map(drop)
    }

    fn name_of(&self, key: &str) -> String {
        if self.name.is_empty() { format!("{key}.json") } else { format!("{}/{key}.json", self.name) }
    }
}

/// The name of a run: engine, instruction set, scene, meshes, and what is asked of it beyond its summary.
pub(super) fn key(scene: &Scene, with_errors: bool, depths: &[f64]) -> String {
    let mut hash = Sha256::new();
    hash.update(engine());
    hash.update(&scene.content_hash);
    hash.update([u8::from(with_errors)]);
    for depth in depths {
        hash.update(depth.to_le_bytes());
    }
    hexadecimal(&hash.finalize())
}

/// The program and the instruction set. Where the build does not know its commit, the size and the time of its file stand for it:
/// two builds of one version may differ.
fn engine() -> &'static str {
    static ENGINE: OnceLock<String> = OnceLock::new();
    ENGINE.get_or_init(|| {
        let build = option_env!("CONTUSE_COMMIT").map(str::to_owned);
        let build = build.unwrap_or_else(|| {
            let file = std::env::current_exe().and_then(std::fs::metadata);
            file.map(|file| format!("{} {:?}", file.len(), file.modified().ok())).unwrap_or_default()
        });
        format!("{} {build} {:?}", env!("CARGO_PKG_VERSION"), pulp::Arch::new())
    })
}
