//! Prints results as indented JSON.

use super::CliError;
use serde::Serialize;
use std::io::Write;

/// Writes a value as readable JSON, with a final line break.
pub(super) fn write_json(value: &impl Serialize, out: &mut dyn Write) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(value).map_err(|error| CliError::Other(Box::new(error)))?;
    Ok(writeln!(out, "{text}")?)
}
