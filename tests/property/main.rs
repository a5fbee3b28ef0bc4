//! Properties that hold for any input.

mod scene_documents;
