//! Deletion of jobs and meshes: recorded at once, while their files go as soon as the store of blobs lets them.

use super::control::StopReason;
use super::queue::Queue;
use super::store::{DeleteAnswer, MeshDeletion, MeshLock};
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
    /// Jobs and meshes that are old enough, and stay since they cannot be read.
    pub unreadable: u64,
}

impl Purged {
    /// Counts what cannot be deleted, unless nothing can be.
    fn go_on(&mut self, error: JobsError) -> Result<(), JobsError> {
        if error.is_of_machine() {
            return Err(error);
        }
        tracing::error!(%error, "what is too old cannot be deleted");
        self.unreadable += 1;
        Ok(())
    }
}

impl Queue {
    /// Deletes a job, which is inaccessible from now on. What it has left is removed by then, or in the background: of a running job
    /// when its worker has released it, of others when the store of blobs answers. False if there is no such job.
    ///
    /// # Errors
    /// If the store fails.
    pub async fn delete(self: &Arc<Self>, owner: &str, id: JobId) -> Result<bool, JobsError> {
        self.with_files(|queue| queue.folder.check_locks()).await?;
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
        self.wait_for_removal(&id.to_string()).await;
    }

    /// Waits a moment for a removal, unless the store of blobs does not answer.
    async fn wait_for_removal(&self, name: &str) {
        let _ = self.unless_silent(self.removals.wait(name, REMOVAL_PATIENCE)).await;
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
        self.with_files(|queue| queue.folder.check_locks()).await?;
        let deletion = self.store.delete_mesh(owner, id).await?;
        if let MeshDeletion::Deleted { unowned: Some(format) } = deletion {
            self.remove_mesh(id.to_owned(), format).await;
        }
        Ok(deletion)
    }

    /// Locks a mesh: to remove its file, or, beside others, to keep and register it.
    pub(super) async fn lock_mesh(&self, id: &str, to_remove: bool) -> Result<MeshLock, JobsError> {
        let files = Arc::clone(&self.mesh_files);
        Ok(match self.store.shared() {
            Some(shared) => shared.lock_mesh(id, to_remove).await?,
            None if to_remove => Box::new(files.write_owned().await),
            None => Box::new(files.read_owned().await),
        })
    }

    /// Removes the file of a mesh, unless someone has it.
    pub(super) async fn remove_mesh(self: &Arc<Self>, id: String, format: MeshFormat) {
        let (queue, name) = (Arc::downgrade(self), mesh_name(&id, format));
        let removed = name.clone();
        self.removals.start(name.clone(), self.closing(), move || {
            let (queue, id, name) = (queue.upgrade(), id.clone(), removed.clone());
            async move {
                let Some(queue) = queue else { return Ok(()) };
                let _no_upload = queue.lock_mesh(&id, true).await?;
                if queue.store.has_owner(&id, format).await? {
                    return Ok(());
                }
                queue.with_files(move |queue| Ok(queue.blobs.delete(&name)?)).await
            }
        });
        self.wait_for_removal(&name).await;
    }

    /// Deletes the jobs that ended, and the meshes that were uploaded, more than some days ago; gives their numbers. A mesh that a
    /// job waits for or runs on stays.
    ///
    /// # Errors
    /// If the store or the files fail, or the object store does not answer.
    pub async fn purge(self: &Arc<Self>, older_than_days: u32) -> Result<Purged, JobsError> {
        let mut purged = Purged::default();
        let mut last = Some(i64::MIN);
        while let Some(after) = last {
            let (jobs, next) = self.store.expired_jobs(older_than_days, after, PURGED_AT_ONCE).await?;
            (purged.unreadable, last) = (purged.unreadable + jobs.unreadable, next);
            for (owner, id) in jobs.found {
                // Otherwise removals would pile up.
                self.check_pulse()?;
                match self.delete(&owner, id).await {
                    Ok(is_deleted) => purged.jobs += u64::from(is_deleted),
                    Err(error) => purged.go_on(error)?,
                }
            }
        }
        let meshes = self.store.expired_meshes(older_than_days).await?;
        purged.unreadable += meshes.unreadable;
        for (owner, id) in meshes.found {
            self.check_pulse()?;
            match self.delete_mesh(&owner, &id).await {
                Ok(deletion) => purged.meshes += u64::from(matches!(deletion, MeshDeletion::Deleted { .. })),
                Err(error) => purged.go_on(error)?,
            }
        }
        Ok(purged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blobs::BlobStore;
    use crate::service::config::ServiceConfig;
    use crate::service::jobs::data_folder::DataFolder;
    use crate::service::jobs::pulse::{Pulse, tests::distant};
    use crate::service::jobs::queue::Storage;
    use crate::service::jobs::simulator::Simulator;
    use crate::service::jobs::store::{StoreAddress, tests::submitted};
    use std::sync::atomic::Ordering;
    use std::time::Instant;

    #[tokio::test]
    async fn no_one_waits_for_an_object_store_that_does_not_answer() {
        let dir = tempfile::tempdir().unwrap();
        let folder = DataFolder::open(dir.path()).unwrap();
        let blobs = distant(dir.path());
        let pulse = Arc::new(Pulse::of(Arc::clone(&blobs) as Arc<dyn BlobStore>, None));
        let jobs = StoreAddress::in_folder(dir.path()).open().await.unwrap();
        let (first, second) = (submitted(&*jobs, "a").await, submitted(&*jobs, "b").await);
        jobs.cancel("anna", second.id).await.unwrap();
        let config = Arc::new(ServiceConfig::default());
        let engine = Arc::new(Simulator::new(&config.runs));
        let storage =
            Storage { jobs, blobs: Arc::clone(&blobs) as _, pulse: Some(Arc::clone(&pulse)), folder };
        let queue = Queue::new(storage, config, engine, Arc::default());

        // A download that waits is answered when the outage is noticed, and later ones at once.
        blobs.is_down.store(true, Ordering::SeqCst);
        let noticed = async { assert!(!pulse.ask()) };
        let (download, ()) = futures::join!(queue.unless_silent(std::future::pending::<()>()), noticed);
        assert!(matches!(download, Err(JobsError::BlobStoreSilent)));
        // So is a deletion, which is recorded, while what is old waits.
        let begun = Instant::now();
        assert!(queue.delete("anna", first.id).await.unwrap());
        assert!(matches!(queue.purge(0).await, Err(JobsError::BlobStoreSilent)));
        assert!(begun.elapsed() < REMOVAL_PATIENCE);
        assert!(queue.store.job("anna", first.id).await.unwrap().is_none());
        assert!(queue.store.job("anna", second.id).await.unwrap().is_some());

        blobs.is_down.store(false, Ordering::SeqCst);
        assert!(pulse.ask());
        queue.blobs_answer().await;
        assert_eq!(queue.unless_silent(std::future::ready(7)).await.unwrap(), 7);
        assert_eq!(queue.purge(0).await.unwrap(), Purged { jobs: 1, ..Purged::default() });
        queue.removals.wait_for_all().await;
        assert_eq!(queue.store.blobs().await.unwrap().names.len(), 0, "nothing is left of either");
    }
}
