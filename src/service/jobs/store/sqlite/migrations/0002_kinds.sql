-- What a job is for, decided where it is submitted. Jobs that are there already are told by their documents: only a study has a
-- `kind`, and only a what-if question has `parameters`.
ALTER TABLE jobs ADD COLUMN kind TEXT NOT NULL DEFAULT 'simulation' CHECK (kind IN ('simulation', 'study', 'what_if'));
UPDATE jobs SET kind = CASE
    WHEN json_type(CAST(scene AS TEXT), '$.kind') IS NOT NULL THEN 'study'
    WHEN json_type(CAST(scene AS TEXT), '$.parameters') IS NOT NULL THEN 'what_if'
    ELSE 'simulation'
END
WHERE json_valid(CAST(scene AS TEXT));
