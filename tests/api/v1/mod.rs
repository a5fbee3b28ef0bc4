//! `/v1`

mod bodies;
mod jobs;
mod meshes;
mod studies;
mod what_if;
