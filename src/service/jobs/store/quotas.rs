//! How much waits, and how much owners keep.

use crate::service::jobs::JobsError;

/// Limits of a store. Those of owners hold for each of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quotas {
    /// Waiting jobs of all owners.
    pub waiting: u64,
    /// Waiting jobs of an owner.
    pub waiting_of_owner: u64,
    /// Jobs of an owner, in whatever state.
    pub jobs_of_owner: u64,
    /// What jobs and meshes of an owner keep: documents, summaries, recordings, files [bytes].
    pub bytes_of_owner: u64,
}

/// What an owner keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Number of jobs, in whatever state.
    pub jobs: u64,
    /// Documents, summaries, recordings and meshes [bytes].
    pub bytes: u64,
}

impl Quotas {
    /// No limits.
    pub const NONE: Self = Self {
        waiting: u64::MAX,
        waiting_of_owner: u64::MAX,
        jobs_of_owner: u64::MAX,
        bytes_of_owner: u64::MAX,
    };

    /// Whether an owner may keep as much as wanted.
    pub fn let_owners_keep_all(&self) -> bool {
        (self.jobs_of_owner, self.bytes_of_owner) == (u64::MAX, u64::MAX)
    }

    /// Checks numbers of waiting jobs, the new one included.
    ///
    /// # Errors
    /// `QueueFull`, `OwnerWaits`
    pub fn check_waiting(&self, all: u64, of_owner: u64) -> Result<(), JobsError> {
        if all > self.waiting {
            return Err(JobsError::QueueFull { waiting: self.waiting });
        }
        if of_owner > self.waiting_of_owner {
            return Err(JobsError::OwnerWaits { waiting: self.waiting_of_owner });
        }
        Ok(())
    }

    /// Checks what an owner keeps, the new job or mesh included.
    ///
    /// # Errors
    /// `OwnerKeeps`
    pub fn check_kept(&self, Kept { jobs, bytes }: Kept) -> Result<(), JobsError> {
        let keeps = |most, what| Err(JobsError::OwnerKeeps { most, what });
        match () {
            () if jobs > self.jobs_of_owner => keeps(self.jobs_of_owner, "jobs"),
            () if bytes > self.bytes_of_owner => keeps(self.bytes_of_owner, "bytes"),
            () => Ok(()),
        }
    }
}
