-- Results by content that a job uses: they are deleted with the last job that does.
CREATE TABLE results (
    job  INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
    key  TEXT    NOT NULL,
    PRIMARY KEY (job, key)
) WITHOUT ROWID;
CREATE INDEX results_key ON results (key);
-- When jobs ended, for their purge.
CREATE INDEX jobs_finished ON jobs (finished_at) WHERE finished_at IS NOT NULL;
