//! The service over HTTP. Modules mirror the URLs; `life` is about what outlives a request.
#![allow(clippy::unwrap_used, clippy::format_push_string, missing_docs)]

mod attacks;
#[path = "../property/changes.rs"]
mod changes;
mod closed;
mod connections;
mod edge;
mod end_to_end;
mod examples;
mod fairness;
mod found;
mod hang_up;
mod isolation;
mod life;
mod operations;
mod pages;
mod privacy;
mod scale;
mod scan_of_a_limb;
mod shares;
mod support;
mod unattended;
mod v1;
