//! Flags of the processes that run jobs: where the stores are, and the limits of runs.

use super::CliError;
use crate::scene::Budget;
use crate::service::config::{RunConfig, ServiceConfig};
use crate::service::jobs::store::StoreAddress;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// Log format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// A line of text for each event.
    Text,
    /// An object of JSON on each line.
    Json,
}

/// Flags of `contuse serve` and `contuse worker`.
#[derive(Args, Clone, Debug)]
pub struct WorkArgs {
    /// Where the service stores its data.
    #[command(flatten)]
    pub(super) store: StoreAddress,
    /// Number of jobs running at the same time [default: the number of cores]
    #[arg(long, env = "CONTUSE_WORKERS")]
    pub(super) workers: Option<usize>,
    /// Number of threads for each run.
    #[arg(long, env = "CONTUSE_THREADS_PER_JOB", default_value_t = 1)]
    threads_per_job: usize,
    /// Number of cases of a what-if question running at the same time [default: the number of cores]
    #[arg(long, env = "CONTUSE_THREADS_PER_WHAT_IF")]
    threads_per_what_if: Option<usize>,
    /// Maximum size of a scene document in bytes; suffixes k, M, G are accepted.
    #[arg(long, env = "CONTUSE_MAX_BODY", default_value_t = Budget::SERVICE.document_bytes, value_parser = size)]
    max_body: u64,
    /// Maximum size of a mesh in bytes.
    #[arg(long, env = "CONTUSE_MAX_MESH", default_value_t = Budget::SERVICE.mesh_bytes, value_parser = size)]
    max_mesh: u64,
    /// Maximum number of elements in a scene.
    #[arg(long, env = "CONTUSE_MAX_ELEMENTS", default_value_t = Budget::SERVICE.elements)]
    max_elements: u64,
    /// Maximum number of time steps of a scene.
    #[arg(long, env = "CONTUSE_MAX_STEPS", default_value_t = Budget::SERVICE.steps)]
    max_steps: u64,
    /// Maximum memory of a run in bytes.
    #[arg(long, env = "CONTUSE_MAX_MEMORY", default_value_t = Budget::SERVICE.memory_bytes, value_parser = size)]
    max_memory: u64,
    /// Maximum memory of all running jobs together in bytes, by their estimates [default: three quarters of the machine's]
    #[arg(long, env = "CONTUSE_MAX_RUNNING_MEMORY", value_parser = size)]
    max_running_memory: Option<u64>,
    /// Folder of cgroups in which each run gets one, with its memory limit: version 2, delegated to this user, or of the memory controller
    /// of version 1 [default: none, the limits of the process alone]
    #[arg(long, env = "CONTUSE_CGROUP")]
    cgroup: Option<PathBuf>,
    /// Maximum size of the fields of a recording in bytes, before compression.
    #[arg(long, env = "CONTUSE_MAX_RECORDING", default_value_t = Budget::SERVICE.recording_bytes, value_parser = size)]
    max_recording: u64,
    /// Number of attempts after which a job that loses its process, or the service, fails.
    #[arg(long, env = "CONTUSE_MAX_ATTEMPTS", default_value_t = 3)]
    max_attempts: u32,
    /// Wall-clock limit of a job in seconds.
    #[arg(long, env = "CONTUSE_DEADLINE_S", default_value_t = 3600)]
    deadline_s: u64,
    /// Free disk space in bytes below which no job is accepted or started.
    #[arg(long, env = "CONTUSE_LEAST_FREE", default_value = "64M", value_parser = size)]
    least_free: u64,
    /// Grace period for running jobs and open responses after SIGTERM, in seconds; then jobs return to the queue.
    #[arg(long, env = "CONTUSE_GRACE_S", default_value_t = 20)]
    grace_s: u64,
    /// Log format on standard error: lines of text, or JSON objects.
    #[arg(long, env = "CONTUSE_LOG_FORMAT", default_value = "text")]
    log_format: LogFormat,
}

impl WorkArgs {
    /// Whether the log is to be lines of JSON.
    pub(super) fn logs_json(&self) -> bool {
        self.log_format == LogFormat::Json
    }

    /// Configuration from the flags.
    ///
    /// # Errors
    /// If a number is invalid.
    pub fn config(self) -> Result<ServiceConfig, CliError> {
        let defaults = ServiceConfig::default();
        let threads_per_what_if = self.threads_per_what_if.unwrap_or(defaults.runs.threads_per_what_if);
        if [self.threads_per_job, threads_per_what_if].contains(&0) {
            return Err(CliError::Usage(
                "--threads-per-job and --threads-per-what-if must be at least 1".into(),
            ));
        }
        Ok(ServiceConfig {
            store: self.store,
            workers: self.workers.unwrap_or(defaults.workers),
            runs: RunConfig {
                threads_per_job: self.threads_per_job,
                threads_per_what_if,
                deadline: Duration::from_secs(self.deadline_s),
                budget: Budget {
                    document_bytes: self.max_body,
                    mesh_bytes: self.max_mesh,
                    elements: self.max_elements,
                    steps: self.max_steps,
                    memory_bytes: self.max_memory,
                    recording_bytes: self.max_recording,
                    ..Budget::SERVICE
                },
            },
            max_running_memory: self.max_running_memory.unwrap_or(defaults.max_running_memory),
            max_attempts: self.max_attempts.max(1),
            cgroup: self.cgroup,
            grace: Duration::from_secs(self.grace_s),
            least_free: self.least_free,
            ..defaults
        })
    }
}

/// Parses a number of bytes: `4096`, `64k`, `4M`, `2G` (powers of 1024).
pub(super) fn size(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.as_bytes().last() {
        Some(b'k' | b'K') => (&text[..text.len() - 1], 10),
        Some(b'M') => (&text[..text.len() - 1], 20),
        Some(b'G') => (&text[..text.len() - 1], 30),
        _ => (text, 0),
    };
    let number: u64 = digits.parse().map_err(|_| format!("{text:?} is not a number of bytes"))?;
    number.checked_mul(1 << shift).ok_or_else(|| format!("{text:?} is too large"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_suffixes() {
        assert_eq!(size("4096"), Ok(4096));
        assert_eq!(size("64k"), Ok(64 << 10));
        assert_eq!(size("4M"), Ok(4 << 20));
        assert_eq!(size("2G"), Ok(2 << 30));
        assert!(
            size("").is_err() && size("M").is_err() && size("1T").is_err() && size("99999999999G").is_err()
        );
    }
}
