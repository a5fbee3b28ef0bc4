//! Opens the file of a recording: one writer at a time, and never through a link.

use super::RecordError;
use std::fs::{File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::path::Path;

/// Opens `path` empty, locked as long as the file is open. The remains of a killed run are overwritten.
///
/// # Errors
/// If another run is writing it, if it is a symbolic link, or if the file system refuses.
pub(super) fn open_exclusively(path: &Path) -> Result<File, RecordError> {
    let at = |source| RecordError::File { path: path.to_owned(), source };
    loop {
        // Truncated only once it is locked.
        let file = options().open(path).map_err(at)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(RecordError::InUse { path: path.to_owned() }),
            Err(TryLockError::Error(source)) => return Err(at(source)),
        }
        // Another run may have finished and renamed the file between opening and locking.
        if is_what_was_found(&file, std::fs::symlink_metadata(path)).map_err(at)? {
            file.set_len(0).map_err(at)?;
            return Ok(file);
        }
    }
}

fn options() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(false);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt as _;
        options.custom_flags(rustix::fs::OFlags::NOFOLLOW.bits().cast_signed());
    }
    options
}

/// Whether an open file is the one that was found under a name; false where nothing was.
///
/// # Errors
/// That of the search, or if the open file has none of its data.
#[cfg(unix)]
pub fn is_what_was_found(file: &File, found: io::Result<Metadata>) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;
    let opened = file.metadata()?;
    match found {
        Ok(found) => Ok((opened.dev(), opened.ino()) == (found.dev(), found.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Files that are open keep their names.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn is_what_was_found(_: &File, _: io::Result<Metadata>) -> io::Result<bool> {
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    #[test]
    fn a_second_writer_is_refused_and_harms_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap.partial");
        let mut first = open_exclusively(&path).unwrap();
        first.write_all(b"first").unwrap();
        assert!(matches!(open_exclusively(&path), Err(RecordError::InUse { .. })));
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        drop(first);
        // The remains of a killed run are overwritten.
        drop(open_exclusively(&path).unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), b"");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (target, path) = (folder.path().join("precious"), folder.path().join("run.mcap.partial"));
        std::fs::write(&target, b"precious").unwrap();
        std::os::unix::fs::symlink(&target, &path).unwrap();
        assert!(matches!(open_exclusively(&path), Err(RecordError::File { .. })));
        assert_eq!(std::fs::read(&target).unwrap(), b"precious");
    }
}
