//! `/v1`

mod bodies;
mod jobs;
mod materials;
mod meshes;
mod studies;
mod what_if;
