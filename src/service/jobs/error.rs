//! Errors of jobs and their storage.

use crate::blobs::{BlobError, BlobStore};
use crate::service::shelves::DATABASE;
use std::error::Error;
use std::io::ErrorKind;
use std::path::PathBuf;

/// Why a job could not be stored, found or run.
#[derive(Debug, thiserror::Error)]
pub enum JobsError {
    /// The job store did not answer.
    #[error("the job store failed: {source}")]
    Store {
        /// Kind of fault, for any store.
        fault: StoreFault,
        /// Error of the store itself.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The database of the jobs could not be opened.
    #[error("--database (CONTUSE_DATABASE): cannot open {database}: {source}; {remedy}")]
    Database {
        /// Name, server and user, without the password.
        database: String,
        /// Error of the connection.
        source: Box<dyn Error + Send + Sync>,
        /// What helps.
        remedy: &'static str,
    },
    /// The tables of the job store could not be migrated to this version.
    #[error("the job store could not be migrated: {0}")]
    Migration(#[source] Box<dyn Error + Send + Sync>),
    /// A row that this version did not write.
    #[error("the job store holds an unknown {what}: {value:?}")]
    Corrupt {
        /// What the value stands for.
        what: &'static str,
        /// The value that is unknown.
        value: String,
    },
    /// A file or folder that could not be used.
    #[error("{}: {source}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A blob that could not be used.
    #[error(transparent)]
    Blob(#[from] BlobError),
    /// The object store cannot be used.
    #[error("--blobs (CONTUSE_BLOBS): cannot use {address}: {source}; {remedy}")]
    BlobStore {
        /// Address of the store.
        address: String,
        /// Error of the store.
        source: BlobError,
        /// What helps.
        remedy: &'static str,
    },
    /// The blobs are those of another database.
    #[error(
        "--blobs (CONTUSE_BLOBS): {address} belongs to another database, {found:?}, and not to that of --database, {own:?}; \
         correct one of the addresses, or give each database a bucket or prefix of its own"
    )]
    ForeignBlobs {
        /// Address of the store.
        address: String,
        /// Identity that was found there.
        found: String,
        /// Identity of the database.
        own: String,
    },
    /// The database has blobs, but not here.
    #[error(
        "--blobs (CONTUSE_BLOBS): {address} is not the store that this database has used, as it has no object `{DATABASE}`; \
         correct the address, or, if the store was lost or copied without that object, write there the text {own}"
    )]
    UnmarkedBlobs {
        /// Address of the store.
        address: String,
        /// Identity of the database.
        own: String,
    },
    /// The object store did not answer when it was last asked.
    #[error("the object store does not answer")]
    BlobStoreSilent,
    /// Nothing of a recording can be read.
    #[error("nothing of the recording can be read: {0}")]
    Unreadable(String),
    /// Runs that have ended wait for the storage to take their recordings.
    #[error("{ends} runs that have ended wait for the storage")]
    EndsWait {
        /// Number of these runs.
        ends: usize,
    },
    /// Another process uses the data folder.
    #[error("{} is in use by another process", path.display())]
    InUse {
        /// Path of the folder.
        path: PathBuf,
    },
    /// What this process had locked in the data folder is gone: another process may use it.
    #[error(
        "{} was removed or replaced while this process uses it, and another process may use it now: put it back, or restart this one",
        path.display()
    )]
    Replaced {
        /// Path of the folder.
        path: PathBuf,
    },
    /// The clock of the machine is wrong.
    #[error("the clock of this machine is before 1970 or after 9999: correct it")]
    WrongClock,
    /// A part of a job could not be serialised as JSON.
    #[error("a part of a job could not be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The disk has too little free space to begin a job.
    #[error("the disk has {free} free bytes, and jobs begin with at least {least}")]
    DiskShort {
        /// Free space [bytes].
        free: u64,
        /// Free space that is required [bytes].
        least: u64,
    },
    /// The disk has no room for an upload beside those that are under way, or not for so much of one owner.
    #[error(
        "the disk has {free} free bytes, of which {least} have to stay free and {to_come} are for uploads to come: of the rest one owner may take three quarters, which {more} more exceed"
    )]
    NoRoom {
        /// Free space [bytes].
        free: u64,
        /// Uploads that are under way and still to come [bytes].
        to_come: u64,
        /// This one, or its next part [bytes].
        more: u64,
        /// Free space that has to stay [bytes].
        least: u64,
    },
    /// The uploads of an owner that are under way take what is left of the quota.
    #[error(
        "uploads of this owner that are under way take {under_way} bytes of the {most} that one may keep"
    )]
    OwnerUploads {
        /// Bytes of uploads under way.
        under_way: u64,
        /// How many an owner may keep.
        most: u64,
    },
    /// The maximum number of jobs of an owner is waiting.
    #[error("{waiting} jobs of this owner wait already")]
    OwnerWaits {
        /// Number of the owner's waiting jobs.
        waiting: u64,
    },
    /// The owner keeps as much as one may.
    #[error("this owner keeps as much as one may: {most} {what}")]
    OwnerKeeps {
        /// How much an owner may keep.
        most: u64,
        /// Of what: `jobs` or `bytes`.
        what: &'static str,
    },
    /// The maximum number of jobs is waiting.
    #[error("{waiting} jobs wait already")]
    QueueFull {
        /// Number of waiting jobs.
        waiting: u64,
    },
}

/// Codes of the system for too many open files: of the system, of the process.
const ENFILE: i32 = 23;
const EMFILE: i32 = 24;

/// How a job store failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreFault {
    /// No space is left.
    Full,
    /// Temporary fault: the disk failed, or the store is overloaded.
    Passing,
    /// Any other fault of the store.
    Other,
}

impl JobsError {
    /// Whether no space was left.
    pub fn is_storage_full(&self) -> bool {
        match self {
            Self::Store { fault, .. } => *fault == StoreFault::Full,
            _ => matches!(self.io_kind(), Some(ErrorKind::StorageFull | ErrorKind::QuotaExceeded)),
        }
    }

    /// Kind of error of a file or a blob.
    pub fn io_kind(&self) -> Option<ErrorKind> {
        match self {
            Self::File { source, .. }
            | Self::Blob(BlobError::Failed { source, .. })
            | Self::BlobStore { source: BlobError::Failed { source, .. }, .. } => Some(source.kind()),
            _ => None,
        }
    }

    /// Whether the process or the system had no file descriptor left.
    pub fn is_out_of_descriptors(&self) -> bool {
        match self {
            Self::File { source, .. } | Self::Blob(BlobError::Failed { source, .. }) => {
                matches!(source.raw_os_error(), Some(ENFILE | EMFILE))
            }
            _ => false,
        }
    }

    /// Whether a retry may succeed.
    pub fn is_passing(&self) -> bool {
        matches!(
            self,
            Self::Store { fault: StoreFault::Passing, .. }
                | Self::BlobStoreSilent
                | Self::EndsWait { .. }
                | Self::Replaced { .. }
                | Self::WrongClock
        ) || matches!(
            self.io_kind(),
            // The last two where the data folder was moved, or is another's.
            Some(
                ErrorKind::NetworkDown
                    | ErrorKind::ReadOnlyFilesystem
                    | ErrorKind::NotFound
                    | ErrorKind::PermissionDenied
            )
        )
    }

    /// Whether the machine or its disk is at fault, rather than what was to be stored.
    pub fn is_of_machine(&self) -> bool {
        self.is_storage_full() || self.is_out_of_descriptors() || self.is_passing()
    }

    /// An object store that cannot be used, with a remedy.
    pub fn of_blob_store(blobs: &dyn BlobStore, source: BlobError) -> Self {
        let kind = match &source {
            BlobError::Failed { source, .. } => Some(source.kind()),
            BlobError::TooLarge { .. } => None,
        };
        let remedy = match kind {
            Some(ErrorKind::NotFound) => "create the bucket, or correct its name",
            Some(ErrorKind::PermissionDenied) => {
                "correct AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or let them list, read, write and delete there"
            }
            _ => "start the store, or correct AWS_ENDPOINT_URL and AWS_REGION",
        };
        let address = blobs.place("").trim_end_matches('/').to_owned();
        Self::BlobStore { address, source, remedy }
    }

    /// An error concerning a file.
    pub fn file(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }
}
