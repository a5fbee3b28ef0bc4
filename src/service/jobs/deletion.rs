//! Deletion of jobs and meshes: recorded at once, while their files go as soon as the store of blobs lets them.

use super::control::StopReason;
use super::queue::Queue;
use super::store::{DeleteAnswer, MeshDeletion};
use super::{JobId, JobsError};
use crate::mesh::read::MeshFormat;
use crate::service::shelves::{mesh_name, result_name};
use std::sync::Arc;
use std::time::Duration;

/// How long the removal of files is waited for.
pub const REMOVAL_PATIENCE: Duration = Duration::from_secs(2);
/// Number of expired jobs that are read from the store at a time.
const PURGED_AT_ONCE: u32 = 100;

/// Numbers of what was purged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Purged {
    /// Jobs with all that they had left.
    pub jobs: u64,
    /// Meshes, counted for each owner.
    pub meshes: u64,
}

impl Queue {
    /// Deletes a job, which is inaccessible from now on. What it has left is removed by then, or in the background: of a running job
    /// when its worker has released it, of others when the store of blobs answers. False if there is no such job.
    ///
    /// # Errors
    /// If the store fails.
    pub async fn delete(self: &Arc<Self>, owner: &str, id: JobId) -> Result<bool, JobsError> {
        let hidden = match self.store.hide(owner, id).await {
            // On a full disk the files are removed first, which makes space for the record of the deletion.
            Err(error) if error.is_storage_full() => {
                let job = self.store.job(owner, id).await?;
                let Some(job) = job.filter(|job| job.state.is_final()) else { return Err(error) };
                self.with_files(move |queue| queue.remove_files(id, job.attempts)).await?;
                self.store.hide(owner, id).await?
            }
            other => other?,
        };
        match hidden {
            DeleteAnswer::Unknown => return Ok(false),
            DeleteAnswer::Running { seq } => {
                self.stop(id, StopReason::Cancel);
                self.ring(Some(seq));
            }
            DeleteAnswer::Idle { seq, attempts } => {
                self.erase(seq, id, attempts).await;
                self.ring(Some(seq));
            }
        }
        Ok(true)
    }

    /// Erases a hidden job with all that it has left. Waits for that a moment; the rest is done in the background.
    pub(super) async fn erase(self: &Arc<Self>, seq: i64, id: JobId, attempts: u32) {
        self.start_to_erase(seq, id, attempts);
        self.removals.wait(&id.to_string(), REMOVAL_PATIENCE).await;
    }

    /// Erases a hidden job with all that it has left in the background, or by the next process. Within a runtime.
    pub(super) fn start_to_erase(self: &Arc<Self>, seq: i64, id: JobId, attempts: u32) {
        let queue = Arc::downgrade(self);
        self.removals.start(id.to_string(), self.closing(), move || {
            let queue = queue.upgrade();
            async move {
                let Some(queue) = queue else { return Ok(()) };
                let results = queue.store.own_results(seq).await?;
                queue
                    .with_files(move |queue| {
                        queue.remove_files(id, attempts)?;
                        Ok(results.iter().try_for_each(|key| queue.blobs.delete(&result_name(key)))?)
                    })
                    .await?;
                queue.store.erase(seq).await
            }
        });
    }

    /// Deletes a mesh of an owner, unless a job of that owner waits for it or runs on it. Its file goes with its last owner, by then or
    /// in the background.
    ///
    /// # Errors
    /// If the store fails.
    pub async fn delete_mesh(self: &Arc<Self>, owner: &str, id: &str) -> Result<MeshDeletion, JobsError> {
        let deletion = self.store.delete_mesh(owner, id).await?;
        if let MeshDeletion::Deleted { unowned: Some(format) } = deletion {
            self.remove_mesh(id.to_owned(), format).await;
        }
        Ok(deletion)
    }

    /// Removes the file of a mesh, unless someone has uploaded it again.
    async fn remove_mesh(self: &Arc<Self>, id: String, format: MeshFormat) {
        let (queue, name) = (Arc::downgrade(self), mesh_name(&id, format));
        let removed = name.clone();
        self.removals.start(name.clone(), self.closing(), move || {
            let (queue, id, name) = (queue.upgrade(), id.clone(), removed.clone());
            async move {
                let Some(queue) = queue else { return Ok(()) };
                let _no_upload = queue.mesh_files.write().await;
                if queue.store.has_owner(&id, format).await? {
                    return Ok(());
                }
                queue.with_files(move |queue| Ok(queue.blobs.delete(&name)?)).await
            }
        });
        self.removals.wait(&name, REMOVAL_PATIENCE).await;
    }

    /// Deletes the jobs that ended, and the meshes that were uploaded, more than some days ago; gives their numbers. A mesh that a
    /// job waits for or runs on stays.
    ///
    /// # Errors
    /// If the store or the files fail.
    pub async fn purge(self: &Arc<Self>, older_than_days: u32) -> Result<Purged, JobsError> {
        let mut purged = Purged::default();
        loop {
            let jobs = self.store.expired_jobs(older_than_days, PURGED_AT_ONCE).await?;
            if jobs.is_empty() {
                break;
            }
            for (owner, id) in jobs {
                purged.jobs += u64::from(self.delete(&owner, id).await?);
            }
        }
        for (owner, id) in self.store.expired_meshes(older_than_days).await? {
            let deletion = self.delete_mesh(&owner, &id).await?;
            purged.meshes += u64::from(matches!(deletion, MeshDeletion::Deleted { .. }));
        }
        Ok(purged)
    }
}
