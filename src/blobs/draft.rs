//! A blob while it is being written.

use super::blob::{Blob, BlobError};
use super::digest::{BlobDigest, Digester, pieces};
use std::io::{self, Read};

/// Bytes without a name yet. Dropped without one, they are discarded.
pub trait Unnamed: Send {
    /// Appends bytes.
    ///
    /// # Errors
    /// When the store fails.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Opens the bytes written so far.
    ///
    /// # Errors
    /// When the store fails.
    fn open(&self) -> io::Result<Box<dyn Blob>>;

    /// Names the bytes: they become a blob, durable on return, replacing any blob of that name.
    ///
    /// # Errors
    /// When the store fails; an existing blob of that name then remains.
    fn keep(self: Box<Self>, name: &str) -> io::Result<()>;
}

/// A blob while it is being written: invisible until it is named, limited in size, and with a digest that is known after
/// its last byte. Dropped without a name, it leaves nothing.
pub struct Draft {
    unnamed: Box<dyn Unnamed>,
    digester: Digester,
    most: u64,
}

/// Name of drafts in errors.
const NAME: &str = "a draft";

impl Draft {
    /// An empty draft of at most `most` bytes.
    pub fn new(unnamed: Box<dyn Unnamed>, most: u64) -> Self {
        Self { unnamed, digester: Digester::default(), most }
    }

    /// Appends bytes.
    ///
    /// # Errors
    /// `TooLarge`, or when the store fails.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), BlobError> {
        self.digester.update(bytes);
        if self.digester.bytes() > self.most {
            return Err(BlobError::TooLarge { most: self.most });
        }
        self.unnamed.append(bytes).map_err(BlobError::of(NAME))
    }

    /// Appends everything that can be read from `input`.
    ///
    /// # Errors
    /// As [`Self::append`], and when reading fails.
    pub fn append_all(&mut self, input: impl Read) -> Result<(), BlobError> {
        pieces(input, |piece| self.append(piece))
    }

    /// Size and digest of the bytes so far.
    pub fn digest(&self) -> BlobDigest {
        self.digester.digest()
    }

    /// Opens the bytes so far.
    ///
    /// # Errors
    /// When the store fails.
    pub fn open(&self) -> Result<Box<dyn Blob>, BlobError> {
        self.unnamed.open().map_err(BlobError::of(NAME))
    }

    /// Names the draft: it becomes a blob, durable on return, replacing any blob of that name.
    ///
    /// # Errors
    /// When the store fails; an existing blob of that name then remains.
    pub fn keep(self, name: &str) -> Result<BlobDigest, BlobError> {
        self.unnamed.keep(name).map_err(BlobError::of(name))?;
        Ok(self.digester.digest())
    }
}
