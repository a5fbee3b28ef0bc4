//! The question of `contuse material fit`: measured curves, a law with starting values, and which of its parameters are free.

mod check;
mod curve_file;
mod document;
mod parameter;
mod read;

pub use document::{Constants, Errors, FitQuestion, TestDocument, TestKind};
pub use parameter::Parameter;
