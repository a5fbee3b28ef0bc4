//! A file that a client uploads: a draft, and room for it on the disk and in the quota of its owner.

use super::JobsError;
use super::queue::Queue;
use super::room::{Limits, Promise};
use crate::blobs::{Blob, BlobDigest, BlobError, Draft};
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::service::shelves::mesh_name;
use std::sync::Arc;

/// Bytes of an upload without a declared length after which it is looked up again what its owner keeps.
const LOOK_INTERVAL: u64 = 4 << 20;

/// An upload while it is received, and until it is kept.
pub struct Upload {
    draft: Draft,
    promise: Promise,
    owner: String,
    bytes: u64,
    /// What the owner keeps, and the length of the upload from which that is looked up again [bytes].
    kept: u64,
    next_look: u64,
}

impl Upload {
    /// Begins an upload of at most `most` bytes. There is room for its declared length; without one, room is made as it arrives.
    ///
    /// # Errors
    /// `NoRoom`, `DiskShort`, `OwnerKeeps`, `OwnerUploads`, or if the store or the files fail.
    pub async fn begin(
        queue: &Arc<Queue>,
        owner: &str,
        declared: Option<u64>,
        most: u64,
    ) -> Result<Self, JobsError> {
        let kept = queue.kept_bytes(owner).await?;
        let mut promise = Promise::none(&queue.room, owner);
        let owner = owner.to_owned();
        let begin = move |queue: &Queue| {
            queue.check_space()?;
            promise.extend(declared.unwrap_or(0), limits(queue, kept)?)?;
            let draft = Draft::new(queue.blobs.unnamed()?, most);
            Ok(Self { draft, promise, owner, bytes: 0, kept, next_look: LOOK_INTERVAL })
        };
        queue.with_files(begin).await
    }

    /// Appends bytes. This is moved to where files are waited for, so that a client that leaves takes its room with it.
    ///
    /// # Errors
    /// `TooLarge`; those of [`Self::begin`] where no length was declared; or if the files fail.
    pub async fn append(
        mut self,
        queue: &Arc<Queue>,
        piece: impl AsRef<[u8]> + Send + 'static,
    ) -> Result<Self, JobsError> {
        let next = piece.as_ref().len() as u64;
        let lacking = self.promise.lacks(next);
        if lacking > 0 && self.bytes >= self.next_look {
            self.kept = queue.kept_bytes(&self.owner).await?;
            self.next_look = self.bytes + LOOK_INTERVAL;
        }
        let append = move |queue: &Queue| {
            if lacking > 0 {
                self.promise.extend(lacking, limits(queue, self.kept)?)?;
            }
            self.draft.append(piece.as_ref())?;
            self.promise.arrived(next);
            self.bytes += next;
            Ok(self)
        };
        queue.with_files(append).await
    }

    /// Size and digest of what has arrived.
    pub fn digest(&self) -> BlobDigest {
        self.draft.digest()
    }

    /// Opens what has arrived.
    ///
    /// # Errors
    /// When the store fails.
    pub fn open(&self) -> Result<Box<dyn Blob>, BlobError> {
        self.draft.open()
    }

    /// Keeps it as a mesh of its owner: its id, and whether it is new to that owner.
    ///
    /// # Errors
    /// `OwnerKeeps`, or if the store or the files fail.
    pub async fn keep_mesh(
        self,
        queue: &Arc<Queue>,
        format: MeshFormat,
        report: &MeshReport,
    ) -> Result<(String, bool), JobsError> {
        // The room is counted until the owner is known to keep the mesh.
        let Self { draft, promise: _room, owner, .. } = self;
        let id = draft.digest().sha256;
        let no_removal = queue.lock_mesh(&id, false).await?;
        let name = mesh_name(&id, format);
        let kept = queue.with_files(move |queue| {
            queue.folder.check_locks()?;
            Ok(draft.keep(&name)?)
        });
        let BlobDigest { bytes, .. } = queue.unless_silent(kept).await??;
        let added = queue.store.add_mesh(&owner, &id, format, bytes, report, queue.config.quotas()).await;
        drop(no_removal);
        if added.is_err() {
            queue.remove_mesh(id.clone(), format).await;
        }
        Ok((id, added?))
    }
}

/// Limits of the room for an owner who keeps so much.
fn limits(queue: &Queue, kept: u64) -> Result<Limits, JobsError> {
    let config = &queue.config;
    let (free, most_kept) = (queue.folder.free_space()?, config.quotas().bytes_of_owner);
    Ok(Limits { free, least_free: config.least_free, kept, most_kept })
}
