//! Cache of results by content: the same engine, instruction set, scene and meshes give the same bits.

use crate::blobs::{BlobError, BlobStore, Draft, FolderBlobs, hexadecimal};
use crate::measure::QuantityOfInterest;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::io::{self, BufReader};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Maximum number of entries on a shelf; the oldest are removed by [`trim_shelf`]. An entry takes about a kilobyte.
const MOST_ENTRIES: usize = 100_000;

/// Results of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Numbers {
    /// Ending, as in [`CaseAnswer`](super::CaseAnswer).
    pub ending: String,
    /// Why there are no numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Number of steps of the run.
    pub steps: u64,
    /// Quantities of interest; empty if the run did not finish, or nothing touched.
    pub values: BTreeMap<QuantityOfInterest, f64>,
    /// Their errors, if estimated for this very run.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub errors: BTreeMap<QuantityOfInterest, f64>,
    /// Quantities that are not resolved.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub unresolved: BTreeSet<QuantityOfInterest>,
    /// Ends of the tissue that truncate the depth of the significant stress.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reaches: Vec<String>,
    /// Quantities that are lower bounds.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub lower_bounds: BTreeSet<QuantityOfInterest>,
    /// Largest von Mises stress below each requested depth [Pa].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub von_mises_below_pa: Vec<f64>,
    /// Their errors [Pa], if estimated for this very run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub von_mises_below_error_pa: Vec<Option<f64>>,
}

/// Stores results in memory and, if it has one, on a shelf of blobs. Copies share them.
#[derive(Clone, Default)]
pub struct Cache {
    kept: Arc<Kept>,
    note: Option<Note>,
}

/// Receives the key of every result that is used, before it is read or stored.
pub type Note = Arc<dyn Fn(&str) + Send + Sync>;

#[derive(Debug, Default)]
struct Kept {
    memory: Mutex<BTreeMap<String, Numbers>>,
    shelf: Option<Shelf>,
}

impl fmt::Debug for Cache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.kept.fmt(f)
    }
}

/// Persistent storage of results.
#[derive(Debug)]
struct Shelf {
    blobs: Arc<dyn BlobStore>,
    name: String,
}

impl Cache {
    /// A cache on a shelf.
    pub fn on_shelf(blobs: Arc<dyn BlobStore>, name: &str) -> Self {
        let shelf = Some(Shelf { blobs, name: name.to_owned() });
        Self { kept: Arc::new(Kept { shelf, ..Kept::default() }), note: None }
    }

    /// A cache in a folder, which is created if necessary.
    ///
    /// # Errors
    /// If the folder cannot be created or read.
    pub fn in_folder(folder: &Path) -> Result<Self, BlobError> {
        let blobs = FolderBlobs::open(folder)?;
        trim_shelf(&blobs, "")?;
        Ok(Self::on_shelf(Arc::new(blobs), ""))
    }

    /// A view of the same results; `note` receives the keys of those that are used through it.
    #[must_use]
    pub fn noting(&self, note: Note) -> Self {
        Self { kept: Arc::clone(&self.kept), note: Some(note) }
    }

    /// Result stored under a key. An unreadable entry counts as missing.
    pub(super) fn get(&self, key: &str) -> Option<Numbers> {
        if let Some(note) = &self.note {
            note(key);
        }
        if let Some(numbers) = self.lock().get(key) {
            return Some(numbers.clone());
        }
        let numbers = self.kept.shelf.as_ref()?.read(key)?;
        self.lock().insert(key.to_owned(), numbers.clone());
        Some(numbers)
    }

    /// Stores a result. If it cannot be written (a full disk), it will be computed again.
    pub(super) fn put(&self, key: &str, numbers: &Numbers) {
        self.lock().insert(key.to_owned(), numbers.clone());
        if let Some(shelf) = &self.kept.shelf
            && let Err(error) = shelf.write(key, numbers)
        {
            tracing::warn!(%error, "a result cannot be kept");
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, Numbers>> {
        self.kept.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Removes the oldest results from a shelf with very many.
///
/// # Errors
/// If the shelf cannot be listed or cleared.
pub fn trim_shelf(blobs: &dyn BlobStore, name: &str) -> Result<(), BlobError> {
    let mut entries = blobs.list(name)?;
    entries.sort_by_key(|entry| entry.kept);
    let surplus = entries.len().saturating_sub(MOST_ENTRIES);
    entries[..surplus].iter().try_for_each(|entry| blobs.delete(&entry.name))
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

/// Short name of the program and its instruction set: results of the same name have the same bits.
pub fn name_of_build() -> String {
    hexadecimal(&Sha256::digest(engine())[..8])
}

/// Key of a run: engine, instruction set, scene, meshes, and requests beyond its summary.
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

/// The program and the instruction set. If the build has no commit, size and time of its file identify it: two builds
/// of one version may differ.
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
