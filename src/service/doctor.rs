//! Examination of a data folder that no service uses: what is damaged or lost, and what of it can be recovered.

use super::ServiceError;
use super::jobs::data_folder::{DataFolder, open_to_others};
use super::jobs::found::Found;
use super::jobs::store::{Identity, KnownBlobs, PROBE_PATIENCE, StoreAddress};
use super::jobs::{JobId, JobsError, ownership};
use super::opening::{lost_log, on_a_thread};
use crate::blobs::BlobStore;
use crate::report::RecordedRun;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A recording without its job.
#[derive(Clone, Debug)]
pub struct LostJob {
    /// Where the recording is: its file, if the store keeps files.
    pub place: String,
    /// Whether reports and exports of it work; otherwise why not.
    pub readable: Result<(), String>,
}

/// What an examination found.
#[derive(Clone, Debug, Default)]
pub struct Diagnosis {
    /// Faults of the job store, as text.
    pub store: Vec<String>,
    /// Why the blobs are not those of the job store; nothing else is known of them then.
    pub blobs: Option<String>,
    /// Sequence numbers of jobs that cannot be read.
    pub unreadable: Vec<i64>,
    /// Jobs whose recordings are lost; scene and summary are in the store.
    pub without_recording: Vec<JobId>,
    /// Recordings whose jobs are lost.
    pub without_job: Vec<LostJob>,
    /// Names of meshes whose files are lost.
    pub without_file: Vec<String>,
    /// Folders and files that other users of the machine could read or enter, with their modes.
    pub open_to_others: Vec<(PathBuf, u32)>,
}

impl Diagnosis {
    /// Whether nothing is damaged or lost.
    pub fn is_sound(&self) -> bool {
        let Self { store, blobs, unreadable, without_recording, without_job, without_file, open_to_others } =
            self;
        store.is_empty()
            && blobs.is_none()
            && unreadable.is_empty()
            && without_recording.is_empty()
            && without_job.is_empty()
            && without_file.is_empty()
            && open_to_others.is_empty()
    }
}

/// Examines the data of a service.
///
/// # Errors
/// If the folder is in use or cannot be read, or the database or the object store does not answer within some seconds.
pub async fn examine(address: &StoreAddress) -> Result<Diagnosis, ServiceError> {
    // Before it is locked, which closes the folder itself.
    let open_to_others = open_to_others(&address.data)?;
    // Locked while it is examined.
    let _folder = DataFolder::open(&address.data)?;
    let blobs = address.open_blobs(PROBE_PATIENCE).map_err(JobsError::from)?;
    let mut diagnosis = Diagnosis { open_to_others, ..Diagnosis::default() };
    let lost_log = lost_log(address).await;
    diagnosis.store.extend(lost_log.iter().map(|(_, words)| words.clone()));
    let store = if address.exists() {
        match address.open().await {
            // Nothing is known to be damaged.
            Err(error @ JobsError::Database { .. }) => return Err(error.into()),
            opened => opened.map_err(|error| error.to_string()),
        }
    } else {
        Err(format!("{address} is missing"))
    };
    let (known, identity) = match store {
        Ok(store) => {
            let (faults, unreadable) = store.faults().await?;
            diagnosis.store.extend(faults);
            diagnosis.unreadable = unreadable;
            let known = store.blobs().await?;
            let identity = match store.shared() {
                Some(shared) => Some(shared.identity().await?),
                None => None,
            };
            store.close().await;
            if let Some((lost, _)) = lost_log {
                address.note_lost_changes(lost).await?;
            }
            (known, identity)
        }
        Err(reason) => {
            diagnosis.store.push(reason);
            (KnownBlobs::default(), None)
        }
    };
    // Reads files, or asks a store in this runtime: not for its threads.
    let is_distant = address.blobs.is_some();
    let examined = on_a_thread(move || match compare(blobs.as_ref(), (&known, identity), &mut diagnosis) {
        Ok(()) => Ok(diagnosis),
        Err(JobsError::Blob(error)) if is_distant => Err(JobsError::of_blob_store(blobs.as_ref(), error)),
        Err(error) => Err(error),
    });
    Ok(examined.await?)
}

/// Compares the blobs with what is known of them.
fn compare(
    blobs: &dyn BlobStore,
    (known, identity): (&KnownBlobs, Option<Identity>),
    diagnosis: &mut Diagnosis,
) -> Result<(), JobsError> {
    match identity.map_or(Ok(true), |own| ownership::check(blobs, &own)) {
        Ok(_) => {}
        Err(error @ (JobsError::ForeignBlobs { .. } | JobsError::UnmarkedBlobs { .. })) => {
            diagnosis.blobs = Some(error.to_string());
            return Ok(());
        }
        Err(error) => return Err(error),
    }
    let found = Found::among(blobs, known, Duration::ZERO)?;
    diagnosis.without_recording = found.without_recording;
    diagnosis.without_file = found.without_file;
    for name in found.without_job {
        let place = blobs.place(&name);
        let readable = match blobs.open(&name)?.map(|blob| RecordedRun::of(blob, Path::new(&name))) {
            Some(Ok(_)) => Ok(()),
            Some(Err(error)) => Err(error.to_string()),
            None => Err("it is gone".to_owned()),
        };
        diagnosis.without_job.push(LostJob { place, readable });
    }
    Ok(())
}
