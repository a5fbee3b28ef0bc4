//! Blobs in memory, for tests of the contract without a folder.

use super::super::{Blob, BlobEntry, BlobError, BlobStore, Unnamed};
use std::collections::BTreeMap;
use std::io::{self, Cursor};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::SystemTime;

/// Bytes and write time by name.
type Blobs = BTreeMap<String, (Arc<[u8]>, SystemTime)>;

/// A blob store in memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryBlobs(Arc<Mutex<Blobs>>);

impl MemoryBlobs {
    fn all(&self) -> MutexGuard<'_, Blobs> {
        self.0.lock().unwrap()
    }
}

impl BlobStore for MemoryBlobs {
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError> {
        Ok(Box::new(UnnamedBytes { bytes: Vec::new(), blobs: self.clone() }))
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, BlobError> {
        let bytes = self.all().get(name).map(|(bytes, _)| Arc::clone(bytes));
        Ok(bytes.map(|bytes| Box::new(Cursor::new(bytes)) as Box<dyn Blob>))
    }

    fn delete(&self, name: &str) -> Result<(), BlobError> {
        self.all().remove(name);
        Ok(())
    }

    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError> {
        let is_on_shelf = |name: &str| name.rsplit_once('/').map_or("", |(shelf, _)| shelf) == shelf;
        let all = self.all();
        let on_shelf = all.iter().filter(|(name, _)| is_on_shelf(name));
        Ok(on_shelf.map(|(name, (_, kept))| BlobEntry { name: name.clone(), kept: *kept }).collect())
    }
}

struct UnnamedBytes {
    bytes: Vec<u8>,
    blobs: MemoryBlobs,
}

impl Unnamed for UnnamedBytes {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.bytes.extend_from_slice(bytes);
        Ok(())
    }

    fn open(&self) -> io::Result<Box<dyn Blob>> {
        Ok(Box::new(Cursor::new(self.bytes.clone())))
    }

    fn keep(self: Box<Self>, name: &str) -> io::Result<()> {
        self.blobs.all().insert(name.to_owned(), (self.bytes.into(), SystemTime::now()));
        Ok(())
    }
}

#[test]
fn it_keeps_what_a_store_promises() {
    super::check(&MemoryBlobs::default());
}
