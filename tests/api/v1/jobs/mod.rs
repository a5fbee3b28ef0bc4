//! `/v1/jobs` and below: one file a call.

mod cancel;
mod delete;
mod events;
mod list;
mod one;
mod plan;
mod recording;
mod submit;
mod summary;
mod validate;
