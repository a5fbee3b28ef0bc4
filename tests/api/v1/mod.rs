mod jobs;
mod meshes;
