-- The process that runs a job, or ran it last, and the attempt that left the recording, which is in its name.
ALTER TABLE jobs ADD COLUMN worker TEXT;
ALTER TABLE jobs ADD COLUMN recording_attempt INTEGER NOT NULL DEFAULT 1;
DROP VIEW job_rows;
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested, created_at, started_at, finished_at, failure,
       summary IS NOT NULL AS has_summary, recording_bytes, recording_sha256, recording_complete, recording_attempt
FROM jobs WHERE deleted = 0;
