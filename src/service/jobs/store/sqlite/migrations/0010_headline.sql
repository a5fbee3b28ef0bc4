-- The projectile of a job and the main numbers of its run as JSON, for lists; jobs that ended before have none.
ALTER TABLE jobs ADD COLUMN headline TEXT;

DROP VIEW job_rows;
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, priority, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested, created_at, started_at, finished_at, failure,
       summary IS NOT NULL AS has_summary, withheld, headline, recording_bytes, recording_sha256, recording_complete, recording_attempt
FROM jobs WHERE deleted = 0;
