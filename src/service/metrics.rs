//! Counters for Prometheus, in the text format of OpenMetrics 1.0.
//!
//! Each service has a registry of its own: two in one process (as in tests) do not mix.

use super::jobs::{JobState, JobsError};
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Upper bounds of the histogram buckets of run times [s].
const RUN_BOUNDS_S: [f64; 8] = [0.1, 1.0, 5.0, 15.0, 60.0, 300.0, 1800.0, 7200.0];
/// Upper bounds of the histogram buckets of response times [s].
const HTTP_BOUNDS_S: [f64; 7] = [0.001, 0.005, 0.025, 0.1, 0.5, 2.5, 10.0];

/// Stores that may fail: of the jobs, and of everything else.
const JOBS: &str = "jobs";
const BLOBS: &str = "blobs";
/// The audit log.
const AUDIT: &str = "audit";

/// Media type of the text.
pub const MEDIA_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

type Labels<const N: usize> = [(&'static str, String); N];
type Seconds = Gauge<f64, AtomicU64>;

/// Counters of a service.
#[derive(Debug)]
pub struct Metrics {
    registry: Registry,
    run_seconds: Histogram,
    http_seconds: Histogram,
    panics: Counter,
    processes_lost: Counter,
    ended: Family<Labels<1>, Counter>,
    answers: Family<Labels<3>, Counter>,
    store_errors: Family<Labels<1>, Counter>,
    levels: Levels,
}

/// What is measured when it is asked for.
#[derive(Clone, Debug, Default)]
struct Levels {
    jobs: Family<Labels<1>, Gauge>,
    queue_depth: Gauge,
    queue_age: Seconds,
    removals: Gauge,
    processes: Gauge,
    running_memory: Gauge,
    resident_memory: Gauge,
    free_disk: Gauge,
    blobs_answer: Gauge,
}

/// The state of a service at this moment.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Number of jobs in each state.
    pub jobs: Vec<(JobState, u64)>,
    /// For how long the oldest job that waits has waited [s]; 0 if none does.
    pub queue_age_s: f64,
    /// Deletions whose files are still there.
    pub removals: u64,
    /// Processes of runs and validations.
    pub processes: u64,
    /// Memory that the running jobs of this process may take together [bytes].
    pub running_memory: u64,
    /// Memory of this process [bytes]; 0 where the system does not say.
    pub resident_memory: u64,
    /// Free space of the disk of the data folder [bytes].
    pub free_disk: u64,
    /// Faults of the job store so far.
    pub job_store_faults: u64,
    /// Lines of the audit log that could not be written so far.
    pub audit_faults: u64,
    /// Whether the store of blobs answered when it was last asked.
    pub blobs_answer: bool,
}

impl Default for Metrics {
    fn default() -> Self {
        let mut all = Self {
            registry: Registry::with_prefix("contuse"),
            run_seconds: Histogram::new(RUN_BOUNDS_S),
            http_seconds: Histogram::new(HTTP_BOUNDS_S),
            panics: Counter::default(),
            processes_lost: Counter::default(),
            ended: Family::default(),
            answers: Family::default(),
            store_errors: Family::default(),
            levels: Levels::default(),
        };
        let mut levels = all.levels.clone();
        levels.register(&mut all.registry);
        let r = &mut all.registry;
        r.register("jobs_ended", "Jobs ended by this process, by final state", all.ended.clone());
        r.register("run_panics", "Runs that ended by a defect of the program", all.panics.clone());
        let help = "Processes of runs that were killed, crashed or were refused memory";
        r.register("processes_lost", help, all.processes_lost.clone());
        r.register("run_seconds", "Wall-clock time of runs", all.run_seconds.clone());
        r.register(
            "store_errors",
            "Faults of the job store, of the store of blobs and of the audit log",
            all.store_errors.clone(),
        );
        r.register("http_requests", "Requests answered", all.answers.clone());
        r.register("http_request_seconds", "Time to the head of the answer", all.http_seconds.clone());
        // A series that is there from the start has a rate when the first fault comes.
        for state in JobState::ALL.into_iter().filter(|state| state.is_final()) {
            drop(all.ended.get_or_create(&state_label(state)));
        }
        for store in [JOBS, BLOBS] {
            drop(all.store_errors.get_or_create(&store_label(store)));
        }
        all
    }
}

impl Levels {
    fn register(&mut self, r: &mut Registry) {
        r.register("jobs", "Jobs kept, by state", self.jobs.clone());
        r.register("queue_depth", "Jobs that wait for a worker", self.queue_depth.clone());
        let help = "For how long the oldest job that waits has waited; 0 if none does";
        r.register("queue_age_seconds", help, self.queue_age.clone());
        let help = "Deleted jobs and meshes whose files this process has not removed yet";
        r.register("removals_pending", help, self.removals.clone());
        r.register("processes", "Processes of runs and validations", self.processes.clone());
        let help = "Memory that the running jobs of this process may take together";
        r.register("running_memory_bytes", help, self.running_memory.clone());
        r.register("resident_memory_bytes", "Memory of this process", self.resident_memory.clone());
        r.register("free_disk_bytes", "Free space of the disk of the data folder", self.free_disk.clone());
        let help = "Whether the store of blobs answered when it was last asked";
        r.register("blobs_answer", help, self.blobs_answer.clone());
    }

    fn set(&self, now: &Reading) {
        for (state, count) in &now.jobs {
            self.jobs.get_or_create(&state_label(*state)).set(level(*count));
        }
        let waiting = now.jobs.iter().find(|(state, _)| *state == JobState::Queued).map_or(0, |(_, n)| *n);
        self.queue_depth.set(level(waiting));
        self.queue_age.set(now.queue_age_s);
        self.removals.set(level(now.removals));
        self.processes.set(level(now.processes));
        self.running_memory.set(level(now.running_memory));
        self.resident_memory.set(level(now.resident_memory));
        self.free_disk.set(level(now.free_disk));
        self.blobs_answer.set(now.blobs_answer.into());
    }
}

impl Metrics {
    /// Counts an ended run, whatever its outcome.
    pub fn run_ended(&self, duration: Duration) {
        self.run_seconds.observe(duration.as_secs_f64());
    }

    /// Counts a run that panicked.
    pub fn run_panicked(&self) {
        self.panics.inc();
    }

    /// Counts a run that lost its process.
    pub fn process_lost(&self) {
        self.processes_lost.inc();
    }

    /// Counts a job that reached a final state.
    pub fn job_ended(&self, state: JobState) {
        self.ended.get_or_create(&state_label(state)).inc();
    }

    /// Counts an error, if it is that of a blob or a file; the job store counts its own.
    pub fn failed(&self, error: &JobsError) {
        if matches!(error, JobsError::Blob(_) | JobsError::BlobStore { .. } | JobsError::File { .. }) {
            self.store_errors.get_or_create(&store_label(BLOBS)).inc();
        }
    }

    /// Counts a response. `route` is the template, not the path, so that ids do not create separate series.
    pub fn answered(&self, method: &str, route: &str, status: u16, duration: Duration) {
        self.http_seconds.observe(duration.as_secs_f64());
        let labels =
            [("method", method.to_owned()), ("route", route.to_owned()), ("status", status.to_string())];
        self.answers.get_or_create(&labels).inc();
    }

    /// All counters as text, with the state of the service at this moment.
    pub fn render(&self, now: &Reading) -> String {
        self.levels.set(now);
        for (store, faults) in [(JOBS, now.job_store_faults), (AUDIT, now.audit_faults)] {
            self.store_errors.get_or_create(&store_label(store)).inner().store(faults, Ordering::Relaxed);
        }
        let mut out = String::new();
        // Only writing fails, which memory does not.
        let _ = encode(&mut out, &self.registry);
        out
    }
}

fn state_label(state: JobState) -> Labels<1> {
    [("state", state.as_str().to_owned())]
}

fn store_label(store: &str) -> Labels<1> {
    [("store", store.to_owned())]
}

fn level(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_are_written_as_prometheus_reads_them() {
        let metrics = Metrics::default();
        metrics.run_ended(Duration::from_millis(1500));
        metrics.job_ended(JobState::Succeeded);
        metrics.answered("GET", "/v1/jobs/{id}", 200, Duration::from_millis(2));
        metrics.failed(&JobsError::BlobStoreSilent);
        metrics.failed(&JobsError::file("a", std::io::ErrorKind::NotFound.into()));
        let now = Reading {
            jobs: vec![(JobState::Queued, 3)],
            queue_age_s: 1.5,
            removals: 2,
            processes: 4,
            job_store_faults: 5,
            ..Reading::default()
        };
        let text = metrics.render(&now);
        for expected in [
            "contuse_queue_depth 3",
            "contuse_queue_age_seconds 1.5",
            "contuse_removals_pending 2",
            "contuse_processes 4",
            "contuse_jobs_ended_total{state=\"succeeded\"} 1",
            "contuse_jobs_ended_total{state=\"failed\"} 0",
            "contuse_store_errors_total{store=\"jobs\"} 5",
            "contuse_store_errors_total{store=\"blobs\"} 1",
            "contuse_run_seconds_bucket{le=\"1.0\"} 0",
            "contuse_run_seconds_bucket{le=\"5.0\"} 1",
            "contuse_run_seconds_sum 1.5",
            "contuse_http_requests_total{method=\"GET\",route=\"/v1/jobs/{id}\",status=\"200\"} 1",
        ] {
            assert!(text.lines().any(|line| line == expected), "{expected:?} is not in\n{text}");
        }
        assert!(text.ends_with("# EOF\n"));
    }
}
