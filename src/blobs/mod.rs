//! Blobs: named bytes that never change. Recordings of finished runs, meshes, snapshots, results.
//!
//! A store is a [`BlobStore`]: [`FolderBlobs`] keeps files in a folder, `ObjectBlobs` objects in an S3-compatible store. Another store is one file that passes
//! `tests/mod.rs`. Bytes that are still being written have no name: they are a [`Draft`], or a local file that a store
//! [adopts](BlobStore::adopt) when it is complete.

mod blob;
mod digest;
mod draft;
mod folder;
#[cfg(feature = "cluster")]
mod object;
mod store;
#[cfg(test)]
mod tests;

pub use blob::{Blob, BlobEntry, BlobError};
pub use digest::{BlobDigest, Digester, hexadecimal};
pub use draft::{Draft, Unnamed};
pub use folder::FolderBlobs;
#[cfg(feature = "cluster")]
pub use object::ObjectBlobs;
pub use store::BlobStore;
