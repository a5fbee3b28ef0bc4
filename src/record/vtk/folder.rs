//! A series in a folder: `out.pvd` and `out_vtu/`, both `.partial` until they are complete.

use super::series::Place;
use crate::record::RecordError;
use crate::record::partial_file::open_exclusively;
use crate::record::writer::{partial_path, seal};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The files of a series being written.
#[derive(Debug)]
pub struct Folder {
    pvd: PathBuf,
    /// The folder of its `.vtu` files, and its name.
    files: PathBuf,
    name: String,
    /// The partial `.pvd` file: locked against other runs.
    list: File,
}

/// The folder of the series with this `.pvd` file: `out.pvd` has `out_vtu`.
pub fn folder_of(pvd: &Path) -> PathBuf {
    let stem = pvd.file_stem().unwrap_or_default().to_string_lossy();
    pvd.with_file_name(super::folder_name(&stem))
}

impl Folder {
    /// Begins a series with this `.pvd` file. What a killed run has left under the partial names is removed.
    ///
    /// # Errors
    /// If another run is writing it, or the file system refuses.
    pub fn create(pvd: &Path) -> Result<Self, RecordError> {
        let list = open_exclusively(&partial_path(pvd))?;
        let files = folder_of(pvd);
        let partial = partial_path(&files);
        remove_series(&partial).and_then(|()| fs::create_dir(&partial)).map_err(at(&partial))?;
        let name = files.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { pvd: pvd.to_owned(), files, name, list })
    }
}

impl Place for Folder {
    fn put(&mut self, name: &str, content: &[u8]) -> Result<(), RecordError> {
        let path = partial_path(&self.files).join(name);
        let written = fs::write(&path, content);
        if written.is_err() {
            // Part of a file, which must not stay in a series that ends here.
            let _ = fs::remove_file(&path);
        }
        written.map_err(at(&path))
    }

    fn folder(&self) -> &str {
        &self.name
    }

    fn close(self, pvd: &str) -> Result<(), RecordError> {
        let list = partial_path(&self.pvd);
        let mut file = BufWriter::new(self.list);
        file.write_all(pvd.as_bytes()).map_err(at(&list))?;
        remove_series(&self.files).map_err(at(&self.files))?;
        let partial = partial_path(&self.files);
        fs::rename(&partial, &self.files).map_err(at(&partial))?;
        seal(file, &self.pvd)
    }

    /// A complete series of the same name stays.
    fn discard(self) {
        let (list, files) = (partial_path(&self.pvd), partial_path(&self.files));
        let removed = remove_series(&files).and_then(|()| fs::remove_file(&list));
        if let Err(error) = removed {
            tracing::warn!(path = %list.display(), %error, "a discarded series could not be removed");
        }
    }
}

/// Removes a folder of `.vtu` files, if it exists. A folder with anything else in it stays, with an error.
fn remove_series(folder: &Path) -> io::Result<()> {
    match fs::symlink_metadata(folder) {
        Ok(found) if found.is_dir() => {}
        // A link is not followed.
        Ok(_) => return Err(io::ErrorKind::NotADirectory.into()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
    }
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "vtu") {
            fs::remove_file(path)?;
        }
    }
    fs::remove_dir(folder)
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> RecordError {
    let path = path.to_owned();
    move |source| RecordError::File { path, source }
}
