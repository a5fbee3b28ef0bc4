//! Queries of jobs, which change nothing.

use super::{Row, SqlStore, attempts_of};
use crate::service::jobs::store::{ClaimedJob, EventRow, Job, JobLinks, NOTICE, Page};
use crate::service::jobs::{FinalRecording, JobId, JobKind, JobState, JobsError, Phase, Priority};
use sqlx::Row as _;

impl SqlStore {
    pub(super) async fn job(&self, owner: &str, id: JobId) -> Result<Option<Job>, JobsError> {
        let row = sqlx::query("SELECT * FROM job_rows WHERE owner = $1 AND id = $2")
            .bind(owner)
            .bind(id.to_string())
            .fetch_optional(&self.pool)
            .await?;
        let Some(row) = row else { return Ok(None) };
        let mut rows = [job_of_row(&row)?];
        self.count_positions(owner, &mut rows).await?;
        Ok(rows.into_iter().next())
    }

    pub(super) async fn jobs(&self, owner: &str, page: &Page) -> Result<Vec<Job>, JobsError> {
        let mut rows = Vec::new();
        if page.states.is_empty() {
            rows = self.readable_jobs(owner, None, page).await?;
        }
        // A page of each state: together they contain the page of all.
        for state in JobState::ALL.into_iter().filter(|state| page.states.contains(state)) {
            rows.extend(self.readable_jobs(owner, Some(state), page).await?);
        }
        rows.sort_by_key(|row| std::cmp::Reverse(row.seq));
        rows.truncate(page.limit as usize);
        self.count_positions(owner, &mut rows).await?;
        Ok(rows)
    }

    /// A page of the jobs in a state, or in any. Those that cannot be read are reported, and do not hide the others.
    async fn readable_jobs(
        &self,
        owner: &str,
        state: Option<JobState>,
        page: &Page,
    ) -> Result<Vec<Job>, JobsError> {
        let statement = if state.is_some() {
            "SELECT * FROM job_rows WHERE owner = $1 AND seq < $2 AND state = $4 ORDER BY seq DESC LIMIT $3"
        } else {
            "SELECT * FROM job_rows WHERE owner = $1 AND seq < $2 ORDER BY seq DESC LIMIT $3"
        };
        let (mut found, mut before) = (Vec::new(), page.before.unwrap_or(i64::MAX));
        loop {
            let lacking = page.limit as usize - found.len();
            let rows =
                sqlx::query(statement).bind(owner).bind(before).bind(i64::try_from(lacking).unwrap_or(0));
            let rows = match state {
                Some(state) => rows.bind(state.as_str()),
                None => rows,
            };
            let rows = rows.fetch_all(&self.pool).await?;
            found.extend(rows.iter().filter_map(readable));
            let Some(last) =
                rows.last().filter(|_| found.len() < page.limit as usize && rows.len() == lacking)
            else {
                return Ok(found);
            };
            before = last.try_get("seq")?;
        }
    }

    /// Sets the positions of waiting jobs among those of their owner: these are counted once, whatever the number of rows.
    async fn count_positions(&self, owner: &str, rows: &mut [Job]) -> Result<(), JobsError> {
        let mut waiting: Vec<&mut Job> = rows.iter_mut().filter(|r| r.state == JobState::Queued).collect();
        if waiting.is_empty() {
            return Ok(());
        }
        waiting.sort_by_key(|row| (row.priority, row.seq));
        let of_priorities = sqlx::query("SELECT priority, n FROM waiting_counts WHERE owner = $1");
        let of_priorities = of_priorities.bind(owner).fetch_all(&self.pool).await?;
        // Those of jobs that cannot be read are not counted.
        let of_priorities: Vec<(i64, i64)> = of_priorities
            .iter()
            .filter_map(|row| Some((row.try_get("priority").ok()?, row.try_get("n").ok()?)))
            .collect();
        let (mut counted_to, mut position) = ((None, i64::MIN), 0);
        for row in waiting {
            if counted_to.0 != Some(row.priority) {
                let before = of_priorities.iter().filter(|(number, _)| *number > row.priority.number());
                (counted_to, position) =
                    ((Some(row.priority), i64::MIN), before.map(|(_, count)| count).sum());
            }
            let (more,): (i64,) = sqlx::query_as(concat!(
                "SELECT COUNT(*) FROM jobs",
                by_owner!(),
                " WHERE owner = $1 AND priority = $2 AND state = 'queued' AND deleted = 0
                     AND seq > $3 AND seq <= $4"
            ))
            .bind(owner)
            .bind(row.priority.number())
            .bind(counted_to.1)
            .bind(row.seq)
            .fetch_one(&self.pool)
            .await?;
            position += more;
            counted_to.1 = row.seq;
            // It may have left the queue in between.
            row.queue_position = Some(position.max(1).cast_unsigned());
        }
        Ok(())
    }

    pub(super) async fn summary(&self, owner: &str, id: JobId) -> Result<Option<String>, JobsError> {
        let row: Option<(Option<String>,)> =
            sqlx::query_as("SELECT summary FROM jobs WHERE owner = $1 AND id = $2 AND deleted = 0")
                .bind(owner)
                .bind(id.to_string())
                .fetch_optional(&self.pool)
                .await?;
        Ok(row.and_then(|(summary,)| summary))
    }

    pub(super) async fn document(
        &self,
        owner: &str,
        id: JobId,
    ) -> Result<Option<(JobKind, Vec<u8>)>, JobsError> {
        let row: Option<(String, Vec<u8>)> =
            sqlx::query_as("SELECT kind, scene FROM jobs WHERE owner = $1 AND id = $2 AND deleted = 0")
                .bind(owner)
                .bind(id.to_string())
                .fetch_optional(&self.pool)
                .await?;
        row.map(|(kind, document)| Ok((kind_of_name(kind)?, document))).transpose()
    }

    pub(super) async fn events_after(
        &self,
        seq: i64,
        after: i64,
        limit: u32,
    ) -> Result<(Vec<EventRow>, bool), JobsError> {
        // The state is read first: the last event of a job that ends in between is in the second result.
        let state: Option<(String, bool)> =
            sqlx::query_as("SELECT state, deleted <> 0 FROM jobs WHERE seq = $1")
                .bind(seq)
                .fetch_optional(&self.pool)
                .await?;
        let rows: Vec<(i64, String, String)> =
            sqlx::query_as("SELECT n, kind, data FROM events WHERE job = $1 AND n > $2 ORDER BY n LIMIT $3")
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

    pub(super) async fn queue_age_s(&self) -> Result<f64, JobsError> {
        let age: Option<(Option<f64>,)> = sqlx::query_as(concat!(
            "SELECT ",
            age_s!(),
            " FROM jobs WHERE state = 'queued' AND deleted = 0 ORDER BY seq LIMIT 1"
        ))
        .fetch_optional(&self.pool)
        .await?;
        Ok(age.and_then(|(age,)| age).unwrap_or(0.0).max(0.0))
    }

    pub(super) async fn counts(&self) -> Result<Vec<(JobState, u64)>, JobsError> {
        let rows: Vec<(String, i64)> =
            sqlx::query_as("SELECT state, n FROM state_counts").fetch_all(&self.pool).await?;
        let count = |state: JobState| {
            rows.iter().find(|(name, _)| name == state.as_str()).map_or(0, |(_, n)| n.cast_unsigned())
        };
        Ok(JobState::ALL.into_iter().map(|s| (s, count(s))).collect())
    }
}

/// Faults of the database, and jobs that cannot be read.
impl SqlStore {
    pub(super) async fn faults(&self) -> Result<(Vec<String>, Vec<i64>), JobsError> {
        let found = self.own_faults().await?;
        // In pieces: there may be very many jobs.
        let (mut unreadable, mut after) = (Vec::new(), i64::MIN);
        loop {
            let rows = sqlx::query(
                "SELECT r.*, j.kind, j.memory_bytes, j.alone <> 0 AS alone, j.trace
                 FROM job_rows r JOIN jobs j ON j.seq = r.seq WHERE r.seq > $1 ORDER BY r.seq LIMIT 1000",
            )
            .bind(after)
            .fetch_all(&self.pool)
            .await?;
            let Some(last) = rows.last() else { return Ok((found, unreadable)) };
            after = last.try_get("seq")?;
            for row in &rows {
                if let Err(error) = job_of_row(row).and_then(|_| claimed_of_row(row)) {
                    let seq = row.try_get("seq")?;
                    tracing::error!(seq, %error, "a job cannot be read");
                    unreadable.push(seq);
                }
            }
        }
    }
}

/// Parses the id of a job.
pub(super) fn job_id(text: String) -> Result<JobId, JobsError> {
    text.parse().map_err(|_| JobsError::Corrupt { what: "job id", value: text })
}

/// Parses the kind of a job.
pub(super) fn kind_of_name(name: String) -> Result<JobKind, JobsError> {
    JobKind::from_name(&name).ok_or(JobsError::Corrupt { what: "kind of job", value: name })
}

/// Converts a row of a list; one that cannot be read is reported.
fn readable(row: &Row) -> Option<Job> {
    match job_of_row(row) {
        Ok(row) => Some(row),
        Err(error) => {
            let seq = row.try_get::<i64, _>("seq").unwrap_or_default();
            tracing::error!(seq, %error, "a job cannot be read");
            None
        }
    }
}

/// Converts a row of the view `job_rows`.
pub(super) fn job_of_row(row: &Row) -> Result<Job, JobsError> {
    let id = job_id(row.try_get("id")?)?;
    let state: String = row.try_get("state")?;
    let phase: String = row.try_get("phase")?;
    let warnings: String = row.try_get("warnings")?;
    let priority: i64 = row.try_get("priority")?;
    let failure: Option<String> = row.try_get("failure")?;
    let headline: Option<String> = row.try_get("headline")?;
    let recording = match (row.try_get("recording_bytes")?, row.try_get("recording_sha256")?) {
        (Some(bytes), Some(sha256)) => Some(FinalRecording {
            bytes: i64::cast_unsigned(bytes),
            sha256,
            complete: row.try_get::<Option<bool>, _>("recording_complete")?.unwrap_or(false),
            attempt: attempts_of(row.try_get("recording_attempt")?)?,
        }),
        _ => None,
    };
    Ok(Job {
        seq: row.try_get("seq")?,
        id,
        name: row.try_get("name")?,
        priority: Priority::from_number(priority)
            .ok_or(JobsError::Corrupt { what: "priority", value: priority.to_string() })?,
        content_hash: row.try_get("content_hash")?,
        end_time_s: row.try_get("end_time_s")?,
        warnings: serde_json::from_str(&warnings)?,
        state: JobState::from_name(&state).ok_or(JobsError::Corrupt { what: "state", value: state })?,
        phase: Phase::from_name(&phase).ok_or(JobsError::Corrupt { what: "phase", value: phase })?,
        progress: row.try_get("progress")?,
        step: row.try_get::<i64, _>("step")?.cast_unsigned(),
        expected_steps: row.try_get::<Option<i64>, _>("expected_steps")?.map(i64::cast_unsigned),
        simulated_time_s: row.try_get("simulated_time_s")?,
        eta_s: row.try_get("eta_s")?,
        attempts: attempts_of(row.try_get("attempts")?)?,
        cancel_requested: row.try_get("cancel_requested")?,
        created_at: row.try_get("created_at")?,
        started_at: row.try_get("started_at")?,
        finished_at: row.try_get("finished_at")?,
        failure: failure.map(|f| serde_json::from_str(&f)).transpose()?,
        withheld: row.try_get("withheld")?,
        // It only serves lists: one that another version wrote is as none.
        headline: headline.and_then(|text| serde_json::from_str(&text).ok()),
        links: JobLinks::new(id, row.try_get("has_summary")?, recording.is_some()),
        recording,
        queue_position: None,
        notice: NOTICE,
    })
}

/// Converts a row into the next attempt at its job, without the document.
pub(super) fn claimed_of_row(row: &Row) -> Result<ClaimedJob, JobsError> {
    Ok(ClaimedJob {
        seq: row.try_get("seq")?,
        id: job_id(row.try_get("id")?)?,
        owner: row.try_get("owner")?,
        kind: kind_of_name(row.try_get("kind")?)?,
        document: Vec::new(),
        memory_bytes: row.try_get::<i64, _>("memory_bytes")?.cast_unsigned(),
        alone: row.try_get("alone")?,
        attempt: attempts_of(row.try_get("attempts")?)?.saturating_add(1),
        trace: row.try_get("trace")?,
    })
}
