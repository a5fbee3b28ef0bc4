-- What distinguishes the blobs of this database from those of others, and whether a store of blobs has it.
CREATE TABLE identity (
    id         TEXT    NOT NULL,
    has_blobs  BOOLEAN NOT NULL
);
INSERT INTO identity (id, has_blobs) VALUES (gen_random_uuid()::text, FALSE);
