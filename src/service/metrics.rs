//! Counters in the text format of Prometheus (version 0.0.4).
//!
//! A few local atomics without a process-wide registry: two services in one process (as in tests) do not mix.

use super::jobs::JobState;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Upper bounds of the histogram buckets of run times [s].
const RUN_BOUNDS_S: [f64; 8] = [0.1, 1.0, 5.0, 15.0, 60.0, 300.0, 1800.0, 7200.0];
/// Upper bounds of the histogram buckets of response times [s].
const HTTP_BOUNDS_S: [f64; 7] = [0.001, 0.005, 0.025, 0.1, 0.5, 2.5, 10.0];

/// Counters of a service.
#[derive(Debug, Default)]
pub struct Metrics {
    run_seconds: Histogram<8>,
    http_seconds: Histogram<7>,
    panics: AtomicU64,
    ended: [AtomicU64; 5],
    /// Responses by method, route and status.
    answers: Mutex<BTreeMap<(String, String, u16), u64>>,
}

impl Metrics {
    /// Counts an ended run, whatever its outcome.
    pub fn run_ended(&self, duration: Duration) {
        self.run_seconds.observe(duration, &RUN_BOUNDS_S);
    }

    /// Counts a run that panicked.
    pub fn run_panicked(&self) {
        self.panics.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a job that reached a final state.
    pub fn job_ended(&self, state: JobState) {
        self.ended[state as usize].fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a response. `route` is the template, not the path, so that ids do not create separate series.
    pub fn answered(&self, method: &str, route: &str, status: u16, duration: Duration) {
        self.http_seconds.observe(duration, &HTTP_BOUNDS_S);
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        *answers.entry((method.to_owned(), route.to_owned(), status)).or_default() += 1;
    }

    /// All counters as text. `jobs` is the current number of jobs in each state, `removals` of deletions whose files are still there.
    pub fn render(&self, jobs: &[(JobState, u64)], removals: u64) -> String {
        let mut out = String::new();
        head(&mut out, "contuse_jobs", "gauge", "Jobs kept, by state.");
        for (state, count) in jobs {
            line(&mut out, &format!("contuse_jobs{{state=\"{}\"}}", state.as_str()), *count as f64);
        }
        let waiting = jobs.iter().find(|(s, _)| *s == JobState::Queued).map_or(0, |(_, n)| *n);
        head(&mut out, "contuse_queue_depth", "gauge", "Jobs that wait for a worker.");
        line(&mut out, "contuse_queue_depth", waiting as f64);
        let help = "Deleted jobs and meshes whose files this process has not removed yet.";
        head(&mut out, "contuse_removals_pending", "gauge", help);
        line(&mut out, "contuse_removals_pending", removals as f64);
        head(&mut out, "contuse_jobs_ended_total", "counter", "Jobs ended by this process, by final state.");
        for state in JobState::ALL.into_iter().filter(|s| s.is_final()) {
            let count = self.ended[state as usize].load(Ordering::Relaxed);
            line(
                &mut out,
                &format!("contuse_jobs_ended_total{{state=\"{}\"}}", state.as_str()),
                count as f64,
            );
        }
        head(&mut out, "contuse_run_panics_total", "counter", "Runs that ended by a defect of the program.");
        line(&mut out, "contuse_run_panics_total", self.panics.load(Ordering::Relaxed) as f64);
        head(&mut out, "contuse_run_seconds", "histogram", "Wall-clock time of runs.");
        self.run_seconds.render(&mut out, "contuse_run_seconds", &RUN_BOUNDS_S);
        head(&mut out, "contuse_http_requests_total", "counter", "Requests answered.");
        for ((method, route, status), count) in &*self.answers.lock().unwrap_or_else(PoisonError::into_inner)
        {
            let name = format!(
                "contuse_http_requests_total{{method=\"{method}\",route=\"{route}\",status=\"{status}\"}}"
            );
            line(&mut out, &name, *count as f64);
        }
        head(&mut out, "contuse_http_request_seconds", "histogram", "Time to the head of the answer.");
        self.http_seconds.render(&mut out, "contuse_http_request_seconds", &HTTP_BOUNDS_S);
        out
    }
}

/// Counts of durations below each of `N` bounds.
#[derive(Debug)]
struct Histogram<const N: usize> {
    below: [AtomicU64; N],
    count: AtomicU64,
    sum_us: AtomicU64,
}

impl<const N: usize> Default for Histogram<N> {
    fn default() -> Self {
        Self { below: [const { AtomicU64::new(0) }; N], count: AtomicU64::new(0), sum_us: AtomicU64::new(0) }
    }
}

impl<const N: usize> Histogram<N> {
    fn observe(&self, duration: Duration, bounds: &[f64; N]) {
        let seconds = duration.as_secs_f64();
        for (counter, bound) in self.below.iter().zip(bounds) {
            if seconds <= *bound {
                counter.fetch_add(1, Ordering::Relaxed);
            }
        }
        self.count.fetch_add(1, Ordering::Relaxed);
        self.sum_us.fetch_add(u64::try_from(duration.as_micros()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    fn render(&self, out: &mut String, name: &str, bounds: &[f64; N]) {
        let count = self.count.load(Ordering::Relaxed) as f64;
        for (counter, bound) in self.below.iter().zip(bounds) {
            line(out, &format!("{name}_bucket{{le=\"{bound}\"}}"), counter.load(Ordering::Relaxed) as f64);
        }
        line(out, &format!("{name}_bucket{{le=\"+Inf\"}}"), count);
        line(out, &format!("{name}_sum"), self.sum_us.load(Ordering::Relaxed) as f64 * 1e-6);
        line(out, &format!("{name}_count"), count);
    }
}

fn head(out: &mut String, name: &str, kind: &str, help: &str) {
    let _ = writeln!(out, "# HELP {name} {help}\n# TYPE {name} {kind}");
}

fn line(out: &mut String, name: &str, value: f64) {
    let _ = writeln!(out, "{name} {value}");
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
        let text = metrics.render(&[(JobState::Queued, 3)], 2);
        for expected in [
            "contuse_queue_depth 3\n",
            "contuse_removals_pending 2\n",
            "contuse_jobs_ended_total{state=\"succeeded\"} 1\n",
            "contuse_run_seconds_bucket{le=\"1\"} 0\n",
            "contuse_run_seconds_bucket{le=\"5\"} 1\n",
            "contuse_run_seconds_sum 1.5\n",
            "contuse_http_requests_total{method=\"GET\",route=\"/v1/jobs/{id}\",status=\"200\"} 1\n",
        ] {
            assert!(text.contains(expected), "{expected:?} is not in\n{text}");
        }
    }
}
