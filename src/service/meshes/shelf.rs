//! The meshes that one owner's scenes may name.

use super::MeshFormat;
use crate::service::jobs::JobsError;
use crate::service::jobs::store::Store;
use std::path::{Path, PathBuf};
use tokio::runtime::Handle;

/// The meshes of one owner. A scene names them by id and by nothing else: the name is never used as a path.
#[derive(Clone, Debug)]
pub struct MeshShelf {
    folder: PathBuf,
    store: Store,
    owner: String,
    runtime: Handle,
}

/// Why a name on a scene is no mesh.
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
    /// The meshes of `owner` in `folder`.
    pub fn new(folder: PathBuf, store: Store, owner: String, runtime: Handle) -> Self {
        Self { folder, store, owner, runtime }
    }

    /// The file of an uploaded mesh. Blocks on the store: not for threads of the runtime.
    ///
    /// # Errors
    /// `Unknown` when the owner has no such mesh.
    pub fn find(&self, id: &str) -> Result<(PathBuf, MeshFormat), ShelfError> {
        if !is_id(id) {
            return Err(ShelfError::Unknown);
        }
        let mesh = self.runtime.block_on(self.store.mesh(&self.owner, id))?.ok_or(ShelfError::Unknown)?;
        Ok((file(&self.folder, &mesh.id, mesh.format), mesh.format))
    }
}

/// Whether a name has the form of an id: 64 lower-case hexadecimal digits.
pub fn is_id(name: &str) -> bool {
    name.len() == 64 && name.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// The file of a mesh.
pub fn file(folder: &Path, id: &str, format: MeshFormat) -> PathBuf {
    folder.join(format!("{id}.{}", format.extension()))
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
