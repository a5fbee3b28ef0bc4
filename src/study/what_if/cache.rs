//! What runs have said before, by content: the same engine, instruction set, scene and meshes give the same bits.

use super::super::error::Quantity;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::SystemTime;
use std::{fs, io};

/// Entries that a folder may have; beyond, the oldest go when it is opened. An entry is about a kilobyte.
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

/// Remembers numbers, in memory and, if it has one, in a folder.
#[derive(Debug, Default)]
pub struct Cache {
    memory: Mutex<BTreeMap<String, Numbers>>,
    folder: Option<PathBuf>,
}

impl Cache {
    /// In a folder, which is made if need be.
    ///
    /// # Errors
    /// When the folder cannot be made or read.
    pub fn in_folder(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        forget_the_oldest(folder)?;
        Ok(Self { folder: Some(folder.to_owned()), ..Self::default() })
    }

    /// What is known under a key. An entry that cannot be read is none.
    pub(super) fn get(&self, key: &str) -> Option<Numbers> {
        if let Some(numbers) = self.lock().get(key) {
            return Some(numbers.clone());
        }
        let bytes = fs::read(self.folder.as_ref()?.join(format!("{key}.json"))).ok()?;
        let numbers: Numbers = serde_json::from_slice(&bytes).ok()?;
        self.lock().insert(key.to_owned(), numbers.clone());
        Some(numbers)
    }

    /// Remembers. What cannot be written (a full disk) is computed again another time.
    pub(super) fn put(&self, key: &str, numbers: &Numbers) {
        self.lock().insert(key.to_owned(), numbers.clone());
        if let Some(folder) = &self.folder
            && let Err(error) = write_entry(folder, key, numbers)
        {
            tracing::warn!(%error, "a result cannot be kept");
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, Numbers>> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Under another name first, so that nobody reads half of it.
fn write_entry(folder: &Path, key: &str, numbers: &Numbers) -> io::Result<()> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    let partial = folder.join(format!("{key}.{}-{count}.partial", std::process::id()));
    fs::write(&partial, serde_json::to_vec(numbers)?)?;
    fs::rename(&partial, folder.join(format!("{key}.json")))
}

fn forget_the_oldest(folder: &Path) -> io::Result<()> {
    let mut entries: Vec<(SystemTime, PathBuf)> = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        entries.push((entry.metadata()?.modified()?, entry.path()));
    }
    entries.sort();
    let surplus = entries.len().saturating_sub(MOST_ENTRIES);
    entries[..surplus].iter().try_for_each(|(_, path)| fs::remove_file(path))
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
    hash.finalize().iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// The program and the instruction set. Where the build does not know its commit, the size and the time of its file stand for it:
/// two builds of one version may differ.
fn engine() -> &'static str {
    static ENGINE: OnceLock<String> = OnceLock::new();
    ENGINE.get_or_init(|| {
        let build = option_env!("CONTUSE_COMMIT").map(str::to_owned);
        let build = build.unwrap_or_else(|| {
            let file = std::env::current_exe().and_then(fs::metadata);
            file.map(|file| format!("{} {:?}", file.len(), file.modified().ok())).unwrap_or_default()
        });
        format!("{} {build} {:?}", env!("CARGO_PKG_VERSION"), pulp::Arch::new())
    })
}
