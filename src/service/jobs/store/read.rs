//! Looking at jobs.

use super::Store;
use crate::service::jobs::engine::SceneProblem;
use crate::service::jobs::{FinalRecording, JobFailure, JobId, JobState, JobsError, Phase, RunProgress};
use sqlx::Row;
use sqlx::sqlite::SqliteRow;

/// A job as it stands.
#[derive(Clone, Debug)]
pub struct JobRow {
    /// Order of arrival.
    pub seq: i64,
    /// Its id.
    pub id: JobId,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// What is odd about the scene.
    pub warnings: Vec<SceneProblem>,
    /// Where it stands.
    pub state: JobState,
    /// How far it has come.
    pub progress: RunProgress,
    /// How often a worker took it.
    pub attempts: u32,
    /// Whether its owner wants it stopped.
    pub cancel_requested: bool,
    /// When it came, RFC 3339.
    pub created_at: String,
    /// When a worker took it last.
    pub started_at: Option<String>,
    /// When it ended.
    pub finished_at: Option<String>,
    /// Why it failed.
    pub failure: Option<JobFailure>,
    /// Whether it has a summary.
    pub has_summary: bool,
    /// Its recording, when final.
    pub recording: Option<FinalRecording>,
    /// Its place in the queue, the next one is 1; `None` when it does not wait.
    pub queue_position: Option<u64>,
}

/// Which jobs to list, newest first.
#[derive(Clone, Debug)]
pub struct Page {
    /// Only these states; all when empty.
    pub states: Vec<JobState>,
    /// Only jobs that came before this one.
    pub before: Option<i64>,
    /// At most so many.
    pub limit: u32,
}

/// An event of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EventRow {
    /// Its number in the job, from 1.
    pub n: i64,
    /// What happened.
    pub kind: String,
    /// The details, JSON.
    pub data: String,
}

impl Store {
    /// One job of an owner.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn job(&self, owner: &str, id: JobId) -> Result<Option<JobRow>, JobsError> {
        sqlx::query("SELECT * FROM job_rows WHERE owner = ?1 AND id = ?2")
            .bind(owner)
            .bind(id.to_string())
            .fetch_optional(&self.pool)
            .await?
            .map(|row| job_of_row(&row))
            .transpose()
    }

    /// A page of the jobs of an owner, newest first.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn jobs(&self, owner: &str, page: &Page) -> Result<Vec<JobRow>, JobsError> {
        // ",queued,running,": each name stands between commas.
        let names: Vec<&str> = page.states.iter().map(|s| s.as_str()).collect();
        let states = if names.is_empty() { String::new() } else { format!(",{},", names.join(",")) };
        let rows = sqlx::query(
            "SELECT * FROM job_rows
             WHERE owner = ?1 AND (?2 = '' OR instr(?2, ',' || state || ',') > 0) AND (?3 IS NULL OR seq < ?3)
             ORDER BY seq DESC LIMIT ?4",
        )
        .bind(owner)
        .bind(states)
        .bind(page.before)
        .bind(i64::from(page.limit))
        .fetch_all(&self.pool)
        .await?;
        rows.iter().map(job_of_row).collect()
    }

    /// The summary of a job of an owner, as JSON text.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn summary(&self, owner: &str, id: JobId) -> Result<Option<String>, JobsError> {
        let row: Option<(Option<String>,)> =
            sqlx::query_as("SELECT summary FROM jobs WHERE owner = ?1 AND id = ?2 AND deleted = 0")
                .bind(owner)
                .bind(id.to_string())
                .fetch_optional(&self.pool)
                .await?;
        Ok(row.and_then(|(summary,)| summary))
    }

    /// The scene document of a job of an owner, as it came.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn scene(&self, owner: &str, id: JobId) -> Result<Option<Vec<u8>>, JobsError> {
        let row: Option<(Vec<u8>,)> =
            sqlx::query_as("SELECT scene FROM jobs WHERE owner = ?1 AND id = ?2 AND deleted = 0")
                .bind(owner)
                .bind(id.to_string())
                .fetch_optional(&self.pool)
                .await?;
        Ok(row.map(|(scene,)| scene))
    }

    /// Events of a job after event number `after`, and whether nothing will come any more (the job is final or gone).
    ///
    /// # Errors
    /// When the store fails.
    pub async fn events_after(
        &self,
        seq: i64,
        after: i64,
        limit: u32,
    ) -> Result<(Vec<EventRow>, bool), JobsError> {
        // The state is read first: a job that ends between the two reads has its last event in the second.
        let state: Option<(String, bool)> = sqlx::query_as("SELECT state, deleted FROM jobs WHERE seq = ?1")
            .bind(seq)
            .fetch_optional(&self.pool)
            .await?;
        let rows: Vec<(i64, String, String)> =
            sqlx::query_as("SELECT n, kind, data FROM events WHERE job = ?1 AND n > ?2 ORDER BY n LIMIT ?3")
                .bind(seq)
                .bind(after)
                .bind(i64::from(limit))
                .fetch_all(&self.pool)
                .await?;
        let ended = state
            .is_none_or(|(s, deleted)| deleted || JobState::from_name(&s).is_some_and(JobState::is_final));
        let complete = rows.len() < limit as usize;
        let events = rows.into_iter().map(|(n, kind, data)| EventRow { n, kind, data }).collect();
        Ok((events, ended && complete))
    }

    /// How many jobs are in each state.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn counts(&self) -> Result<Vec<(JobState, u64)>, JobsError> {
        let rows: Vec<(String, i64)> =
            sqlx::query_as("SELECT state, COUNT(*) FROM jobs WHERE deleted = 0 GROUP BY state")
                .fetch_all(&self.pool)
                .await?;
        let count = |state: JobState| {
            rows.iter().find(|(name, _)| name == state.as_str()).map_or(0, |(_, n)| n.cast_unsigned())
        };
        Ok(JobState::ALL.into_iter().map(|s| (s, count(s))).collect())
    }
}

/// A job of a row of the view `job_rows`.
fn job_of_row(row: &SqliteRow) -> Result<JobRow, JobsError> {
    let id: String = row.try_get("id")?;
    let state: String = row.try_get("state")?;
    let phase: String = row.try_get("phase")?;
    let warnings: String = row.try_get("warnings")?;
    let failure: Option<String> = row.try_get("failure")?;
    let recording = match (row.try_get("recording_bytes")?, row.try_get("recording_sha256")?) {
        (Some(bytes), Some(sha256)) => Some(FinalRecording {
            bytes: i64::cast_unsigned(bytes),
            sha256,
            complete: row.try_get::<Option<bool>, _>("recording_complete")?.unwrap_or(false),
        }),
        _ => None,
    };
    Ok(JobRow {
        seq: row.try_get("seq")?,
        id: id.parse().map_err(|_| JobsError::Corrupt { what: "job id", value: id })?,
        name: row.try_get("name")?,
        content_hash: row.try_get("content_hash")?,
        end_time_s: row.try_get("end_time_s")?,
        warnings: serde_json::from_str(&warnings)?,
        state: JobState::from_name(&state).ok_or(JobsError::Corrupt { what: "state", value: state })?,
        progress: RunProgress {
            phase: Phase::from_name(&phase).ok_or(JobsError::Corrupt { what: "phase", value: phase })?,
            progress: row.try_get("progress")?,
            step: row.try_get::<i64, _>("step")?.cast_unsigned(),
            expected_steps: row.try_get::<Option<i64>, _>("expected_steps")?.map(i64::cast_unsigned),
            simulated_time_s: row.try_get("simulated_time_s")?,
            eta_s: row.try_get("eta_s")?,
        },
        attempts: row.try_get("attempts")?,
        cancel_requested: row.try_get("cancel_requested")?,
        created_at: row.try_get("created_at")?,
        started_at: row.try_get("started_at")?,
        finished_at: row.try_get("finished_at")?,
        failure: failure.map(|f| serde_json::from_str(&f)).transpose()?,
        has_summary: row.try_get("has_summary")?,
        recording,
        queue_position: row.try_get::<Option<i64>, _>("position")?.map(i64::cast_unsigned),
    })
}
