-- Times are RFC 3339 in UTC with milliseconds, as in the documents of the API; `seq` is the order of arrival.
CREATE FUNCTION rfc3339(at TIMESTAMPTZ) RETURNS TEXT LANGUAGE SQL STABLE
    RETURN to_char(at AT TIME ZONE 'UTC', 'YYYY-MM-DD"T"HH24:MI:SS.MS"Z"');

CREATE TABLE jobs (
    seq                 BIGINT  GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    id                  TEXT    NOT NULL UNIQUE,
    owner               TEXT    NOT NULL,
    idempotency_key     TEXT,
    body_sha256         TEXT    NOT NULL,
    kind                TEXT    NOT NULL CHECK (kind IN ('simulation', 'study', 'what_if')),
    scene               BYTEA   NOT NULL,
    name                TEXT    NOT NULL,
    content_hash        TEXT    NOT NULL,
    end_time_s          DOUBLE PRECISION NOT NULL,
    warnings            TEXT    NOT NULL,
    -- Memory that its run is expected to take [bytes], and whether it lost a process and runs without others.
    memory_bytes        BIGINT  NOT NULL,
    alone               INTEGER NOT NULL DEFAULT 0,
    state               TEXT    NOT NULL DEFAULT 'queued'
                        CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    -- The process that has the job, and until when, unless it renews that.
    worker              TEXT,
    lease_until         TIMESTAMPTZ,
    phase               TEXT    NOT NULL DEFAULT 'waiting',
    progress            DOUBLE PRECISION NOT NULL DEFAULT 0,
    step                BIGINT  NOT NULL DEFAULT 0,
    expected_steps      BIGINT,
    simulated_time_s    DOUBLE PRECISION NOT NULL DEFAULT 0,
    eta_s               DOUBLE PRECISION,
    attempts            BIGINT  NOT NULL DEFAULT 0,
    cancel_requested    INTEGER NOT NULL DEFAULT 0,
    deleted             INTEGER NOT NULL DEFAULT 0,
    created_at          TEXT    NOT NULL DEFAULT rfc3339(clock_timestamp()),
    started_at          TEXT,
    finished_at         TEXT,
    failure             TEXT,
    summary             TEXT,
    recording_bytes     BIGINT,
    recording_sha256    TEXT,
    recording_complete  BOOLEAN,
    recording_attempt   BIGINT  NOT NULL DEFAULT 1
);
CREATE UNIQUE INDEX jobs_idempotency ON jobs (owner, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE INDEX jobs_owner ON jobs (owner, seq);
CREATE INDEX jobs_owner_state ON jobs (owner, state, seq);
CREATE INDEX jobs_state ON jobs (state) WHERE deleted = 0;
CREATE INDEX jobs_waiting ON jobs (seq) WHERE state = 'queued' AND deleted = 0;
CREATE INDEX jobs_held ON jobs (lease_until) WHERE state = 'running' OR deleted = 1;
CREATE INDEX jobs_finished ON jobs (finished_at) WHERE finished_at IS NOT NULL;

-- What anybody may ask about a job: without the scene and the summary, which are long.
CREATE VIEW job_rows AS
SELECT seq, id, owner, name, content_hash, end_time_s, warnings, state, phase, progress, step, expected_steps,
       simulated_time_s, eta_s, attempts, cancel_requested <> 0 AS cancel_requested, created_at, started_at, finished_at,
       failure, summary IS NOT NULL AS has_summary, recording_bytes, recording_sha256, recording_complete,
       recording_attempt
FROM jobs WHERE deleted = 0;

-- Number of jobs that are not hidden, by state: counted, as counters would be a row that all writers wait for.
CREATE VIEW state_counts AS SELECT state, COUNT(*) AS n FROM jobs WHERE deleted = 0 GROUP BY state;

-- What happened to a job, numbered from 1 within the job: the ids of its event stream.
CREATE TABLE events (
    job   BIGINT NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
    n     BIGINT NOT NULL,
    kind  TEXT   NOT NULL,
    data  TEXT   NOT NULL,
    PRIMARY KEY (job, n)
);

-- Uploaded meshes, named by the SHA-256 of their bytes. The bytes are shared, the right to name them is not.
CREATE TABLE meshes (
    id          TEXT   NOT NULL,
    owner       TEXT   NOT NULL,
    format      TEXT   NOT NULL,
    bytes       BIGINT NOT NULL,
    report      TEXT   NOT NULL,
    created_at  TEXT   NOT NULL DEFAULT rfc3339(clock_timestamp()),
    PRIMARY KEY (owner, id)
);

-- Results by content that a job uses: they are deleted with the last job that does.
CREATE TABLE results (
    job  BIGINT NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
    key  TEXT   NOT NULL,
    PRIMARY KEY (job, key)
);
CREATE INDEX results_key ON results (key);

-- Processes hear of events and of requests to stop when the transaction commits, on a channel of the schema.
CREATE FUNCTION announce_event() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM pg_notify('contuse_' || TG_TABLE_SCHEMA, NEW.job || ' ' || NEW.kind);
    RETURN NULL;
END $$;
CREATE TRIGGER events_announced AFTER INSERT ON events FOR EACH ROW EXECUTE FUNCTION announce_event();
CREATE FUNCTION announce_request() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    PERFORM pg_notify('contuse_' || TG_TABLE_SCHEMA, NEW.seq || ' request');
    RETURN NULL;
END $$;
CREATE TRIGGER requests_announced AFTER UPDATE OF cancel_requested, deleted ON jobs
    FOR EACH ROW EXECUTE FUNCTION announce_request();
