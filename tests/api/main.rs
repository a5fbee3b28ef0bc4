//! The service over HTTP. Modules mirror the URLs; `life` is about what outlives a request.
#![allow(clippy::unwrap_used, clippy::format_push_string, missing_docs)]

#[path = "../property/changes.rs"]
mod changes;
mod edge;
mod end_to_end;
mod examples;
mod life;
mod pages;
mod support;
mod v1;
