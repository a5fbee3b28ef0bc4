//! Limits and addresses of the service. Every limit has a default; nothing is unlimited.

use super::jobs::store::{Quotas, StoreAddress};
use super::tokens::Tokens;
use crate::scene::Budget;
use crate::study::process::usable_memory_bytes;
use serde::{Deserialize, Serialize};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// Configuration of scenes and runs, which the process of a run receives.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunConfig {
    /// Number of threads for each run.
    pub threads_per_job: usize,
    /// Number of cases of a what-if question running at the same time.
    pub threads_per_what_if: usize,
    /// Wall-clock limit of a job.
    pub deadline: Duration,
    /// Limits of a scene; also the largest document and the largest mesh.
    pub budget: Budget,
}

impl Default for RunConfig {
    fn default() -> Self {
        Self {
            threads_per_job: 1,
            threads_per_what_if: std::thread::available_parallelism().map_or(1, usize::from),
            deadline: Duration::from_secs(3600),
            budget: Budget::SERVICE,
        }
    }
}

/// What a process does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It answers requests, and may run jobs.
    Service,
    /// It runs jobs only.
    Worker,
}

/// Configuration of the service.
#[derive(Clone, Debug)]
pub struct ServiceConfig {
    /// What this process does.
    pub role: Role,
    /// Address to listen on; port 0 selects a free one.
    pub listen: SocketAddr,
    /// Where jobs, meshes and recordings are stored.
    pub store: StoreAddress,
    /// Number of jobs running at the same time.
    pub workers: usize,
    /// Threads and limits of scenes and runs.
    pub runs: RunConfig,
    /// Memory of all running jobs together, by their estimates [bytes]; a job waits until its own is free.
    pub max_running_memory: u64,
    /// Folder of cgroups for the runs.
    pub cgroup: Option<PathBuf>,
    /// Maximum number of waiting jobs.
    pub max_queued: u64,
    /// Maximum number of waiting jobs of each owner; with tokens a quarter of all if `None`.
    pub max_queued_per_owner: Option<u64>,
    /// Maximum number of jobs that each owner keeps, in whatever state.
    pub max_jobs_per_owner: Option<u64>,
    /// Maximum size of what jobs and meshes of each owner keep [bytes].
    pub max_bytes_per_owner: Option<u64>,
    /// Size of all files of the audit log beyond which the oldest is removed [bytes].
    pub max_audit_bytes: u64,
    /// Requests per second of each owner of a token, who may save up those of ten seconds.
    pub max_requests_per_s: u32,
    /// Maximum number of simultaneous connections; those beyond are answered `503`, probes apart.
    pub max_connections: usize,
    /// Maximum number of waiting validations of small scenes, and of large ones.
    pub max_validations_waiting: usize,
    /// Maximum time that a validation waits.
    pub validation_patience: Duration,
    /// Time allowed to a client for the headers of a request, and for its JSON body.
    pub request_timeout: Duration,
    /// Time allowed to a client for the upload of a mesh.
    pub upload_timeout: Duration,
    /// Least rate of uploads and downloads [bytes/s]; slower clients are cut off after `request_timeout`.
    pub least_rate: u64,
    /// Free space of the disk below which no job is accepted or begun [bytes].
    pub least_free: u64,
    /// Grace period of running jobs and open responses after a request to shut down.
    pub grace: Duration,
    /// Days after which jobs that have ended, and meshes, are deleted; never if `None`.
    pub keep_days: Option<u32>,
    /// Number of attempts after which a job counts as the cause of losing its worker.
    pub max_attempts: u32,
    /// Tokens that grant access; open to everyone on this machine if there are none.
    pub tokens: Tokens,
    /// File of these tokens, which replace them when it changes.
    pub tokens_file: Option<PathBuf>,
    /// Origins of web pages that may use the service, beside its own.
    pub cors_origins: Vec<String>,
    /// Names under which a service without tokens is reached, beside `localhost` and the addresses of this machine.
    pub hosts: Vec<String>,
    /// Idle time of an event stream after which a comment is sent.
    pub heartbeat: Duration,
}

impl Default for ServiceConfig {
    fn default() -> Self {
        Self {
            role: Role::Service,
            listen: SocketAddr::from(([127, 0, 0, 1], 8080)),
            store: StoreAddress::in_folder("data"),
            workers: std::thread::available_parallelism().map_or(1, usize::from),
            runs: RunConfig::default(),
            max_running_memory: usable_memory_bytes().map_or(u64::MAX, |bytes| bytes / 4 * 3),
            cgroup: None,
            max_queued: 1000,
            max_queued_per_owner: None,
            max_jobs_per_owner: None,
            max_bytes_per_owner: None,
            max_audit_bytes: 10 << 30,
            max_requests_per_s: 100,
            max_connections: 512,
            max_validations_waiting: 64,
            validation_patience: Duration::from_secs(30),
            request_timeout: Duration::from_secs(30),
            upload_timeout: Duration::from_secs(600),
            least_rate: 4096,
            least_free: 64 << 20,
            grace: Duration::from_secs(20),
            keep_days: None,
            max_attempts: 3,
            tokens: Tokens::default(),
            tokens_file: None,
            cors_origins: Vec::new(),
            hosts: Vec::new(),
            heartbeat: Duration::from_secs(15),
        }
    }
}

impl ServiceConfig {
    /// Number of owners who fill a queue together; without tokens, everyone is one owner.
    pub fn owners_per_queue(&self) -> usize {
        if self.tokens.is_open() { 1 } else { 4 }
    }

    /// Limits of what waits and what owners keep.
    pub fn quotas(&self) -> Quotas {
        let share = self.max_queued.div_ceil(self.owners_per_queue() as u64);
        Quotas {
            waiting: self.max_queued,
            waiting_of_owner: self.max_queued_per_owner.unwrap_or(share),
            jobs_of_owner: self.max_jobs_per_owner.unwrap_or(u64::MAX),
            bytes_of_owner: self.max_bytes_per_owner.unwrap_or(u64::MAX),
        }
    }
}
