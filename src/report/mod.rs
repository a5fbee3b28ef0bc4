//! Exports of a recorded run: a report page, tables, a bundle for clinical systems, fields and surfaces for other programs.
//!
//! Everything comes from the recording ([`RecordedRun`]), so the report of a received file states what its run stated; only who had it
//! computed and when comes from the service.

mod averaged_force;
mod chart;
pub mod csv;
pub mod date;
mod depth_picture;
pub mod fhir;
pub mod fields;
pub mod html;
pub mod instant;
mod numbers;
mod omissions;
mod parameters;
mod pictures;
mod read;
mod section;
mod section_frame;
mod section_impact;
mod section_picture;
mod section_scale;
mod simulated;
pub mod surface;
mod surface_file;
mod text;

pub use read::{ReadError, RecordedRun, Series};

#[cfg(test)]
mod tests;
