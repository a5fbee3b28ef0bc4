//! Input of a command: a file, or standard input.

use super::CliError;
use std::io::{self, Read};
use std::path::Path;

/// Bytes of a file, or of standard input for `-`.
pub(super) fn read_file(file: &Path) -> Result<Vec<u8>, CliError> {
    let mut bytes = Vec::new();
    let read = if file.as_os_str() == "-" {
        io::stdin().lock().read_to_end(&mut bytes).map(|_| ())
    } else {
        std::fs::read(file).map(|content| bytes = content)
    };
    read.map_err(|source| CliError::Input { path: file.to_owned(), source })?;
    Ok(bytes)
}
