-- Times are RFC 3339 in UTC with milliseconds: they sort as text. `seq` is the order of arrival.
CREATE TABLE jobs (
    seq                 INTEGER PRIMARY KEY AUTOINCREMENT,
    id                  TEXT    NOT NULL UNIQUE,
    owner               TEXT    NOT NULL,
    idempotency_key     TEXT,
    body_sha256         TEXT    NOT NULL,
    scene               BLOB    NOT NULL,
    name                TEXT    NOT NULL,
    content_hash        TEXT    NOT NULL,
    end_time_s          REAL    NOT NULL,
    warnings            TEXT    NOT NULL,
    state               TEXT    NOT NULL DEFAULT 'queued'
                        CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    phase               TEXT    NOT NULL DEFAULT 'waiting',
    progress            REAL    NOT NULL DEFAULT 0,
    step                INTEGER NOT NULL DEFAULT 0,
    expected_steps      INTEGER,
    simulated_time_s    REAL    NOT NULL DEFAULT 0,
    eta_s               REAL,
    attempts            INTEGER NOT NULL DEFAULT 0,
    cancel_requested    INTEGER NOT NULL DEFAULT 0,
    deleted             INTEGER NOT NULL DEFAULT 0,
    created_at          TEXT    NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
    started_at          TEXT,
    finished_at         TEXT,
    failure             TEXT,
    summary             TEXT,
    recording_bytes     INTEGER,
    recording_sha256    TEXT,
    recording_complete  INTEGER
);
CREATE UNIQUE INDEX jobs_idempotency ON jobs (owner, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE INDEX jobs_state ON jobs (state, seq);
CREATE INDEX jobs_owner ON jobs (owner, seq);

-- What anybody may ask about a job: without the scene and the summary, which are long.
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested, created_at, started_at, finished_at, failure,
       summary IS NOT NULL AS has_summary, recording_bytes, recording_sha256, recording_complete,
       CASE WHEN state = 'queued' THEN
           (SELECT COUNT(*) FROM jobs q WHERE q.state = 'queued' AND q.deleted = 0 AND q.seq <= jobs.seq)
       END AS position
FROM jobs WHERE deleted = 0;

-- What happened to a job, numbered from 1 within the job: the ids of its event stream.
CREATE TABLE events (
    job   INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
    n     INTEGER NOT NULL,
    kind  TEXT    NOT NULL,
    data  TEXT    NOT NULL,
    PRIMARY KEY (job, n)
) WITHOUT ROWID;

-- Uploaded meshes, named by the SHA-256 of their bytes. The bytes are shared, the right to name them is not.
CREATE TABLE meshes (
    id          TEXT    NOT NULL,
    owner       TEXT    NOT NULL,
    format      TEXT    NOT NULL,
    bytes       INTEGER NOT NULL,
    report      TEXT    NOT NULL,
    created_at  TEXT    NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
    PRIMARY KEY (owner, id)
) WITHOUT ROWID;
