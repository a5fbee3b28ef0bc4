-- The phase `settling` is named `dynamic_relaxation`.
UPDATE jobs SET phase = 'dynamic_relaxation' WHERE phase = 'settling';
