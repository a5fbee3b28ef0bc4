//! A blob while it is written.

use super::digest::{Digester, pieces};
use super::{Blob, BlobDigest, BlobError};
use std::io::{self, Read};

/// A place for bytes that have no name yet. Dropped without one, they are gone.
pub trait Unnamed: Send {
    /// Takes the next bytes.
    ///
    /// # Errors
    /// When it cannot.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Opens what came so far.
    ///
    /// # Errors
    /// When it cannot.
    fn open(&self) -> io::Result<Box<dyn Blob>>;

    /// Makes the bytes a blob, durable when this returns, in place of what had the name.
    ///
    /// # Errors
    /// When it cannot; what had the name keeps it then.
    fn keep(self: Box<Self>, name: &str) -> io::Result<()>;
}

/// A blob while it is written: nobody sees it before it has a name, it is no larger than it may be, and its digest is known when its
/// last byte has come. Dropped without a name, it leaves nothing.
pub struct Draft {
    unnamed: Box<dyn Unnamed>,
    digester: Digester,
    most: u64,
}

/// What a draft is called in errors.
const NAME: &str = "a draft";

impl Draft {
    /// Nothing yet, and at most so many bytes.
    pub fn new(unnamed: Box<dyn Unnamed>, most: u64) -> Self {
        Self { unnamed, digester: Digester::default(), most }
    }

    /// Takes the next bytes.
    ///
    /// # Errors
    /// `TooLarge`, and when the store fails.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), BlobError> {
        self.digester.update(bytes);
        if self.digester.bytes() > self.most {
            return Err(BlobError::TooLarge { most: self.most });
        }
        self.unnamed.append(bytes).map_err(BlobError::of(NAME))
    }

    /// Takes all that there is to read.
    ///
    /// # Errors
    /// As [`Self::append`], and when reading fails.
    pub fn append_all(&mut self, input: impl Read) -> Result<(), BlobError> {
        pieces(input, |piece| self.append(piece))
    }

    /// Size and digest of what came so far.
    pub fn digest(&self) -> BlobDigest {
        self.digester.digest()
    }

    /// What came so far.
    ///
    /// # Errors
    /// When the store fails.
    pub fn read(&self) -> Result<Vec<u8>, BlobError> {
        let mut bytes = Vec::new();
        let opened = self.unnamed.open();
        opened.and_then(|mut blob| blob.read_to_end(&mut bytes)).map_err(BlobError::of(NAME))?;
        Ok(bytes)
    }

    /// Makes it a blob, durable when this returns, in place of what had the name.
    ///
    /// # Errors
    /// When the store fails; what had the name keeps it then.
    pub fn keep(self, name: &str) -> Result<BlobDigest, BlobError> {
        self.unnamed.keep(name).map_err(BlobError::of(name))?;
        Ok(self.digester.digest())
    }
}
