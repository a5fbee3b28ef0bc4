//! `/v1`

mod jobs;
mod meshes;
mod studies;
