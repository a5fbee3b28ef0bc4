//! Output files: checked for write access before the work begins, with errors that name them.

use super::CliError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// Rejects a file that cannot be written, naming its flag. An existing file keeps its contents; a missing one is not
/// left behind.
pub(super) fn check_writable(path: &Path, flag: &str) -> Result<(), CliError> {
    let existed = path.exists();
    let opened = OpenOptions::new().append(true).create(true).open(path);
    match opened {
        Ok(_) if existed => Ok(()),
        Ok(_) => fs::remove_file(path).map_err(|source| refused(path, flag, &source)),
        Err(source) => Err(refused(path, flag, &source)),
    }
}

fn refused(path: &Path, flag: &str, why: &io::Error) -> CliError {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let reason =
        if folder.is_dir() { why.to_string() } else { format!("there is no folder {}", folder.display()) };
    CliError::Usage(format!(
        "{flag}: {} cannot be written: {reason}; name a file in a folder that you may write to with {flag}",
        path.display()
    ))
}

/// Writes a whole file.
pub(super) fn write_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CliError> {
    let written = File::create(path).and_then(|file| {
        let mut file = io::BufWriter::new(file);
        write(&mut file)?;
        file.flush()
    });
    written.map_err(|source| CliError::File { path: path.to_owned(), source })
}
