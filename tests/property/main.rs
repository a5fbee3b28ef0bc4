//! Properties that hold for any input.
#![allow(clippy::unwrap_used)] // tests say what they expect by panicking, their own functions too

mod scene_documents;
