//! Properties that hold for any input.
//!
//! Each runs 256 cases; `PROPTEST_CASES=100000 cargo test --release --test property` runs as many as there is time for.
#![allow(clippy::unwrap_used, clippy::format_push_string)] // tests say what they expect by panicking, their own functions too

mod changes;
mod contact_problem_files;
mod file_changes;
mod material_questions;
mod mesh_files;
mod scene_documents;
mod surface_files;
mod table_files;
