-- Whether a job lost its process, and therefore runs without others.
ALTER TABLE jobs ADD COLUMN alone INTEGER NOT NULL DEFAULT 0;
