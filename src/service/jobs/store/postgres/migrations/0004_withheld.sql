-- Whether the numbers of a run are withheld, as its summary says.
ALTER TABLE jobs ADD COLUMN withheld BOOLEAN NOT NULL DEFAULT FALSE;
UPDATE jobs SET withheld = TRUE WHERE json_typeof(summary::json -> 'withheld') = 'object';

DROP VIEW job_rows;
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, priority, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested <> 0 AS cancel_requested, created_at, started_at, finished_at,
       failure, summary IS NOT NULL AS has_summary, withheld, recording_bytes, recording_sha256, recording_complete,
       recording_attempt
FROM jobs WHERE deleted = 0;
