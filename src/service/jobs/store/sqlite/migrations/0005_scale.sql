-- What lists, counts and the queue read does not grow with the number of jobs.
CREATE INDEX jobs_owner_state ON jobs (owner, state, seq);
CREATE INDEX jobs_waiting ON jobs (seq) WHERE state = 'queued' AND deleted = 0;

-- Number of jobs that are not hidden, by state.
CREATE TABLE state_counts (
    state  TEXT    PRIMARY KEY,
    n      INTEGER NOT NULL
) WITHOUT ROWID;
INSERT INTO state_counts (state, n)
VALUES ('queued', 0), ('running', 0), ('succeeded', 0), ('failed', 0), ('cancelled', 0);
UPDATE state_counts SET n = (SELECT COUNT(*) FROM jobs WHERE jobs.state = state_counts.state AND deleted = 0);
CREATE TRIGGER jobs_counted_in AFTER INSERT ON jobs WHEN NEW.deleted = 0
BEGIN UPDATE state_counts SET n = n + 1 WHERE state = NEW.state; END;
CREATE TRIGGER jobs_counted_out AFTER DELETE ON jobs WHEN OLD.deleted = 0
BEGIN UPDATE state_counts SET n = n - 1 WHERE state = OLD.state; END;
CREATE TRIGGER jobs_counted_from AFTER UPDATE OF state, deleted ON jobs WHEN OLD.deleted = 0
BEGIN UPDATE state_counts SET n = n - 1 WHERE state = OLD.state; END;
CREATE TRIGGER jobs_counted_to AFTER UPDATE OF state, deleted ON jobs WHEN NEW.deleted = 0
BEGIN UPDATE state_counts SET n = n + 1 WHERE state = NEW.state; END;

-- Memory that the run of a job is expected to take [bytes]: it waits until so much is free.
ALTER TABLE jobs ADD COLUMN memory_bytes INTEGER NOT NULL DEFAULT 0;

-- Positions in the queue are counted for a page at once.
DROP VIEW job_rows;
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested, created_at, started_at, finished_at, failure,
       summary IS NOT NULL AS has_summary, recording_bytes, recording_sha256, recording_complete
FROM jobs WHERE deleted = 0;
