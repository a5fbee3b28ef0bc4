-- Owners take turns; of the jobs of one, those with the highest priority begin first (0 low, 1 normal, 2 high).
ALTER TABLE jobs ADD COLUMN priority INTEGER NOT NULL DEFAULT 1;
CREATE INDEX jobs_waiting_of_owner ON jobs (owner, priority DESC, seq) WHERE state = 'queued' AND deleted = 0;
CREATE INDEX jobs_running_of_owner ON jobs (owner) WHERE state = 'running';
-- Number of waiting jobs of an owner, by priority.
CREATE TABLE waiting_counts (
    owner     TEXT    NOT NULL,
    priority  INTEGER NOT NULL,
    n         INTEGER NOT NULL,
    PRIMARY KEY (owner, priority)
) WITHOUT ROWID;
INSERT INTO waiting_counts (owner, priority, n)
SELECT owner, priority, COUNT(*) FROM jobs WHERE state = 'queued' AND deleted = 0 GROUP BY owner, priority;
CREATE TRIGGER jobs_waiting_in AFTER INSERT ON jobs WHEN NEW.state = 'queued' AND NEW.deleted = 0
BEGIN INSERT INTO waiting_counts (owner, priority, n) VALUES (NEW.owner, NEW.priority, 1) ON CONFLICT DO UPDATE SET n = n + 1; END;
CREATE TRIGGER jobs_waiting_out AFTER DELETE ON jobs WHEN OLD.state = 'queued' AND OLD.deleted = 0
BEGIN UPDATE waiting_counts SET n = n - 1 WHERE owner = OLD.owner AND priority = OLD.priority; END;
CREATE TRIGGER jobs_waiting_from AFTER UPDATE OF state, deleted ON jobs WHEN OLD.state = 'queued' AND OLD.deleted = 0
BEGIN UPDATE waiting_counts SET n = n - 1 WHERE owner = OLD.owner AND priority = OLD.priority; END;
CREATE TRIGGER jobs_waiting_to AFTER UPDATE OF state, deleted ON jobs WHEN NEW.state = 'queued' AND NEW.deleted = 0
BEGIN INSERT INTO waiting_counts (owner, priority, n) VALUES (NEW.owner, NEW.priority, 1) ON CONFLICT DO UPDATE SET n = n + 1; END;
-- When an owner had a turn, as a count of all turns.
CREATE TABLE owners (
    owner  TEXT    PRIMARY KEY,
    turn   INTEGER NOT NULL
) WITHOUT ROWID;

-- What a job keeps: its document, summary and recording [bytes].
ALTER TABLE jobs ADD COLUMN kept_bytes INTEGER NOT NULL DEFAULT 0;
UPDATE jobs SET kept_bytes = length(scene) + COALESCE(length(CAST(summary AS BLOB)), 0) + COALESCE(recording_bytes, 0);
CREATE INDEX jobs_kept ON jobs (owner, kept_bytes);

-- Context of the trace of the request that submitted a job (W3C Trace Context), which its run continues.
ALTER TABLE jobs ADD COLUMN trace TEXT;

DROP VIEW job_rows;
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, priority, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested, created_at, started_at, finished_at, failure,
       summary IS NOT NULL AS has_summary, recording_bytes, recording_sha256, recording_complete, recording_attempt
FROM jobs WHERE deleted = 0;
