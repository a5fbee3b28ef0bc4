-- Owners take turns; of the jobs of one, those with the highest priority begin first (0 low, 1 normal, 2 high).
ALTER TABLE jobs ADD COLUMN priority BIGINT NOT NULL DEFAULT 1;
CREATE INDEX jobs_waiting_of_owner ON jobs (owner, priority DESC, seq) WHERE state = 'queued' AND deleted = 0;
CREATE INDEX jobs_running_of_owner ON jobs (owner) WHERE state = 'running';
-- Number of waiting jobs of an owner, by priority: counted, as those of the states are.
CREATE VIEW waiting_counts AS
SELECT owner, priority, COUNT(*) AS n FROM jobs WHERE state = 'queued' AND deleted = 0 GROUP BY owner, priority;
-- When an owner had a turn, as a count of all turns.
CREATE TABLE owners (
    owner  TEXT   PRIMARY KEY,
    turn   BIGINT NOT NULL
);

-- What a job keeps: its document, summary and recording [bytes].
ALTER TABLE jobs ADD COLUMN kept_bytes BIGINT NOT NULL DEFAULT 0;
UPDATE jobs SET kept_bytes = length(scene) + COALESCE(octet_length(summary), 0) + COALESCE(recording_bytes, 0);
CREATE INDEX jobs_kept ON jobs (owner, kept_bytes);

-- Context of the trace of the request that submitted a job (W3C Trace Context), which its run continues.
ALTER TABLE jobs ADD COLUMN trace TEXT;

DROP VIEW job_rows;
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, priority, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested <> 0 AS cancel_requested, created_at, started_at, finished_at,
       failure, summary IS NOT NULL AS has_summary, recording_bytes, recording_sha256, recording_complete,
       recording_attempt
FROM jobs WHERE deleted = 0;
