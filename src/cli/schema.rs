//! `contuse schema`: the JSON Schema of the scene document.

use super::{CliError, Exit};
use crate::scene::scene_schema;
use std::io::Write;

/// Prints the schema.
///
/// # Errors
/// If it cannot be written.
pub fn print(out: &mut dyn Write) -> Result<Exit, CliError> {
    writeln!(out, "{:#}", scene_schema())?;
    Ok(Exit::Success)
}
