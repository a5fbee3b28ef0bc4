//! The meshes available to one owner's scenes.

use super::StoredMesh;
use crate::blobs::{Blob, BlobStore};
use crate::service::jobs::JobsError;
use crate::service::jobs::store::JobStore;
use crate::service::shelves::mesh_name;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::runtime::Handle;

/// Meshes of one owner. A scene names them only by id: the name is never used as a path.
#[derive(Clone, Debug)]
pub struct MeshShelf {
    blobs: Arc<dyn BlobStore>,
    store: Arc<dyn JobStore>,
    owner: String,
    runtime: Handle,
    /// Ids of those that were found.
    found: Arc<Mutex<BTreeSet<String>>>,
}

/// Why a name in a scene is not a mesh.
#[derive(Debug, thiserror::Error)]
pub enum ShelfError {
    /// The name is not the id of a mesh that this owner uploaded.
    #[error("no uploaded mesh has this id")]
    Unknown,
    /// The store or the file failed.
    #[error(transparent)]
    Jobs(#[from] JobsError),
}

impl MeshShelf {
    /// The meshes uploaded by `owner`.
    pub fn new(blobs: Arc<dyn BlobStore>, store: Arc<dyn JobStore>, owner: String, runtime: Handle) -> Self {
        Self { blobs, store, owner, runtime, found: Arc::default() }
    }

    /// An uploaded mesh. Blocks on the store: not for threads of the runtime.
    ///
    /// # Errors
    /// `Unknown` if the owner has no such mesh.
    pub fn find(&self, id: &str) -> Result<StoredMesh, ShelfError> {
        if !is_id(id) {
            return Err(ShelfError::Unknown);
        }
        let mesh = self.runtime.block_on(self.store.mesh(&self.owner, id))?.ok_or(ShelfError::Unknown)?;
        self.found.lock().unwrap_or_else(PoisonError::into_inner).insert(mesh.id.clone());
        Ok(mesh)
    }

    /// Ids of the meshes that were found so far.
    pub fn found(&self) -> BTreeSet<String> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The contents of an uploaded mesh; `None` if they were removed.
    ///
    /// # Errors
    /// If they cannot be opened.
    pub fn content(&self, mesh: &StoredMesh) -> Result<Option<Box<dyn Blob>>, JobsError> {
        Ok(self.blobs.open(&mesh_name(&mesh.id, mesh.format))?)
    }
}

/// Whether a name has the form of an id: 64 lower-case hexadecimal digits.
pub fn is_id(name: &str) -> bool {
    name.len() == 64 && name.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_digests_are_ids() {
        assert!(is_id(&"0a".repeat(32)));
        for name in [
            "",
            "../../etc/passwd",
            "/etc/passwd",
            &"0A".repeat(32),
            &"0a".repeat(33),
            &format!("{}\0", "a".repeat(63)),
        ] {
            assert!(!is_id(name), "{name:?}");
        }
    }
}
