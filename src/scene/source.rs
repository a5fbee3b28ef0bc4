//! Sources of mesh bytes: files in the folder of the scene, or the store of a service.

use crate::mesh::read::MeshFormat;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Provides the bytes of a mesh by the name used in the scene.
pub trait MeshSource: Sync {
    /// The bytes of the mesh called `name`, and a file name whose extension gives the format.
    ///
    /// # Errors
    /// When the mesh does not exist, lies outside the source, is larger than `limit` bytes, or cannot be read.
    fn read(&self, name: &str, limit: u64) -> Result<MeshBytes, MeshSourceError>;

    /// The file that the mesh called `name` includes as `included`: its name in this source, and its bytes. Only files
    /// include others: by default, a mesh is one file.
    ///
    /// # Errors
    /// As [`Self::read`].
    fn read_included(&self, name: &str, _: &str, _: u64) -> Result<MeshBytes, MeshSourceError> {
        Err(MeshSourceError::OneFile { name: name.to_owned() })
    }
}

/// A mesh file, not yet parsed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshBytes {
    /// File name; its extension gives the format.
    pub file_name: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// Why a mesh cannot be provided.
#[derive(Debug, Serialize, Deserialize, thiserror::Error)]
pub enum MeshSourceError {
    /// No mesh of that name in the folder.
    #[error("there is no mesh {name:?}")]
    NotFound {
        /// Name of the mesh that was requested.
        name: String,
        /// Names of the existing meshes.
        known: Vec<String>,
    },
    /// No uploaded mesh with that id; other ids are not disclosed.
    #[error("there is no mesh {name:?}")]
    NotUploaded {
        /// Id of the mesh that was requested.
        name: String,
    },
    /// A mesh that includes other files where there are none.
    #[error("the mesh {name:?} is uploaded as one file")]
    OneFile {
        /// The name by which the scene requested it.
        name: String,
    },
    /// A name that points outside the folder of the scene.
    #[error("{name:?} is outside the folder of the scene")]
    Outside {
        /// Name of the mesh that was requested.
        name: String,
    },
    /// More bytes than the budget allows.
    #[error("the mesh {name:?} has {bytes} bytes")]
    TooLarge {
        /// Name of the mesh that was requested.
        name: String,
        /// Size of the file [bytes].
        bytes: u64,
        /// The largest accepted size [bytes].
        limit: u64,
    },
    /// Reading from the storage failed.
    #[error("the mesh {name:?} cannot be read: {reason}")]
    Unreadable {
        /// Name of the mesh that was requested.
        name: String,
        /// Error of the storage.
        reason: String,
    },
}

/// A source without files, for scenes whose meshes are all generated.
#[derive(Clone, Copy, Debug)]
pub struct NoFiles;

impl MeshSource for NoFiles {
    fn read(&self, name: &str, _: u64) -> Result<MeshBytes, MeshSourceError> {
        Err(MeshSourceError::NotFound { name: name.to_owned(), known: Vec::new() })
    }
}

/// The scans and surfaces of a scene, kept to make its meshes again in other sizes.
#[derive(Clone, Debug, Default)]
pub struct KeptFiles(Arc<BTreeMap<String, MeshBytes>>);

impl KeptFiles {
    /// Files by their names in the scene.
    pub fn new(files: BTreeMap<String, MeshBytes>) -> Self {
        Self(Arc::new(files))
    }
}

impl MeshSource for KeptFiles {
    fn read(&self, name: &str, _: u64) -> Result<MeshBytes, MeshSourceError> {
        let missing =
            || MeshSourceError::NotFound { name: name.to_owned(), known: self.0.keys().cloned().collect() };
        self.0.get(name).cloned().ok_or_else(missing)
    }
}

/// Files in the folder of the scene and below it. A name cannot leave the folder: absolute paths, `..` and symbolic links
/// to elsewhere are refused.
#[derive(Clone, Debug)]
pub struct FolderSource {
    folder: PathBuf,
}

impl FolderSource {
    /// A source of the files in `folder`.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// Canonical path of a name inside the folder.
    fn resolve(&self, name: &str) -> Result<PathBuf, MeshSourceError> {
        let outside = || MeshSourceError::Outside { name: name.to_owned() };
        let missing = || MeshSourceError::NotFound { name: name.to_owned(), known: self.names() };
        let relative = Path::new(name);
        if !relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
            return Err(outside());
        }
        let folder = self.folder.canonicalize().map_err(|_| missing())?;
        // `canonicalize` follows links, so the comparison is with the true location of the file.
        let path = folder.join(relative).canonicalize().map_err(|_| missing())?;
        if !path.starts_with(&folder) {
            return Err(outside());
        }
        if path.is_file() {
            return Ok(path);
        }
        if path.is_dir() {
            return Err(missing());
        }
        let reason = "it is a pipe or a device: copy its content to a file".to_owned();
        Err(MeshSourceError::Unreadable { name: name.to_owned(), reason })
    }

    /// Names of the mesh files directly in the folder, sorted, for suggestions.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries
            .map(|entry| entry.path())
            .filter(|path| !path.is_dir())
            .filter_map(|path| Some(path.file_name()?.to_str()?.to_owned()))
            .filter(|name| MeshFormat::from_name(name).is_some())
            .collect();
        names.sort();
        names
    }
}

impl MeshSource for FolderSource {
    fn read(&self, name: &str, limit: u64) -> Result<MeshBytes, MeshSourceError> {
        let path = self.resolve(name)?;
        let unreadable = |error: std::io::Error| MeshSourceError::Unreadable {
            name: name.to_owned(),
            reason: error.to_string(),
        };
        let file = std::fs::File::open(&path).map_err(unreadable)?;
        let size = file.metadata().map_err(unreadable)?.len();
        let too_large = |bytes| MeshSourceError::TooLarge { name: name.to_owned(), bytes, limit };
        if size > limit {
            return Err(too_large(size));
        }
        let mut bytes = Vec::with_capacity(size as usize);
        // The file may grow between querying its size and reading it.
        file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        if bytes.len() as u64 > limit {
            return Err(too_large(bytes.len() as u64));
        }
        Ok(MeshBytes { file_name: name.to_owned(), bytes })
    }

    /// Included names are relative to the folder of the mesh.
    fn read_included(&self, name: &str, included: &str, limit: u64) -> Result<MeshBytes, MeshSourceError> {
        let beside = Path::new(name).with_file_name("").join(included);
        let beside = beside.to_str().filter(|_| !Path::new(included).is_absolute());
        let outside = || MeshSourceError::Outside { name: included.to_owned() };
        self.read(beside.ok_or_else(outside)?, limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_inside_the_folder_are_read() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("scene");
        std::fs::create_dir_all(folder.join("meshes")).unwrap();
        std::fs::write(root.path().join("secret.msh"), "secret").unwrap();
        std::fs::write(folder.join("meshes/ball.msh"), "ball").unwrap();
        std::fs::write(folder.join("block.msh"), "block").unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(root.path().join("secret.msh"), folder.join("link.msh")).unwrap();

        let source = FolderSource::new(&folder);
        assert_eq!(source.read("meshes/ball.msh", 4).unwrap().bytes, b"ball");
        assert_eq!(source.read("./block.msh", 100).unwrap().bytes, b"block");
        std::fs::create_dir(folder.join("folder.stl")).unwrap();
        let absolute = root.path().join("secret.msh");
        for name in ["../secret.msh", "meshes/../../secret.msh", absolute.to_str().unwrap(), "link.msh"] {
            let result = source.read(name, 100);
            assert!(matches!(result, Err(MeshSourceError::Outside { .. })), "{name}: {result:?}");
        }
        assert!(matches!(source.read("block.msh", 4), Err(MeshSourceError::TooLarge { bytes: 5, .. })));
        for name in ["", ".", "meshes", "folder.stl", "blok.msh", "a\0b"] {
            let Err(MeshSourceError::NotFound { known, .. }) = source.read(name, 100) else {
                panic!("{name:?} was found")
            };
            assert!(known.contains(&"block.msh".into()) && !known.contains(&"folder.stl".into()));
        }
    }

    #[test]
    #[cfg(unix)]
    fn pipes_and_devices_are_no_files() {
        let folder = tempfile::tempdir().unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(folder.path().join("mesh.k")).unwrap();
        let error = FolderSource::new(folder.path()).read("mesh.k", 100).unwrap_err();
        assert!(error.to_string().contains("a pipe or a device"), "{error}");
    }

    #[test]
    fn files_are_included_from_the_folder_of_the_mesh() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(root.path().join("meshes")).unwrap();
        std::fs::write(root.path().join("meshes/nodes.k"), "nodes").unwrap();
        std::fs::write(root.path().join("secret.k"), "secret").unwrap();
        let source = FolderSource::new(root.path().join("meshes"));
        let found = source.read_included("ball.k", "nodes.k", 100).unwrap();
        assert_eq!((found.file_name.as_str(), found.bytes.as_slice()), ("nodes.k", &b"nodes"[..]));
        let source = FolderSource::new(root.path());
        assert_eq!(
            source.read_included("meshes/ball.k", "nodes.k", 100).unwrap().file_name,
            "meshes/nodes.k"
        );
        for name in ["../secret.k", "/etc/passwd"] {
            let result = source.read_included("meshes/ball.k", name, 100);
            assert!(matches!(result, Err(MeshSourceError::Outside { .. })), "{name}: {result:?}");
        }
        let result = NoFiles.read_included("ball", "nodes.k", 100);
        assert!(matches!(result, Err(MeshSourceError::OneFile { .. })), "{result:?}");
    }
}
